//! Rotations followed by translations, named by where they lead: `render_from_object`.

use glam::{DMat3, DVec3};

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

    /// Image of a point.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }
}
