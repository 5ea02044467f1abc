//! Weighted rays that wait to be traced, and the batches that they are traced in.

use super::chosen::Chosen;
use slo_accel::math::columns::{BATCH, Column, Vec3s};
use slo_accel::{Coherence, Rays};

/// What goes with a ray besides its geometry.
#[derive(Debug)]
pub(super) struct Labels {
    /// Time in the shutter, `[0, 1]`.
    pub(super) time: Column<f32>,
    /// Sum that what the ray brings is added to.
    pub(super) slot: Column<u32>,
    /// Code of the branches that led here.
    pub(super) path: Column<u32>,
    /// Number of the ray among those of the same path in the pixel's samples.
    pub(super) index: Column<u32>,
}

impl Default for Labels {
    fn default() -> Self {
        Self { time: [0.0; BATCH], slot: [0; BATCH], path: [0; BATCH], index: [0; BATCH] }
    }
}

/// Rays in columns, and what radiance that arrives along each is worth.
#[derive(Debug)]
pub(super) struct Batch {
    /// With room for [`BATCH`].
    pub(super) rays: Rays,
    pub(super) weight: Vec3s,
    /// See [`Sent::density`].
    pub(super) density: Column<f32>,
    pub(super) labels: Labels,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            rays: Rays::with_capacity(BATCH),
            weight: Vec3s::default(),
            density: [0.0; BATCH],
            labels: Labels::default(),
        }
    }
}

/// Rays that a batch of hits sends out: entry `i` is that of hit `i`.
#[derive(Debug)]
pub(super) struct Sent {
    pub(super) origin: Vec3s,
    /// Unit for bounces; from hit to light for rays to lights.
    pub(super) direction: Vec3s,
    pub(super) t_max: Column<f32>,
    /// What radiance that arrives is multiplied with, or the light that comes if nothing blocks.
    pub(super) weight: Vec3s,
    /// How many rays of the lobe there are per solid angle, where rays to lamps look for the same
    /// light; 0: none do.
    pub(super) density: Column<f32>,
}

impl Default for Sent {
    fn default() -> Self {
        Self {
            origin: Vec3s::default(),
            direction: Vec3s::default(),
            t_max: [0.0; BATCH],
            weight: Vec3s::default(),
            density: [0.0; BATCH],
        }
    }
}

impl Sent {
    /// Whether ray `i` is one: coordinates beyond all bounds leave none.
    #[inline(always)]
    pub(super) fn is_ray(&self, i: usize) -> bool {
        let (o, d) = (self.origin.get(i), self.direction.get(i));
        let size = d.length_squared();
        let sum = (o.x + o.y + o.z) + size;
        sum.abs() < f32::INFINITY && size > 0.0
    }
}

/// Where rays to lights come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShadowKind {
    /// Hits of camera rays.
    FromPrimary,
    /// Hits of bounces.
    FromDeeper,
}

impl ShadowKind {
    /// That of hits with `depth` bounces behind them.
    pub(super) fn at(depth: u32) -> Self {
        if depth == 0 { Self::FromPrimary } else { Self::FromDeeper }
    }
}

/// Rays that wait.
#[derive(Debug, Default)]
pub(super) struct RayQueue {
    rays: Rays,
    weight: [Vec<f32>; 3],
    time: Vec<f32>,
    slot: Vec<u32>,
    /// Nothing in a queue of rays to lights.
    names: Names,
    pub(super) habit: Habit,
}

/// Whether the rays of a queue go similar ways, by what its last batches turned out to be. It
/// decides how fast they are traced, and nothing else.
#[derive(Debug, Default)]
pub(super) struct Habit {
    /// Batches that are not tried as similar ones.
    untried: u32,
}

impl Habit {
    /// Of rays that went different ways, one batch of so many is tried again.
    const TRIED: u32 = 8;

    /// What the next batch is taken for.
    pub(super) fn expected(&mut self) -> Coherence {
        if self.untried == 0 {
            return Coherence::Coherent;
        }
        self.untried -= 1;
        Coherence::Incoherent
    }

    /// Notes what a batch turned out to be that was taken for `expected`.
    pub(super) fn learn(&mut self, expected: Coherence, found: Coherence) {
        if (expected, found) == (Coherence::Coherent, Coherence::Incoherent) {
            self.untried = Self::TRIED - 1;
        }
    }
}

/// What goes with rays of lobes alone.
#[derive(Debug, Default)]
struct Names {
    density: Vec<f32>,
    path: Vec<u32>,
    index: Vec<u32>,
}

impl RayQueue {
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Rays that there is room for: as many as ever waited, or more.
    #[cfg(test)]
    pub(super) fn room(&self) -> usize {
        self.slot.capacity()
    }

    /// Adds the chosen ones of the rays that were sent to lights.
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

    /// Adds the chosen ones of the rays that were sent by lobes.
    pub(super) fn append_named(&mut self, sent: &Sent, labels: &Labels, chosen: &Chosen) {
        self.append(sent, labels, chosen);
        chosen.append(&sent.density, &mut self.names.density);
        chosen.append(&labels.path, &mut self.names.path);
        chosen.append(&labels.index, &mut self.names.index);
    }

    /// Moves the last rays, a batch at most, to `batch`, their order kept.
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
    }
}

/// Moves what is from `start` on to the front of a column.
fn move_to<T: Copy>(from: &mut Vec<T>, start: usize, to: &mut Column<T>) {
    to[..from.len() - start].copy_from_slice(&from[start..]);
    from.truncate(start);
}

#[cfg(test)]
mod tests {
    use super::*;
    use Coherence::{Coherent, Incoherent};

    #[test]
    fn rays_that_go_different_ways_are_tried_again_now_and_then() {
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
