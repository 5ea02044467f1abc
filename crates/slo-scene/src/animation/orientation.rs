//! Two vectors -> a rotation, by Gram-Schmidt.

use glam::{DMat3, DVec3};

/// Sine of the angle below which two directions count as parallel, and length (of the control
/// points') below which a vector counts as zero.
///
/// What is left of a vector after a part of it was subtracted is wrong by about 1e-16 of the
/// vector; above this limit its direction is good to 1e-7 radians, far below a pixel.
pub(super) const DEGENERATE: f64 = 1e-9;

/// The vector at length 1, whatever its length; `None` for 0 and for what is not finite.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    // scaled first: squares of lengths below 1e-154 or above 1e154 leave f64
    (largest > 0.0 && v.is_finite()).then(|| (v / largest).normalize())
}

/// The part of `v` at right angles to the unit vector `axis`, at length 1; `None` if they are
/// parallel or `v` is 0.
pub(super) fn perpendicular(axis: DVec3, v: DVec3) -> Option<DVec3> {
    let direction = unit(v)?;
    let rest = direction - axis * axis.dot(direction);
    (rest.length() > DEGENERATE).then(|| {
        let rest = rest.normalize();
        // once more: the first pass leaves rounding / |rest| along the axis
        (rest - axis * axis.dot(rest)).normalize()
    })
}

/// The rotation with columns (right, forward, up): `right` normalised, `up` made orthogonal to
/// it, forward = up x right. `None` if up is parallel to right, or one of them is 0.
pub(super) fn orientation(right: DVec3, up: DVec3) -> Option<DMat3> {
    let right = unit(right)?;
    let up = perpendicular(right, up)?;
    Some(DMat3::from_cols(right, up.cross(right), up))
}

/// Whether these two give an object an orientation: whoever asks decides by the rule by which it is
/// made.
pub fn have_orientation(right: DVec3, up: DVec3) -> bool {
    orientation(right, up).is_some()
}

/// Sine and cosine of an angle in degrees; exact for quarter turns.
pub fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let degrees = degrees % 360.0;
    let quarters = (degrees / 90.0).round();
    let rest = (degrees - 90.0 * quarters).to_radians();
    let (sine, cosine) = (libm::sin(rest), libm::cos(rest));
    match quarters.rem_euclid(4.0) {
        0.0 => (sine, cosine),
        1.0 => (cosine, -sine),
        2.0 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// The rotation about a unit axis, counter-clockwise seen from its tip.
pub fn about(axis: DVec3, degrees: f64) -> DMat3 {
    let (sine, cosine) = sin_cos_deg(degrees);
    let turned =
        |v: DVec3| v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine));
    DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_x_and_up_z_turn_nothing() {
        assert_eq!(orientation(DVec3::X * 3.0, DVec3::Z * 0.2), Some(DMat3::IDENTITY));
    }

    #[test]
    fn a_quarter_turn_about_z() {
        // x goes to y, y to -x
        let turn = orientation(DVec3::Y, DVec3::Z).unwrap();
        assert_eq!(turn * DVec3::new(1.0, 2.0, 3.0), DVec3::new(-2.0, 1.0, 3.0));
    }

    #[test]
    fn angles_in_degrees() {
        for (degrees, expected) in [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (-90.0, (-1.0, 0.0))] {
            assert_eq!(sin_cos_deg(degrees), expected);
            assert_eq!(sin_cos_deg(degrees + 720.0), expected);
            assert_eq!(sin_cos_deg(degrees - 36e9), expected);
        }
        for degrees in (-80..80).map(|i| f64::from(i) * 10.3) {
            let (sine, cosine) = sin_cos_deg(degrees);
            assert!((sine - libm::sin(degrees.to_radians())).abs() < 1e-14, "{degrees}");
            assert!((cosine - libm::cos(degrees.to_radians())).abs() < 1e-14, "{degrees}");
        }
        assert_eq!(about(DVec3::Z, 90.0), DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z));
        let third = about(DVec3::ONE.normalize(), 120.0) * DVec3::X;
        assert!((third - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn up_gives_way_to_right() {
        let turn = orientation(DVec3::X, DVec3::new(5.0, 0.0, 5.0)).unwrap();
        assert!((turn - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-15));
    }

    #[test]
    fn is_a_rotation_for_any_pair_of_lengths_and_angles() {
        for angle in [1.0, 1e-2, 1e-4, 1e-6, 3e-9] {
            for scale in [1e-300, 1e-3, 1.0, 1e9, 1e300] {
                let right = DVec3::new(0.3, -0.2, 0.9).normalize();
                let up = (right + DVec3::new(0.0, angle * 2.0, 0.1 * angle)) * scale;
                let turn = orientation(right / scale, up).unwrap();
                let error = turn.transpose() * turn - DMat3::IDENTITY;
                assert!(error.to_cols_array().iter().all(|x| x.abs() < 1e-15), "{angle} {scale}");
                assert!((turn.determinant() - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn parallel_and_vanished_vectors_have_none() {
        assert_eq!(orientation(DVec3::X, DVec3::NEG_X * 7.0), None);
        assert_eq!(orientation(DVec3::ZERO, DVec3::Z), None);
        assert_eq!(orientation(DVec3::X, DVec3::ZERO), None);
        assert_eq!(orientation(DVec3::X, DVec3::NAN), None);
        assert_eq!(orientation(DVec3::INFINITY, DVec3::Z), None);
    }
}
