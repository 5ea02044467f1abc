//! Moves of a view: about a point, along its axes, on the spot.

use glam::{DQuat, DVec3};
use slo_scene::animation::View;

/// Least sine between the view and its sky after a move.
const LEAST_SINE: f64 = 0.01;

/// A move of the camera. Angles are radians; positive ones turn the view to the right and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Move {
    /// The camera goes around the point.
    Orbit(f64, f64),
    /// The camera turns on the spot.
    Turn(f64, f64),
    /// The camera goes to the right, up and forward, by shares of its distance from the point.
    Walk(DVec3),
    /// The camera's distance from the point is multiplied.
    Dolly(f64),
    /// The camera looks at the point along an axis.
    Along(DVec3),
}

/// Returns the view after a move; `pivot` is the point that it is about.
pub(crate) fn moved(view: &View, by: Move, pivot: DVec3) -> View {
    match by {
        Move::Orbit(yaw, pitch) => turned(view, yaw, pitch, pivot),
        Move::Turn(yaw, pitch) => turned(view, yaw, -pitch, view.position),
        Move::Walk(by) => {
            let [right, up, forward] = axes(view);
            let distance = (pivot - view.position).length().max(f64::MIN_POSITIVE);
            let way = (right * by.x + up * by.y + forward * by.z) * distance;
            View { position: view.position + way, target: view.target + way, ..*view }
        }
        Move::Dolly(factor) => {
            let from_pivot = |point: DVec3| pivot + (point - pivot) * factor;
            View { position: from_pivot(view.position), target: from_pivot(view.target), ..*view }
        }
        Move::Along(axis) => {
            let distance = (pivot - view.position).length();
            let sky = view.sky.normalize_or(DVec3::Z);
            // Looking along the sky, the picture's top is where the camera looked before.
            let [_, _, forward] = axes(view);
            let flat =
                (forward - axis * forward.dot(axis)).normalize_or(axis.any_orthonormal_vector());
            let sky = if sky.cross(axis).length() < LEAST_SINE { flat } else { view.sky };
            View { position: pivot + axis * distance, target: pivot, sky, ..*view }
        }
    }
}

/// Turns a view about a point: clockwise around its sky, seen from above, and then down, but never over the
/// top.
fn turned(view: &View, yaw: f64, pitch: f64, about: DVec3) -> View {
    let sky = view.sky.normalize_or(DVec3::Z);
    let turn = |view: &View, rotation: DQuat| View {
        position: about + rotation * (view.position - about),
        target: about + rotation * (view.target - about),
        ..*view
    };
    let around = turn(view, DQuat::from_axis_angle(sky, -yaw));
    let [right, _, _] = axes(&around);
    let up = turn(&around, DQuat::from_axis_angle(right, -pitch));
    let forward = (up.target - up.position).normalize_or_zero();
    if forward.cross(sky).length() < LEAST_SINE || axes(&up)[0].dot(right) < 0.0 {
        return around;
    }
    up
}

/// Unit vectors to the right, up and forward.
pub(crate) fn axes(view: &View) -> [DVec3; 3] {
    let forward = (view.target - view.position).normalize_or(DVec3::Y);
    let side = forward.cross(view.sky);
    let right = side.normalize_or(forward.any_orthonormal_vector());
    [right, right.cross(forward), forward]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const VIEW: View = View {
        position: DVec3::new(0.0, -10.0, 0.0),
        target: DVec3::ZERO,
        sky: DVec3::Z,
        fov: 0.5,
        dof: 10.0,
        lens_radius: 0.0,
    };

    fn check(by: Move, pivot: DVec3, position: [f64; 3], target: [f64; 3]) {
        let view = moved(&VIEW, by, pivot);
        for (found, expected) in [(view.position, position), (view.target, target)] {
            assert!((found - DVec3::from(expected)).length() < 1e-9, "{by:?}: {view:?}");
        }
    }

    #[test]
    fn the_camera_goes_around_a_point() {
        // What is seen turns to the right: the camera goes to the left.
        check(Move::Orbit(FRAC_PI_2, 0.0), DVec3::ZERO, [-10.0, 0.0, 0.0], [0.0; 3]);
        check(
            Move::Orbit(0.0, 0.5),
            DVec3::ZERO,
            [0.0, -10.0 * libm::cos(0.5), 10.0 * libm::sin(0.5)],
            [0.0; 3],
        );
        check(Move::Orbit(FRAC_PI_2, 0.0), DVec3::Y, [-11.0, 1.0, 0.0], [-1.0, 1.0, 0.0]);
    }

    #[test]
    fn the_camera_turns_on_the_spot() {
        check(Move::Turn(FRAC_PI_2, 0.0), DVec3::ZERO, [0.0, -10.0, 0.0], [10.0, -10.0, 0.0]);
        let up = moved(&VIEW, Move::Turn(0.0, 0.3), DVec3::ZERO);
        assert!(up.target.z > 0.0 && up.position == VIEW.position, "{up:?}");
    }

    #[test]
    fn the_camera_never_turns_over() {
        for pitch in [1.565, 2.0, 3.0, -1.565, -2.0] {
            for by in [Move::Orbit(0.0, pitch), Move::Turn(0.0, pitch)] {
                assert_eq!(moved(&VIEW, by, DVec3::ZERO), VIEW, "{by:?}");
            }
        }
    }

    #[test]
    fn steps_are_shares_of_the_distance() {
        check(
            Move::Walk(DVec3::new(0.1, 0.2, 0.5)),
            DVec3::ZERO,
            [1.0, -5.0, 2.0],
            [1.0, 5.0, 2.0],
        );
        check(Move::Dolly(0.5), DVec3::ZERO, [0.0, -5.0, 0.0], [0.0; 3]);
    }

    #[test]
    fn axes_keep_the_distance() {
        check(Move::Along(DVec3::X), DVec3::ZERO, [10.0, 0.0, 0.0], [0.0; 3]);
        let above = moved(&VIEW, Move::Along(DVec3::Z), DVec3::ZERO);
        assert_eq!((above.position, above.sky), (DVec3::Z * 10.0, DVec3::Y));
    }
}
