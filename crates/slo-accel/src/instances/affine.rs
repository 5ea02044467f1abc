//! Affine maps, and how exactly a ray is taken through one.

use glam::{DMat3, Mat3, Vec3, Vec4};

use crate::math::rounding::UNIT_ROUNDOFF;
use crate::rays::{LANES, Rays};

/// The map `x -> matrix x + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Its columns are the images of the axes.
    pub matrix: Mat3,
    /// The image of the origin.
    pub translation: Vec3,
}

impl Affine {
    /// The identity.
    pub const IDENTITY: Self = Self { matrix: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// Transforms a point.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.matrix * p + self.translation
    }

    /// Transforms a vector.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.matrix * v
    }
}

/// The inverse of an affine map: `x -> matrix (x - center)`.
///
/// Points are taken relative to the centre before they are turned, so that a ray that starts near
/// an instance keeps its digits however far both are from the origin.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Inverse {
    /// Columns of the matrix, each with a coordinate of the centre behind it.
    columns: [[f32; 4]; 3],
}

impl Inverse {
    /// The inverse of a map; none if it has none in f32.
    pub(super) fn of(map: &Affine) -> Option<Self> {
        let inverse = inverse(map)?;
        let column = |i: usize| {
            let [x, y, z] = inverse.col(i).as_vec3().to_array();
            [x, y, z, map.translation[i]]
        };
        let columns = [column(0), column(1), column(2)];
        columns.as_flattened().iter().all(|x| x.is_finite()).then_some(Self { columns })
    }

    /// Takes a ray to the space before the map: origin and direction.
    #[inline(always)]
    pub(super) fn ray(&self, origin: Vec3, direction: Vec3) -> (Vec3, Vec3) {
        let [x, y, z] = self.columns.map(Vec4::from_array);
        let p = origin - Vec3::new(x.w, y.w, z.w);
        let d = direction;
        let origin = (x * p.x + y * p.y) + z * p.z;
        let direction = (x * d.x + y * d.y) + z * d.z;
        (origin.truncate(), direction.truncate())
    }
}

impl Inverse {
    /// Takes sixteen rays, the neighbours from `first` on, as [`ray`](Self::ray) does each: x, y and z of
    /// their origins, then of their directions.
    #[inline(always)]
    pub(super) fn neighbours(&self, rays: &Rays, first: usize, to: &mut [[f32; LANES]; 6]) {
        let [x, y, z] = self.columns;
        let lanes = |column: &Vec<f32>| -> [f32; LANES] {
            column[first..first + LANES].try_into().unwrap_or([0.0; LANES])
        };
        let [ox, oy, oz] = [lanes(&rays.origin[0]), lanes(&rays.origin[1]), lanes(&rays.origin[2])];
        let [dx, dy, dz] =
            [lanes(&rays.direction[0]), lanes(&rays.direction[1]), lanes(&rays.direction[2])];
        for axis in 0..3 {
            for lane in 0..LANES {
                let p = [ox[lane] - x[3], oy[lane] - y[3], oz[lane] - z[3]];
                to[axis][lane] = (x[axis] * p[0] + y[axis] * p[1]) + z[axis] * p[2];
                to[3 + axis][lane] = (x[axis] * dx[lane] + y[axis] * dy[lane]) + z[axis] * dz[lane];
            }
        }
    }
}

/// The inverse of the matrix of a map; none if it is not finite. That of a rotation that was rounded
/// to f32 is its transpose.
fn inverse(map: &Affine) -> Option<DMat3> {
    let matrix = map.matrix.as_dmat3();
    let determinant = matrix.determinant();
    let squares = (matrix.transpose() * matrix - DMat3::IDENTITY).to_cols_array();
    let is_rotation = squares.iter().all(|x| x.abs() <= 2.5 * f64::from(UNIT_ROUNDOFF));
    let inverse = if is_rotation { matrix.transpose() } else { matrix.inverse() };
    (determinant != 0.0 && map.translation.is_finite() && inverse.is_finite()).then_some(inverse)
}

/// By how much a hit that was found in the space before a map may lie outside of what was hit,
/// taken through the map.
///
/// A ray `o + t d` becomes `fl(A fl(o - c)) + t fl(A d)`, where `A` is the rounded inverse of the
/// matrix `M`, and `c` the translation. Each coordinate of a point of this ray makes at most five
/// roundings, and three more by the inverse of a rotation; `t |d|` is at most the distance of the
/// origin and that of the hit from the centre, so the point is off by
/// `8 u |M| |A| (2 |o - c| + |p - c|)` for a hit `p`. The test of the primitive
/// adds its own error, in units of the hit and of `A (o - c)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Error {
    /// As it is.
    pub(super) absolute: f32,
    /// In units of the largest coordinate of the ray's origin.
    pub(super) of_origin: f32,
}

