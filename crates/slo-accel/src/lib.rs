//! Structures that answer batches of rays: which primitive is hit first, or whether any is.
//!
//! All structures share one primitive layout ([`Primitives`]) and one interface ([`Structure`]);
//! they know no materials, no time and no file. Hits at the same distance go to the lowest
//! primitive id in every structure, and all instruction sets give the same hits.

mod box_tree;
mod brute;
pub mod bvh;
mod clip;
mod compress;
pub mod curved;
mod cwbvh;
mod isa;
pub mod kdtree;
pub mod math;
mod order;
mod pages;
mod primitives;
mod rays;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod simd;
mod stops;
pub mod triangle;

pub use box_tree::BoxScratch;
pub use box_tree::BoxTree;
pub use compress::{GROUP, Word};
pub use isa::Isa;
pub use isa::Lanewise;
pub use primitives::{Curved, Primitives, Triangle};
pub use rays::{Coherence, Hits, LANES, NO_HIT, Rays};

use crate::math::Bounds;

/// The structure that rays are traced through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Accelerator {
    /// SAH kd-tree.
    KdTree,
    /// 8-wide bounding volume hierarchy.
    #[default]
    Bvh,
    /// obvhs's compressed wide hierarchy, the library yardstick.
    Cwbvh,
    /// Every primitive is tested.
    None,
}

impl Accelerator {
    /// All, by their names in scenes and on the command line.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("KDTREE", Self::KdTree),
        ("BVH", Self::Bvh),
        ("CWBVH", Self::Cwbvh),
        ("NONE", Self::None),
    ];

    /// The structure of a name, in any case.
    ///
    /// # Errors
    /// A name that is none of [`NAMES`](Self::NAMES).
    pub fn by_name(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|&(_, accelerator)| accelerator).ok_or_else(|| {
            format!("unknown accelerator `{name}`, expected KDTREE, BVH, CWBVH or NONE")
        })
    }
}

impl std::fmt::Display for Accelerator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = Self::NAMES.iter().find(|(_, of)| of == self).map_or("", |(name, _)| name);
        f.write_str(name)
    }
}

/// How a structure is built. None of it changes a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The instruction set of builder and queries; one that the CPU has.
    pub isa: Isa,
    /// Whether triangles may be cut where boxes would overlap: among long ones incoherent rays
    /// are faster, packets of shadow rays and building slower. Of the structures only the BVH
    /// knows it.
    pub spatial_splits: bool,
}

impl From<Isa> for BuildOptions {
    fn from(isa: Isa) -> Self {
        Self { isa, spatial_splits: false }
    }
}

/// Primitives of one space, with whatever finds them fast.
#[derive(Debug)]
pub enum Structure {
    /// SAH kd-tree.
    KdTree(kdtree::KdTree),
    /// 8-wide bounding volume hierarchy.
    Bvh(bvh::Bvh),
    /// obvhs's compressed wide hierarchy.
    Cwbvh(cwbvh::Cwbvh),
    /// Every primitive is tested: the oracle of the others.
    Brute(brute::Brute),
}

/// Working memory of queries, one per thread; holds nothing between calls.
#[derive(Debug, Default)]
pub struct Scratch {
    bvh: bvh::Scratch,
    kdtree: kdtree::Scratch,
}

impl Structure {
    /// Builds a structure, on all threads of the current rayon pool. The same primitives give the
    /// same structure for any number of threads.
    pub fn build(
        accelerator: Accelerator,
        primitives: Primitives,
        options: impl Into<BuildOptions>,
    ) -> Self {
        let options = options.into();
        let isa = options.isa;
        match accelerator {
            Accelerator::None => Self::Brute(brute::Brute::new(primitives)),
            Accelerator::Bvh => Self::Bvh(bvh::Bvh::build(primitives, options)),
            Accelerator::Cwbvh => Self::Cwbvh(cwbvh::Cwbvh::build(primitives, isa)),
            Accelerator::KdTree => Self::KdTree(kdtree::KdTree::build(primitives, isa)),
        }
    }

