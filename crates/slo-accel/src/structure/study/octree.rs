//! An octree whose nodes are cut in the middle, or by cost.
//!
//! Source: Glassner, *Space Subdivision for Fast Ray Tracing*, IEEE CG&A 1984. It departs from it:
//! nodes lie in arrays and not in a hash table, and the children of a node are visited from near to
//! far from a stack. A child is visited if its part of the ray, between the crossings of the three
//! planes, is not empty.
//!
//! [`Planes::Cost`] is Octree-R: Whang, Song, Chang, Lee, Cho, Kim, *Octree-R: An Adaptive Octree for
//! Efficient Ray Tracing*, IEEE TVCG 1995, after MacDonald and Booth, *Heuristics for Ray Tracing
//! Using Space Subdivision*, The Visual Computer 1990. Each axis by itself is cut at the best of ten
//! places, evenly spaced from the middle of the cell to the median of the objects, which is taken to
//! be the mean of their middles within the cell. Havran and Sixta (1999) do not say which median is
//! theirs; this one gives their numbers of nodes.
//!
//! An object belongs to all leaves that its box touches. Nodes are cut level by level, until the
//! leaves would hold too many references.

use std::collections::VecDeque;

use super::counting::Counting;
use super::memory::{Memory, Tests, Visit};
use super::parameters::{Parameters, Planes};
use super::ray::{Cell, Crossing, Line, Ray, solid};
use super::statistics::{Meter, Statistics};
use super::{MARGIN, Study};
use crate::math::Bounds;

/// Most references, unless there are more than that many for each object.
const MOST: usize = 1 << 20;
const MOST_PER_OBJECT: usize = 256;

/// Deeper trees would have cells that f64 cannot tell apart.
const DEEPEST: u32 = 24;

/// An octree.
#[derive(Debug)]
pub struct Octree {
    bounds: Cell,
    objects: usize,
    mailbox: bool,
    nodes: Vec<Node>,
    /// Where each interior node is cut: the first has the children 1 to 8, the next 9 to 16.
    planes: Vec<[f64; 3]>,
    references: Vec<u32>,
    bytes_of_building: usize,
}

/// A node.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Of an interior node: its number among these. Of a leaf: its first reference.
    start: u32,
    /// Number of references of a leaf; [`INTERIOR`] for an interior node.
    count: u32,
}

const INTERIOR: u32 = u32::MAX;

/// A node that is not finished.
struct Pending {
    node: usize,
    cell: Cell,
    depth: u32,
    objects: Vec<u32>,
}

impl Study for Octree {
    fn build(objects: &[Bounds], parameters: &Parameters) -> Self {
        let (ids, bounds) = solid(objects);
        let bounds = bounds.grown(MARGIN);
        let depth = parameters.depth.unwrap_or_else(|| depth_of(ids.len())).min(DEEPEST);
        let leaf = parameters.leaf.unwrap_or(1) as usize;
        let most = (ids.len() * MOST_PER_OBJECT).max(MOST);
        let mut tree = Self {
            bounds,
            objects: objects.len(),
            mailbox: parameters.mailbox,
            nodes: vec![],
            planes: vec![],
            references: vec![],
            bytes_of_building: 0,
        };
        if ids.is_empty() {
            return tree;
        }
        let mut meter = Meter::default();
        meter.take(size_of_val(&*ids));
        let mut pending = 0;
        let mut queue = VecDeque::from([Pending { node: 0, cell: bounds, depth: 0, objects: ids }]);
        tree.nodes.push(Node { start: 0, count: 0 });
        while let Some(Pending { node, cell, depth: at, objects: inside }) = queue.pop_front() {
            pending -= inside.len().min(pending);
            let cut = if inside.len() <= leaf || at == depth {
                None
            } else {
                let planes = match parameters.planes {
                    Planes::Middle => middle(&cell),
                    Planes::Cost => cheapest(&cell, objects, &inside),
                };
                Some((planes, children(objects, &inside, planes)))
            };
            let cut = cut.filter(|(_, children)| {
                let sum: usize = children.iter().map(Vec::len).sum();
                tree.references.len() + pending + sum <= most
            });
            let bytes = size_of_val(&*inside);
            if let Some((planes, children)) = cut {
                tree.nodes[node] = Node { start: tree.planes.len() as u32, count: INTERIOR };
                tree.planes.push(planes);
                meter.take(size_of_val(&planes));
                for (number, objects) in children.into_iter().enumerate() {
                    let cell = part(&cell, planes, number);
                    pending += objects.len();
                    meter.take(size_of::<Node>() + size_of_val(&*objects));
                    let node = tree.nodes.len();
                    tree.nodes.push(Node { start: 0, count: 0 });
                    queue.push_back(Pending { node, cell, depth: at + 1, objects });
                }
            } else {
                let start = tree.references.len() as u32;
                tree.nodes[node] = Node { start, count: inside.len() as u32 };
                tree.references.extend(&inside);
                meter.take(bytes);
            }
            meter.give_back(bytes);
        }
        tree.bytes_of_building = meter.highest();
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
            self.follow(&Line::new(ray, &self.bounds), stack, &mut tests);
        }
        tests.t_max
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::new(self.objects);
        let root = (!self.nodes.is_empty()).then_some((0, self.bounds, 0));
        let mut stack = Vec::from_iter(root);
        while let Some((node, cell, depth)) = stack.pop() {
            let Node { start, count } = self.nodes[node];
            if count == INTERIOR {
                statistics.add_interior(cell.area());
                let planes = self.planes[start as usize];
                let child = |number| (child(start, number), part(&cell, planes, number), depth + 1);
                stack.extend((0..8).map(child));
            } else {
                statistics.add_leaf(count as usize, depth, cell.area());
            }
        }
        statistics.finish(self.bounds.area(), self.bytes(), self.bytes_of_building)
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.planes) + size_of_val(&*self.references)
    }
}

