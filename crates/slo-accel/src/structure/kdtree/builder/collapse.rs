//! Joining the nodes of a finished tree to treelets.

use std::ops::Range;

use super::node::Node;
use crate::math::Bounds;
use crate::structure::kdtree::treelet::{Child, MIDDLE, TOP, Treelet, WIDTH};
use crate::structure::shared::pages::Array;

/// Least expected number of treelets that a ray visits in a node and below, in areas: if a treelet
/// begins there, and if one that begins above has one or two more levels.
type Steps = [f32; 3];

struct Collapse<'a> {
    nodes: &'a [Node],
    steps: Vec<Steps>,
    /// What makes the largest extent 1.
    scale: f64,
    /// Leaves have their places in the arena, as if it came first.
    treelets: Vec<Treelet>,
}

/// Joins nodes to treelets so that the expected number of treelets that a ray visits is least; the
/// root comes first, and the words of the arena follow. Also returns the number of treelets on the
/// longest way down.
pub(super) fn collapse(nodes: &[Node], arena: &[u32], bounds: Bounds) -> (Array<Treelet>, usize) {
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    let mut collapse = Collapse {
        nodes,
        steps: vec![[0.0; 3]; nodes.len()],
        scale: if extent > 0.0 { 1.0 / extent } else { 1.0 },
        treelets: Vec::with_capacity(nodes.len() / 6),
    };
    collapse.plan(Node::ROOT, bounds);
    collapse.treelets.push(Treelet::EMPTY);
    let depth = collapse.fill(0, Node::ROOT);
    let treelets = collapse.treelets;
    let words = treelets.len() * LINE;
    let mut lines = Array::filled(Treelet::EMPTY, treelets.len() + arena.len().div_ceil(LINE));
    let (first, rest) = lines.split_at_mut(treelets.len());
    for (line, treelet) in first.iter_mut().zip(treelets) {
        let children = treelet.children.map(|child| child.behind(words));
        *line = Treelet { children, ..treelet };
    }
    for (line, words) in rest.iter_mut().zip(arena.chunks(LINE)) {
        *line = line_of(words);
    }
    (lines, depth)
}

/// Words of a line.
const LINE: usize = size_of::<Treelet>() / 4;

/// A line of words, filled up with zeros.
fn line_of(words: &[u32]) -> Treelet {
    let mut line = [0; LINE];
    line[..words.len()].copy_from_slice(words);
    Treelet {
        planes: std::array::from_fn(|i| f32::from_bits(line[i])),
        axes: line[WIDTH - 1],
        children: std::array::from_fn(|i| Child(line[WIDTH + i])),
    }
}

impl Child {
    /// The same after words were put before the arena.
    fn behind(self, words: usize) -> Self {
        if self.is_treelet() { self } else { Self(self.0 + (words / Self::UNIT) as u32) }
    }
}

impl Collapse<'_> {
    fn plan(&mut self, node: usize, bounds: Bounds) {
        let inner = self.nodes[node];
        if inner.is_leaf() {
            return;
        }
        let children = inner.children();
        let (mut below, mut above) = (bounds, bounds);
        below.max[inner.axis()] = inner.position();
        above.min[inner.axis()] = inner.position();
        self.plan(children[0], below);
        self.plan(children[1], above);
        let d = (bounds.max.as_dvec3() - bounds.min.as_dvec3()) * self.scale;
        let area = (d.x * d.y + d.y * d.z + d.z * d.x) as f32;
        let [low, high] = children.map(|child| self.steps[child]);
        let joined = |levels: usize| low[levels] + high[levels];
        let begun = area + joined(2);
        self.steps[node] = [begun, begun.min(joined(0)), begun.min(joined(1))];
    }

    /// Makes a node the root of the treelet in a line; returns the number of treelets down to the
    /// deepest leaf.
    fn fill(&mut self, line: usize, node: usize) -> usize {
        let mut treelet = Treelet::EMPTY;
        let mut roots = vec![];
        if self.nodes[node].is_leaf() {
            treelet.children[0] = self.leaf(node);
        } else {
            self.join(&mut treelet, node, TOP, 0..WIDTH, &mut roots);
        }
        let first = self.treelets.len();
        for (i, &(place, _)) in roots.iter().enumerate() {
            treelet.children[place] = Child::treelet(first + i);
        }
        self.treelets[line] = treelet;
        self.treelets.extend(roots.iter().map(|_| Treelet::EMPTY));
        let depths = roots.into_iter().enumerate().map(|(i, (_, root))| self.fill(first + i, root));
        1 + depths.max().unwrap_or(0)
    }

    /// Makes a node a plane of a treelet, whose children in some places are those below and above
    /// it; `roots` get those that are treelets, by their places.
    fn join(
        &self,
        treelet: &mut Treelet,
        node: usize,
        plane: usize,
        places: Range<usize>,
        roots: &mut Vec<(usize, usize)>,
    ) {
        let inner = self.nodes[node];
        let empty = inner.children().map(|child| self.nodes[child].is_empty());
        treelet.set_plane(plane, inner.axis(), inner.position(), empty);
        let half = places.len() / 2;
        let levels = half.ilog2() as usize;
        for (side, child) in inner.children().into_iter().enumerate() {
            let first = places.start + side * half;
            let steps = self.steps[child];
            if self.nodes[child].is_leaf() {
                treelet.children[first] = self.leaf(child);
            } else if steps[levels] < steps[0] {
                let plane = if plane == TOP { MIDDLE + side } else { first / 2 };
                self.join(treelet, child, plane, first..first + half, roots);
            } else {
                roots.push((first, child));
            }
        }
    }

    fn leaf(&self, node: usize) -> Child {
        let leaf = self.nodes[node];
        if leaf.is_empty() { Child::EMPTY } else { Child::leaf(leaf.chunk(), leaf.offset()) }
    }
}
