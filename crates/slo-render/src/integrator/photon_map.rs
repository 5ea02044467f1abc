//! Photon mapping: all light, with a bias instead of noise.
//!
//! Rays from the camera follow all lobes that are not diffuse as those of [`Path`](super::path) do,
//! and ask lamps at every hit. The rest of the light of diffuse lobes comes from photons: at once
//! (`gather 0`), or by rays that gather it one bounce farther away (`gather 1`), where errors of the
//! photons do not show. Caustics always come from photons of their own.
//!
//! Sources: H. W. Jensen, "Realistic Image Synthesis Using Photon Mapping" (2001); P. H. Christensen,
//! "Faster Photon Map Global Illumination" (1999).

use slo_picture::film::{Features, PlaceLayers};

use super::batch::Batch;
use super::branching::{continuations, most_camera_rays};
use super::machine::{Connection, Integrator, Machine};
use super::stages::arrived::{Arrived, arrived_parts};
use super::stages::bsdfs::Bsdfs;
use super::stages::camera_rays::CameraRays;
use super::stages::continuation::{Continuation, Rays};
use super::stages::direct_light::questions;
use super::stages::emission::Emission;
use super::stages::features::FeatureSums;
use super::stages::first_hits::FirstHits;
use super::stages::guiding::Guiding;
use super::stages::hemispheres::{Hemispheres, Probe};
use super::stages::hits::Hits;
use super::stages::lamp_light::LampLight;
use super::stages::passing::Passing;
use super::stages::points::Points;
use super::stages::stored_light::StoredLight;
use super::stages::to_shaded::ToShaded;
use super::stages::visibility::Visibility;
use super::work::Job;
use crate::frame::WorldScratch;
use crate::photons::{Grid, PhotonLight};

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct PhotonMapping {
    camera_rays: Box<CameraRays>,
    /// The current batch.
    batch: Box<Batch>,
    hits: Box<Hits>,
    arrived: Box<Arrived>,
    points: Box<Points>,
    passing: Box<Passing>,
    emission: Box<Emission>,
    features: FeatureSums,
    pub(super) first_hits: FirstHits,
    bsdfs: Box<Bsdfs>,
    stored: Box<StoredLight>,
    /// No field guides the rays.
    guiding: Box<Guiding>,
    lamp_light: Box<LampLight>,
    to_shaded: Box<ToShaded>,
    visibility: Box<Visibility>,
    continuation: Box<Continuation>,
    /// Where rays start instead of at the camera, while records of the cache are made.
    hemispheres: Option<Box<Hemispheres>>,
    /// See [`Path::restart`](super::path::Path::restart).
    stride: u32,
    /// Working memory of ray queries, used by one stage at a time.
    scratch: WorldScratch,
}

impl PhotonMapping {
    /// Begins new work, as [`Path::restart`](super::path::Path::restart) does.
    pub(super) fn restart(&mut self, features: usize, stride: usize) {
        self.camera_rays.restart();
        self.features.reset(features);
        self.stride = stride as u32;
        self.hemispheres = None;
    }

    /// Begins to gather the hemispheres about some points.
    pub(super) fn restart_hemispheres(&mut self, probes: &[Probe], grid: Grid, round: u32) {
        self.restart(0, 0);
        self.first_hits.reset(PlaceLayers::default(), false, 0);
        self.hemispheres.get_or_insert_default().restart(probes, grid, round);
    }

    /// Returns how far the rays of hemispheres went.
    pub(super) fn distances(&self) -> &[f32] {
        self.hemispheres.as_ref().map_or(&[], |hemispheres| &hemispheres.distances)
    }

    /// Returns the surface features of each slot.
    pub(super) fn features(&self) -> &[Features] {
        self.features.get()
    }