    /// How many triangles there are: ids below it are triangles.
    #[inline]
    pub fn triangle_count(&self) -> usize {
        match self {
            Self::KdTree(tree) => tree.primitives().triangles.len(),
            Self::Bvh(bvh) => bvh.triangle_count(),
            Self::Cwbvh(cwbvh) => cwbvh.primitives().triangles.len(),
            Self::Brute(brute) => brute.primitives().triangles.len(),
        }
    }

    /// The triangle of an id, as it was given.
    #[inline]
    pub fn triangle(&self, id: u32) -> Triangle {
        match self {
            Self::KdTree(tree) => tree.primitives().triangles[id as usize],
            Self::Bvh(bvh) => bvh.triangle(id),
            Self::Cwbvh(cwbvh) => cwbvh.primitives().triangles[id as usize],
            Self::Brute(brute) => brute.primitives().triangles[id as usize],
        }
    }

    /// The curved surfaces, as they were given: the first has the id
    /// [`triangle_count`](Self::triangle_count).
    pub fn curved(&self) -> &[Curved] {
        match self {
            Self::KdTree(tree) => &tree.primitives().curved,
            Self::Bvh(bvh) => bvh.curved(),
            Self::Cwbvh(cwbvh) => &cwbvh.primitives().curved,
            Self::Brute(brute) => &brute.primitives().curved,
        }
    }

    /// Bytes held: the primitives and everything built over them.
    pub fn memory(&self) -> usize {
        match self {
            Self::KdTree(tree) => tree.primitives().memory() + tree.memory(),
            Self::Bvh(bvh) => bvh.memory(),
            Self::Cwbvh(cwbvh) => cwbvh.primitives().memory() + cwbvh.memory(),
            Self::Brute(brute) => brute.primitives().memory() + brute.memory(),
        }
    }

    /// The smallest box about all primitives.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::KdTree(tree) => tree.primitives().all_bounds(),
            Self::Bvh(bvh) => bvh.bounds(),
            Self::Cwbvh(cwbvh) => cwbvh.primitives().all_bounds(),
            Self::Brute(brute) => brute.primitives().all_bounds(),
        }
    }

    /// The first hit of every ray with `0 < t < t_max`, written to `hits[0..rays.len()]`; comes back
    /// with how alike the rays turned out to be, where that can be told.
    pub fn intersect(
        &self,
        rays: &Rays,
        coherence: Coherence,
        hits: &mut Hits,
        scratch: &mut Scratch,
    ) -> Coherence {
        hits.reset(rays.len());
        match self {
            Self::KdTree(tree) => tree.intersect(rays, coherence, hits, &mut scratch.kdtree),
            Self::Bvh(bvh) => return bvh.intersect(rays, coherence, hits, &mut scratch.bvh),
            Self::Cwbvh(cwbvh) => cwbvh.intersect(rays, hits),
            Self::Brute(brute) => brute.intersect(rays, hits),
        }
        coherence
    }

    /// Whether anything lies on each ray with `0 < t < t_max`, written to `blocked[0..rays.len()]`;
    /// comes back with how alike the rays turned out to be, where that can be told.
    pub fn occluded(
        &self,
        rays: &Rays,
        coherence: Coherence,
        blocked: &mut Vec<bool>,
        scratch: &mut Scratch,
    ) -> Coherence {
        blocked.clear();
        blocked.resize(rays.len().next_multiple_of(LANES), false);
        match self {
            Self::KdTree(tree) => tree.occluded(rays, coherence, blocked, &mut scratch.kdtree),
            Self::Bvh(bvh) => return bvh.occluded(rays, coherence, blocked, &mut scratch.bvh),
            Self::Cwbvh(cwbvh) => cwbvh.occluded(rays, blocked),
            Self::Brute(brute) => brute.occluded(rays, blocked),
        }
        coherence
    }
}

#[cfg(test)]
mod tests {
    use super::Accelerator;

    #[test]
    fn accelerators_are_found_by_the_names_that_they_show() {
        for (name, accelerator) in Accelerator::NAMES {
            assert_eq!(accelerator.to_string(), name);
            assert_eq!(Accelerator::by_name(&name.to_lowercase()), Ok(accelerator));
        }
        assert!(Accelerator::by_name("OCTREE").is_err());
    }
}
