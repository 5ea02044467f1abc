//! Rotations followed by translations, named by where they lead: `render_from_object`.

use glam::{DMat3, DVec3, Mat3, Vec3};

/// `x -> rotation x + translation`, with an orthonormal rotation; f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DRigid {
    /// Columns are the images of the axes; orthonormal, right-handed.
    pub rotation: DMat3,
    /// Image of the origin.
    pub translation: DVec3,
}

impl DRigid {
    /// Moves nothing.
    pub const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Where a point goes.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    /// The same transform in f32, into a space whose origin lies at `origin` of the old target.
    pub fn relative_to(&self, origin: DVec3) -> Rigid {
        Rigid {
            rotation: self.rotation.as_mat3(),
            translation: (self.translation - origin).as_vec3(),
        }
    }
}

/// `x -> rotation x + translation`, with an orthonormal rotation; f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Columns are the images of the axes; orthonormal, right-handed.
    pub rotation: Mat3,
    /// Image of the origin.
    pub translation: Vec3,
}

impl Rigid {
    /// Moves nothing.
    pub const IDENTITY: Self = Self { rotation: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// Where a point goes.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// Where a direction goes.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    /// Where a point came from.
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }

    /// Where a direction came from.
    pub fn inverse_vector(&self, v: Vec3) -> Vec3 {
        Vec3::new(
            self.rotation.x_axis.dot(v),
            self.rotation.y_axis.dot(v),
            self.rotation.z_axis.dot(v),
        )
    }
}
