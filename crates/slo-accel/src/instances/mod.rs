//! Structures at many places.
//!
//! ```
//! use std::sync::Arc;
//! use slo_accel::glam::Vec3;
//! use slo_accel::instances::{Affine, Child, Placements};
//! use slo_accel::{Accelerator, Coherence, Hits, Instances, Isa, Rays, Structure};
//!
//! let triangle = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]];
//! let child = Structure::build(Accelerator::Bvh, triangle, Isa::best());
//! let mut placements = Placements::default();
//! for x in 0..3 {
//!     placements.push(0, &[Affine { translation: Vec3::X * x as f32, ..Affine::IDENTITY }]);
//! }
//! let children = vec![Child::Structure(Arc::new(child))];
//! let instances = Instances::build(children, placements, Isa::best())?;
//! let mut rays = Rays::default();
//! rays.push(Vec3::new(2.25, 0.5, 2.0), Vec3::NEG_Z, f32::INFINITY);
//! let (mut hits, mut instance) = (Hits::default(), vec![]);
//! let time = [0.0];
//! instances.intersect(
//!     &rays, &time, Coherence::Coherent, &mut hits, &mut instance, &mut Default::default(),
//! );
//! assert_eq!((hits.t[0], hits.primitive[0], instance[0]), (2.0, 0, 2));
//! # Ok::<(), slo_accel::instances::BuildError>(())
//! ```

mod affine;
mod placements;
mod query;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use rayon::prelude::*;

pub use self::affine::Affine;
use self::affine::{Error, Inverse};
pub use self::placements::Placements;
use self::placements::nearest;
pub use self::query::InstancesScratch;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::math::rounding::UNIT_ROUNDOFF;
use crate::primitives::triangle::POSITION_ERROR;
use crate::structure::bvh::halting::Boxes;
use crate::structure::{Bending, Structure};

/// Instance number of a ray that hits nothing.
pub const NO_INSTANCE: u32 = u32::MAX;

/// Most levels of instances above a structure.
pub const MAX_DEPTH: usize = 8;

/// What is placed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Child {
    /// Primitives.
    Structure(Arc<Structure>),
    /// Triangles that bend: each ray meets them at its own time.
    Bending(Arc<Bending>),
    /// Instances of other things: copies of copies.
    Instances(Arc<Instances>),
}

impl Child {
    /// Number of structures that are placed along with it: that of the deepest level.
    fn count(&self) -> u64 {
        match self {
            Self::Structure(_) | Self::Bending(_) => 1,
            Self::Instances(instances) => u64::from(instances.count),
        }
    }

    /// Levels of instances above structures.
    fn depth(&self) -> usize {
        match self {
            Self::Structure(_) | Self::Bending(_) => 0,
            Self::Instances(instances) => instances.depth,
        }
    }

    /// Boxes about all that can be hit, at most `count`.
    fn parts(&self, count: usize) -> Vec<Bounds> {
        match self {
            Self::Structure(structure) => structure.parts(count),
            Self::Bending(bending) => vec![bending.bounds()],
            Self::Instances(instances) => instances.boxes.parts(count),
        }
    }
}

/// Why instances cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// There are more placements, or instances at all levels together, than numbers.
    TooMany,
    /// Instances of instances, more than [`MAX_DEPTH`] deep.
    TooDeep,
    /// The map of this placement has no inverse in f32, or is not finite.
    NotInvertible(u32),
}

impl std::fmt::Display for BuildError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooMany => f.write_str("more instances than can be numbered"),
            Self::TooDeep => write!(f, "instances of instances, more than {MAX_DEPTH} deep"),
            Self::NotInvertible(placement) => {
                write!(f, "the map of placement {placement} has no inverse")
            }
        }
    }
}

impl std::error::Error for BuildError {}

/// Children at many places: structures, and other instances.
///
/// A hit tells its instance: the number of the structure that was hit, if all levels are written
/// out depth first, in the order of placements. [`chain`](Self::chain) leads from there to the
/// placements. Of hits at the same distance the one of the lowest instance counts, then the one of
/// the lowest primitive.
///
/// Rays are taken to the space of a child in f32, and hits are those of the child. A hit may lie
/// beside the surface, taken through the map, by about 130 roundings of the distance between the
/// ray's origin and the middle of the instance, and of the size of the instance. Answers do not
/// depend on the instruction set, the number of threads, or the other rays of a batch.
///
/// Instances are immutable: any number of threads may ask, each with a scratch of its own.
#[derive(Debug)]
pub struct Instances {
    children: Vec<Child>,
    placements: Placements,
    numbers: Numbers,
    boxes: Boxes<Content>,
    /// Inverses of all poses of placements that have several.
    inverses: Vec<Inverse>,
    error: Error,
    count: u32,
    depth: usize,
}

