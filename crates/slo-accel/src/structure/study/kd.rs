//! A kd-tree, built by the surface area heuristic, and four ways to traverse it.
//!
//! Sources: Wald, Havran, *On building fast kd-Trees for Ray Tracing, and on doing that in
//! O(N log N)*, RT 2006 (the cost; here events are sorted again in each node, which is
//! O(N log^2 N)); Foley, Sugerman, *KD-Tree Acceleration Structures for a GPU Raytracer*, Graphics
//! Hardware 2005 (restart); Horn, Sugerman, Houston, Hanrahan, *Interactive k-D Tree GPU Raytracing*,
//! I3D 2007 (push-down and short stack).
//!
//! It departs from them where a ray starts again. They go on where the last leaf ended, so that flat
//! cells and leaves within rounding of each other are lost or visited for ever. Here two bits for each
//! level remember which far children wait, and which have been taken, after Laine, *Restart Trail for
//! Stackless BVH Traversal*, HPG 2010. All four ways therefore visit the same leaves.
//!
//! Boxes of objects are cut at the cells, but not the objects within. Nothing is taken off the cost of
//! planes that cut off empty space.

use super::Study;
use super::counting::Counting;
use super::layout::{KdNode as Node, Layout};
use super::memory::{Memory, Tests, Visit};
use super::parameters::{Parameters, Traversal};
use super::ray::{Cell, Line, Ray, solid};
use super::statistics::{COST_OF_STEP, COST_OF_TEST, Meter, Statistics};
use crate::math::Bounds;

/// Levels have a bit each.
const DEEPEST: u32 = 63;

/// Entries of a short stack, if not given.
const SHORT: u32 = 4;

/// Most references: nodes are not cut any more.
const MOST: usize = 1 << 28;

/// A kd-tree.
#[derive(Debug)]
pub struct Kd {
    bounds: Cell,
    objects: usize,
    mailbox: bool,
    traversal: Traversal,
    stack: usize,
    nodes: Vec<Node>,
    references: Vec<u32>,
    bytes_of_building: usize,
}

impl Study for Kd {
    fn build(objects: &[Bounds], parameters: &Parameters) -> Self {
        let (ids, bounds) = solid(objects);
        // As Wald and Havran limit it.
        let usual = 8 + (13 * ids.len().max(1).ilog2()) / 10;
        let mut tree = Self {
            bounds,
            objects: objects.len(),
            mailbox: parameters.mailbox,
            traversal: parameters.traversal,
            stack: parameters.stack.unwrap_or(SHORT).max(1) as usize,
            nodes: vec![],
            references: vec![],
            bytes_of_building: 0,
        };
        if !ids.is_empty() {
            let deepest = parameters.depth.unwrap_or(usual).min(DEEPEST);
            let leaf = parameters.leaf.unwrap_or(1) as usize;
            let mut plan = Plan { objects, deepest, leaf, events: vec![], meter: Meter::default() };
            tree.nodes.push(Node::Leaf { start: 0, count: 0 });
            plan.meter.take(size_of_val(&*ids));
            tree.split(&mut plan, 0, bounds, 0, ids);
            tree.bytes_of_building = plan.meter.highest();
        }
        tree
    }

    fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &Ray,
        memory: &mut Memory,
        counting: &mut C,
        visit: V,
    ) -> f32 {
        let (stack, mut tests) =
            memory.begin(self.objects, self.mailbox, ray.t_max, counting, visit);
        if !self.nodes.is_empty() {
            let line = Line::new(ray, &self.bounds);
            let [near, far] = line.span(&self.bounds, ray.t_max);
            let root = Visit { node: 0, near, far };
            if near > far {
                // The ray passes by.
            } else if self.traversal == Traversal::Stack {
                self.follow(&line, root, stack, &mut tests);
            } else {
                self.follow_again(&line, root, stack, &mut tests);
            }
        }
        tests.t_max
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::new(self.objects);
        let root = (!self.nodes.is_empty()).then_some((0, self.bounds, 0));
        let mut stack = Vec::from_iter(root);
        while let Some((node, cell, depth)) = stack.pop() {
            match self.nodes[node as usize] {
                Node::Interior { axis, plane, first } => {
                    statistics.add_interior(cell.area());
                    let [left, right] = halves(&cell, usize::from(axis), plane);
                    stack.extend([(first, left, depth + 1), (first + 1, right, depth + 1)]);
                }
                Node::Leaf { count, .. } => {
                    statistics.add_leaf(count as usize, depth, cell.area());
                }
            }
        }
        let area = if self.nodes.is_empty() { 0.0 } else { self.bounds.area() };
        statistics.finish(area, self.bytes(), self.bytes_of_building)
    }

    fn layout(&self) -> Option<Layout<'_>> {
        let stack = match self.traversal {
            Traversal::Stack => None,
            Traversal::ShortStack => Some(self.stack),
            Traversal::Restart | Traversal::PushDown => Some(0),
        };
        let pushes_down = self.traversal != Traversal::Restart;
        (!self.mailbox).then_some(Layout::Kd {
            ends: [self.bounds.min, self.bounds.max],
            nodes: &self.nodes,
            references: &self.references,
            stack,
            pushes_down,
        })
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.references)
    }
}