/// More of [`Error::of_origin`] would widen the boxes of all other places too far. Only maps that
/// flatten, and shear what they have flattened, reach it: their boxes may then be missed by rays
/// that graze them.
const MOST_OF_ORIGIN: f32 = 4096.0 * UNIT_ROUNDOFF;

impl Error {
    pub(super) const NONE: Self = Self { absolute: 0.0, of_origin: 0.0 };

    /// The larger of both, in each way.
    pub(super) fn larger(self, other: Self) -> Self {
        Self {
            absolute: self.absolute.max(other.absolute),
            of_origin: self.of_origin.max(other.of_origin),
        }
    }

    /// The error behind a map. `before` is the error of hits in the space before it; whether it
    /// `is_along_axes` in the sense that what belongs to the origin holds for each axis by itself.
    /// `size` is the largest coordinate of what lies there.
    pub(super) fn behind(map: &Affine, before: Self, is_along_axes: bool, size: f32) -> Self {
        let Some(inverse) = inverse(map) else { return before };
        let (matrix, inverse) = (map.matrix.abs(), inverse.as_mat3().abs());
        let both = row_sum(&(matrix * inverse));
        let (forward, center) = (row_sum(&matrix), map.translation.abs().max_element());
        let factor = if is_along_axes { both } else { forward * row_sum(&inverse) };
        let of_origin = before.of_origin * factor + 16.0 * UNIT_ROUNDOFF * both;
        // The box itself is made with a few roundings too.
        let of_size = forward * size * (8.0 * both + 8.0) * UNIT_ROUNDOFF;
        let of_center = center * (of_origin + 8.0 * UNIT_ROUNDOFF);
        Self {
            absolute: forward * before.absolute + of_size + of_center,
            of_origin: of_origin.min(MOST_OF_ORIGIN),
        }
    }
}

/// The largest sum of a row of a matrix without negative numbers.
fn row_sum(matrix: &Mat3) -> f32 {
    (matrix.x_axis + matrix.y_axis + matrix.z_axis).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_taken_back() {
        let map = Affine {
            matrix: Mat3::from_cols(Vec3::Y * 2.0, Vec3::NEG_X, Vec3::new(0.0, 0.5, 4.0)),
            translation: Vec3::new(1.0, -2.0, 3.0),
        };
        let inverse = Inverse::of(&map).expect("it has one");
        let (p, v) = (Vec3::new(0.25, -3.0, 0.5), Vec3::new(1.0, 2.0, -0.5));
        assert_eq!(inverse.ray(map.point(p), map.vector(v)), (p, v));
        let flat = Affine { matrix: Mat3::from_diagonal(Vec3::new(1.0, 0.0, 1.0)), ..map };
        assert!(Inverse::of(&flat).is_none());
        let tiny = Affine { matrix: Mat3::from_diagonal(Vec3::splat(1e-40)), ..map };
        assert!(Inverse::of(&tiny).is_none());
        let lost = Affine { translation: Vec3::new(0.0, f32::NAN, 0.0), ..map };
        assert!(Inverse::of(&lost).is_none());
    }

    #[test]
    fn rotations_are_transposed() {
        let matrix = Mat3::from_rotation_z(0.7) * Mat3::from_rotation_x(0.4);
        let map = Affine { matrix, ..Affine::IDENTITY };
        let inverse = Inverse::of(&map).expect("it has one");
        let v = Vec3::new(0.3, -2.0, 0.7);
        assert_eq!(inverse.ray(v, v), (matrix.transpose() * v, matrix.transpose() * v));
    }

    #[test]
    fn rotation_and_scale_along_axes_keep_errors_small() {
        let turn = Mat3::from_rotation_z(0.7) * Mat3::from_rotation_x(0.4);
        let map = Affine {
            matrix: turn * Mat3::from_diagonal(Vec3::new(1.0, 1e-3, 5.0)),
            translation: Vec3::ZERO,
        };
        let error = Error::behind(&map, Error::NONE, true, 1.0);
        assert!(error.of_origin < 49.0 * UNIT_ROUNDOFF, "{error:?}");
        assert!(Error::behind(&map, Error::NONE, false, 1.0).of_origin >= error.of_origin);
    }
}
