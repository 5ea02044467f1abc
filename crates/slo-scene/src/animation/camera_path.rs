//! Position and orientation of the camera along a camera segment.

use glam::DVec3;

use crate::description::CamSegment;

use super::bezier::bezier;
use super::mix::mix;
use super::orientation::{perpendicular, unit};

/// The camera at one time, in scene space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Centre of the lens.
    pub position: DVec3,
    /// Point that the camera looks at.
    pub target: DVec3,
    /// Upward direction; need not be unit.
    pub sky: DVec3,
    /// Half height of the view at distance 1.
    pub fov: f64,
    /// Distance of the sharp plane.
    pub dof: f64,
    /// Radius of the lens; 0 is a pinhole.
    pub lens_radius: f64,
}

/// The camera at `parameter` of a segment: 0 is its start, 1 its end. Scene space.
///
/// Position and target run along their Bézier curves, all else is linear (thesis 5.2). Where the
/// camera passes through its target, or looks straight along its sky, it keeps the orientation that
/// it had just before; at the start of the path, the one that it has just after.
pub fn view_at(segment: &CamSegment, parameter: f64) -> View {
    let view = free_view_at(segment, parameter);
    if axes(&view).is_some() {
        return view;
    }
    let Some([_, up, forward]) = last_axes(segment, parameter) else { return view };
    if unit(view.target - view.position).is_some() {
        View { sky: up, ..view }
    } else {
        View { sky: up, target: view.position + forward, ..view }
    }
}

/// The axes near a place of the path that has none: the last ones before it, or else the first ones
/// after it.
fn last_axes(segment: &CamSegment, parameter: f64) -> Option<[DVec3; 3]> {
    let axes_at = |parameter: f64| axes(&free_view_at(segment, parameter));
    for sign in [-1.0, 1.0] {
        let mut without = parameter;
        let mut step = f64::EPSILON;
        loop {
            let mut with = parameter + sign * step;
            if !(0.0..=1.0).contains(&with) {
                // The end of the path is looked at too.
                with = with.clamp(0.0, 1.0);
                if without == with {
                    break;
                }
            }
            if axes_at(with).is_some() {
                return axes_at(edge(with, without, |at| axes_at(at).is_some()));
            }
            without = with;
            step *= 2.0;
        }
    }
    None
}

/// The last number for which a condition holds, between one for which it holds and one for which it
/// does not.
fn edge(mut with: f64, mut without: f64, holds: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = with + (without - with) * 0.5;
        if middle == with || middle == without {
            return with;
        }
        if holds(middle) {
            with = middle;
        } else {
            without = middle;
        }
    }
}

fn free_view_at(segment: &CamSegment, parameter: f64) -> View {
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
pub fn between(a: &View, b: &View, u: f64) -> View {
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
/// `None` if the camera looks at its own place, or straight along its sky.
pub fn axes(view: &View) -> Option<[DVec3; 3]> {
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
    fn a_camera_that_passes_over_its_target_keeps_its_orientation() {
        let mut segment = segment("s", [0.0, 1.0], [0.0, 1.0]);
        segment.positions = vec![DVec3::new(0.0, -1.0, 8.0), DVec3::new(0.0, 1.0, 8.0)];
        let [right, up, forward] = axes(&view_at(&segment, 0.5)).unwrap();
        assert!((right - DVec3::X).length() < 1e-6, "{right}");
        assert!((up - DVec3::Y).length() < 1e-6, "{up}");
        assert!((forward - DVec3::NEG_Z).length() < 1e-6, "{forward}");
        // Through its target, and upside down by its sky.
        segment.positions = vec![DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
        segment.sky = [DVec3::Z, DVec3::NEG_Z];
        let [right, _, forward] = axes(&view_at(&segment, 0.5)).unwrap();
        assert!((right - DVec3::X).length() < 1e-6, "{right}");
        assert!((forward - DVec3::Y).length() < 1e-6, "{forward}");
    }

    #[test]
    fn the_orientation_is_kept_all_along_a_stretch_and_taken_from_behind_at_the_start() {
        let mut segment = segment("s", [0.0, 1.0], [0.0, 1.0]);
        // In the second half the sky is nearly what is looked along.
        segment.positions = vec![DVec3::new(0.0, 0.0, 8.0)];
        segment.targets = vec![DVec3::Y * 15e-9, DVec3::Y * 1e-9];
        let at = |parameter| axes(&view_at(&segment, parameter)).unwrap();
        for parameter in [0.0, 0.3, 0.6, 0.9, 1.0] {
            assert!((at(parameter)[1] - DVec3::Y).length() < 1e-6, "{parameter}");
        }
        segment.positions = vec![DVec3::new(0.0, 0.0, 8.0), DVec3::new(0.0, -3.0, 8.0)];
        segment.targets = vec![DVec3::ZERO];
        let [_, up, _] = axes(&view_at(&segment, 0.0)).unwrap();
        assert!((up - DVec3::Y).length() < 1e-6, "{up}");
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
