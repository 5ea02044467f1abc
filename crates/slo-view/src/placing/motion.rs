//! How a thing is moved, turned or scaled, in scene space.

use glam::{DMat3, DQuat, DVec3};

/// How a thing is moved, turned or scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// By this way, in scene space.
    Move(DVec3),
    /// About a unit axis of scene space, by degrees.
    Turn(DVec3, f64),
    /// By factors along its own axes.
    Scale(DVec3),
}

/// Degrees about x, then about y, then about z, that make a rotation.
pub(super) fn angles_of(rotation: &DMat3) -> DVec3 {
    let DMat3 { x_axis, y_axis, z_axis } = *rotation;
    let sine = (-x_axis.z).clamp(-1.0, 1.0);
    let angles = if sine.abs() > 1.0 - 1e-12 {
        // Looking along z, turns about x and z are the same.
        [libm::atan2(-z_axis.y, y_axis.y), libm::asin(sine), 0.0]
    } else {
        [libm::atan2(y_axis.z, z_axis.z), libm::asin(sine), libm::atan2(x_axis.y, x_axis.x)]
    };
    DVec3::from(angles.map(f64::to_degrees))
}

/// The unit axis and the degrees of a rotation.
pub(super) fn axis_of(rotation: &DMat3) -> (DVec3, f64) {
    let turn = DQuat::from_mat3(rotation).normalize();
    let axis = DVec3::new(turn.x, turn.y, turn.z);
    let degrees = 2.0 * libm::atan2(axis.length(), turn.w).to_degrees();
    let (axis, degrees) = if degrees > 180.0 { (-axis, 360.0 - degrees) } else { (axis, degrees) };
    (axis.normalize_or(DVec3::Z), degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(axis: DVec3, degrees: f64) -> DMat3 {
        DMat3::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians()))
    }

    #[test]
    fn rotations_are_angles() {
        for angles in
            [[10.0, 20.0, 30.0], [-170.0, 80.0, 5.0], [0.0, 0.0, -90.0], [40.0, 90.0, 0.0]]
        {
            let [x, y, z] = angles;
            let rotation = about(DVec3::Z, z) * about(DVec3::Y, y) * about(DVec3::X, x);
            let found = angles_of(&rotation);
            let again =
                about(DVec3::Z, found.z) * about(DVec3::Y, found.y) * about(DVec3::X, found.x);
            let error = (again - rotation)
                .to_cols_array()
                .into_iter()
                .fold(0.0, |a: f64, b| a.max(b.abs()));
            assert!(error < 1e-9, "{angles:?}: {found}");
        }
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let (found, degrees) = axis_of(&about(axis, 200.0));
        assert!((found + axis).length() < 1e-9 && (degrees - 160.0).abs() < 1e-9);
    }
}
