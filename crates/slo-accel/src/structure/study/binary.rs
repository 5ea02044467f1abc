//! A binary hierarchy, built by the surface area heuristic over bins.
//!
//! Sources: Goldsmith, Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing*, IEEE CG&A
//! 1987; Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, RT 2007. The bins
//! divide the box of the centres evenly, along each axis. A node becomes a leaf if no cut costs less,
//! with the constants of [`Statistics::sah`](super::Statistics::sah).

use super::hierarchy::{Builder, Plan};
use super::parameters::Parameters;
use super::ray::Cell;
use super::statistics::{COST_OF_STEP, COST_OF_TEST};

/// Builds by the surface area heuristic.
#[derive(Debug)]
pub struct Binned;

/// Bins along an axis.
const BINS: usize = 32;

/// Most objects of a leaf that is not cut because of its cost.
const MOST: usize = 16;

/// Nodes deeper than this are halved, so that the depth is bounded.
const DEEP: u32 = 96;

impl Builder for Binned {
    fn build(plan: &mut Plan<'_>, mut ids: Vec<u32>, parameters: &Parameters) {
        let leaf = parameters.leaf.unwrap_or(1).max(1) as usize;
        let deepest = parameters.depth.unwrap_or(u32::MAX);
        let root = plan.add(1);
        split(plan, root, &mut ids, 0, leaf, deepest);
    }
}

fn split(plan: &mut Plan<'_>, node: usize, ids: &mut [u32], depth: u32, leaf: usize, deepest: u32) {
    let cut = if ids.len() <= leaf || depth >= deepest {
        None
    } else {
        let best = if depth < DEEP { best_cut(plan, ids) } else { None };
        let pays = best.as_ref().is_some_and(|best| best.cost < COST_OF_TEST * ids.len() as f64);
        match best {
            Some(best) if pays || ids.len() > MOST => Some(partition(plan, ids, &best)),
            // All centres are the same, or the tree is too deep.
            None if ids.len() > MOST => Some(ids.len() / 2),
            _ => None,
        }
    };
    let Some(middle) = cut else { return plan.set_leaf(node, ids) };
    let first = plan.add(2);
    plan.set_children(node, first, 2, ids);
    let (left, right) = ids.split_at_mut(middle);
    split(plan, first, left, depth + 1, leaf, deepest);
    split(plan, first + 1, right, depth + 1, leaf, deepest);
}

/// A cut behind a bin.
struct Cut {
    axis: usize,
    /// Centres in this bin and before it go to the left.
    bin: usize,
    cost: f64,
    centers: [f64; 2],
}

/// The bin of a centre.
fn bin(center: f64, [low, high]: [f64; 2]) -> usize {
    ((BINS as f64 * (center - low) / (high - low)) as usize).min(BINS - 1)
}

/// The cheapest cut; none if all centres are the same.
fn best_cut(plan: &Plan<'_>, ids: &[u32]) -> Option<Cut> {
    let area = Cell::of(&plan.bounds(ids)).area();
    let mut best: Option<Cut> = None;
    for axis in 0..3 {
        let centers = ids.iter().map(|&id| plan.center(id)[axis]);
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = centers.fold(ends, |[low, high], c| [low.min(c), high.max(c)]);
        if low == high {
            continue;
        }
        let mut bins = [(0usize, Cell::NOTHING); BINS];
        for &id in ids {
            let (count, cell) = &mut bins[bin(plan.center(id)[axis], [low, high])];
            *count += 1;
            *cell = cell.union(&Cell::of(&plan.objects[id as usize]));
        }
        // From the right: objects and areas of what is behind each bin.
        let mut behind = [(0usize, 0.0f64); BINS];
        let (mut count, mut cell) = (0, Cell::NOTHING);
        for i in (1..BINS).rev() {
            count += bins[i].0;
            cell = cell.union(&bins[i].1);
            behind[i - 1] = (count, if count > 0 { cell.area() } else { 0.0 });
        }
        let (mut count, mut cell) = (0, Cell::NOTHING);
        for i in 0..BINS - 1 {
            count += bins[i].0;
            cell = cell.union(&bins[i].1);
            let (right, right_area) = behind[i];
            if count == 0 || right == 0 {
                continue;
            }
            let weighted = cell.area() * count as f64 + right_area * right as f64;
            let share = if area > 0.0 { weighted / area } else { 0.5 * ids.len() as f64 };
            let cost = COST_OF_STEP + COST_OF_TEST * share;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Cut { axis, bin: i, cost, centers: [low, high] });
            }
        }
    }
    best
}

/// Brings the objects left of a cut to the front, in their order; returns their number.
fn partition(plan: &Plan<'_>, ids: &mut [u32], cut: &Cut) -> usize {
    let is_left = |id: u32| bin(plan.center(id)[cut.axis], cut.centers) <= cut.bin;
    ids.sort_by_key(|&id| !is_left(id));
    ids.partition_point(|&id| is_left(id))
}
