//! Where the camera is and how it looks, along a camera segment.

use glam::DVec3;

use crate::camera::View;
use crate::scene::CamSegment;

use super::orientation::{perpendicular, unit};
use super::{bezier, mix};

/// The camera at `parameter` of a segment: 0 is its start, 1 its end. Scene space.
///
/// Position and target run along their Bézier curves, all else is linear (thesis 5.2).
pub fn view_at(segment: &CamSegment, parameter: f64) -> View {
    let linear = |ends: [f64; 2]| mix(ends[0], ends[1], parameter);
    View {
        position: bezier(&segment.positions, parameter),
        target: bezier(&segment.targets, parameter),
        sky: bezier(&segment.sky, parameter),
        fov: linear(segment.fov),
        dof: linear(segment.dof),
        lens_radius: linear(segment.lens_radius),
    }
}

/// The view between `a` (`u` = 0) and `b` (`u` = 1), every component linear.
pub(super) fn between(a: &View, b: &View, u: f64) -> View {
    let vector = |a: DVec3, b: DVec3| bezier(&[a, b], u);
    View {
        position: vector(a.position, b.position),
        target: vector(a.target, b.target),
        sky: vector(a.sky, b.sky),
        fov: mix(a.fov, b.fov, u),
        dof: mix(a.dof, b.dof, u),
        lens_radius: mix(a.lens_radius, b.lens_radius, u),
    }
}

/// Unit vectors to the right of the picture, to its top, and into it: R = D x sky, U = R x D,
/// D = target - position (thesis 5.6 to 5.9).
///
/// `None` where the camera looks at its own place, or straight along its sky.
pub(super) fn axes(view: &View) -> Option<[DVec3; 3]> {
    let forward = unit(view.target - view.position)?;
    let up = perpendicular(forward, view.sky)?;
    Some([forward.cross(up), up, forward])
}

#[cfg(test)]
mod tests {
    use super::super::clock::tests::segment;
    use super::*;

    #[test]
    fn a_segment_runs_from_start_to_end() {
        let mut segment = segment("s", [0.0, 1.0], [0.0, 1.0]);
        segment.positions = vec![DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::Y];
        segment.targets = vec![DVec3::ZERO, DVec3::Z];
        segment.sky = [DVec3::Z, DVec3::X];
        segment.fov = [0.25, 0.75];
        segment.dof = [4.0, 8.0];
        segment.lens_radius = [0.0, 0.5];
        let middle = view_at(&segment, 0.5);
        assert_eq!(middle.position, DVec3::new(0.75, 1.25, 0.0)); // (p0 + 2 p1 + p2) / 4
        assert_eq!(middle.target, DVec3::new(0.0, 0.0, 0.5));
        assert_eq!(middle.sky, DVec3::new(0.5, 0.0, 0.5));
        assert_eq!((middle.fov, middle.dof, middle.lens_radius), (0.5, 6.0, 0.25));
        assert_eq!(view_at(&segment, 0.0).position, DVec3::X);
        let end = view_at(&segment, 1.0);
        assert_eq!((end.position, end.target, end.sky), (DVec3::Y, DVec3::Z, DVec3::X));
        assert_eq!((end.fov, end.dof, end.lens_radius), (0.75, 8.0, 0.5));
    }

    #[test]
    fn axes_of_a_camera_that_looks_north() {
        let segment = segment("s", [0.0, 1.0], [0.0, 1.0]);
        let pose = view_at(&segment, 0.0); // from (0, -10, 0) along y, sky z
        assert_eq!(axes(&pose), Some([DVec3::X, DVec3::Z, DVec3::Y]));
        let tilted = View { sky: DVec3::new(0.0, 5.0, 3.0) * 1e-200, ..pose };
        assert_eq!(axes(&tilted).map(|[right, ..]| right), Some(DVec3::X));
    }

    #[test]
    fn a_camera_that_sees_nothing_has_no_axes() {
        let pose = view_at(&segment("s", [0.0, 1.0], [0.0, 1.0]), 0.0);
        assert_eq!(axes(&View { target: pose.position, ..pose }), None);
        assert_eq!(axes(&View { sky: DVec3::NEG_Y * 3.0, ..pose }), None);
        assert_eq!(axes(&View { sky: DVec3::ZERO, ..pose }), None);
    }
}
