//! Path tracing: all light.
//!
//! A hit sends rays to lamps, and one ray that follows one of its lobes. Rays that hit a lamp or the
//! sky share its light with the rays to lamps by multiple importance sampling. The last hit of a
//! path sends a ray too, which only collects what glows.
//!
//! Scenes of `DISTRIBUTED` with physical lamps or materials are rendered here as well; their diffuse
//! lobes are not followed.

use slo_picture::film::Features;
use slo_scene::Integrator as Kind;

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
use super::stages::hits::Hits;
use super::stages::lamp_light::LampLight;
use super::stages::merging::Merging;
use super::stages::passing::Passing;
use super::stages::pilot::Pilot;
use super::stages::points::Points;
use super::stages::to_shaded::ToShaded;
use super::stages::visibility::Visibility;
use super::work::Job;
use crate::frame::WorldScratch;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct Path {
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
    guiding: Box<Guiding>,
    lamp_light: Box<LampLight>,
    to_shaded: Box<ToShaded>,
    merging: Box<Merging>,
    visibility: Box<Visibility>,
    continuation: Box<Continuation>,
    pub(super) pilot: Pilot,
    /// Distance between the slots of two groups of lights; 0 if groups are not told apart.
    stride: u32,
    /// Working memory of ray queries, used by one stage at a time.
    scratch: WorldScratch,
}

impl Path {
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

    /// Traces the batch, adds the light of its rays, and queues the rays that its hits send out.
    /// Returns `None` if the work is given up.
    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let frame = job.frame;
        let Self {
            camera_rays,
            batch,
            hits,
            arrived,
            points,
            emission,
            features,
            first_hits,
            bsdfs,
            passing,
            stride,
            scratch,
            ..
        } = self;
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
        bsdfs.find(frame, points);
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
        if table.has_ambient && frame.settings.integrator == Kind::Distributed {
            points.look_up_phong(frame);
            machine.add(frame.isa, &points.ambient, &points.labels.slot, points.len());
        }
        if depth == 0 {
            first_hits.add(frame, batch, hits, points);
        }
        if features.are_wanted() {
            bsdfs.find_own(frame, points);
            features.add(frame, batch, hits, points, |i| bsdfs.own(i));
        }
        self.guiding.find(job, &self.points);
        if let Some(maps) = job.maps {
            let Self { batch, hits, points, bsdfs, guiding, merging, stride, .. } = self;
            points.find_footprints(batch, hits);
            merging.reach(frame, maps, points, depth);
            while merging.find(job, maps, points, (&**bsdfs, &**guiding), (depth, *stride)) {
                machine.add(frame.isa, &merging.light, &merging.slot, merging.len);
                job.goes_on()?;
            }
        }
        self.ask_lamps(machine, job, depth)?;
        self.follow(machine, job, depth)
    }

    /// Queues the rays from all points to lamps. Returns `None` if the work is given up.
    fn ask_lamps(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let kind = Connection::at(depth);
        for question in questions(job.frame, depth) {
            let Self { points, bsdfs, guiding, lamp_light, stride, .. } = self;
            lamp_light.ask(job, points, (&**bsdfs, &**guiding), question, depth);
            lamp_light.name(job.frame, points, *stride);
            machine.connect(kind, &lamp_light.sent, &lamp_light.labels, &lamp_light.chosen);
            let Self { points, lamp_light, to_shaded, features, .. } = self;
            if job.frame.has_shaded_lights() {
                to_shaded.find(job.frame, points, lamp_light, features.first_behind());
                let ToShaded { sent, labels, past, chosen, .. } = &**to_shaded;
                machine.extend_path(depth + 1, sent, labels, past, chosen);
            }
            machine.relieve(self, job, kind);
            job.goes_on()?;
        }
        Some(())
    }

    /// Queues the rays that follow lobes of all points. Returns `None` if the work is given up.
    fn follow(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Self { points, bsdfs, guiding, continuation, features, pilot, .. } = self;
        let count = continuations(&job.frame.settings, depth);
        // A pilot path doesn't branch.
        let sent = if job.is_pilot { 1 } else { count };
        for number in 0..sent {
            let (place, first_behind) = ([number, count], features.first_behind());
            continuation.send(job, points, (&**bsdfs, &**guiding), place, depth, first_behind);
            if job.is_pilot {
                pilot.remember(points, continuation, count);
            }
            let Continuation { rays: Rays { sent, past, .. }, labels, chosen, .. } =
                &**continuation;
            machine.extend_path(depth + 1, sent, labels, past, chosen);
            job.goes_on()?;
        }
        Some(())
    }
}

impl Integrator for Path {
    fn start_paths(&mut self, machine: &mut Machine, job: &Job<'_>) -> Option<bool> {
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
