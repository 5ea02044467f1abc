//! Cells of a growing tree, and how a plane splits them.

use rayon::prelude::*;

use super::axes::{PARALLEL_SIZE, for_axes};
use super::events::{
    END, Event, MAX_SLOTS, PLANAR, START, at, kind, merge_into, push_events, slot, sort, with_slot,
};
use super::sweep::Plane;
use crate::math::Bounds;
use crate::primitives::Primitives;
use crate::primitives::clip::clipped_bounds;

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
        let boxes: Vec<Bounds> = ids.par_iter().map(|&id| primitives.bounds(id)).collect();
        let bounds = boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(*b));
        let sorted = |axis| {
            let mut events = Vec::with_capacity(2 * boxes.len());
            for (slot, bounds) in (0..).zip(&boxes) {
                push_events(bounds, axis, slot, &mut events);
            }
            sort(events)
        };
        Self { bounds, events: for_axes(true, [0, 1, 2], sorted), ids }
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
        let [below, above] = parts;
        let room = 2 * above.ids.len();
        let mut axes = self.events.into_iter().zip(below.clipped.into_iter().zip(above.clipped));
        let axes = std::array::from_fn(|_| axes.next().unwrap_or_default());
        let in_parallel = self.ids.len() >= PARALLEL_SIZE;
        let [x, y, z] = for_axes(in_parallel, axes, |(events, (low, high))| {
            distribute(events, &places, room, [low, high])
        });
        [
            Self { bounds: below.bounds, ids: below.ids, events: [x.0, y.0, z.0] },
            Self { bounds: above.bounds, ids: above.ids, events: [x.1, y.1, z.1] },
        ]
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
    let events = &cell.events[plane.axis];
    let from = at(plane.position, if plane.planar_below { START } else { PLANAR });
    let (below, above) = events.split_at(events.partition_point(|&event| event < from));
    // The last write counts, so that nothing depends on a primitive's other event.
    for &event in below {
        sides[slot(event)] = if kind(event) == START { Side::Both } else { Side::Below };
    }
    for &event in above.iter().rev() {
        sides[slot(event)] = if kind(event) == END { Side::Both } else { Side::Above };
    }
    sides
}

/// One side of a split while it is filled.
struct Part {
    bounds: Bounds,
    ids: Vec<u32>,
    /// Events of primitives that were clipped.
    clipped: [Vec<Event>; 3],
}

impl Part {
    fn new(bounds: Bounds) -> Self {
        Self { bounds, ids: Vec::new(), clipped: Default::default() }
    }

    /// Makes room for the primitives that are on a side or on both.
    fn reserve(&mut self, sides: &[Side], other: Side) {
        self.ids.reserve_exact(sides.iter().filter(|&&side| side != other).count() + 1);
    }

    fn push(&mut self, id: u32) -> u32 {
        self.ids.push(id);
        self.ids.len() as u32 - 1
    }

    /// Adds the part of a primitive inside the box.
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
    below.reserve(sides, Side::Above);
    above.reserve(sides, Side::Below);
    let places = ids.iter().zip(sides).map(|(&id, &side)| {
        if side == Side::Both {
            below.push_clipped(id, primitives);
            above.push_clipped(id, primitives);
            return CUT;
        }
        // Without a branch, which could not be predicted: pushed on both sides, kept on one.
        let is_above = side == Side::Above;
        let places = [below.push(id), above.push(id) | ABOVE];
        below.ids.truncate(below.ids.len() - usize::from(is_above));
        above.ids.truncate(above.ids.len() - usize::from(!is_above));
        places[usize::from(is_above)]
    });
    places.collect()
}

/// The events of an axis below and above, in order; `clipped` are those of cut primitives, and at
/// most `room` lie above.
fn distribute(
    mut events: Vec<Event>,
    places: &[Place],
    room: usize,
    mut clipped: [Vec<Event>; 2],
) -> (Vec<Event>, Vec<Event>) {
    // The lower part keeps the parent's memory. Events are written to both sides and kept on one.
    let mut high = vec![0; room.min(events.len()) + 1];
    let (mut lows, mut highs) = (0, 0);
    for i in 0..events.len() {
        let event = events[i];
        let place = places[slot(event)];
        let moved = with_slot(event, place & (MAX_SLOTS as u32 - 1));
        events[lows] = moved;
        high[highs] = moved;
        lows += usize::from(place < ABOVE);
        highs += usize::from(place >= ABOVE && place != CUT);
    }
    events.truncate(lows);
    high.truncate(highs);
    for (events, clipped) in [&mut events, &mut high].into_iter().zip(&mut clipped) {
        clipped.sort_unstable();
        merge_into(events, clipped);
    }
    (events, high)
}
