//! Structures to study and to compare: short, plain, one ray at a time, one file for each, with its
//! paper and how it departs from it.
//!
//! They are no match for [`Accelerator::Bvh`](crate::Accelerator::Bvh) and are not meant to be:
//! each is the textbook's structure, so that its [counters](Counts) can be compared with published
//! ones. They find exactly the same hits.
//!
//! They hold *objects*: boxes with numbers. An object is whatever the caller tests, a primitive or a
//! polygon of a hundred triangles; references and tests are counted by object. A traversal calls
//! back with the number of each object that the ray may hit and with the largest t that still
//! counts; the answer is the new one.
//!
//! ```
//! use slo_accel::glam::Vec3;
//! use slo_accel::math::Bounds;
//! use slo_accel::study::{Counts, Grid, Memory, Parameters, Ray, Study};
//!
//! // Ten walls across the ray, at x = 0 to 9.
//! let wall = |x: u8| Vec3::X * f32::from(x);
//! let walls: Vec<Bounds> =
//!     (0..10).map(|x| Bounds { min: wall(x) - Vec3::Y - Vec3::Z, max: wall(x) + Vec3::Y + Vec3::Z }).collect();
//! let grid = Grid::build(&walls, &Parameters::default());
//! let ray = Ray { origin: Vec3::new(3.5, 0.1, 0.1), direction: Vec3::X, t_max: f32::INFINITY };
//! let (mut counts, mut nearest) = (Counts::default(), None);
//! let t = grid.walk(&ray, &mut Memory::default(), &mut counts, |wall, t_max| {
//!     let t = wall as f32 - 3.5;
//!     if t > 0.0 && t < t_max {
//!         nearest = Some(wall);
//!         t
//!     } else {
//!         t_max
//!     }
//! });
//! assert_eq!((nearest, t), (Some(4), 0.5));
//! assert!(counts.tests < 10);
//! ```

mod answer;
mod binary;
mod boxes;
mod counting;
mod grid;
mod hierarchy;
mod kd;
mod layout;
mod median;
mod memory;
mod octree;
mod overlap;
mod parameters;
mod ray;
mod rendered;
mod rtree;
mod statistics;
#[cfg(test)]
mod tests;

use std::fmt::Debug;

pub use self::answer::Answer;
pub use self::boxes::Boxes;
pub use self::counting::{Counting, Counts, Totals};
pub use self::grid::Grid;
pub use self::hierarchy::{Builder, Hierarchy};
pub use self::kd::Kd;
pub use self::layout::{BoxNode, KdNode, Layout};
pub use self::memory::Memory;
pub use self::octree::Octree;
pub use self::parameters::{Parameters, Planes, Traversal};
pub use self::ray::Ray;
pub(crate) use self::rendered::Rendered;
pub use self::statistics::{COST_OF_STEP, COST_OF_TEST, Statistics};
use crate::math::Bounds;
use crate::primitives::Triangle;

/// Part of its size by which the box of all objects is grown on each side before space is divided.
pub const MARGIN: f64 = 1.0 / 8192.0;

/// A structure over objects.
pub trait Study: Debug + Sized + Send + Sync {
    /// Builds the structure. The same boxes give the same structure everywhere. Objects whose box is
    /// empty or not finite are never met.
    fn build(objects: &[Bounds], parameters: &Parameters) -> Self;

    /// Calls `visit` with the objects that a ray may hit, roughly from near to far, and with the
    /// largest t that still counts: first the ray's own end, then what `visit` returned last. Each
    /// answer is the argument or less; a negative one ends the walk. Returns the last.
    ///
    /// Every object is visited that has a hit up to the last answer, within the error of
    /// [`triangle::POSITION_ERROR`](crate::triangle::POSITION_ERROR). Without mailboxes an object may
    /// be visited several times.
    fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &Ray,
        memory: &mut Memory,
        counting: &mut C,
        visit: V,
    ) -> f32;

    /// What the structure is made of.
    fn statistics(&self) -> Statistics;

    /// End-point overlap, for hierarchies of boxes: over all nodes, the sum of [`COST_OF_STEP`], or of
    /// [`COST_OF_TEST`] for each object of a leaf, times the share of all surface that lies in the node's
    /// box but does not belong to it. `surfaces` are triangles, each with the object that it belongs to.
    /// Source: Aila, Karras, Laine, *On Quality Metrics of Bounding Volume Hierarchies*, HPG 2013.
    ///
    /// # Panics
    /// If there is no such object.
    fn end_point_overlap(&self, surfaces: &[(u32, Triangle)]) -> Option<f64> {
        let _ = surfaces;
        None
    }

    /// The arrays of the structure, for [devices](crate::Device) that traverse it by programs of their
    /// own; `None` if it has none that they could, or uses mailboxes.
    fn layout(&self) -> Option<Layout<'_>> {
        None
    }

    /// Bytes held, without the objects.
    fn bytes(&self) -> usize;
}

/// A binary hierarchy of halves.
pub type MedianTree = Hierarchy<median::Median>;

/// An R-tree.
pub type RTree = Hierarchy<rtree::SortTile>;

/// A binary hierarchy, built by the surface area heuristic.
pub type BinaryTree = Hierarchy<binary::Binned>;

/// Makes of the list of structures their kinds, and one type for all.
macro_rules! studies {
    ($($(#[$attribute:meta])* $name:ident, $text:literal;)*) => {
        /// A structure to study.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum Kind {
            $($(#[$attribute])* $name,)*
        }

        impl Kind {
            /// All kinds, each with its name.
            pub const NAMES: &[(&str, Self)] = &[$(($text, Self::$name),)*];
        }

        /// Any of the structures to study.
        #[derive(Debug)]
        #[non_exhaustive]
        pub enum Any {
            $($(#[$attribute])* $name($name),)*
        }

        impl Any {
            /// Builds a structure of a kind; see [`Study::build`].
            pub fn new(kind: Kind, objects: &[Bounds], parameters: &Parameters) -> Self {
                match kind {
                    $(Kind::$name => Self::$name(Study::build(objects, parameters)),)*
                }
            }

            /// See [`Study::walk`].
            pub fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
                &self,
                ray: &Ray,
                memory: &mut Memory,
                counting: &mut C,
                visit: V,
            ) -> f32 {
                match self {
                    $(Self::$name(study) => study.walk(ray, memory, counting, visit),)*
                }
            }

            /// See [`Study::end_point_overlap`].
            pub fn end_point_overlap(&self, surfaces: &[(u32, Triangle)]) -> Option<f64> {
                match self {
                    $(Self::$name(study) => study.end_point_overlap(surfaces),)*
                }
            }

            /// See [`Study::statistics`].
            pub fn statistics(&self) -> Statistics {
                match self {
                    $(Self::$name(study) => study.statistics(),)*
                }
            }
        }
    };
}

studies! {
    /// A uniform grid.
    Grid, "GRID";
    /// An octree.
    Octree, "OCTREE";
    /// A binary hierarchy: objects are halved along the longest axis.
    MedianTree, "MEDIAN";
    /// An R-tree, packed by sort-tile-recursive.
    RTree, "RTREE";
    /// A binary hierarchy, built by the surface area heuristic.
    BinaryTree, "BINARY";
    /// A kd-tree, built by the surface area heuristic, with four ways to traverse it.
    Kd, "KD";
    /// The boxes of all objects, one after the other.
    Boxes, "BOXES";
}
