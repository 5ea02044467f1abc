//! Path tracing: all light.
//!
//! A hit sends rays to lamps, and one ray that follows one of its lobes. Rays that hit a lamp or the
//! sky share its light with the rays to lamps by multiple importance sampling. The last hit of a
//! path sends a ray too, which only collects what glows.
//!
//! Scenes of `DISTRIBUTED` with physical lamps or materials are rendered here as well; their diffuse
//! lobes are not followed.

use slo_scene::Integrator as Kind;

use super::account::Source;
use super::batch::Batch;
use super::branching::continuations;
use super::machine::{Integrator, Machine};
use super::stages::merging::Merging;
use super::stages::pilot::Pilot;
use super::vertices::Vertices;
use super::work::Job;
use crate::sampling::PixelSeed;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct Path {
    pub(super) vertices: Vertices,
    merging: Box<Merging>,
    pub(super) pilot: Pilot,
}

impl Path {
    /// Adds the light that passes of photons bring to the points. Returns `None` if the work is given
    /// up.
    fn merge(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Some(maps) = job.maps else { return Some(()) };
        let Self { vertices: Vertices { batch, hits, points, bsdfs, guiding, stride, .. }, .. } =
            self;
        let merging = &mut self.merging;
        points.find_footprints(batch, hits);
        merging.reach(job.frame, maps, points, depth);
        while merging.find(job, maps, points, (&**bsdfs, &**guiding), (depth, *stride)) {
            let Merging { light, slot, len, .. } = &**merging;
            machine.add(job.frame.isa, Source::Photons, light, slot, *len);
            job.goes_on()?;
        }
        Some(())
    }

    /// Queues the rays that follow lobes of all points. Returns `None` if the work is given up.
    fn follow(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Self { vertices, pilot, .. } = self;
        let count = continuations(&job.frame.settings, depth);
        // A pilot path doesn't branch.
        let sent = if job.is_pilot { 1 } else { count };
        for number in 0..sent {
            vertices.send(job, [number, count], depth);
            if job.is_pilot {
                pilot.remember(&vertices.points, &mut vertices.continuation, count);
            }
            vertices.queue(machine, depth);
            job.goes_on()?;
        }
        Some(())
    }
}

impl Integrator for Path {
    fn start(&mut self, job: &Job<'_>, seeds: &[PixelSeed]) -> Option<u32> {
        self.vertices.start(job, seeds)
    }

    fn batch(&mut self) -> &mut Batch {
        &mut self.vertices.batch
    }

    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let follows_diffuse = job.frame.settings.integrator != Kind::Distributed;
        if !self.vertices.arrive(machine, job, depth, follows_diffuse) {
            return Some(());
        }
        self.merge(machine, job, depth)?;
        self.vertices.ask_lamps(machine, job, depth)?;
        self.follow(machine, job, depth)
    }
}
