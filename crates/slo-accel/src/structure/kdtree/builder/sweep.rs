//! The best plane to split a cell by.
//!
//! Source: Wald, Havran, *On building fast kd-trees for ray tracing, and on doing that in
//! O(N log N)*, RT 2006, algorithms 2 and 4.

use super::axes::{PARALLEL_SIZE, for_axes};
use super::events::{Event, PLANAR, key, kind, position};
use crate::math::Bounds;

/// Costs of the surface area heuristic, in steps of a ray from node to node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    /// Any leaf that is not empty.
    pub(super) leaf: f64,
    /// Each primitive of it.
    pub(super) primitive: f64,
    /// Factor of a split that cuts off emptiness.
    pub(super) empty_bonus: f64,
}

impl Costs {
    /// Expected cost of a leaf of `n` primitives.
    #[inline(always)]
    pub(super) fn of_leaf(&self, n: u32) -> f64 {
        if n == 0 { 0.0 } else { self.leaf + self.primitive * f64::from(n) }
    }
}

/// A plane to split by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) axis: usize,
    pub(super) position: f32,
    /// Whether primitives that lie in it go to the lower side.
    pub(super) planar_below: bool,
    pub(super) cost: f64,
}

/// The plane with the lowest expected cost, strictly inside the cell; the first of equals.
pub(super) fn best_plane(
    bounds: &Bounds,
    events: &[Vec<Event>; 3],
    n: u32,
    costs: &Costs,
) -> Option<Plane> {
    let on_axis = |axis: usize| best_on_axis(bounds, axis, &events[axis], n, costs);
    for_axes(n as usize >= PARALLEL_SIZE, [0, 1, 2], on_axis)
        .into_iter()
        .flatten()
        .reduce(|a, b| if b.cost < a.cost { b } else { a })
}

/// Probability that a ray through the cell meets the part of it below (or above) a plane.
struct Chances {
    min: f64,
    max: f64,
    /// Of a part without extent along the axis.
    flat: f64,
    /// Per unit of extent.
    slope: f64,
}

impl Chances {
    fn new(bounds: &Bounds, axis: usize) -> Self {
        let d = bounds.max.as_dvec3() - bounds.min.as_dvec3();
        let (a, b) = (d[(axis + 1) % 3], d[(axis + 2) % 3]);
        let (ends, ring) = (a * b, a + b);
        let area = ends + ring * d[axis];
        Self {
            min: f64::from(bounds.min[axis]),
            max: f64::from(bounds.max[axis]),
            flat: ends / area,
            slope: ring / area,
        }
    }
}

fn best_on_axis(
    bounds: &Bounds,
    axis: usize,
    events: &[Event],
    n: u32,
    costs: &Costs,
) -> Option<Plane> {
    let chances = Chances::new(bounds, axis);
    let (mut below, mut above) = (0u32, n);
    let mut best = Plane { axis, position: 0.0, planar_below: true, cost: f64::INFINITY };
    let mut i = 0;
    while i < events.len() {
        let at = key(events[i]);
        // Bit 0 of a kind tells planar ones, bit 1 tells starts.
        let (mut count, mut planar, mut starts) = (0, 0, 0);
        for event in events[i..].iter().take_while(|&&event| key(event) == at) {
            planar += kind(*event) as u32 & PLANAR as u32;
            starts += kind(*event) as u32 >> 1;
            count += 1;
        }
        i += count as usize;
        above -= count - starts;
        let x = f64::from(position(at));
        if chances.min < x && x < chances.max {
            let (cost, planar_below) = chances.cost(x, [below, planar, above], costs);
            if cost < best.cost {
                best = Plane { axis, position: position(at), planar_below, cost };
            }
        }
        below += planar + starts;
    }
    (best.cost < f64::INFINITY).then_some(best)
}

impl Chances {
    /// The cost of the cheaper of the two ways to give planar primitives to a side, and whether
    /// that is the lower one.
    #[inline(always)]
    fn cost(&self, x: f64, [below, planar, above]: [u32; 3], costs: &Costs) -> (f64, bool) {
        let chance_below = self.flat + self.slope * (x - self.min);
        let chance_above = self.flat + self.slope * (self.max - x);
        let cost = |nb: u32, na: u32| {
            let bonus = if nb == 0 || na == 0 { costs.empty_bonus } else { 1.0 };
            let children = chance_below * costs.of_leaf(nb) + chance_above * costs.of_leaf(na);
            bonus * (1.0 + children)
        };
        let low = cost(below + planar, above);
        if planar == 0 {
            return (low, true);
        }
        let high = cost(below, above + planar);
        (low.min(high), low <= high)
    }
}
