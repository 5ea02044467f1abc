//! Photon mapping: all light, with a bias instead of noise.
//!
//! Rays from the camera follow all lobes that are not diffuse as those of [`Path`](super::path) do,
//! and ask lamps at every hit. The rest of the light of diffuse lobes comes from photons: at once
//! (`gather 0`), or by rays that gather it one bounce farther away (`gather 1`), where errors of the
//! photons do not show. Caustics always come from photons of their own.
//!
//! Sources: H. W. Jensen, "Realistic Image Synthesis Using Photon Mapping" (2001); P. H. Christensen,
//! "Faster Photon Map Global Illumination" (1999).

use slo_picture::film::PlaceLayers;

use super::account::Source;
use super::batch::Batch;
use super::branching::continuations;
use super::machine::{Integrator, Machine};
use super::stages::hemispheres::{Hemispheres, Probe};
use super::stages::stored_light::StoredLight;
use super::vertices::Vertices;
use super::work::Job;
use crate::photons::{Grid, PhotonLight};
use crate::sampling::PixelSeed;

/// The stages, in the order in which a batch passes them.
#[derive(Debug, Default)]
pub(super) struct PhotonMapping {
    pub(super) vertices: Vertices,
    stored: Box<StoredLight>,
    /// Where rays start instead of at the camera, while records of the cache are made.
    hemispheres: Option<Box<Hemispheres>>,
}

impl PhotonMapping {
    /// Begins new work, as [`Vertices::restart`] does.
    pub(super) fn restart(&mut self, features: usize, stride: usize) {
        self.vertices.restart(features, stride);
        self.hemispheres = None;
    }

    /// Begins to gather the hemispheres about some points.
    pub(super) fn restart_hemispheres(&mut self, probes: &[Probe], grid: Grid, round: u32) {
        self.restart(0, 0);
        self.vertices.first_hits.reset(PlaceLayers::default(), false, 0);
        self.hemispheres.get_or_insert_default().restart(probes, grid, round);
    }

    /// Returns how far the rays of hemispheres went.
    pub(super) fn distances(&self) -> &[f32] {
        self.hemispheres.as_ref().map_or(&[], |hemispheres| &hemispheres.distances)
    }

    /// Queues the rays that follow lobes. Returns `None` if the work is given up.
    fn follow(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let Self { vertices, stored, .. } = self;
        let count = continuations(&job.frame.settings, depth);
        for number in 0..count {
            vertices.send(job, [number, count], depth);
            stored.restrict(job.frame, &vertices.points, &mut vertices.continuation);
            vertices.queue(machine, depth);
            job.goes_on()?;
        }
        Some(())
    }
}

impl Integrator for PhotonMapping {
    fn start(&mut self, job: &Job<'_>, seeds: &[PixelSeed]) -> Option<u32> {
        match &mut self.hemispheres {
            Some(hemispheres) => {
                hemispheres.fill(job.frame, &mut self.vertices.batch).then_some(Hemispheres::DEPTH)
            }
            None => self.vertices.start(job, seeds),
        }
    }

    fn batch(&mut self) -> &mut Batch {
        &mut self.vertices.batch
    }

    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()> {
        let frame = job.frame;
        let Self { vertices, stored, hemispheres } = self;
        let goes_on = vertices.arrive(machine, job, depth, frame.settings.gather);
        if depth == Hemispheres::DEPTH
            && let Some(hemispheres) = hemispheres
        {
            hemispheres.note(&vertices.batch, &vertices.hits);
        }
        if !goes_on {
            return Some(());
        }
        let Vertices { batch, hits, points, bsdfs, .. } = vertices;
        let none = PhotonLight::default();
        stored.find(frame, job.light.unwrap_or(&none), (batch, hits), points, bsdfs);
        let slot = &points.labels.slot;
        machine.add(frame.isa, Source::Photons, &stored.light, slot, points.len());
        stored.close(frame, points, bsdfs);
        if !stored.any_goes_on(points) {
            return Some(());
        }
        if stored.any_open(points) {
            stored.hide_ends(points);
            vertices.ask_lamps(machine, job, depth)?;
            stored.show_ends(&mut vertices.points);
        }
        self.follow(machine, job, depth)
    }
}
