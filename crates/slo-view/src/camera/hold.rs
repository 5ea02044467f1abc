//! A view that replaces what the camera sees in one frame.

use glam::DVec3;
use slo_scene::CamSegment;
use slo_scene::animation::View;

/// The camera as it is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Held {
    pub(crate) view: View,
    /// Seconds of video time that the shutter stays open.
    pub(crate) shutter: f64,
}

/// Changes a segment such that the view `from`, of one of its frames, becomes `to`. The whole path moves
/// along: its other frames change by the same way, and by the same factors of the lens.
pub(crate) fn hold(segment: &mut CamSegment, from: &View, to: &Held) {
    let Held { view: to, shutter } = to;
    let shift =
        |points: &mut [DVec3], way: DVec3| points.iter_mut().for_each(|point| *point += way);
    shift(&mut segment.positions, to.position - from.position);
    shift(&mut segment.targets, to.target - from.target);
    if from.sky != to.sky {
        segment.sky = [to.sky; 2];
    }
    scale(&mut segment.fov, from.fov, to.fov);
    scale(&mut segment.dof, from.dof, to.dof);
    scale(&mut segment.lens_radius, from.lens_radius, to.lens_radius);
    segment.blur_duration = *shutter;
}

/// Multiplies numbers such that one between them becomes another.
fn scale(ends: &mut [f64; 2], from: f64, to: f64) {
    if from == to {
        return;
    }
    *ends =
        if ends[0] == ends[1] || from == 0.0 { [to; 2] } else { ends.map(|end| end * (to / from)) };
}

#[cfg(test)]
mod tests {
    use slo_scene::animation::view_at;

    use super::*;

    #[test]
    fn the_frame_sees_what_is_held() {
        let mut segment = CamSegment {
            name: "s".into(),
            video: [0.0, 1.0],
            scene: [0.0, 1.0],
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(3.0, 1.0, 0.0)],
            targets: vec![DVec3::Y * 5.0],
            sky: [DVec3::Z; 2],
            fov: [0.4, 0.6],
            dof: [5.0; 2],
            lens_radius: [0.0; 2],
            blur_duration: 0.0,
        };
        let from = view_at(&segment, 0.25);
        let to = View {
            position: from.position + DVec3::new(1.0, 2.0, 3.0),
            target: DVec3::ONE,
            fov: 0.2,
            dof: 7.0,
            lens_radius: 0.5,
            ..from
        };
        hold(&mut segment, &from, &Held { view: to, shutter: 0.01 });
        let seen = view_at(&segment, 0.25);
        assert!((seen.position - to.position).length() < 1e-12, "{seen:?}");
        assert!((seen.target - to.target).length() < 1e-12, "{seen:?}");
        assert!((seen.fov - 0.2).abs() < 1e-12, "{seen:?}");
        assert_eq!((seen.dof, seen.lens_radius, segment.blur_duration), (7.0, 0.5, 0.01));
    }
}