    /// Traces the batch, adds the light of its rays, and queues the rays that its hits send out.
    /// Returns `None` if the work is given up.
    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let frame = job.frame;
        let Self { batch, hits, arrived, points, emission, features, bsdfs, .. } = self;
        let Self { camera_rays, first_hits, passing, stored, stride, scratch, .. } = self;
        match depth {
            0 => hits.trace_first(frame, batch, camera_rays, machine.habit(0), scratch),
            _ => hits.trace(frame, batch, machine.habit(depth), scratch),
        }
        if frame.has_passable_lamps(depth) {
            passing.lamps(frame, batch, hits, depth);
            passing.queue(machine, depth);
        }
        for part in 0..arrived_parts(frame, *stride) {
            arrived.find(frame, batch, hits, depth, (*stride, part));
            machine.add(frame.isa, &arrived.light, &arrived.slot, arrived.len);
        }
        let is_last = depth > frame.settings.recursion();
        let table = &frame.material_table;
        if is_last && !table.emits && !table.images.any_passes() {
            return Some(());
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
        bsdfs.find_lobes(frame, points, frame.settings.gather);
        bsdfs.open_receivers(points);
        if table.emits && emission.find(frame, batch, hits, points, bsdfs, depth) {
            emission.name(frame, hits, points, *stride);
            machine.add(frame.isa, &emission.light, &emission.slot, points.len());
        }
        if is_last {
            return Some(());
        }
        if frame.has_shaded_lights() {
            Emission::end(batch, points, depth);
        }
        if depth == 0 {
            first_hits.add(frame, batch, hits, points);
        }
        if features.are_wanted() {
            bsdfs.find_own(frame, points);
            features.add(frame, batch, hits, points, |i| bsdfs.own(i));
        }
        let none = PhotonLight::default();
        stored.find(frame, job.light.unwrap_or(&none), (batch, hits), points, bsdfs);
        machine.add(frame.isa, &stored.light, &points.labels.slot, points.len());
        stored.close(frame, points, bsdfs);
        if !stored.any_goes_on(points) {
            return Some(());
        }
        if stored.any_open(points) {
            stored.hide_ends(points);
            self.ask_lamps(machine, job, depth)?;
            self.stored.show_ends(&mut self.points);
        }
        self.follow(machine, job, depth)
    }

    /// Queues the rays from all points to lamps. Returns `None` if the work is given up.
    fn ask_lamps(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let kind = Connection::at(depth);
        for question in questions(job.frame, depth) {
            let Self { points, bsdfs, guiding, lamp_light, to_shaded, .. } = self;
            lamp_light.ask(job, points, (&**bsdfs, &**guiding), question, depth);
            lamp_light.name(job.frame, points, self.stride);
            machine.connect(kind, &lamp_light.sent, &lamp_light.labels, &lamp_light.chosen);
            if job.frame.has_shaded_lights() {
                to_shaded.find(job.frame, points, lamp_light, self.features.first_behind());
                let ToShaded { sent, labels, past, chosen, .. } = &**to_shaded;
                machine.extend_path(depth + 1, sent, labels, past, chosen);
            }
            machine.relieve(self, job, kind);
            job.goes_on()?;
        }
        Some(())
    }

    /// Queues the rays that follow lobes. Returns `None` if the work is given up.
    fn follow(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Self { points, bsdfs, guiding, stored, continuation, features, .. } = self;
        let count = continuations(&job.frame.settings, depth);
        for number in 0..count {
            let (place, first_behind) = ([number, count], features.first_behind());
            let lobes = (&**bsdfs, &**guiding);
            continuation.send(job, points, lobes, place, depth, first_behind);
            stored.restrict(job.frame, points, continuation);
            let Continuation { rays: Rays { sent, past, .. }, labels, chosen, .. } =
                &**continuation;
            machine.extend_path(depth + 1, sent, labels, past, chosen);
            job.goes_on()?;
        }
        Some(())
    }
}

impl Integrator for PhotonMapping {
    fn start_paths(&mut self, machine: &mut Machine, job: &Job<'_>) -> Option<bool> {
        if let Some(hemispheres) = &mut self.hemispheres {
            if !hemispheres.fill(job.frame, &mut self.batch) {
                return Some(false);
            }
            self.trace(machine, job, 1)?;
            let Self { hemispheres, batch, hits, .. } = self;
            hemispheres.iter_mut().for_each(|hemispheres| hemispheres.note(batch, hits));
            return Some(true);
        }
        let most = most_camera_rays(&job.frame.settings);
        self.camera_rays.fill(job, machine.seeds(), most, &mut self.batch);
        if self.batch.len() == 0 {
            return Some(false);
        }
        machine.count_camera_rays(&self.batch);
        self.trace(machine, job, 0)?;
        Some(true)
    }

    fn extend_paths(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        machine.take_paths(depth, &mut self.batch);
        self.trace(machine, job, depth)
    }

    fn trace_connections(&mut self, machine: &mut Machine, job: &Job<'_>, kind: Connection) {
        let Self { visibility, scratch, .. } = self;
        machine.take_connections(kind, &mut visibility.batch);
        visibility.trace(job.frame, machine.connection_habit(kind), scratch);
        if let Some((sent, labels, chosen)) = visibility.beyond() {
            machine.connect(kind, sent, labels, chosen);
        }
        let Batch { weight, labels, .. } = &visibility.batch;
        machine.add(job.frame.isa, weight, &labels.slot, visibility.batch.len());
    }
}
