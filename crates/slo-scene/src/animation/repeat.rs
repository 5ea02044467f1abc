//! How a path goes on beyond its key frames: in cycles, each as long as they are.

use glam::{DQuat, DVec3};

use crate::settings::Repeat;

use super::orientation::about;
use super::rigid::DRigid;

/// Cycles beyond this number cannot be told apart in f64.
const FARTHEST_CYCLE: f64 = 9_007_199_254_740_992.0;

/// Distance from a whole number of cycles, in cycles, that is taken for rounding: times of frames
/// such as 7/25 and cycles such as 1/25 are not exact.
const ROUNDING: f64 = 1e-9;

/// Sine of the angle below which a turn is rounding.
const ROUNDED: f64 = 1e-14;

/// Most moments that a list holds of a long interval. More do not help whoever samples it.
const MOST_MOMENTS: usize = 20_000;

/// Largest coordinate that a path may lead to by going on from where it ended.
const FARTHEST: f64 = 1e9;

/// The cycles of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycles {
    repeat: Repeat,
    /// Time of the first key.
    start: f64,
    /// From the first key to the last; more than 0.
    length: f64,
    step: Step,
}

/// What a cycle adds to those before it.
#[derive(Clone, Copy, Debug)]
struct Step {
    translation: DVec3,
    axis: DVec3,
    /// About `axis`.
    degrees: f64,
}

/// A part of an interval of time that lies in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    cycle: f64,
    /// The time among the keys, in ascending order; in a cycle that goes back, the later end comes
    /// first.
    pub(super) local: [f64; 2],
    /// Whether it follows another stretch, so that a cycle begins with it.
    pub(super) is_new: bool,
}

impl Cycles {
    /// Cycles between the poses at the first and the last key; `None` without a length.
    pub(super) fn new(repeat: Repeat, keys: [(f64, DRigid); 2]) -> Option<Self> {
        let [(start, first), (end, last)] = keys;
        let length = end - start;
        let turn = DQuat::from_mat3(&(last.rotation * first.rotation.transpose()));
        let axis = turn.xyz();
        let sine = axis.length();
        let step = Step {
            translation: last.translation - first.translation,
            axis: if sine > ROUNDED { axis / sine } else { DVec3::Z },
            degrees: if sine > ROUNDED {
                2.0 * libm::atan2(sine, turn.w).to_degrees()
            } else {
                0.0
            },
        };
        (length > 0.0 && length.is_finite()).then_some(Self { repeat, start, length, step })
    }

    /// The cycle that a time lies in, counted from that of the key frames, and the time among the keys
    /// whose pose the path has there.
    pub(super) fn fold(&self, time: f64) -> (f64, f64) {
        let cycles = (time - self.start) / self.length;
        let nearest = cycles.round();
        let is_whole = (cycles - nearest).abs() <= ROUNDING.max(4.0 * f64::EPSILON * cycles.abs());
        let cycle = if is_whole { nearest } else { cycles.floor() };
        if cycle.abs() >= FARTHEST_CYCLE || cycle.is_nan() {
            return (FARTHEST_CYCLE.copysign(cycle), self.start);
        }
        (cycle, self.local(cycle, time))
    }

    /// The time among the keys of a time in some cycle.
    fn local(&self, cycle: f64, time: f64) -> f64 {
        let since = (time - self.start_of(cycle)).clamp(0.0, self.length);
        self.start + if self.is_backward(cycle) { self.length - since } else { since }
    }

    /// The time in some cycle of a time among the keys.
    fn time(&self, cycle: f64, local: f64) -> f64 {
        let since = local - self.start;
        self.start_of(cycle) + if self.is_backward(cycle) { self.length - since } else { since }
    }

    fn start_of(&self, cycle: f64) -> f64 {
        self.start + cycle * self.length
    }

    fn is_backward(&self, cycle: f64) -> bool {
        self.repeat == Repeat::PingPong && cycle.rem_euclid(2.0) == 1.0
    }

    /// The pose of the path in some cycle; `pose` is the one among the keys.
    pub(super) fn carry(&self, cycle: f64, pose: DRigid) -> DRigid {
        if self.repeat != Repeat::Offset || cycle == 0.0 {
            return pose;
        }
        let Step { translation, axis, degrees } = self.step;
        let moved = pose.translation + translation * cycle;
        DRigid {
            rotation: about(axis, degrees * cycle) * pose.rotation,
            translation: moved.clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)),
        }
    }

    /// Whether the path is where it was when each cycle begins; `leaps`: its first and last keys
    /// differ.
    pub(super) fn is_closed(&self, leaps: bool) -> bool {
        self.repeat != Repeat::Cycle || !leaps
    }

    /// The parts of an interval of time, in order, for a path with `keys` keys; of a very long one, not
    /// all.
    pub(super) fn stretches(
        &self,
        [from, to]: [f64; 2],
        keys: usize,
    ) -> impl Iterator<Item = Stretch> + use<> {
        let [first, last] = [from, to].map(|time| self.fold(time).0);
        let most = (MOST_MOMENTS / keys.max(1)).max(2);
        let count = (last - first + 1.0).clamp(0.0, most as f64) as usize;
        let cycles = *self;
        (0..count).map(move |i| {
            let cycle = first + i as f64;
            let [start, end] = [cycles.start_of(cycle), cycles.start_of(cycle + 1.0)];
            let mut local = [from.max(start), to.min(end)].map(|time| cycles.local(cycle, time));
            local.sort_by(f64::total_cmp);
            Stretch { cycle, local, is_new: i > 0 }
        })
    }
}

impl Stretch {
    /// The time of a time among the keys.
    pub(super) fn time(&self, cycles: &Cycles, local: f64) -> f64 {
        cycles.time(self.cycle, local)
    }

    /// The time at which the cycle begins.
    pub(super) fn start(&self, cycles: &Cycles) -> f64 {
        cycles.start_of(self.cycle)
    }

    /// Whether the path runs from its last key to its first.
    pub(super) fn is_backward(&self, cycles: &Cycles) -> bool {
        cycles.is_backward(self.cycle)
    }
}
