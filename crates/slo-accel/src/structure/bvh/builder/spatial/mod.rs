//! Spatial splits: if the sides of the best split of primitives would overlap, space itself is
//! split, and the triangles on both sides are cut.
//!
//! Sources: Stich, Friedrich, Dietrich, *Spatial Splits in Bounding Volume Hierarchies* (HPG 2009);
//! Popov, Georgiev, Dimov, Slusallek, *Object Partitioning Considered Harmful* (HPG 2009), for the
//! bound on references. We differ in three points. An overlap counts as the area that a cut would
//! save instead of its own area, so neighbours that touch do not count. Subtrees that cannot gain
//! are left to the builder without spatial splits. The room for additional references is divided on
//! the way down, so the tree is the same for any number of threads.

mod cut;
mod planes;
mod room;
mod sides;
#[cfg(test)]
mod tests;

use glam::Vec4;

use self::planes::{Plane, best_plane};
use self::room::Room;
use self::sides::Sides;
use super::binary::Job;
use super::bins::{self, Binning};
use super::boxes::{Box8, Reference, extent};
use super::few::FEW;
use super::heuristic::{SAH_DEPTH, cost};
use super::plan::Subtree;
use super::tree::{BinaryNode, BinaryTree, PARALLEL_SUBTREE, fork};
use crate::isa::Isa;
use crate::primitives::Triangle;
use crate::structure::bvh::layout::MAX_SLOTS;

/// Least saving of a cut, in units of the area of the box about everything. A tenth of it gains
/// nothing more; ten times as much loses about 2 % of speed.
const LEAST_OVERLAP: f32 = 1e-3;

/// Primitives for each additional reference that there is room for.
const SPARE: usize = 4;

/// Builds the hierarchy of references to triangles and, with ids beyond those, curved surfaces,
/// which are never cut. `extent` is as in [`binary::build`](super::binary::build).
pub(super) fn build(
    mut references: Vec<Reference>,
    [all, centers]: [Box8; 2],
    triangles: &[Triangle],
    isa: Isa,
) -> BinaryTree<'static> {
    let n = references.len();
    // Triangles without area take slots too.
    let spare = (n / SPARE).min(MAX_SLOTS.saturating_sub(n.max(triangles.len())));
    references.resize(n + spare, Reference::NONE);
    let splitter = Splitter { triangles, least_overlap: LEAST_OVERLAP * all.half_area() };
    let job = Job { all, centers, depth: 0, first_curved: triangles.len() as u32, isa };
    let sketch = splitter.sketch(job, Room { first: 0, count: n, slots: &mut references });
    let count = sketch.gather(&mut references, 0);
    references.truncate(count);
    let mut nodes = vec![BinaryNode::UNBUILT; count.saturating_sub(1)];
    if count > 0 {
        sketch.build(&mut references, &mut nodes);
    }
    BinaryTree::new(nodes, references, count > n)
}

/// The upper part of a hierarchy.
enum Sketch {
    /// A split that is made.
    Fork { all: Box8, count: usize, sides: Box<[Sketch; 2]> },
    /// References that are left to the builder without spatial splits, from `first` on.
    Rest { job: Job, first: usize, count: usize },
}

impl Sketch {
    fn count(&self) -> usize {
        match self {
            Self::Fork { count, .. } | Self::Rest { count, .. } => *count,
        }
    }

    /// Closes the gaps between the references; returns their end.
    fn gather(&self, references: &mut [Reference], end: usize) -> usize {
        match self {
            Self::Fork { sides, .. } => {
                sides.iter().fold(end, |end, side| side.gather(references, end))
            }
            Self::Rest { first, count, .. } => {
                references.copy_within(*first..first + count, end);
                end + count
            }
        }
    }

    /// Builds the hierarchy of gathered references.
    fn build(self, references: &mut [Reference], nodes: &mut [BinaryNode]) -> Subtree {
        match self {
            Self::Rest { job, .. } => job.build(references, nodes),
            Self::Fork { all, sides, .. } => {
                let [left, right] = *sides;
                fork(
                    &all,
                    left.count(),
                    (references, nodes),
                    |references, nodes| left.build(references, nodes),
                    |references, nodes| right.build(references, nodes),
                )
            }
        }
    }
}

