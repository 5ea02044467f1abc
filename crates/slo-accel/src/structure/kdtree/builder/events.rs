//! Where primitives begin and end along an axis.

use crate::math::Bounds;

/// One event in 64 bits that sort as the sweep wants them: position, kind, slot of the primitive.
pub(super) type Event = u64;

/// Kinds of events, in the order they are met in at one position.
pub(super) const END: u64 = 0;
/// A primitive that is flat across the axis.
pub(super) const PLANAR: u64 = 1;
/// A primitive begins.
pub(super) const START: u64 = 2;

/// Number of slots that an event can name.
pub(super) const MAX_SLOTS: usize = 1 << 30;

/// The events of a box along an axis, of the primitive in `slot`.
pub(super) fn push_events(bounds: &Bounds, axis: usize, slot: u32, events: &mut Vec<Event>) {
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    if min == max {
        events.push(event(min, PLANAR, slot));
    } else {
        events.push(event(min, START, slot));
        events.push(event(max, END, slot));
    }
}

/// The least event of a kind at a position.
pub(super) fn at(position: f32, kind: u64) -> Event {
    event(position, kind, 0)
}

fn event(position: f32, kind: u64, slot: u32) -> Event {
    u64::from(ordered(position)) << 32 | kind << 30 | u64::from(slot)
}

/// Bits that order as the number does; -0 and 0 are the same.
fn ordered(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Key of all events at one position.
#[inline(always)]
pub(super) fn key(event: Event) -> u32 {
    (event >> 32) as u32
}

/// The position that a key stands for.
#[inline(always)]
pub(super) fn position(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

#[inline(always)]
pub(super) fn kind(event: Event) -> u64 {
    event >> 30 & 3
}

#[inline(always)]
pub(super) fn slot(event: Event) -> usize {
    (event & (MAX_SLOTS as u64 - 1)) as usize
}

/// The same event of another slot.
#[inline(always)]
pub(super) fn with_slot(event: Event, slot: u32) -> Event {
    event & !(MAX_SLOTS as u64 - 1) | u64::from(slot)
}

/// Bits that one pass of [`sort`] looks at.
const DIGIT: u32 = 12;

/// Sorts events whose slots ascend already: by digits, from the lowest above the slot.
pub(super) fn sort(mut events: Vec<Event>) -> Vec<Event> {
    if events.len() < 1 << DIGIT {
        events.sort_unstable();
        return events;
    }
    let mut sorted = vec![0; events.len()];
    for shift in (MAX_SLOTS.ilog2()..u64::BITS).step_by(DIGIT as usize) {
        let digit = |event: Event| (event >> shift) as usize & ((1 << DIGIT) - 1);
        let mut places = vec![0; 1 << DIGIT];
        for &event in &events {
            places[digit(event)] += 1;
        }
        let mut first = 0;
        for place in &mut places {
            (*place, first) = (first, first + *place);
        }
        for &event in &events {
            let place = &mut places[digit(event)];
            sorted[*place] = event;
            *place += 1;
        }
        std::mem::swap(&mut events, &mut sorted);
    }
    events
}

/// Merges a sorted list into another.
pub(super) fn merge_into(events: &mut Vec<Event>, new: &[Event]) {
    if new.is_empty() {
        return;
    }
    let (mut old, mut rest) = (events.len(), new.len());
    events.resize(old + rest, 0);
    while rest > 0 {
        let to = old + rest - 1;
        if old > 0 && events[old - 1] > new[rest - 1] {
            old -= 1;
            events[to] = events[old];
        } else {
            rest -= 1;
            events[to] = new[rest];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn events_order_by_position_then_kind() {
        let flat = Bounds { min: Vec3::ZERO, max: Vec3::new(-0.0, 1.0, 1.0) };
        let wide = Bounds { min: Vec3::new(-2.0, 0.0, 0.0), max: Vec3::new(0.0, 1.0, 1.0) };
        let next = Bounds { min: Vec3::new(-0.0, 0.0, 0.0), max: Vec3::ONE };
        let mut events = Vec::new();
        for (slot, bounds) in [next, flat, wide].iter().enumerate() {
            push_events(bounds, 0, slot as u32, &mut events);
        }
        events.sort_unstable();
        let told: Vec<_> = events.iter().map(|&e| (position(key(e)), kind(e), slot(e))).collect();
        let expected =
            [(-2.0, START, 2), (0.0, END, 2), (0.0, PLANAR, 1), (0.0, START, 0), (1.0, END, 0)];
        assert_eq!(told, expected);
    }

    #[test]
    fn digits_sort() {
        let mut events = Vec::new();
        for slot in 0..9_000u32 {
            let x = (slot * 7919 % 501) as f32 - 250.0;
            let max = Vec3::splat(if slot % 5 == 0 { x } else { x + (slot % 3) as f32 });
            push_events(&Bounds { min: Vec3::splat(x), max }, 1, slot, &mut events);
        }
        let mut expected = events.clone();
        expected.sort_unstable();
        assert_eq!(sort(events), expected);
    }

    #[test]
    fn merging_sorts() {
        for (old, new) in
            [(vec![], vec![1, 2]), (vec![1, 5, 9], vec![0, 5, 7, 12]), (vec![3], vec![])]
        {
            let mut merged = old.clone();
            merge_into(&mut merged, &new);
            let mut expected = [old, new].concat();
            expected.sort_unstable();
            assert_eq!(merged, expected);
        }
    }
}
