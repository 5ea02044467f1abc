//! An R-tree, packed by sort-tile-recursive.
//!
//! Source: Leutenegger, Lopez, Edgington, *STR: A Simple and Efficient Algorithm for R-Tree Packing*,
//! ICDE 1997, in three dimensions. The centres of boxes are sorted along x and cut into slabs, each
//! slab along y into runs, each run along z into nodes of `capacity` objects. The nodes are packed in
//! the same way, level by level, until one is left. It departs from it: children are visited from near
//! to far.

use super::hierarchy::{Builder, Plan};
use super::parameters::Parameters;

/// Packs by sort-tile-recursive.
#[derive(Debug)]
pub struct SortTile;

/// Children of a node, if not given.
const CAPACITY: u32 = 4;

/// A node of the level that is packed: its objects, and its children, if it has any.
struct Part {
    ids: Vec<u32>,
    parts: Vec<Part>,
    /// Twice the centre of its box.
    center: [f64; 3],
}

impl Builder for SortTile {
    fn build(plan: &mut Plan<'_>, ids: Vec<u32>, parameters: &Parameters) {
        let capacity = parameters.capacity.unwrap_or(CAPACITY).clamp(2, 1 << 16) as usize;
        let object = |id: u32| Part { ids: vec![id], parts: vec![], center: plan.center(id) };
        let objects = ids.into_iter().map(object).collect();
        let mut level = pack(plan, objects, capacity, true);
        while level.len() > 1 {
            level = pack(plan, level, capacity, false);
        }
        let root = plan.add(1);
        place(plan, root, &level[0]);
    }
}

/// Packs parts into fewer parts. Parts of objects become leaves.
fn pack(plan: &mut Plan<'_>, parts: Vec<Part>, capacity: usize, are_objects: bool) -> Vec<Part> {
    let mut packed = vec![];
    tile(parts, 0, capacity, &mut |group| {
        let ids: Vec<u32> = group.iter().flat_map(|part| &part.ids).copied().collect();
        let bounds = plan.bounds(&ids);
        let center =
            std::array::from_fn(|axis| f64::from(bounds.min[axis]) + f64::from(bounds.max[axis]));
        plan.meter.take(size_of::<Part>() + size_of_val(&*ids));
        packed.push(Part { ids, parts: if are_objects { vec![] } else { group }, center });
    });
    packed
}

/// Cuts parts into slabs along an axis, and these along the next; behind the last axis, into groups.
fn tile(mut parts: Vec<Part>, axis: usize, capacity: usize, group: &mut impl FnMut(Vec<Part>)) {
    // Equal centres stay in their order.
    parts.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let pages = parts.len().div_ceil(capacity);
    let slab = match axis {
        0 => capacity * root_up(pages as u128 * pages as u128, 3),
        1 => capacity * root_up(pages as u128, 2),
        _ => capacity,
    };
    while !parts.is_empty() {
        let rest = parts.split_off(slab.min(parts.len()));
        if axis == 2 {
            group(parts);
        } else {
            tile(parts, axis + 1, capacity, group);
        }
        parts = rest;
    }
}

/// The least number whose power is not below `x`.
fn root_up(x: u128, power: u32) -> usize {
    let (mut low, mut high) = (0u128, 1u128 << 40);
    while low < high {
        let middle = (low + high) / 2;
        if middle.pow(power) >= x {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low as usize
}

fn place(plan: &mut Plan<'_>, node: usize, part: &Part) {
    if part.parts.is_empty() {
        return plan.set_leaf(node, &part.ids);
    }
    let first = plan.add(part.parts.len());
    plan.set_children(node, first, part.parts.len(), &part.ids);
    for (child, part) in (first..).zip(&part.parts) {
        place(plan, child, part);
    }
}
