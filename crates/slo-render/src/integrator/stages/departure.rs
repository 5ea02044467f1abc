//! Light paths where they start.

use std::ops::Range;

use slo_accel::math::columns::BATCH;

use crate::frame::FrameScene;
use crate::integrator::batch::Batch;
use crate::integrator::photon_pass::PhotonPass;
use crate::photons::Numbers;
use crate::sampling::{Hit, PixelSeed, Purpose};

/// The light paths that are still to start.
#[derive(Debug)]
pub(in crate::integrator) struct Departure {
    pass: PhotonPass,
    seed: PixelSeed,
    left: Range<u32>,
}

impl Default for Departure {
    fn default() -> Self {
        let pass = PhotonPass { first: 0, paths: 0, slabs: 1 };
        Self { pass, seed: PixelSeed::from_word(0), left: 0..0 }
    }
}

impl Departure {
    /// Begins with the light paths of these numbers.
    pub(in crate::integrator) fn restart(
        &mut self,
        pass: PhotonPass,
        range: Range<u32>,
        seed: PixelSeed,
    ) {
        *self = Self { pass, seed, left: range };
    }

    /// Number of slabs of time.
    pub(in crate::integrator) fn slabs(&self) -> u32 {
        self.pass.slabs
    }

    /// Starts the next light paths. Returns whether there were any.
    pub(in crate::integrator) fn fill(&mut self, frame: &FrameScene, batch: &mut Batch) -> bool {
        let Some(emission) = &frame.emission else { return false };
        let mut len = 0;
        batch.rays.set_len(0);
        while len < BATCH {
            let Some(number) = self.left.next() else { break };
            let index = self.pass.first.wrapping_add(number);
            let numbers = self.numbers(frame, number, index);
            let Some(start) = emission.start(&frame.lights, numbers) else { continue };
            batch.rays.push(start.origin, start.direction, f32::INFINITY);
            batch.weight.set(len, start.power);
            batch.density[len] = start.density;
            batch.labels.time[len] = numbers.time;
            batch.labels.slot[len] = start.light;
            batch.labels.path[len] = 0;
            batch.labels.index[len] = index;
            batch.past.marks[len] = 0;
            len += 1;
        }
        batch.past.rough.is_kept = false;
        len > 0 || !self.left.is_empty()
    }

    fn numbers(&self, frame: &FrameScene, number: u32, index: u32) -> Numbers {
        let at = |depth, purpose| {
            let hit = Hit { path: 0, depth, split: false };
            frame.photon_sampler.point3(self.seed.key(hit, purpose), index)
        };
        // Two groups of dimensions, so that places and directions are independent.
        let [u, v, choice] = at(0, Purpose::Departure);
        let [a, b, time] = at(1, Purpose::Heading);
        let slabs = self.pass.slabs;
        let time = ((number % slabs) as f32 + time) / slabs as f32;
        Numbers { choice, place: [u, v], direction: [a, b], time: time.min(BELOW_ONE) }
    }
}

/// The largest time before the shutter closes.
const BELOW_ONE: f32 = 0.999_999_94;