/// The depth at which cells of a surface of as many objects hold about one: each level cuts the
/// cells that a surface passes into four.
fn depth_of(objects: usize) -> u32 {
    (objects.max(1).ilog2() / 2).clamp(1, 12)
}

fn middle(cell: &Cell) -> [f64; 3] {
    std::array::from_fn(|axis| 0.5 * (cell.min[axis] + cell.max[axis]))
}

/// Places that are compared along an axis.
const PLACES: u32 = 10;

/// Along each axis, the place between the middle and the mean of the objects at which the areas of the
/// two halves, times the numbers of their objects, have the least sum.
fn cheapest(cell: &Cell, objects: &[Bounds], inside: &[u32]) -> [f64; 3] {
    let middle = middle(cell);
    std::array::from_fn(|axis| {
        let ends = |id: &u32| {
            let Bounds { min, max } = objects[*id as usize];
            [f64::from(min[axis]), f64::from(max[axis])]
        };
        let clamp = |x: f64| x.clamp(cell.min[axis], cell.max[axis]);
        let middles = inside.iter().map(ends).map(|[min, max]| 0.5 * (clamp(min) + clamp(max)));
        let mean = clamp(middles.sum::<f64>() / inside.len() as f64);
        let place = |i: u32| {
            let share = f64::from(i) / f64::from(PLACES - 1);
            clamp(middle[axis] + share * (mean - middle[axis]))
        };
        let cost = |plane: f64| {
            let (mut below, mut above) = (*cell, *cell);
            (below.max[axis], above.min[axis]) = (plane, plane);
            let (mut left, mut right) = (0, 0);
            for [min, max] in inside.iter().map(ends) {
                left += u32::from(min <= plane);
                right += u32::from(max >= plane);
            }
            below.area() * f64::from(left) + above.area() * f64::from(right)
        };
        let costs = (0..PLACES).map(|i| (place(i), cost(place(i))));
        costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(middle[axis], |(plane, _)| plane)
    })
}

/// Child `number` of an interior node: bit 0, 1 and 2 choose the upper half along x, y and z.
#[inline]
fn child(interior: u32, number: usize) -> usize {
    8 * interior as usize + 1 + number
}

/// The box of a child.
fn part(cell: &Cell, planes: [f64; 3], number: usize) -> Cell {
    let mut part = *cell;
    for (axis, plane) in planes.into_iter().enumerate() {
        if number >> axis & 1 == 1 {
            part.min[axis] = plane;
        } else {
            part.max[axis] = plane;
        }
    }
    part
}

/// The objects of each child.
fn children(objects: &[Bounds], inside: &[u32], planes: [f64; 3]) -> [Vec<u32>; 8] {
    std::array::from_fn(|number| {
        let touches = |&&id: &&u32| {
            let bounds = &objects[id as usize];
            (0..3).all(|axis| {
                if number >> axis & 1 == 1 {
                    f64::from(bounds.max[axis]) >= planes[axis]
                } else {
                    f64::from(bounds.min[axis]) <= planes[axis]
                }
            })
        };
        inside.iter().filter(touches).copied().collect()
    })
}

impl Octree {
    fn follow<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        stack: &mut Vec<Visit>,
        tests: &mut Tests<'_, C, V>,
    ) {
        // The numbers of children from near to far, for a ray that rises everywhere: 0 to 7.
        let mirror = (0..3).fold(0, |mirror, axis| mirror | usize::from(line.falls(axis)) << axis);
        let [near, far] = line.span(&self.bounds, tests.t_max);
        if near <= far {
            stack.push(Visit { node: 0, near, far });
        }
        while let Some(Visit { node, near, far }) = stack.pop() {
            if !tests.reaches(near) {
                continue;
            }
            tests.counting.step();
            let Node { start, count } = self.nodes[node as usize];
            if count != INTERIOR {
                tests.leaf(&self.references[start as usize..][..count as usize]);
                continue;
            }
            let planes = self.planes[start as usize];
            let crossings: [Crossing; 3] =
                std::array::from_fn(|axis| line.crossing(axis, planes[axis]));
            for order in (0..8usize).rev() {
                let (mut near, mut far) = (near, far);
                for (axis, crossing) in crossings.iter().enumerate() {
                    if order >> axis & 1 == 1 {
                        near = near.max(crossing.early);
                    } else {
                        far = far.min(crossing.late);
                    }
                }
                if near <= far {
                    let node = child(start, order ^ mirror) as u32;
                    stack.push(Visit { node, near, far });
                }
            }
        }
    }
}
