//! Kinds of rays.

/// Kinds of rays that are counted apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// Rays of the camera.
    Camera,
    /// Rays to lights.
    Shadow,
    /// Rays of mirrors and glass; where the thesis's integrator renders, of all lobes.
    Specular,
    /// Rays of other lobes that are not diffuse.
    Glossy,
    /// Rays of diffuse lobes.
    Diffuse,
    /// Rays that continue unbent behind what they hit.
    Passing,
}

impl RayKind {
    /// All kinds, each with its name, in the order of `Statistics::rays`.
    pub const NAMES: [(&'static str, Self); 6] = [
        ("camera", Self::Camera),
        ("shadow", Self::Shadow),
        ("specular", Self::Specular),
        ("glossy", Self::Glossy),
        ("diffuse", Self::Diffuse),
        ("passing", Self::Passing),
    ];
}
