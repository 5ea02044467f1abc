//! Distributed ray tracing: direct light from lamps, and reflection and refraction, perfect and
//! glossy.
//!
//! A hit sends rays to lights, and rays of its reflected and refracted lobes up to the limit of the
//! recursion.

use slo_picture::film::Features;

use super::account::Source;
use super::batch::Batch;
use super::branching::most_camera_rays;
use super::machine::{Connection, Integrator, Machine};
use super::stages::camera_rays::CameraRays;
use super::stages::direct_light::{DirectLight, questions};
use super::stages::ended::Ended;
use super::stages::features::{FeatureSums, Own};
use super::stages::first_hits::FirstHits;
use super::stages::hits::Hits;
use super::stages::lobes::Lobes;
use super::stages::points::Points;
use super::stages::scattering::{Scattering, bounces};
use super::work::Job;
use crate::sampling::PixelSeed;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct Distributed {
    camera_rays: Box<CameraRays>,
    /// The current batch.
    batch: Box<Batch>,
    hits: Box<Hits>,
    ended: Box<Ended>,
    points: Box<Points>,
    features: FeatureSums,
    pub(super) first_hits: FirstHits,
    lobes: Box<Lobes>,
    direct_light: Box<DirectLight>,
    scattering: Box<Scattering>,
}

impl Distributed {
    /// Begins new work. Features are collected for `features` slots.
    pub(super) fn restart(&mut self, features: usize) {
        self.camera_rays.restart();
        self.features.reset(features);
    }

    /// Returns the surface features of each slot.
    pub(super) fn features(&self) -> &[Features] {
        self.features.get()
    }

    /// Queues the rays from all points to lights. Returns `None` if the work is given up.
    fn ask_lights(
        &mut self,
        machine: &mut Machine,
        job: &Job<'_>,
        scatters: bool,
        depth: u32,
    ) -> Option<()> {
        let kind = Connection::at(depth);
        let glossy = scatters && job.frame.combines();
        for question in questions(job.frame, depth) {
            let Self { points, lobes, direct_light, .. } = self;
            direct_light.ask(job, points, lobes, glossy, question, depth)?;
            let DirectLight { sent, chosen, .. } = &**direct_light;
            let light = |i| direct_light.light(question, i);
            machine.connect(kind, sent, &points.labels, chosen, light);
            machine.relieve(job, kind)?;
        }
        Some(())
    }

    /// Queues the rays of the lobes of all points. Returns `None` if the work is given up.
    fn scatter(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Self { points, lobes, scattering, features, .. } = self;
        for bounce in bounces(job.frame, lobes, points, depth) {
            scattering.send(job.frame, points, lobes, bounce, depth, features.first_behind());
            let Scattering { sent, labels, chosen, .. } = &**scattering;
            machine.extend(depth + 1, sent, labels, chosen);
            job.goes_on()?;
        }
        Some(())
    }
}

impl Integrator for Distributed {
    fn start(&mut self, job: &Job<'_>, seeds: &[PixelSeed]) -> Option<u32> {
        let most = most_camera_rays(&job.frame.settings);
        self.camera_rays.fill(job, seeds, most, &mut self.batch);
        (self.batch.len() > 0).then_some(0)
    }

    fn batch(&mut self) -> &mut Batch {
        &mut self.batch
    }

    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let frame = job.frame;
        let Self { batch, hits, ended, points, features, first_hits, lobes, .. } = self;
        machine.find_hits(job, batch, hits, depth);
        ended.find(frame, batch, hits, depth);
        machine.add(frame.isa, Source::Arrived, &ended.light, &ended.slot, ended.len);
        points.find(frame, batch, hits, machine.seeds());
        points.look_up_phong(frame);
        if frame.material_table.has_ambient {
            let Points { ambient, labels, .. } = &**points;
            machine.add(frame.isa, Source::Ambient, ambient, &labels.slot, points.len());
        }
        if depth == 0 {
            first_hits.add(frame, batch, hits, points);
        }
        features.add(frame, batch, hits, points, |i| Own::of_phong(frame, points, i));
        let scatters = depth < frame.settings.recursion() && lobes.find(frame, points);
        self.ask_lights(machine, job, scatters, depth)?;
        if scatters {
            self.scatter(machine, job, depth)?;
        }
        Some(())
    }
}
