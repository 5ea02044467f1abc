//! Cells of a growing tree, and how a plane splits them.

use super::clip::clipped_bounds;
use super::events::{
    END, Event, PLANAR, START, key, kind, merge_into, position, push_events, slot, with_slot,
};
use super::sweep::Plane;
use crate::accel::Primitives;
use crate::math::Bounds;

/// A cell and the primitives that reach into it, each in a slot of its own.
#[derive(Debug)]
pub(super) struct Cell {
    pub(super) bounds: Bounds,
    /// Primitive of each slot, ids ascending.
    pub(super) ids: Vec<u32>,
    /// Sorted, per axis.
    pub(super) events: [Vec<Event>; 3],
}

impl Cell {
    /// The cell of some primitives, ids ascending.
    pub(super) fn new(primitives: &Primitives, ids: Vec<u32>) -> Self {
        let boxes: Vec<Bounds> = ids.iter().map(|&id| primitives.bounds(id)).collect();
        let bounds = boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let sorted = |axis| {
            let mut events = Vec::with_capacity(2 * boxes.len());
            for (slot, bounds) in (0..).zip(&boxes) {
                push_events(bounds, axis, slot, &mut events);
            }
            rayon::slice::ParallelSliceMut::par_sort_unstable(events.as_mut_slice());
            events
        };
        let (x, (y, z)) = rayon::join(|| sorted(0), || rayon::join(|| sorted(1), || sorted(2)));
        Self { bounds, ids, events: [x, y, z] }
    }

    /// Half of the surface area.
    pub(super) fn area(&self) -> f64 {
        let d = self.bounds.max.as_dvec3() - self.bounds.min.as_dvec3();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// The parts below and above a plane.
    pub(super) fn split(self, primitives: &Primitives, plane: &Plane) -> [Self; 2] {
        let mut bounds = [self.bounds; 2];
        bounds[0].max[plane.axis] = plane.position;
        bounds[1].min[plane.axis] = plane.position;
        let sides = sides(&self, plane);
        let mut parts = bounds.map(Part::new);
        let places = place(&self.ids, &sides, primitives, &mut parts);
        drop(sides);
        let [below, above] = &mut parts;
        for axis in 0..3 {
            distribute(&self.events[axis], &places, axis, below, above);
        }
        parts.map(Part::into_cell)
    }
}

/// On which side of a plane a primitive lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Both,
    Below,
    Above,
}

fn sides(cell: &Cell, plane: &Plane) -> Vec<Side> {
    let mut sides = vec![Side::Both; cell.ids.len()];
    for &event in &cell.events[plane.axis] {
        let at = position(key(event));
        let side = &mut sides[slot(event)];
        match kind(event) {
            END if at <= plane.position => *side = Side::Below,
            START if at >= plane.position => *side = Side::Above,
            PLANAR => {
                let below = at < plane.position || (at == plane.position && plane.planar_below);
                *side = if below { Side::Below } else { Side::Above };
            }
            _ => {}
        }
    }
    sides
}

/// One side of a split while it is filled.
struct Part {
    bounds: Bounds,
    ids: Vec<u32>,
    /// Events of primitives that were clipped.
    clipped: [Vec<Event>; 3],
    events: [Vec<Event>; 3],
}

impl Part {
    fn new(bounds: Bounds) -> Self {
        Self { bounds, ids: Vec::new(), clipped: Default::default(), events: Default::default() }
    }

    fn push(&mut self, id: u32) -> u32 {
        self.ids.push(id);
        self.ids.len() as u32 - 1
    }

    /// Takes what of a primitive lies in the part's box.
    fn push_clipped(&mut self, id: u32, primitives: &Primitives) {
        let clipped = match primitives.triangles.get(id as usize) {
            Some(triangle) => clipped_bounds(triangle, &self.bounds),
            None => Some(primitives.bounds(id).intersection(self.bounds)),
        };
        if let Some(clipped) = clipped.filter(|bounds| !bounds.is_empty()) {
            let slot = self.push(id);
            for axis in 0..3 {
                push_events(&clipped, axis, slot, &mut self.clipped[axis]);
            }
        }
    }

    fn into_cell(self) -> Cell {
        Cell { bounds: self.bounds, ids: self.ids, events: self.events }
    }
}

/// A primitive's slot in its part; in both parts or none: [`CUT`].
type Place = u32;
const ABOVE: Place = 1 << 31;
const CUT: Place = u32::MAX;

fn place(
    ids: &[u32],
    sides: &[Side],
    primitives: &Primitives,
    [below, above]: &mut [Part; 2],
) -> Vec<Place> {
    let places = ids.iter().zip(sides).map(|(&id, side)| match side {
        Side::Below => below.push(id),
        Side::Above => above.push(id) | ABOVE,
        Side::Both => {
            below.push_clipped(id, primitives);
            above.push_clipped(id, primitives);
            CUT
        }
    });
    places.collect()
}

/// Gives the events of an axis to the parts, in order.
fn distribute(events: &[Event], places: &[Place], axis: usize, below: &mut Part, above: &mut Part) {
    let room = |part: &Part| 2 * part.ids.len();
    let (mut low, mut high) = (Vec::with_capacity(room(below)), Vec::with_capacity(room(above)));
    for &event in events {
        let place = places[slot(event)];
        if place < ABOVE {
            low.push(with_slot(event, place));
        } else if place != CUT {
            high.push(with_slot(event, place & !ABOVE));
        }
    }
    for (part, mut events) in [(below, low), (above, high)] {
        let clipped = &mut part.clipped[axis];
        clipped.sort_unstable();
        merge_into(&mut events, clipped);
        part.events[axis] = events;
    }
}
