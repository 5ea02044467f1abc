//! Building: the surface area heuristic over all planes that matter, in O(N log N).
//!
//! Source: Wald, Havran, *On building fast kd-trees for ray tracing, and on doing that in
//! O(N log N)*, RT 2006. Here leaves cost by the registers of triangles they fill, subtrees are
//! built in parallel, and a bound on the references keeps any input within a known memory.

mod arena;
mod axes;
mod collapse;
mod events;
mod node;
mod split;
mod sweep;

use rayon::prelude::*;

use self::arena::Arena;
use self::axes::PARALLEL_SIZE;
use self::node::Node;
use self::split::Cell;
use self::sweep::{Costs, Plane, best_plane};
use super::leaf::Chunk;
use super::tree::{FAR, KdTree, MAX_DEPTH};
use crate::isa::Isa;
use crate::primitives::{Primitives, triangle};

/// Costs that the sweep expects, before it is known how primitives fill registers.
const COSTS: Costs = Costs { leaf: 6.0, primitive: 0.6, empty_bonus: 0.9 };

/// Cost of a register of triangles, in planes that a ray comes to.
const REGISTER_COST: f64 = 10.0;

/// Expected cost of a leaf of `n` primitives.
fn leaf_cost(n: usize) -> f64 {
    REGISTER_COST * n.div_ceil(Chunk::MAX_TRIANGLES) as f64
}

/// Builds the tree of all primitives that can be hit.
pub(super) fn build(primitives: Primitives, isa: Isa) -> KdTree {
    let ids: Vec<u32> = (0..primitives.len() as u32)
        .into_par_iter()
        .filter(|&id| {
            primitives.triangles.get(id as usize).is_none_or(|t| !triangle::is_degenerate(t))
        })
        .collect();
    let n = ids.len();
    let cell = Cell::new(&primitives, ids);
    let bounds = cell.bounds;
    let depth = (8 + 2 * n.max(1).ilog2() as usize).min(MAX_DEPTH);
    let builder = Builder { primitives: &primitives };
    let mut part = Part::new();
    builder.grow(&mut part, Node::ROOT, cell, Limits { depth, duplicates: 4 * n });
    part.arena.finish();
    let (lines, depth) = collapse::collapse(&part.nodes, &part.arena.words, bounds);
    let is_far = size_of_val(&*lines) > FAR;
    KdTree { primitives, bounds, lines, depth, is_far, isa }
}

/// What a subtree may use.
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
    /// The root, its unused neighbour, and pairs of siblings.
    nodes: Vec<Node>,
    arena: Arena,
}

impl Part {
    fn new() -> Self {
        Self { nodes: vec![Node::EMPTY; 2], arena: Arena::default() }
    }

    /// Takes over a subtree grown apart, as node `at`.
    fn graft(&mut self, at: usize, grown: Self) {
        // Its first pair, the root's, stays behind.
        let (pairs, words) = (self.nodes.len() as u32 / 2 - 1, self.arena.words.len() as u32);
        self.nodes[at] = grown.nodes[Node::ROOT].moved(pairs, words);
        self.nodes.extend(grown.nodes[2..].iter().map(|node| node.moved(pairs, words)));
        self.arena.append(grown.arena);
    }
}

/// Subtrees of up to this many primitives become leaves if that turns out to be no more expensive.
const PRUNED_SIZE: usize = 64;

struct Builder<'a> {
    primitives: &'a Primitives,
}

impl Builder<'_> {
    /// Makes node `at` of `part` the root of a cell's tree; its expected cost.
    fn grow(&self, part: &mut Part, at: usize, cell: Cell, limits: Limits) -> f64 {
        let n = cell.ids.len();
        let Some(plane) = self.plane(&cell, limits) else {
            return self.leaf(part, at, &cell.ids);
        };
        let before = (part.nodes.len(), part.arena.words.len());
        let ids = (n <= PRUNED_SIZE).then(|| cell.ids.clone());
        let area = cell.area();
        let children = cell.split(self.primitives, &plane);
        let chances = [children[0].area() / area, children[1].area() / area];
        let limits = limits.of_children(n, [children[0].ids.len(), children[1].ids.len()]);
        part.nodes.extend([Node::EMPTY; 2]);
        let costs = self.grow_both(part, before.0, children, limits, n >= PARALLEL_SIZE);
        let cost = 1.0 + chances[0] * costs[0] + chances[1] * costs[1];
        if let Some(ids) = ids.filter(|_| leaf_cost(n) <= cost) {
            part.nodes.truncate(before.0);
            part.arena.words.truncate(before.1);
            return self.leaf(part, at, &ids);
        }
        part.nodes[at] = Node::inner(plane.axis, plane.position, before.0 / 2);
        cost
    }

    fn leaf(&self, part: &mut Part, at: usize, ids: &[u32]) -> f64 {
        if !ids.is_empty() {
            part.nodes[at] = part.arena.push_leaf(self.primitives, ids);
        }
        leaf_cost(ids.len())
    }

    /// Grows two siblings, in parallel each in a part of its own.
    fn grow_both(
        &self,
        part: &mut Part,
        at: usize,
        [below, above]: [Cell; 2],
        limits: [Limits; 2],
        parallel: bool,
    ) -> [f64; 2] {
        if !parallel {
            let below = self.grow(part, at, below, limits[0]);
            return [below, self.grow(part, at + 1, above, limits[1])];
        }
        let grow = |cell, limits| {
            let mut part = Part::new();
            (self.grow(&mut part, Node::ROOT, cell, limits), part)
        };
        let (below, above) = rayon::join(|| grow(below, limits[0]), || grow(above, limits[1]));
        part.graft(at, below.1);
        part.graft(at + 1, above.1);
        [below.0, above.0]
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
