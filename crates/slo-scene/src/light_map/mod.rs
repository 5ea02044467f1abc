//! Light maps: images that hold the irradiance of an object by its texture coordinates.

mod layout;

pub use layout::{Layout, Place};

/// Most texels along a side of a light map.
pub const MOST_TEXELS: u32 = 8192;

/// The light map of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightMap {
    /// `lightMap`: texels along each side; 1 or more.
    pub side: u32,
    /// `lightMapInside`: whether it holds the irradiance of the inside of the surface, which outward
    /// normals do not point to.
    pub inside: bool,
}

/// Where a surface lies in an image that is looked up by its texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Unwrapped {
    /// Each triangle has corners in the image, in the order of its vertices. Triangles are in the order
    /// of the shape.
    Faces(Vec<[[f32; 2]; 3]>),
    /// A sphere fills the unit square.
    Sphere,
}

impl Unwrapped {
    /// A rectangle of two triangles that fills the unit square.
    pub(crate) fn rectangle() -> Self {
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        Self::Faces(vec![[a, b, c], [a, c, d]])
    }
}
