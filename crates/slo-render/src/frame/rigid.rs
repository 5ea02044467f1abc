//! Rotations followed by translations in render space, named target first: `render_from_object`.

use glam::{DVec3, Mat3, Vec3};

use slo_scene::animation::DRigid;

/// The transform `x -> rotation x + translation`, with an orthonormal rotation; f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rigid {
    /// Orthonormal and right-handed. Its columns are the images of the axes.
    pub(super) rotation: Mat3,
    /// Image of the origin.
    pub(super) translation: Vec3,
}

impl Rigid {
    /// The identity.
    pub(super) const IDENTITY: Self = Self { rotation: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// Converts `rigid` to f32 and to a target space whose origin lies at `origin` of the old
    /// target space.
    pub(super) fn relative(rigid: &DRigid, origin: DVec3) -> Self {
        Self {
            rotation: rigid.rotation.as_mat3(),
            translation: (rigid.translation - origin).as_vec3(),
        }
    }

    /// Transforms a point.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// Transforms a vector.
    pub(super) fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    /// Transforms a point by the inverse.
    pub(super) fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }

    /// Transforms a vector by the inverse.
    pub(super) fn inverse_vector(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            self.rotation.x_axis.dot(v),
            self.rotation.y_axis.dot(v),
            self.rotation.z_axis.dot(v),
        )
    }
}
