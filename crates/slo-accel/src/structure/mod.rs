//! The structures, and how a batch of rays gets to the one that was built.
//!
//! To add a structure: a file or a folder with a type that implements [`SpatialIndex`], its `mod`
//! below, and one line of the list. The compiler then asks for nothing else in this crate, and the
//! tests in `tests.rs` compare it with brute force.

mod bending;
mod brute;
pub(crate) mod bvh;
mod cwbvh;
mod device;
pub(crate) mod interface;
mod kdtree;
pub(crate) mod shared;
pub mod study;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

pub use self::bending::{Bending, Moment};
pub use self::device::{Device, Uploaded};
pub use self::interface::{BuildOptions, Sections};
use self::interface::{Geometry, SpatialIndex};
use self::study::Rendered;
use crate::math::Bounds;
use crate::primitives::{Curved, Primitives, Triangle};
use crate::rays::{Coherence, Hits, LANES, Rays};

/// Makes of the list of structures what differs from one to the other: their names, the one that
/// was built, and the working memory of each.
macro_rules! structures {
    ($($(#[$attribute:meta])* $name:ident, $text:literal: $memory:ident, $type:ty;)*) => {
        /// Which structure is built.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
        #[non_exhaustive]
        pub enum Accelerator {
            $($(#[$attribute])* $name,)*
        }

        impl Accelerator {
            /// All structures, each with the name that [`by_name`](Self::by_name) knows.
            pub const NAMES: &[(&str, Self)] = &[$(($text, Self::$name),)*];
        }

        /// The structure that was built.
        #[derive(Debug)]
        enum Built {
            $($name($type),)*
        }

        impl Built {
            fn new(accelerator: Accelerator, primitives: Primitives, options: BuildOptions) -> Self {
                match accelerator {
                    $(Accelerator::$name => Self::$name(SpatialIndex::build(primitives, options)),)*
                }
            }

            fn refitted(
                &self,
                primitives: &Primitives,
                most_growth: f64,
                options: BuildOptions,
            ) -> Option<Self> {
                match self {
                    $(Self::$name(index) => {
                        index.refitted(primitives, most_growth, options).map(Self::$name)
                    })*
                }
            }

            fn restored(
                accelerator: Accelerator,
                primitives: Primitives,
                options: BuildOptions,
                sections: &dyn Sections,
            ) -> Result<Self, Primitives> {
                match accelerator {
                    $(Accelerator::$name => {
                        SpatialIndex::restore(primitives, options, sections).map(Self::$name)
                    })*
                }
            }
        }

        /// Working memory of queries, one for each thread. It holds nothing between calls, so any
        /// structure may use it next.
        #[derive(Debug, Default)]
        pub struct Scratch {
            $($memory: <$type as SpatialIndex>::Scratch,)*
            of_piece: bending::OfPiece,
        }

        /// Asks the structure that was built.
        macro_rules! ask {
            ($built:expr, $index:ident => $answer:expr) => {
                match $built {
                    $(Built::$name($index) => $answer,)*
                }
            };
            ($built:expr, $all:expr, $index:ident, $scratch:ident => $answer:expr) => {
                match $built {
                    $(Built::$name($index) => {
                        let $scratch = &mut $all.$memory;
                        $answer
                    })*
                }
            };
        }
    };
}

structures! {
    /// A kd-tree, built by the surface area heuristic. It takes the least memory on closed meshes.
    KdTree, "KDTREE": kdtree, kdtree::KdTree;
    /// A bounding volume hierarchy of eight children to a node: the fastest.
    #[default]
    Bvh, "BVH": bvh, bvh::Bvh;
    /// The compressed wide hierarchy of the obvhs library, to be measured against. Its tests of
    /// boxes are not conservative: of 100 000 rays a few that run along faces of boxes miss their
    /// hit.
    Cwbvh, "CWBVH": cwbvh, cwbvh::Cwbvh;
    /// No structure: each ray is tested against every primitive. The reference of the others.
    None, "NONE": brute, brute::Brute;
    /// A uniform grid, [to study](study).
    Grid, "GRID": grid, Rendered<study::Grid>;
    /// An octree, [to study](study).
    Octree, "OCTREE": octree, Rendered<study::Octree>;
    /// A binary hierarchy of halves, [to study](study).
    Median, "MEDIAN": median, Rendered<study::MedianTree>;
    /// An R-tree, packed by sort-tile-recursive, [to study](study).
    RTree, "RTREE": rtree, Rendered<study::RTree>;
    /// A binary hierarchy, built by the surface area heuristic, [to study](study).
    Binary, "BINARY": binary, Rendered<study::BinaryTree>;
    /// A kd-tree with four ways to traverse it, [to study](study).
    Kd, "KD": kd, Rendered<study::Kd>;
    /// The boxes of all primitives, one after the other, [to study](study).
    Boxes, "BOXES": boxes, Rendered<study::Boxes>;
}

impl Accelerator {
    /// The structure of a name, in upper or lower case.
    ///
    /// # Errors
    /// If the name is none of [`NAMES`](Self::NAMES).
    pub fn by_name(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|&(_, accelerator)| accelerator).ok_or_else(|| {
            let known: Vec<&str> = Self::NAMES.iter().map(|&(known, _)| known).collect();
            format!("unknown accelerator `{name}`, expected one of {}", known.join(", "))
        })
    }
}

impl std::fmt::Display for Accelerator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = Self::NAMES.iter().find(|(_, of)| of == self).map_or("", |(name, _)| name);
        f.write_str(name)
    }
}

/// Primitives of one space, with a structure that finds those on a ray.
///
/// Structures are immutable: any number of threads may ask one, each with a [`Scratch`] of its own.
#[derive(Debug)]
pub struct Structure {
    built: Built,
}

impl Structure {
    /// More primitives have no ids in every structure.
    pub const MAX_PRIMITIVES: usize = 1 << 28;

    /// Builds a structure over `primitives`, on all threads of the current rayon pool. The same
    /// primitives give the same structure for any number of threads.
    ///
    /// `primitives` may be just a `Vec` of triangles, and `options` just an [`Isa`](crate::Isa).
    /// Coordinates are finite; triangles without area (their corners lie on a line) and triangles
    /// with coordinates that are not finite are never hit.
    ///
    /// # Panics
    /// If there are more than [`MAX_PRIMITIVES`](Self::MAX_PRIMITIVES).
    pub fn build(
        accelerator: Accelerator,
        primitives: impl Into<Primitives>,
        options: impl Into<BuildOptions>,
    ) -> Self {
        let primitives = primitives.into();
        assert!(primitives.len() <= Self::MAX_PRIMITIVES, "at most 2^28 primitives");
        Self { built: Built::new(accelerator, primitives, options.into()) }
    }

    /// Makes of this structure one over the same primitives in other places, such as those of a mesh
    /// that has changed its shape from frame to frame. This takes a fraction of the time of building,
    /// but boxes overlap more, and rays take longer. `most_growth` limits how much: it is the ratio of
    /// what a ray is expected to cost, by the surface area heuristic, to what it would have cost in
    /// the structure that was built; 1 and above.
    ///
    /// Hits are those of any structure over the primitives.
    ///
    /// # Errors
    /// The primitives, which are to be built over instead: rays would cost more, or the primitives are
    /// others, or include curved surfaces, or the structure is not a [`Bvh`](Accelerator::Bvh) without
    /// spatial splits.
    pub fn refitted(
        &self,
        primitives: Primitives,
        most_growth: f64,
        options: impl Into<BuildOptions>,
    ) -> Result<Self, Primitives> {
        let options = options.into();
        match self.built.refitted(&primitives, most_growth, options) {
            Some(built) => Ok(Self { built }),
            None => Err(primitives),
        }
    }

    /// Builds a structure [to study](study) that a device traverses: `GRID`, `KD` or a hierarchy of boxes,
    /// without mailboxes. Hits are those of the CPU, which also answers for the device if it fails, and
    /// about curved surfaces. Counts are the CPU's.
    ///
    /// # Errors
    /// Why the device cannot take the structure, in words for the user.
    ///
    /// # Panics
    /// If there are more primitives than [`MAX_PRIMITIVES`](Self::MAX_PRIMITIVES).
    pub fn build_on(
        device: &dyn Device,
        accelerator: Accelerator,
        primitives: impl Into<Primitives>,
        options: impl Into<BuildOptions>,
    ) -> Result<Self, String> {
        let mut structure = Self::build(accelerator, primitives, options);
        ask!(&mut structure.built, index => index.upload(device))?;
        Ok(structure)
    }

    /// Returns the bytes of all triangles, as they lie in memory: the corners one after the other, each
    /// with its x, y and z. What is [kept](Self::kept) depends on nothing else, on curved surfaces, and on
    /// the options.
    pub fn bytes_of_triangles(primitives: &Primitives) -> &[u8] {
        shared::pages::bytes_of(&primitives.triangles)
    }

    /// Version of what [`kept`](Self::kept) returns. A structure that another version kept may be
    /// [restored](Self::restore) to another one, which gives the same hits.
    pub const KEPT: u32 = 1;

    /// Returns what was built over the primitives, in sections of bytes, from which
    /// [`restore`](Self::restore) makes the structure again faster than it was built. The bytes are
    /// the same on all machines.
    ///
    /// Returns `None` for structures that cannot be kept, and on machines whose numbers begin with
    /// their highest byte.
    pub fn kept(&self) -> Option<Vec<Cow<'_, [u8]>>> {
        ask!(&self.built, index => index.kept()).filter(|_| cfg!(target_endian = "little"))
    }

    /// Makes a structure of what was [kept](Self::kept) of one over the same primitives, with the
    /// same options but for the instruction set. It gives the same hits.
    ///
    /// The sections need not be trusted: if they cannot belong to these primitives, the primitives come
    /// back. Sections of another structure over as many primitives may be accepted, and hits may then be
    /// missed, but no query fails, and none returns a hit that is not there.
    ///
    /// # Errors
    /// The primitives come back if the sections cannot be used.
    pub fn restore(
        accelerator: Accelerator,
        primitives: impl Into<Primitives>,
        options: impl Into<BuildOptions>,
        sections: &dyn Sections,
    ) -> Result<Self, Primitives> {
        let primitives = primitives.into();
        if primitives.len() > Self::MAX_PRIMITIVES || cfg!(target_endian = "big") {
            return Err(primitives);
        }
        let built = Built::restored(accelerator, primitives, options.into(), sections)?;
        Ok(Self { built })
    }

    /// Number of triangles: ids below it are triangles.
    #[inline]
    pub fn triangle_count(&self) -> usize {
        ask!(&self.built, index => index.geometry().triangle_count())
    }

    /// The triangle of an id, as it was given.
    ///
    /// # Panics
    /// If `id` is not below [`triangle_count`](Self::triangle_count).
    #[inline]
    pub fn triangle(&self, id: u32) -> Triangle {
        ask!(&self.built, index => index.geometry().triangle(id))
    }

    /// The curved surfaces, as they were given: the first has the id
    /// [`triangle_count`](Self::triangle_count).
    #[inline]
    pub fn curved(&self) -> &[Curved] {
        ask!(&self.built, index => index.geometry().curved())
    }

    /// Bytes held: the primitives and everything built over them.
    pub fn memory(&self) -> usize {
        ask!(&self.built, index => index.geometry().memory() + index.overhead())
    }

    /// The smallest box about all primitives.
    pub fn bounds(&self) -> Bounds {
        ask!(&self.built, index => index.geometry().all_bounds())
    }

    /// What the structure is made of; `None` for `KDTREE`, `CWBVH` and `NONE`.
    pub fn statistics(&self) -> Option<study::Statistics> {
        ask!(&self.built, index => index.statistics())
    }

    /// Whether [`count`](Self::count) counts; all structures do but `CWBVH`.
    pub fn can_count(&self) -> bool {
        ask!(&self.built, index => index.can_count())
    }

    /// Traces one ray of a batch by itself, in plain Rust, and adds what it takes to `counts`: to the first
    /// hit, or to any hit if `any` is enough. Returns the t of the hit; infinite if there is none.
    ///
    /// Counts are the same on all machines. [`intersect`](Self::intersect) and
    /// [`occluded`](Self::occluded) find the same hits, but the kernels of `BVH` and `KDTREE` answer many
    /// rays together and visit other nodes.
    pub fn count(
        &self,
        rays: &Rays,
        i: usize,
        any: bool,
        scratch: &mut Scratch,
        counts: &mut study::Counts,
    ) -> f32 {
        ask!(&self.built, scratch, index, memory => index.count(rays, i, any, memory, counts))
    }

    /// Boxes about all primitives that can be hit, at most `count`, or 8 if that is less.
    pub(crate) fn parts(&self, count: usize) -> Vec<Bounds> {
        let mut parts = ask!(&self.built, index => index.parts(count));
        parts.retain(|part| !part.is_empty());
        parts
    }

    /// Writes the first hit of each ray with `0 < t < t_max` to `hits[0..rays.len()]`; what `hits`
    /// held before is dropped.
    ///
    /// `coherence` tells how alike neighbouring rays are expected to be, for the structure to
    /// choose a kernel by. Returns how alike they turned out to be, or `coherence` if the structure
    /// cannot tell: pass that on for the next batch of the same kind.
    pub fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        hits.reset(rays.len());
        ask!(&self.built, scratch, index, memory => {
            index.intersect(rays, coherence, hits, memory)
        })
    }

    /// Writes to `blocked[0..rays.len()]` whether anything lies on each ray with `0 < t < t_max`;
    /// what `blocked` held before is dropped. `coherence` and what comes back are as for
    /// [`intersect`](Self::intersect).
    pub fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut Vec<bool>,
        scratch: &mut Scratch,
    ) -> Coherence {
        blocked.clear();
        blocked.resize(rays.len().next_multiple_of(LANES), false);
        ask!(&self.built, scratch, index, memory => {
            index.occluded(rays, coherence, blocked, memory)
        })
    }
}