/// What the splits of all subtrees share.
struct Splitter<'a> {
    triangles: &'a [Triangle],
    /// Half the area that a cut must be able to save.
    least_overlap: f32,
}

impl Splitter<'_> {
    fn sketch(&self, job: Job, mut room: Room<'_>) -> Sketch {
        if job.depth >= SAH_DEPTH || room.count <= FEW || !self.may_gain(&job, &room) {
            return Sketch::Rest { job, first: room.first, count: room.count };
        }
        let (middle, [left, right]) = self.split(&job, &mut room);
        let count = room.count;
        let [left_room, right_room] = room.split(middle);
        let sketch_left = || self.sketch(left, left_room);
        let sketch_right = || self.sketch(right, right_room);
        let (left, right) = if count > PARALLEL_SUBTREE {
            rayon::join(sketch_left, sketch_right)
        } else {
            (sketch_left(), sketch_right())
        };
        let count = left.count() + right.count();
        Sketch::Fork { all: job.all, count, sides: Box::new([left, right]) }
    }

    /// Whether any split below could overlap enough: the sides of one reach no further into each
    /// other than a primitive does.
    fn may_gain(&self, job: &Job, room: &Room<'_>) -> bool {
        let size = job.all.size();
        let longest =
            room.references().iter().fold(Vec4::ZERO, |all, r| all.max(r.bounds().size()));
        let most = (longest.x * (size.y + size.z))
            .max(longest.y * (size.z + size.x))
            .max(longest.z * (size.x + size.y));
        room.spare() > 0 && most > self.least_overlap
    }

    /// Sorts the references to both sides of the best split, of space or of primitives: how many
    /// go left, and the jobs of both sides.
    fn split(&self, job: &Job, room: &mut Room<'_>) -> (usize, [Job; 2]) {
        let binning = Binning::new(&job.centers);
        let best = bins::best_split(&binning, room.references(), job.isa);
        let (limit, overlap) = match &best {
            Some(split) => (split.cost, overlap(&split.sides)),
            None => (cost(job.all.half_area(), room.count as u32), f32::INFINITY),
        };
        if overlap > self.least_overlap
            && let Some(plane) = best_plane(&job.all, room, self.triangles, job.isa)
            && plane.cost < limit
        {
            let Some(middle) = self.cut(room, plane) else {
                // Boxes may have shrunk meanwhile, and are no longer what `best` was found for.
                return job.split_at(&mut room.slots[..room.count], &binning, None);
            };
            let (left, right) = room.references().split_at(middle);
            let [left, right] = [extent(left), extent(right)];
            return (middle, job.children([left[0], right[0]], [left[1], right[1]]));
        }
        job.split_at(&mut room.slots[..room.count], &binning, best)
    }

    /// Sorts references to both sides of a plane and cuts those that lie on both, unless a whole
    /// one on one side is cheaper. Returns the number on the left; `None` if one side is empty, and
    /// then no reference has been cut in two.
    fn cut(&self, room: &mut Room<'_>, plane: Plane) -> Option<usize> {
        let mut sides = Sides::new(&plane);
        let mut middle = 0;
        for i in 0..room.count {
            let reference = room.slots[i];
            let may_cut = room.spare() > 0;
            match sides.place(&plane, reference, self.triangles, may_cut) {
                [Some(left), right] => {
                    room.slots[i] = left;
                    room.slots.swap(i, middle);
                    middle += 1;
                    if let Some(right) = right {
                        room.slots[room.count] = right;
                        room.count += 1;
                    }
                }
                [None, right] => room.slots[i] = right.unwrap_or(reference),
            }
        }
        (0 < middle && middle < room.count).then_some(middle)
    }
}

/// Half the area that a cut through the overlap of two sides would save at best: the overlap's own
/// area without the face of the cut. 0 if they only touch.
fn overlap([left, right]: &[Box8; 2]) -> f32 {
    let common = left.intersection(right).size().truncate();
    if common.min_element() <= 0.0 {
        return 0.0;
    }
    common.min_element() * (common.element_sum() - common.min_element())
}
