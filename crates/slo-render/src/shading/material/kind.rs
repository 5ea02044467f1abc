//! Which columns describe a material.

use slo_scene::MaterialKind;

/// Which columns of the material table describe a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The thesis's lighting model.
    Phong,
    /// Physical surfaces.
    Principled,
    /// Two materials, one of which is chosen at each hit.
    Mix,
}

impl Kind {
    /// Returns the kind of a material of a scene.
    pub fn of(material: &slo_scene::Material) -> Self {
        match material.kind {
            MaterialKind::Phong(_) => Self::Phong,
            MaterialKind::Principled(_) => Self::Principled,
            MaterialKind::Mix(_) => Self::Mix,
        }
    }
}
