//! Rotations followed by translations in render space, named by where they lead: `render_from_object`.

use glam::{DVec3, Mat3, Vec3};

use slo_scene::animation::DRigid;

/// `x -> rotation x + translation`, with an orthonormal rotation; f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rigid {
    /// Columns are the images of the axes; orthonormal, right-handed.
    pub(super) rotation: Mat3,
    /// Image of the origin.
    pub(super) translation: Vec3,
}

impl Rigid {
    /// Moves nothing.
    pub(super) const IDENTITY: Self = Self { rotation: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// The same transform as `rigid`, into a space whose origin lies at `origin` of the old target.
    pub(super) fn relative(rigid: &DRigid, origin: DVec3) -> Self {
        Self {
            rotation: rigid.rotation.as_mat3(),
            translation: (rigid.translation - origin).as_vec3(),
        }
    }

    /// Where a point goes.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// Where a direction goes.
    pub(super) fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    /// Where a point came from.
    pub(super) fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }

    /// Where a direction came from.
    pub(super) fn inverse_vector(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            self.rotation.x_axis.dot(v),
            self.rotation.y_axis.dot(v),
            self.rotation.z_axis.dot(v),
        )
    }
}
