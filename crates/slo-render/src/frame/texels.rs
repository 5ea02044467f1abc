//! The texels of light maps on surfaces of a frame.

use glam::Vec3;

use slo_scene::light_map::Layout;

/// The texels of the light map of an object, on one side of its surface.
#[derive(Debug)]
pub(crate) struct Texels {
    pub(super) side: u32,
    /// Index of the object.
    pub(super) object: u32,
    /// Number of its instance, or [`STILL`](super::world::STILL).
    pub(super) instance: u32,
    /// Id of its first primitive.
    pub(super) first: u32,
    /// Whether they lie on the inside of the surface.
    pub(super) inside: bool,
    pub(super) map: Map,
}

#[derive(Debug)]
pub(super) enum Map {
    Faces(Layout),
    /// A sphere in object space.
    Sphere {
        center: Vec3,
        radius: f32,
    },
}

/// A point of a surface that stands for a texel, or for a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelPoint {
    /// The primitive and its instance, as of a ray that hits the point.
    pub(crate) primitive: u32,
    pub(crate) instance: u32,
    pub(crate) uv: [f32; 2],
    /// In render space.
    pub(crate) point: Vec3,
    /// Unit, on the side whose light is wanted.
    pub(crate) normal: Vec3,
    /// Side of a texel there.
    pub(crate) width: f32,
}

impl Texels {
    /// Number of texels along each side.
    pub(crate) fn side(&self) -> u32 {
        self.side
    }

    /// Returns the index, row by row from the top, of the texel with texture coordinates on one side of
    /// the surface; `None` if it is the other side.
    pub(super) fn at(&self, [u, v]: [f32; 2], from_outside: bool) -> Option<usize> {
        let last = self.side - 1;
        let along = |c: f32| ((c * self.side as f32) as u32).min(last) as usize;
        let index = along(1.0 - v) * self.side as usize + along(u);
        (self.inside != from_outside).then_some(index)
    }

    /// Whether a texel lies on the surface, in column `x` and row `y` from the top.
    pub(crate) fn is_covered(&self, x: u32, y: u32) -> bool {
        match &self.map {
            Map::Faces(layout) => layout.is_covered(x, y),
            Map::Sphere { .. } => true,
        }
    }
}

/// The light map of an object, whose texels are the pixels of a frame.
#[derive(Debug)]
pub(crate) struct Baked {
    pub(crate) texels: Texels,
    /// Index of the material that texels have in place of their own: perfectly white and diffuse. The
    /// radiance of a texel is therefore its irradiance over pi.
    pub(crate) white: u32,
}

/// The light maps that `PHOTON_MAP` makes of photons, and reads where rays that gather light end.
#[derive(Debug, Default)]
pub(crate) struct LightMaps {
    pub(super) all: Vec<Texels>,
    /// For each object, the index of its light map, or a number that is none; empty if there are none.
    pub(super) of_objects: Vec<u32>,
}

impl LightMaps {
    /// The light maps of objects, of which there are `objects`.
    pub(super) fn new(all: Vec<Texels>, objects: usize) -> Self {
        let mut of_objects = Vec::new();
        if !all.is_empty() {
            of_objects.resize(objects, u32::MAX);
        }
        for (number, texels) in (0..).zip(&all) {
            of_objects[texels.object as usize] = number;
        }
        Self { all, of_objects }
    }

    /// The texels of all light maps.
    pub(crate) fn all(&self) -> &[Texels] {
        &self.all
    }
}
