//! What objects of one mesh share: it is made once, however many there are.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::sampled_motion::ObjectBox;
use super::shapes::Geometry;
use slo_accel::Structure;
use slo_scene::{Mesh, Shape};

/// Still objects of one mesh are copied into the structure of all still objects, unless they have
/// more triangles than this together. Then they become instances, which take about as much memory
/// for each as two triangles do.
pub(super) const MOST_COPIED: usize = 1 << 20;

/// What the objects of each mesh share, by the address of the mesh: meshes live as long as the
/// scene does.
#[derive(Default)]
pub(super) struct Shared(HashMap<usize, Common>);

/// What the objects of one mesh share. It is in object space; the structure is translated so that
/// the middle of the mesh is its origin.
#[derive(Default)]
pub(super) struct Common {
    /// Objects that are made of the mesh.
    objects: usize,
    about: Option<ObjectBox>,
    pub(super) structure: Option<Arc<Structure>>,
    pub(super) normals: Option<Arc<[Vec3]>>,
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh) as usize
}

impl Shared {
    /// Counts the objects of each mesh among these shapes, which come with a number of objects.
    pub(super) fn new<'a>(shapes: impl Iterator<Item = (&'a Shape, u64)>) -> Self {
        let mut shared = Self::default();
        for (shape, count) in shapes {
            if let Shape::Mesh(surface) = shape {
                let objects = &mut shared.0.entry(address(&surface.mesh)).or_default().objects;
                *objects = objects.saturating_add(count as usize);
            }
        }
        shared
    }

    /// Returns what the objects of a mesh share; `None` if the mesh belongs to a single object.
    pub(super) fn of(&mut self, geometry: &Geometry) -> Option<&mut Common> {
        let Geometry::Mesh(mesh, _) = geometry else { return None };
        self.0.get_mut(&address(mesh)).filter(|common| common.objects > 1)
    }

    /// Returns a bounding box of a geometry in object space.
    pub(super) fn about(&mut self, geometry: &Geometry) -> ObjectBox {
        match self.of(geometry) {
            Some(common) => *common.about.get_or_insert_with(|| object_box(geometry)),
            None => object_box(geometry),
        }
    }

    /// Whether still objects of this geometry become instances. It depends on nothing but the
    /// scene.
    pub(super) fn is_placed(&mut self, geometry: &Geometry) -> bool {
        let Geometry::Mesh(mesh, _) = geometry else { return false };
        let faces = mesh.faces.len();
        self.of(geometry).is_some_and(|common| common.objects.saturating_mul(faces) > MOST_COPIED)
    }
}

/// Returns the bounding box of a geometry in object space.
fn object_box(geometry: &Geometry) -> ObjectBox {
    match geometry {
        Geometry::Mesh(mesh, _) => ObjectBox::about(mesh.positions.iter().copied()),
        Geometry::Curved(surface) => surface.bounds(),
    }
}