/// The parts of a cell below and above a plane.
fn halves(cell: &Cell, axis: usize, plane: f32) -> [Cell; 2] {
    let (mut left, mut right) = (*cell, *cell);
    left.max[axis] = f64::from(plane);
    right.min[axis] = f64::from(plane);
    [left, right]
}

/// What building needs.
struct Plan<'a> {
    objects: &'a [Bounds],
    deepest: u32,
    leaf: usize,
    events: Vec<Event>,
    meter: Meter,
}

/// Where a box begins, lies flat, or ends along an axis.
#[derive(Clone, Copy)]
struct Event {
    at: f32,
    kind: EventKind,
}

/// At the same place, what ends comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum EventKind {
    Ends,
    LiesFlat,
    Begins,
}

/// Where a node is cut.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    plane: f32,
    /// Whether boxes that lie in the plane go to the left.
    flat_left: bool,
    cost: f64,
}

impl Plan<'_> {
    /// The ends of an object's box within a cell.
    fn ends(&self, id: u32, cell: &Cell, axis: usize) -> [f32; 2] {
        let Bounds { min, max } = self.objects[id as usize];
        [min[axis].max(cell.min[axis] as f32), max[axis].min(cell.max[axis] as f32)]
    }

    /// The cheapest cut, if one costs less than a leaf.
    fn best_cut(&mut self, ids: &[u32], cell: &Cell) -> Option<Cut> {
        let mut best: Option<Cut> = None;
        for axis in 0..3 {
            let mut events = std::mem::take(&mut self.events);
            events.clear();
            for &id in ids {
                let [at, end] = self.ends(id, cell, axis);
                if at == end {
                    events.push(Event { at, kind: EventKind::LiesFlat });
                } else {
                    events.push(Event { at, kind: EventKind::Begins });
                    events.push(Event { at: end, kind: EventKind::Ends });
                }
            }
            events.sort_unstable_by(|a, b| a.at.total_cmp(&b.at).then(a.kind.cmp(&b.kind)));
            self.sweep(&events, ids.len(), cell, axis, &mut best);
            self.events = events;
        }
        best.filter(|best| best.cost < COST_OF_TEST * ids.len() as f64)
    }

    /// Compares the planes of an axis at which boxes begin or end.
    fn sweep(
        &self,
        events: &[Event],
        objects: usize,
        cell: &Cell,
        axis: usize,
        best: &mut Option<Cut>,
    ) {
        let whole = cell.area();
        let (mut left, mut right) = (0, objects);
        let mut i = 0;
        while i < events.len() {
            let plane = events[i].at;
            let mut at_plane = [0usize; 3];
            while i < events.len() && events[i].at == plane {
                at_plane[events[i].kind as usize] += 1;
                i += 1;
            }
            let [end, flat, begin] = at_plane;
            right -= end + flat;
            let is_inside = cell.min[axis] < f64::from(plane) && f64::from(plane) < cell.max[axis];
            if is_inside {
                let areas = halves(cell, axis, plane).map(|half| half.area() / whole);
                for flat_left in [true, false] {
                    let (l, r) =
                        if flat_left { (left + flat, right) } else { (left, right + flat) };
                    let tests = areas[0] * l as f64 + areas[1] * r as f64;
                    let cost = COST_OF_STEP + COST_OF_TEST * tests;
                    if best.is_none_or(|best| cost < best.cost) {
                        *best = Some(Cut { axis, plane, flat_left, cost });
                    }
                }
            }
            left += begin + flat;
        }
    }
}

