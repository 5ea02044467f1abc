//! Maps from object space to render space, named target first: `render_from_object`.

use glam::{DMat3, DVec3, Mat3, Vec3};

use slo_accel::instances;
use slo_accel::math::rounding::UNIT_ROUNDOFF;
use slo_scene::animation::DAffine;

/// The transform `x -> linear x + translation`, with its inverse; f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    /// Inverse of `linear`; exactly its transpose if the map is rigid.
    inverse: Mat3,
    /// Image of the origin.
    pub(super) translation: Vec3,
    /// Its columns are the images of the axes. It never mirrors.
    pub(super) linear: Mat3,
    /// Whether `linear` is a rotation.
    pub(super) is_rigid: bool,
}

impl Affine {
    /// The identity.
    pub(super) const IDENTITY: Self = Self {
        inverse: Mat3::IDENTITY,
        translation: Vec3::ZERO,
        linear: Mat3::IDENTITY,
        is_rigid: true,
    };

    /// Converts `affine` to f32 and to a target space whose origin lies at `origin` of the old
    /// target space.
    pub(super) fn relative(affine: &DAffine, origin: DVec3) -> Self {
        Self::of(affine.linear.as_mat3(), (affine.translation - origin).as_vec3())
    }

    /// The map `x -> linear x + translation`.
    pub(super) fn of(linear: Mat3, translation: Vec3) -> Self {
        let wide = linear.as_dmat3();
        // The products of columns of a rotation are rounded twice.
        let rest = (wide.transpose() * wide - DMat3::IDENTITY).to_cols_array();
        let is_rigid = rest.iter().all(|c| c.abs() <= 2.5 * f64::from(UNIT_ROUNDOFF));
        let inverse = if is_rigid { linear.transpose() } else { wide.inverse().as_mat3() };
        Self { inverse, translation, linear, is_rigid }
    }

    /// The map as structures know it.
    pub(super) fn placed(&self) -> instances::Affine {
        instances::Affine { matrix: self.linear, translation: self.translation }
    }

    /// Transforms a point.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation
    }

    /// Transforms a vector.
    pub(super) fn vector(&self, v: Vec3) -> Vec3 {
        self.linear * v
    }

    /// Transforms a normal, by the inverse transpose. Its length changes, in proportion for all
    /// normals that are interpolated together.
    pub(super) fn normal(&self, n: Vec3) -> Vec3 {
        let Mat3 { x_axis, y_axis, z_axis } = self.inverse;
        Vec3::new(x_axis.dot(n), y_axis.dot(n), z_axis.dot(n))
    }

    /// Transforms the direction of a vector that keeps its length.
    pub(super) fn direction(&self, v: Vec3) -> Vec3 {
        let image = self.vector(v);
        let length = image.length();
        let is_kept = self.is_rigid || length == 0.0;
        if is_kept { image } else { image * (v.length() / length) }
    }

    /// Transforms a point by the inverse.
    pub(super) fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }

    /// Transforms a vector by the inverse.
    pub(super) fn inverse_vector(&self, v: Vec3) -> Vec3 {
        self.inverse * v
    }

    /// Returns the unit normal whose image is a unit normal.
    pub(super) fn inverse_normal(&self, n: Vec3) -> Vec3 {
        if self.is_rigid {
            self.inverse_vector(n)
        } else {
            let Mat3 { x_axis, y_axis, z_axis } = self.linear;
            Vec3::new(x_axis.dot(n), y_axis.dot(n), z_axis.dot(n)).normalize_or(n)
        }
    }

    /// Bounds the absolute coordinates from which the image of a point is computed, given those of
    /// the point.
    pub(super) fn magnitude(&self, of: Vec3) -> Vec3 {
        let image = abs_product(&self.linear, of) + self.translation.abs();
        if self.is_rigid { image } else { image + self.round_trip(image) }
    }

    /// Bounds the absolute values that are added when a point with these bounds goes to object space
    /// and back.
    pub(super) fn round_trip(&self, of: Vec3) -> Vec3 {
        abs_product(&self.linear, abs_product(&self.inverse, of + self.translation.abs()))
    }
}

/// Returns |m| v, with absolute values by components.
fn abs_product(m: &Mat3, v: Vec3) -> Vec3 {
    m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::animation::DRigid;

    fn turned() -> DRigid {
        let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 0.7);
        DRigid { rotation, translation: DVec3::new(5.0, -3.0, 2.0) }
    }

    #[test]
    fn a_stretch_maps_points_back_and_keeps_normals_normal() {
        let stretch = DAffine::scaled(DVec3::new(3.0, 0.5, 2.0), turned());
        let sheared = stretch.after(&DAffine::scaled(DVec3::new(1.0, 2.0, 7.0), turned()));
        for affine in [stretch, sheared, turned().into()] {
            let affine = Affine::relative(&affine, DVec3::ONE);
            let p = Vec3::new(0.3, -0.7, 1.1);
            assert!((affine.inverse_point(affine.point(p)) - p).length() < 1e-5);
            let (n, along) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.8, 2.0, -0.6));
            let image = affine.normal(n).normalize();
            assert!(image.dot(affine.vector(along)).abs() < 1e-5);
            assert!((affine.inverse_normal(image) - n).length() < 1e-5);
            assert!((affine.direction(along).length() - along.length()).abs() < 1e-5);
            assert!(affine.magnitude(p.abs()).cmpge(affine.point(p).abs()).all());
        }
    }

    #[test]
    fn a_rigid_map_computes_as_by_its_rotation() {
        let affine = Affine::relative(&turned().into(), DVec3::ONE);
        let rotation = turned().rotation.as_mat3();
        let v = Vec3::new(0.3, -0.7, 1.1);
        let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
        assert_eq!(affine.inverse_vector(v), Vec3::from(axes.map(|axis| axis.dot(v))));
        assert_eq!((affine.normal(v), affine.vector(v)), (rotation * v, rotation * v));
    }
}
