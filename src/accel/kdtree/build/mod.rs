//! Building: the surface area heuristic over all planes that matter, in O(N log N).
//!
//! Source: Wald, Havran, *On building fast kd-trees for ray tracing, and on doing that in
//! O(N log N)*, RT 2006. Here leaves cost by the registers of triangles they fill, subtrees are
//! built in parallel, and a bound on the references keeps any input within a known memory.

mod clip;
mod events;
mod split;
mod sweep;

use split::Cell;
use sweep::{Costs, Plane, best_plane};

use super::leaf::Arena;
use super::node::Node;
use crate::accel::{Primitives, triangle};
use crate::math::Bounds;

/// No tree is deeper, so that stacks of this many entries never overflow.
pub(super) const MAX_DEPTH: usize = 60;

const COSTS: Costs = Costs { leaf: 4.0, primitive: 0.6, empty_bonus: 0.8 };

/// Cells with at least so many primitives are built in parallel.
const PARALLEL_SIZE: usize = 4096;

/// A tree, or a part of one.
#[derive(Debug)]
pub(super) struct Built {
    pub(super) bounds: Bounds,
    /// Root first.
    pub(super) nodes: Vec<Node>,
    pub(super) arena: Arena,
}

/// Builds the tree of all primitives that can be hit.
pub(super) fn build(primitives: &Primitives) -> Built {
    let ids: Vec<u32> = (0..primitives.len() as u32)
        .filter(|&id| {
            primitives.triangles.get(id as usize).is_none_or(|t| !triangle::is_degenerate(t))
        })
        .collect();
    let n = ids.len();
    let cell = Cell::new(primitives, ids);
    let bounds = cell.bounds;
    let depth = (8 + 2 * n.max(1).ilog2() as usize).min(MAX_DEPTH);
    let builder = Builder { primitives };
    let mut part = Part { nodes: vec![Node::EMPTY], arena: Arena::default() };
    builder.grow(&mut part, 0, cell, Limits { depth, duplicates: 4 * n });
    part.arena.finish();
    part.nodes.shrink_to_fit();
    Built { bounds, nodes: part.nodes, arena: part.arena }
}

/// What a subtree may still use.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Levels below this one.
    depth: usize,
    /// References beyond those in the cell.
    duplicates: usize,
}

impl Limits {
    /// The limits of two children that hold `sizes` primitives, of a cell with `n`.
    fn of_children(self, n: usize, sizes: [usize; 2]) -> [Self; 2] {
        let total = sizes[0] + sizes[1];
        let left = (self.duplicates + n).saturating_sub(total);
        let first = (left as u128 * sizes[0] as u128 / total.max(1) as u128) as usize;
        [first, left - first].map(|duplicates| Self { depth: self.depth - 1, duplicates })
    }
}

/// Nodes and leaves of a subtree, and of those before it.
struct Part {
    nodes: Vec<Node>,
    arena: Arena,
}

struct Builder<'a> {
    primitives: &'a Primitives,
}

impl Builder<'_> {
    /// Makes node `at` of `part` the root of a cell's tree.
    fn grow(&self, part: &mut Part, at: usize, cell: Cell, limits: Limits) {
        let Some(plane) = self.plane(&cell, limits) else {
            if !cell.ids.is_empty() {
                part.nodes[at] = part.arena.push_leaf(self.primitives, &cell.ids);
            }
            return;
        };
        let n = cell.ids.len();
        let [below, above] = cell.split(self.primitives, &plane);
        let limits = limits.of_children(n, [below.ids.len(), above.ids.len()]);
        let child = part.nodes.len();
        part.nodes[at] = Node::inner(plane.axis, plane.position, child as u32);
        part.nodes.extend([Node::EMPTY; 2]);
        if n < PARALLEL_SIZE {
            self.grow(part, child, below, limits[0]);
            self.grow(part, child + 1, above, limits[1]);
        } else {
            self.grow_both(part, child, [below, above], limits);
        }
    }

    /// Grows two siblings at once, each in a part of its own.
    fn grow_both(
        &self,
        part: &mut Part,
        child: usize,
        [below, above]: [Cell; 2],
        limits: [Limits; 2],
    ) {
        let grow = |cell, limits| {
            let mut part = Part { nodes: vec![Node::EMPTY], arena: Arena::default() };
            self.grow(&mut part, 0, cell, limits);
            part
        };
        let grown = rayon::join(|| grow(below, limits[0]), || grow(above, limits[1]));
        for (at, grown) in [(child, grown.0), (child + 1, grown.1)] {
            // Its root goes to `at`, the rest to the end.
            let (nodes, words) = (part.nodes.len() as u32 - 1, part.arena.words.len() as u32);
            part.nodes[at] = grown.nodes[0].moved(nodes, words);
            part.nodes.extend(grown.nodes[1..].iter().map(|node| node.moved(nodes, words)));
            part.arena.append(grown.arena);
        }
    }

    /// The plane to split by; none if a leaf is expected to be cheaper, or a limit is reached.
    fn plane(&self, cell: &Cell, limits: Limits) -> Option<Plane> {
        let n = cell.ids.len();
        if n < 2 || limits.depth == 0 || limits.duplicates == 0 {
            return None;
        }
        let plane = best_plane(&cell.bounds, &cell.events, n as u32, &COSTS)?;
        (plane.cost < COSTS.of_leaf(n as u32)).then_some(plane)
    }
}