impl Kd {
    fn split(&mut self, plan: &mut Plan<'_>, node: usize, cell: Cell, depth: u32, ids: Vec<u32>) {
        let may_cut = ids.len() > plan.leaf && depth < plan.deepest && self.references.len() < MOST;
        let cut = may_cut.then(|| plan.best_cut(&ids, &cell)).flatten();
        let Some(Cut { axis, plane, flat_left, .. }) = cut else {
            self.nodes[node] =
                Node::Leaf { start: self.references.len() as u32, count: ids.len() as u32 };
            self.references.extend(&ids);
            plan.meter.take(size_of_val(&*ids));
            return plan.meter.give_back(size_of_val(&*ids));
        };
        let (mut left, mut right) = (vec![], vec![]);
        for &id in &ids {
            let [min, max] = plan.ends(id, &cell, axis);
            let is_in_plane = min == plane && max == plane;
            if min < plane || (is_in_plane && flat_left) {
                left.push(id);
            }
            if max > plane || (is_in_plane && !flat_left) {
                right.push(id);
            }
        }
        let first = self.nodes.len();
        self.nodes[node] = Node::Interior { axis: axis as u8, plane, first: first as u32 };
        self.nodes.extend([Node::Leaf { start: 0, count: 0 }; 2]);
        plan.meter.take(2 * size_of::<Node>() + size_of_val(&*left) + size_of_val(&*right));
        plan.meter.give_back(size_of_val(&*ids));
        drop(ids);
        let [below, above] = halves(&cell, axis, plane);
        self.split(plan, first, below, depth + 1, left);
        self.split(plan, first + 1, above, depth + 1, right);
    }

    /// The children that a ray visits in an interior node: the first, if it does, and the second.
    fn children(
        line: &Line,
        Visit { near, far, .. }: Visit,
        (axis, plane, first): (u8, f32, u32),
    ) -> [Option<Visit>; 2] {
        let axis = usize::from(axis);
        let crossing = line.crossing(axis, f64::from(plane));
        let falls = u32::from(line.falls(axis));
        let before = Visit { node: first + falls, near, far: far.min(crossing.late) };
        let behind = Visit { node: first + 1 - falls, near: near.max(crossing.early), far };
        [before, behind].map(|visit| Some(visit).filter(|visit| visit.near <= visit.far))
    }

    /// Visits leaves with a stack that holds all nodes that wait.
    fn follow<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        root: Visit,
        stack: &mut Vec<Visit>,
        tests: &mut Tests<'_, C, V>,
    ) {
        stack.push(root);
        while let Some(visit) = stack.pop() {
            if !tests.reaches(visit.near) {
                continue;
            }
            tests.counting.step();
            match self.nodes[visit.node as usize] {
                Node::Interior { axis, plane, first } => {
                    let [before, behind] = Self::children(line, visit, (axis, plane, first));
                    stack.extend(behind);
                    stack.extend(before);
                }
                Node::Leaf { start, count } => {
                    tests.leaf(&self.references[start as usize..][..count as usize]);
                }
            }
        }
    }

    /// Visits leaves with a short stack or none, and starts again for nodes that it does not hold.
    fn follow_again<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        root: Visit,
        stack: &mut Vec<Visit>,
        tests: &mut Tests<'_, C, V>,
    ) {
        let entries = if self.traversal == Traversal::ShortStack { self.stack } else { 0 };
        let pushes_down = self.traversal != Traversal::Restart;
        // The node at which the ray starts again, and its level.
        let (mut again, mut top) = (root, 0);
        let (mut at, mut level) = (root, 0u32);
        // Levels whose second child waits, and levels whose second child has its turn.
        let (mut waiting, mut taken) = (0u64, 0u64);
        loop {
            let leaf = loop {
                if !tests.reaches(at.near) {
                    break None;
                }
                tests.counting.step();
                let (axis, plane, first) = match self.nodes[at.node as usize] {
                    Node::Interior { axis, plane, first } => (axis, plane, first),
                    Node::Leaf { start, count } => {
                        break Some(start as usize..(start + count) as usize);
                    }
                };
                let bit = 1 << level;
                at = match Self::children(line, at, (axis, plane, first)) {
                    [Some(_), Some(behind)] if taken & bit != 0 => behind,
                    [Some(before), Some(behind)] => {
                        waiting |= bit;
                        if stack.len() == entries && entries > 0 {
                            stack.remove(0);
                        }
                        if entries > 0 {
                            stack.push(behind);
                        }
                        before
                    }
                    [Some(only), None] | [None, Some(only)] => only,
                    // Not so: a ray that enters a node enters a child.
                    [None, None] => break None,
                };
                level += 1;
                if pushes_down && waiting == 0 {
                    (again, top) = (at, level);
                }
            };
            if let Some(leaf) = leaf {
                tests.leaf(&self.references[leaf]);
            }
            // The deepest second child that waits is the next.
            loop {
                if waiting == 0 {
                    return;
                }
                let deepest = 63 - waiting.leading_zeros();
                waiting &= !(1 << deepest);
                taken = (taken & ((1 << deepest) - 1)) | 1 << deepest;
                if let Some(next) = stack.pop() {
                    if !tests.reaches(next.near) {
                        continue;
                    }
                    (at, level) = (next, deepest + 1);
                    if pushes_down && waiting == 0 {
                        (again, top) = (at, level);
                    }
                } else {
                    if !tests.reaches(again.near) {
                        return;
                    }
                    tests.counting.restart();
                    (at, level) = (again, top);
                }
                break;
            }
        }
    }
}
