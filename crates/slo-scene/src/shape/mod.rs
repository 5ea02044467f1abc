//! Shapes: one file each, with its data, its element of the language, and how that is read.

mod axis;
mod cone;
mod corners;
mod cuboid;
mod cylinder;
mod flat;
mod mesh;
mod plane;
mod rectangle;
mod shapes;
mod sphere;
mod surface;
mod triangle;

use glam::DVec3;

use crate::assets::Assets;
use crate::attributes::Fields;
use crate::kinds::kinds;
use crate::light_map::Unwrapped;
use surface::{Surface, WrittenShape};

pub use cone::Cone;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use mesh::MeshSurface;
pub use plane::Plane;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use triangle::Triangle;

pub(crate) use flat::axes_about;

/// How an element becomes a shape.
pub(crate) type ReadShape = fn(&mut Fields<'_, '_, '_>, &mut Assets<'_>) -> Option<Shape>;

kinds! {
    /// A surface, in object space.
    pub enum Shape: dyn Surface, read by ReadShape {
        /// `plane`
        Plane(Plane),
        /// `sphere`
        Sphere(Sphere),
        /// `triangle`
        Triangle(Triangle),
        /// `rectangle`
        Rectangle(Rectangle),
        /// `box`
        Box(Cuboid),
        /// `cylinder`
        Cylinder(Cylinder),
        /// `cone`
        Cone(Cone),
        /// `mesh`
        Mesh(MeshSurface),
    }
}

impl Shape {
    /// Whether all of its indices lead somewhere.
    pub(crate) fn is_consistent(&self) -> bool {
        self.common().is_consistent()
    }

    /// Whether it has several shapes over time.
    pub fn changes(&self) -> bool {
        matches!(self, Self::Mesh(mesh) if mesh.shapes.is_some())
    }

    /// Number of triangles that the shape consists of; 0 if it is curved.
    pub fn triangle_count(&self) -> usize {
        self.common().triangle_count()
    }

    /// Whether only the outside of the surface can be seen from outside of it.
    pub(crate) fn is_closed(&self) -> bool {
        self.common().is_closed()
    }

    /// Returns where the surface lies in images, by its texture coordinates.
    ///
    /// # Errors
    /// Why no place in an image belongs to one place of the surface.
    pub fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        self.common().unwrapped()
    }

    /// Hands the flat parts of the surface to `put`, for as long as that returns true:
    /// counter-clockwise seen from outside, in object space.
    pub(crate) fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        self.common().for_flat_parts(put);
    }
}
