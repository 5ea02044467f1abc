//! The vertices of paths: what the integrators of physical light do where the rays of a batch arrive.

use slo_picture::film::Features;
use slo_scene::Integrator as Kind;

use super::account::Source;
use super::batch::Batch;
use super::branching::most_camera_rays;
use super::machine::{Connection, Machine};
use super::stages::arrived::{Arrived, arrived_parts};
use super::stages::bsdfs::Bsdfs;
use super::stages::camera_rays::CameraRays;
use super::stages::continuation::{Continuation, Rays};
use super::stages::direct_light::questions;
use super::stages::emission::Emission;
use super::stages::features::FeatureSums;
use super::stages::first_hits::FirstHits;
use super::stages::guiding::Guiding;
use super::stages::hits::Hits;
use super::stages::lamp_light::LampLight;
use super::stages::passing::Passing;
use super::stages::points::Points;
use super::stages::to_shaded::ToShaded;
use super::work::Job;
use crate::sampling::PixelSeed;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    camera_rays: Box<CameraRays>,
    /// The current batch.
    pub(super) batch: Box<Batch>,
    pub(super) hits: Box<Hits>,
    arrived: Box<Arrived>,
    pub(super) points: Box<Points>,
    passing: Box<Passing>,
    emission: Box<Emission>,
    features: FeatureSums,
    pub(super) first_hits: FirstHits,
    pub(super) bsdfs: Box<Bsdfs>,
    pub(super) guiding: Box<Guiding>,
    lamp_light: Box<LampLight>,
    to_shaded: Box<ToShaded>,
    pub(super) continuation: Box<Continuation>,
    /// Distance between the slots of two groups of lights; 0 if groups are not told apart.
    pub(super) stride: u32,
}

impl Vertices {
    /// Begins new work. Features are collected for `features` slots. If the light of groups of lights
    /// is collected, the slots of each group follow those of the one before at a distance of
    /// `stride`; otherwise it is 0.
    pub(super) fn restart(&mut self, features: usize, stride: usize) {
        self.camera_rays.restart();
        self.features.reset(features);
        self.stride = stride as u32;
    }

    /// Returns the surface features of each slot.
    pub(super) fn features(&self) -> &[Features] {
        self.features.get()
    }

    /// Fills the batch with the next camera rays. Returns the number of bounces before them, or `None`
    /// if all were created.
    pub(super) fn start(&mut self, job: &Job<'_>, seeds: &[PixelSeed]) -> Option<u32> {
        let most = most_camera_rays(&job.frame.settings);
        self.camera_rays.fill(job, seeds, most, &mut self.batch);
        (self.batch.len() > 0).then_some(0)
    }

    /// Traces the batch, adds the light that its rays find, and sets up the lobes where they hit.
    /// `diffuse` says whether rays follow diffuse lobes. Returns false if paths end here.
    pub(super) fn arrive(
        &mut self,
        machine: &mut Machine,
        job: &Job<'_>,
        depth: u32,
        diffuse: bool,
    ) -> bool {
        let frame = job.frame;
        let Self { camera_rays, batch, hits, arrived, points, passing, emission, .. } = self;
        let Self { features, first_hits, bsdfs, guiding, stride, .. } = self;
        if depth > 0 || !hits.take_texels(frame, batch, camera_rays) {
            machine.find_hits(job, batch, hits, depth);
        }
        if frame.has_passable_lamps(depth) {
            passing.lamps(frame, batch, hits, depth);
            passing.queue(machine, depth);
        }
        for part in 0..arrived_parts(frame, *stride) {
            arrived.find(frame, batch, hits, depth, (*stride, part));
            let Arrived { light, slot, len, .. } = &**arrived;
            machine.add(frame.isa, Source::Arrived, light, slot, *len);
        }
        let is_last = depth > frame.settings.recursion();
        let table = &frame.material_table;
        if is_last && !table.emits && !table.images.any_passes() {
            return false;
        }
        points.find(frame, batch, hits, machine.seeds());
        points.choose_materials(frame, &frame.sampler, depth);
        bsdfs.look_up(frame, points);
        points.find_receivers(frame);
        if table.absorbs {
            bsdfs.absorb(batch, points);
        }
        if table.images.any_passes() {
            bsdfs.let_pass(points);
            passing.surfaces(frame, batch, points);
            passing.queue(machine, depth);
        }
        bsdfs.find(frame, points, diffuse);
        bsdfs.open_receivers(points);
        if table.emits && emission.find(frame, batch, hits, points, bsdfs, depth) {
            emission.name(frame, hits, points, *stride);
            let Emission { light, slot } = &**emission;
            machine.add(frame.isa, Source::Emitted, light, slot, points.len());
        }
        if is_last {
            return false;
        }
        if frame.has_shaded_lights() {
            Emission::end(batch, points, depth);
        }
        if table.has_ambient && frame.settings.integrator == Kind::Distributed {
            points.look_up_phong(frame);
            let Points { ambient, labels, .. } = &**points;
            machine.add(frame.isa, Source::Ambient, ambient, &labels.slot, points.len());
        }
        if depth == 0 {
            first_hits.add(frame, batch, hits, points);
        }
        if features.are_wanted() {
            bsdfs.find_own(frame, points);
            features.add(frame, batch, hits, points, |i| bsdfs.own(i));
        }
        guiding.find(job, points);
        true
    }

    /// Queues the rays from all points to lamps. Returns `None` if the work is given up.
    pub(super) fn ask_lamps(
        &mut self,
        machine: &mut Machine,
        job: &Job<'_>,
        depth: u32,
    ) -> Option<()> {
        let kind = Connection::at(depth);
        for question in questions(job.frame, depth) {
            let Self { points, bsdfs, guiding, lamp_light, to_shaded, .. } = self;
            lamp_light.ask(job, points, (&**bsdfs, &**guiding), question, depth);
            lamp_light.name(job.frame, points, self.stride);
            let LampLight { sent, labels, chosen, .. } = &**lamp_light;
            machine.connect(kind, sent, labels, chosen, |i| lamp_light.light(i));
            if job.frame.has_shaded_lights() {
                to_shaded.find(job.frame, points, lamp_light, self.features.first_behind());
                let ToShaded { sent, labels, past, chosen, .. } = &**to_shaded;
                machine.extend_path(depth + 1, sent, labels, past, chosen);
            }
            machine.relieve(job, kind)?;
        }
        Some(())
    }

    /// Creates ray number `place[0]` of `place[1]` from every point.
    pub(super) fn send(&mut self, job: &Job<'_>, place: [u32; 2], depth: u32) {
        let Self { points, bsdfs, guiding, continuation, features, .. } = self;
        let lobes = (&**bsdfs, &**guiding);
        continuation.send(job, points, lobes, place, depth, features.first_behind());
    }

    /// Queues the rays that were sent from here, after `depth` bounces.
    pub(super) fn queue(&self, machine: &mut Machine, depth: u32) {
        let Continuation { rays: Rays { sent, past, .. }, labels, chosen, .. } =
            &*self.continuation;
        machine.extend_path(depth + 1, sent, labels, past, chosen);
    }
}
