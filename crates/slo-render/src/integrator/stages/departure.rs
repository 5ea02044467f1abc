//! Light paths where they start.

use std::ops::Range;

use slo_accel::math::columns::BATCH;

use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, marks};
use crate::integrator::photon_pass::PhotonPass;
use crate::photons::{Emitted, Numbers};
use crate::sampling::{Hit, PixelSeed, Purpose};

/// Which light paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flux {
    /// A pass of photons under `PATH`: light that is sent to something sharp.
    Pass(PhotonPass),
    /// Under `PHOTON_MAP`: all light that lamps send.
    #[default]
    Everywhere,
    /// Under `PHOTON_MAP`: light that is sent to something sharp.
    Caustics,
}

impl Flux {
    /// Whether the paths follow rough lobes too.
    pub(in crate::integrator) fn follows_rough(self) -> bool {
        self == Self::Everywhere
    }

    /// Number of slabs of time.
    fn slabs(self) -> u32 {
        if let Self::Pass(pass) = self { pass.slabs } else { 1 }
    }
}

/// The light paths that are still to start.
#[derive(Debug)]
pub(in crate::integrator) struct Departure {
    flux: Flux,
    seed: PixelSeed,
    left: Range<u32>,
}

impl Default for Departure {
    fn default() -> Self {
        Self { flux: Flux::Everywhere, seed: PixelSeed::from_word(0), left: 0..0 }
    }
}

impl Departure {
    /// Begins with the light paths of these numbers.
    pub(in crate::integrator) fn restart(
        &mut self,
        flux: Flux,
        range: Range<u32>,
        seed: PixelSeed,
    ) {
        *self = Self { flux, seed, left: range };
    }

    /// Starts the next light paths. Returns whether there were any.
    pub(in crate::integrator) fn fill(&mut self, frame: &FrameScene, batch: &mut Batch) -> bool {
        let mut len = 0;
        batch.rays.set_len(0);
        while len < BATCH {
            let Some(number) = self.left.next() else { break };
            let first = if let Flux::Pass(pass) = self.flux { pass.first } else { 0 };
            let index = first.wrapping_add(number);
            let numbers = self.numbers(frame, number, index);
            let Some(start) = self.start(frame, numbers) else { continue };
            let shaded = start.light.checked_sub(frame.first_shaded);
            // Where a light is shaded where rays arrive, a ray looks back at it first.
            let direction = if shaded.is_some() { -start.direction } else { start.direction };
            batch.rays.push(start.origin, direction, f32::INFINITY);
            batch.weight.set(len, start.power);
            batch.density[len] = start.density;
            batch.labels.time[len] = numbers.time;
            batch.labels.slot[len] = start.light;
            batch.labels.path[len] = 0;
            batch.labels.index[len] = index;
            batch.past.marks[len] = shaded.map_or(0, marks::asking);
            len += 1;
        }
        batch.past.rough.is_kept = false;
        len > 0 || !self.left.is_empty()
    }

    fn start(&self, frame: &FrameScene, numbers: Numbers) -> Option<Emitted> {
        let lamps = frame.photon_lamps.as_ref();
        match self.flux {
            Flux::Pass(_) => frame.emission.as_ref()?.start(&frame.lights, numbers),
            Flux::Everywhere => lamps?.all.start(&frame.lights, numbers),
            Flux::Caustics => lamps?.aimed.as_ref()?.start(&frame.lights, numbers),
        }
    }

    fn numbers(&self, frame: &FrameScene, number: u32, index: u32) -> Numbers {
        let at = |depth, purpose| {
            let hit = Hit { path: 0, depth, split: false };
            frame.photon_sampler.point3(self.seed.key(hit, purpose), index)
        };
        // Two groups of dimensions, so that places and directions are independent.
        let [u, v, choice] = at(0, Purpose::Departure);
        let [a, b, time] = at(1, Purpose::Heading);
        let slabs = self.flux.slabs();
        let time = ((number % slabs) as f32 + time) / slabs as f32;
        Numbers { choice, place: [u, v], direction: [a, b], time: time.min(BELOW_ONE) }
    }
}

/// The largest time before the shutter closes.
const BELOW_ONE: f32 = 0.999_999_94;
