//! Queues of weighted rays that wait to be traced.

use slo_accel::math::columns::{BATCH, Column};
use slo_accel::{Coherence, Rays};

use super::batch::{Batch, Labels, Past, Sent};
use super::chosen::Chosen;

/// A queue of waiting rays.
#[derive(Debug, Default)]
pub(super) struct RayQueue {
    rays: Rays,
    weight: [Vec<f32>; 3],
    time: Vec<f32>,
    slot: Vec<u32>,
    /// Columns that a queue of rays to lights does not use.
    names: Names,
    past: PastColumns,
    pub(super) habit: Habit,
}

/// Whether the rays of a queue are coherent, judged by its last batches. It affects only the speed
/// of tracing.
#[derive(Debug, Default)]
pub(super) struct Habit {
    /// Number of batches to trace as incoherent before the next try.
    untried: u32,
}

impl Habit {
    /// After an incoherent batch, one batch in this many is traced as a coherent one.
    const TRIED: u32 = 8;

    /// Returns how to trace the next batch.
    pub(super) fn expected(&mut self) -> Coherence {
        if self.untried == 0 {
            return Coherence::Coherent;
        }
        self.untried -= 1;
        Coherence::Incoherent
    }

    /// Notes how coherent a batch turned out to be that was traced as `expected`.
    pub(super) fn learn(&mut self, expected: Coherence, found: Coherence) {
        if (expected, found) == (Coherence::Coherent, Coherence::Incoherent) {
            self.untried = Self::TRIED - 1;
        }
    }
}

/// Columns of rays of lobes, which rays to lights do not have.
#[derive(Debug, Default)]
struct Names {
    density: Vec<f32>,
    path: Vec<u32>,
    index: Vec<u32>,
}

/// Columns of rays of paths, which other rays do not have.
#[derive(Debug, Default)]
struct PastColumns {
    from: [Vec<f32>; 3],
    normal: Vec<u32>,
    marks: Vec<u32>,
    /// See [`RoughStart`](super::batch::RoughStart).
    rough: [Vec<f32>; 3],
}

impl RayQueue {
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Capacity in rays: at least the largest number that ever waited.
    #[cfg(test)]
    pub(super) fn room(&self) -> usize {
        self.slot.capacity()
    }

    /// Appends the chosen rays to lights.
    pub(super) fn append(&mut self, sent: &Sent, labels: &Labels, chosen: &Chosen) {
        let start = self.rays.len();
        self.rays.set_len(start + chosen.len());
        let new = start..start + chosen.len();
        for (axis, (origin, direction)) in
            sent.origin.columns().into_iter().zip(sent.direction.columns()).enumerate()
        {
            chosen.copy(origin, &mut self.rays.origin[axis][new.clone()]);
            chosen.copy(direction, &mut self.rays.direction[axis][new.clone()]);
        }
        chosen.copy(&sent.t_max, &mut self.rays.t_max[new]);
        for (to, from) in self.weight.iter_mut().zip(sent.weight.columns()) {
            chosen.append(from, to);
        }
        chosen.append(&labels.time, &mut self.time);
        chosen.append(&labels.slot, &mut self.slot);
    }

    /// Appends the chosen rays of lobes.
    pub(super) fn append_named(&mut self, sent: &Sent, labels: &Labels, chosen: &Chosen) {
        self.append(sent, labels, chosen);
        chosen.append(&sent.density, &mut self.names.density);
        chosen.append(&labels.path, &mut self.names.path);
        chosen.append(&labels.index, &mut self.names.index);
    }

    /// Appends the chosen rays of paths.
    pub(super) fn append_path(
        &mut self,
        sent: &Sent,
        labels: &Labels,
        past: &Past,
        chosen: &Chosen,
    ) {
        self.append_named(sent, labels, chosen);
        for (to, from) in self.past.from.iter_mut().zip(past.from.columns()) {
            chosen.append(from, to);
        }
        chosen.append(&past.normal, &mut self.past.normal);
        chosen.append(&past.marks, &mut self.past.marks);
        if past.rough.is_kept {
            for (to, from) in self.past.rough.iter_mut().zip(past.rough.columns()) {
                chosen.append(from, to);
            }
        }
    }

    /// Moves the last rays, at most [`BATCH`], to `batch` in their order.
    pub(super) fn take_batch(&mut self, batch: &mut Batch) {
        let start = self.len().saturating_sub(BATCH);
        self.rays.split_off_into(start, &mut batch.rays);
        let Batch { weight, density, labels, .. } = batch;
        for (from, to) in self.weight.iter_mut().zip([&mut weight.x, &mut weight.y, &mut weight.z])
        {
            move_to(from, start, to);
        }
        move_to(&mut self.time, start, &mut labels.time);
        move_to(&mut self.slot, start, &mut labels.slot);
        if !self.names.path.is_empty() {
            move_to(&mut self.names.density, start, density);
            move_to(&mut self.names.path, start, &mut labels.path);
            move_to(&mut self.names.index, start, &mut labels.index);
        }
        if !self.past.normal.is_empty() {
            let Past { from, normal, marks, rough } = &mut batch.past;
            for (column, to) in
                self.past.from.iter_mut().zip([&mut from.x, &mut from.y, &mut from.z])
            {
                move_to(column, start, to);
            }
            move_to(&mut self.past.normal, start, normal);
            move_to(&mut self.past.marks, start, marks);
            rough.is_kept = !self.past.rough[0].is_empty();
            if rough.is_kept {
                for (column, to) in self.past.rough.iter_mut().zip(rough.columns_mut()) {
                    move_to(column, start, to);
                }
            }
        }
    }
}

/// Moves the entries from `start` onwards to the front of a column.
fn move_to<T: Copy>(from: &mut Vec<T>, start: usize, to: &mut Column<T>) {
    to[..from.len() - start].copy_from_slice(&from[start..]);
    from.truncate(start);
}

#[cfg(test)]
mod tests {
    use super::*;
    use Coherence::{Coherent, Incoherent};

    #[test]
    fn incoherent_queues_are_tried_again_now_and_then() {
        let mut habit = Habit::default();
        assert_eq!([habit.expected(), habit.expected()], [Coherent; 2]);
        habit.learn(Coherent, Coherent);
        assert_eq!(habit.expected(), Coherent);
        habit.learn(Coherent, Incoherent);
        let tried = (0..16).filter(|_| {
            let expected = habit.expected();
            habit.learn(expected, Incoherent);
            expected == Coherent
        });
        assert_eq!(tried.count(), 2);
    }
}
