//! Hierarchies of boxes: nodes of any number of children, and one traversal for all builders.
//!
//! Source: Rubin, Whitted, *A 3-Dimensional Representation for Fast Rendering of Complex Scenes*,
//! SIGGRAPH 1980; children are visited in the order in which the ray enters their boxes, after Kay,
//! Kajiya, *Ray Tracing Complex Scenes*, SIGGRAPH 1986, though not those of different parents. A
//! visited node tests the boxes of all of its children; the children that the ray enters wait on a
//! stack, and are dropped if a nearer hit is found before their turn.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::Study;
use super::counting::Counting;
use super::layout::{BoxNode as Node, Layout};
use super::memory::{Memory, Tests, Visit};
use super::overlap::{Part, end_point_overlap};
use super::parameters::Parameters;
use super::ray::{Cell, Line, Ray, solid};
use super::statistics::{Meter, Statistics};
use crate::math::Bounds;
use crate::primitives::Triangle;

/// How a hierarchy is built.
pub trait Builder: Debug + Send + Sync {
    /// Builds a hierarchy over `ids`, which are not empty, from their boxes.
    #[doc(hidden)]
    fn build(plan: &mut Plan<'_>, ids: Vec<u32>, parameters: &Parameters);
}

/// A hierarchy of boxes.
#[derive(Debug)]
pub struct Hierarchy<B> {
    objects: usize,
    nodes: Vec<Node>,
    references: Vec<u32>,
    bytes_of_building: usize,
    builder: PhantomData<B>,
}

/// A hierarchy that is being built. The root is node 0.
#[derive(Debug)]
pub struct Plan<'a> {
    pub(super) objects: &'a [Bounds],
    nodes: Vec<Node>,
    references: Vec<u32>,
    pub(super) meter: Meter,
}

impl Plan<'_> {
    /// Adds nodes without contents, side by side, and returns the number of the first.
    pub(super) fn add(&mut self, count: usize) -> usize {
        let first = self.nodes.len();
        let node = Node { bounds: Bounds::EMPTY, start: 0, count: 0, is_leaf: true };
        self.nodes.resize(first + count, node);
        self.meter.take(count * size_of::<Node>());
        first
    }

    /// Makes a leaf of a node.
    pub(super) fn set_leaf(&mut self, node: usize, ids: &[u32]) {
        let start = self.references.len() as u32;
        self.references.extend(ids);
        self.meter.take(size_of_val(ids));
        let bounds = self.bounds(ids);
        self.nodes[node] = Node { bounds, start, count: ids.len() as u32, is_leaf: true };
    }

    /// Makes `count` nodes from `first` on the children of a node. Its box is that of `ids`, all objects
    /// below.
    pub(super) fn set_children(&mut self, node: usize, first: usize, count: usize, ids: &[u32]) {
        let (start, count) = (first as u32, count as u32);
        self.nodes[node] = Node { bounds: self.bounds(ids), start, count, is_leaf: false };
    }

    /// The smallest box about objects.
    pub(super) fn bounds(&self, ids: &[u32]) -> Bounds {
        ids.iter().fold(Bounds::EMPTY, |all, &id| all.union(self.objects[id as usize]))
    }

    /// Twice the centre of an object's box.
    pub(super) fn center(&self, id: u32) -> [f64; 3] {
        let Bounds { min, max } = self.objects[id as usize];
        std::array::from_fn(|axis| f64::from(min[axis]) + f64::from(max[axis]))
    }

    /// Sorts objects by their centres along an axis; equal ones by their numbers.
    pub(super) fn sort(&self, ids: &mut [u32], axis: usize) {
        let center = |id: u32| self.center(id)[axis];
        ids.sort_unstable_by(|&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
    }
}

impl<B: Builder> Study for Hierarchy<B> {
    fn build(objects: &[Bounds], parameters: &Parameters) -> Self {
        let (ids, _) = solid(objects);
        let (nodes, references, meter) = (vec![], vec![], Meter::default());
        let mut plan = Plan { objects, nodes, references, meter };
        if !ids.is_empty() {
            plan.meter.take(size_of_val(&*ids));
            B::build(&mut plan, ids, parameters);
        }
        let Plan { nodes, references, meter, .. } = plan;
        let bytes_of_building = meter.highest();
        let objects = objects.len();
        Self { objects, nodes, references, bytes_of_building, builder: PhantomData }
    }

    fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &Ray,
        memory: &mut Memory,
        counting: &mut C,
        visit: V,
    ) -> f32 {
        let (stack, mut tests) = memory.begin(self.objects, false, ray.t_max, counting, visit);
        if let Some(root) = self.nodes.first() {
            let line = Line::new(ray, &Cell::of(&root.bounds));
            self.follow(&line, stack, &mut tests);
        }
        tests.t_max
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::new(self.objects);
        let mut stack = vec![(0, 0)];
        let area = |node: &Node| Cell::of(&node.bounds).area();
        while let Some((number, depth)) = stack.pop() {
            let Some(node) = self.nodes.get(number) else { break };
            if node.is_leaf {
                statistics.add_leaf(node.count as usize, depth, area(node));
            } else {
                statistics.add_interior(area(node));
                let children = node.start as usize..(node.start + node.count) as usize;
                stack.extend(children.map(|child| (child, depth + 1)));
            }
        }
        let area = self.nodes.first().map_or(0.0, area);
        statistics.finish(area, self.bytes(), self.bytes_of_building)
    }

    fn layout(&self) -> Option<Layout<'_>> {
        Some(Layout::Hierarchy { nodes: &self.nodes, references: &self.references })
    }

    fn end_point_overlap(&self, surfaces: &[(u32, Triangle)]) -> Option<f64> {
        let mut places = vec![0; self.objects];
        for (place, &object) in (0..).zip(&self.references) {
            places[object as usize] = place;
        }
        let placed = |&(object, triangle): &(u32, Triangle)| (places[object as usize], triangle);
        let surfaces: Vec<_> = surfaces.iter().map(placed).collect();
        Some(end_point_overlap(&self.parts(), &surfaces))
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.references)
    }
}

impl<B> Hierarchy<B> {
    /// The nodes, with the references below each.
    fn parts(&self) -> Vec<Part> {
        let part = |node: &Node| Part {
            cell: Cell::of(&node.bounds),
            start: node.start,
            count: node.count,
            is_leaf: node.is_leaf,
            first: node.start,
            end: node.start + node.count,
        };
        let mut parts: Vec<Part> = self.nodes.iter().map(part).collect();
        // Children follow their parents, and builders list leaves from left to right.
        for number in (0..parts.len()).rev().filter(|&number| !self.nodes[number].is_leaf) {
            let Part { start, count, .. } = parts[number];
            let children = &parts[start as usize..(start + count) as usize];
            let first = children.iter().map(|child| child.first).min().unwrap_or_default();
            let end = children.iter().map(|child| child.end).max().unwrap_or_default();
            (parts[number].first, parts[number].end) = (first, end);
        }
        parts
    }

    fn follow<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        stack: &mut Vec<Visit>,
        tests: &mut Tests<'_, C, V>,
    ) {
        self.push(line, 0..1, stack, tests);
        while let Some(Visit { node, near, .. }) = stack.pop() {
            if !tests.reaches(near) {
                continue;
            }
            tests.counting.step();
            let Node { start, count, is_leaf, .. } = self.nodes[node as usize];
            if is_leaf {
                tests.leaf(&self.references[start as usize..][..count as usize]);
            } else {
                self.push(line, start..start + count, stack, tests);
            }
        }
    }

    /// Puts the nodes that the ray enters on the stack, the nearest on top.
    fn push<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        nodes: std::ops::Range<u32>,
        stack: &mut Vec<Visit>,
        tests: &mut Tests<'_, C, V>,
    ) {
        tests.counting.boxes(nodes.len() as u64);
        let first = stack.len();
        for node in nodes.rev() {
            let cell = Cell::of(&self.nodes[node as usize].bounds);
            let [near, far] = line.span(&cell, tests.t_max);
            if near <= far {
                stack.push(Visit { node, near, far });
            }
        }
        stack[first..].sort_by(|a, b| b.near.total_cmp(&a.near));
    }
}