/// A placement as rays see it, in a line of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Content {
    /// Of the only pose, or of the first.
    inverse: Inverse,
    child: u32,
    /// The number of its first instance.
    number: u32,
    poses: u32,
    /// Its first pose in [`Instances::inverses`], if it has several.
    first_inverse: u32,
}

/// The first number of each placement.
#[derive(Debug)]
enum Numbers {
    /// All children count as many instances.
    Even(u32),
    Sums(Vec<u32>),
}

/// Boxes of a child that are taken through each map: they stay closer about it when it is turned
/// than one box would.
const PARTS: usize = 32;

impl Instances {
    /// Builds instances of `children`, on all threads of the current rayon pool.
    ///
    /// # Errors
    /// If there are too many instances or levels, or a map has no inverse.
    ///
    /// # Panics
    /// If a placement's child is not in the list.
    pub fn build(
        children: Vec<Child>,
        mut placements: Placements,
        isa: Isa,
    ) -> Result<Self, BuildError> {
        placements.shrink();
        let len = placements.len();
        let depth = 1 + children.iter().map(Child::depth).max().unwrap_or(0);
        if depth > MAX_DEPTH {
            return Err(BuildError::TooDeep);
        }
        let (numbers, count) = number(&children, &placements)?;
        let originals: Vec<Original> = children.iter().map(Original::new).collect();
        let original = |id: u32| &originals[placements.child(id) as usize];
        let error = |id: u32| {
            let poses = placements.poses(id).iter();
            poses.map(|pose| original(id).error(pose)).fold(Error::NONE, Error::larger)
        };
        let worst = (0..len as u32).into_par_iter().map(|id| {
            let is_ready = placements.poses(id).iter().all(|pose| Inverse::of(pose).is_some());
            if is_ready { Ok(error(id)) } else { Err(BuildError::NotInvertible(id)) }
        });
        let worst = worst.try_reduce(|| Error::NONE, |a, b| Ok(a.larger(b)))?;
        let bounds = |id: u32| {
            let (original, poses) = (original(id), placements.poses(id).iter());
            let bounds = poses.map(|pose| original.bounds(pose)).fold(Bounds::EMPTY, Bounds::union);
            (!bounds.is_empty()).then(|| {
                let margin = glam::Vec3::splat(error(id).absolute);
                Bounds { min: bounds.min - margin, max: bounds.max + margin }
            })
        };
        let moving = |id: &u32| placements.poses(*id).len() > 1;
        let (mut first_inverse, mut inverses) = (vec![0; len], vec![]);
        for id in (0..len as u32).filter(moving) {
            first_inverse[id as usize] = inverses.len() as u32;
            inverses.extend(placements.poses(id).iter().filter_map(Inverse::of));
        }
        let content = |id: u32| Content {
            inverse: Inverse::of(&placements.poses(id)[0]).expect("each map has an inverse"),
            child: placements.child(id),
            number: numbers.first(id),
            poses: placements.poses(id).len() as u32,
            first_inverse: first_inverse[id as usize],
        };
        let boxes = Boxes::build(len, bounds, content, worst.of_origin, isa);
        Ok(Self { children, placements, numbers, boxes, inverses, error: worst, count, depth })
    }

    /// Number of structures that are placed, at all levels together: instance numbers are below it.
    #[inline]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The placements of this level.
    #[inline]
    pub fn placements(&self) -> &Placements {
        &self.placements
    }

    /// What is placed.
    #[inline]
    pub fn children(&self) -> &[Child] {
        &self.children
    }

    /// The placement of this level that an instance number lies in, and the number that the
    /// instance has within the placement's child.
    ///
    /// # Panics
    /// If the number is not below [`count`](Self::count).
    #[inline]
    pub fn placement(&self, number: u32) -> (u32, u32) {
        assert!(number < self.count, "an instance of that number");
        match &self.numbers {
            Numbers::Even(each) => (number / each, number % each),
            Numbers::Sums(sums) => {
                let placement = sums.partition_point(|&first| first <= number) - 1;
                (placement as u32, number - sums[placement])
            }
        }
    }

    /// The placements from this level down to the structure of an instance number, each with the
    /// instances that it belongs to.
    ///
    /// # Panics
    /// If the number is not below [`count`](Self::count).
    pub fn chain(&self, number: u32) -> impl Iterator<Item = (&Instances, u32)> {
        let mut next = Some((self, number));
        std::iter::from_fn(move || {
            let (instances, number) = next.take()?;
            let (placement, rest) = instances.placement(number);
            if let Child::Instances(child) = instances.child(placement) {
                next = Some((child, rest));
            }
            Some((instances, placement))
        })
    }

    /// What a placement of this level places.
    #[inline]
    pub fn child(&self, placement: u32) -> &Child {
        &self.children[self.placements.child(placement) as usize]
    }

    /// A box about everything at all times.
    pub fn bounds(&self) -> Bounds {
        self.boxes.bounds()
    }

    /// Bytes held, without those of the children.
    pub fn memory(&self) -> usize {
        let sums = match &self.numbers {
            Numbers::Even(_) => 0,
            Numbers::Sums(sums) => size_of_val(sums.as_slice()),
        };
        self.placements.memory()
            + self.boxes.memory()
            + size_of_val(self.inverses.as_slice())
            + sums
    }
}

impl Numbers {
    fn first(&self, placement: u32) -> u32 {
        match self {
            Self::Even(each) => placement * each,
            Self::Sums(sums) => sums[placement as usize],
        }
    }
}

/// Numbers all instances; also returns how many there are.
fn number(children: &[Child], placements: &Placements) -> Result<(Numbers, u32), BuildError> {
    let counts: Vec<u64> = children.iter().map(Child::count).collect();
    let len = placements.len();
    let total: u64 = (0..len as u32).map(|id| counts[placements.child(id) as usize]).sum();
    let count = u32::try_from(total).ok().filter(|&count| count < NO_INSTANCE);
    let count = count.filter(|_| len <= Boxes::<Content>::MAX).ok_or(BuildError::TooMany)?;
    let first = counts.first().copied().unwrap_or(1);
    if first > 0 && counts.iter().all(|&count| count == first) {
        return Ok((Numbers::Even(first as u32), count));
    }
    let mut next = 0;
    let sums = (0..len as u32).map(|id| {
        let first = next;
        next += counts[placements.child(id) as usize] as u32;
        first
    });
    Ok((Numbers::Sums(sums.collect()), count))
}

/// A child as a builder sees it.
struct Original {
    /// Middles and half sizes of boxes about it.
    parts: Vec<[glam::Vec3A; 2]>,
    error: Error,
    is_along_axes: bool,
    /// Its largest coordinate.
    size: f32,
}

impl Original {
    fn new(child: &Child) -> Self {
        let mut parts = child.parts(PARTS);
        parts.retain(|part| !part.is_empty());
        let largest = |part: &Bounds| part.min.abs().max(part.max.abs()).max_element();
        let size = parts.iter().map(largest).fold(0.0, f32::max);
        let (error, is_along_axes) = match child {
            Child::Structure(_) => {
                (Error { absolute: POSITION_ERROR * size, of_origin: POSITION_ERROR }, true)
            }
            Child::Bending(_) => {
                // Where corners are is rounded too.
                let absolute = (POSITION_ERROR + 16.0 * UNIT_ROUNDOFF) * size;
                (Error { absolute, of_origin: POSITION_ERROR }, true)
            }
            Child::Instances(instances) => (Error { absolute: 0.0, ..instances.error }, false),
        };
        let half = |part: Bounds| {
            let (min, max) = (glam::Vec3A::from(part.min), glam::Vec3A::from(part.max));
            [(min + max) * 0.5, (max - min) * 0.5]
        };
        Self { parts: parts.into_iter().map(half).collect(), error, is_along_axes, size }
    }

    fn error(&self, pose: &Affine) -> Error {
        Error::behind(pose, self.error, self.is_along_axes, self.size)
    }

    /// A box about it in a pose, but for [`Error::absolute`].
    fn bounds(&self, pose: &Affine) -> Bounds {
        use glam::Vec3A;
        let matrix = glam::Mat3A::from(pose.matrix);
        let sizes = glam::Mat3A::from(pose.matrix.abs());
        let (mut min, mut max) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for [middle, half] in &self.parts {
            let (middle, half) = (matrix * *middle, sizes * *half);
            min = min.min(middle - half);
            max = max.max(middle + half);
        }
        let at = Vec3A::from(pose.translation);
        Bounds { min: (min + at).into(), max: (max + at).into() }
    }
}
