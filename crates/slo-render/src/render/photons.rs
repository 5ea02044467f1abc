//! Photons for the samples of a picture: which maps there are at a time, and who traces them.

use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::lock::lock;
use super::plan::Plan;
use crate::frame::FrameScene;
use crate::integrator::{PhotonPass, PhotonTracer};
use crate::photons::{PhotonLight, PhotonMap, PhotonMaps, Slab, pass_of, radius_share, samples_of};

/// Memory that the maps of one stretch may take, in bytes, unless a single one takes more.
const MOST_MEMORY: usize = 256 << 20;

/// Light paths that a thread traces at a time.
const PATHS_AT_ONCE: u32 = 8192;

/// A stretch of samples that all pixels take before any goes on to the next: those whose photons are
/// in memory. A picture without photons is one stretch. Their borders do not change the picture.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    pub(super) maps: Option<Arc<PhotonMaps>>,
    /// The light that photons brought, under `PHOTON_MAP`.
    pub(super) light: Option<Arc<PhotonLight>>,
    /// The number of the first sample that is not part of it.
    pub(super) end: u32,
    /// How much of the picture it is, if all pixels take as many samples as they may.
    pub(super) share: f64,
    /// Whether it is the first of the run.
    pub(super) is_first: bool,
}

impl Stretch {
    /// All samples of a picture without photons.
    pub(super) const WHOLE: Self =
        Self { maps: None, light: None, end: u32::MAX, share: 1.0, is_first: true };
}

/// The stretches of a picture, one after the other.
pub(super) struct Stretches<'a> {
    frame: &'a FrameScene,
    /// The number of the next sample; `None` if no sample needs photons.
    next: Option<u32>,
    is_first: bool,
    light: Option<Arc<PhotonLight>>,
    tracers: Tracers,
}

impl<'a> Stretches<'a> {
    /// The stretches from sample number `first` on, where photons are needed. All have the `light`.
    pub(super) fn new(
        frame: &'a FrameScene,
        first: Option<u32>,
        light: Option<Arc<PhotonLight>>,
    ) -> Self {
        let tracers = if first.is_some() { Tracers::new() } else { Tracers(Vec::new()) };
        Self { frame, next: first, is_first: true, light, tracers }
    }

    /// Returns the next stretch of a plan, at most to where it decides which pixels need more; `None` if
    /// there are no more samples, or if `gives_up` says to give up.
    pub(super) fn next(
        &mut self,
        plan: &Plan,
        gives_up: &(dyn Fn() -> bool + Sync),
    ) -> Option<Stretch> {
        let is_first = std::mem::replace(&mut self.is_first, false);
        let light = self.light.clone();
        let Some(next) = self.next else {
            return is_first.then_some(Stretch { light, ..Stretch::WHOLE });
        };
        let share = plan.samples().map_or(0, |share| share.start);
        let end = share.saturating_add(plan.next_border(next - share));
        if next >= end {
            return None;
        }
        let first = pass_of(next);
        let (mut passes, mut memory) = (Vec::new(), 0);
        for pass in first.. {
            let next = PhotonPass::new(self.frame, pass);
            memory += next.most_memory();
            if samples_of(pass).start >= end || (pass > first && memory > MOST_MEMORY) {
                break;
            }
            passes.push(next);
        }
        let maps = self.tracers.trace(self.frame, first, &passes, gives_up)?;
        let end = samples_of(first + passes.len() as u32 - 1).end;
        self.next = Some(end);
        let all = plan.samples().unwrap_or(0..plan.most());
        let share = f64::from(end.min(all.end).saturating_sub(next)) / all.len().max(1) as f64;
        Some(Stretch { maps: Some(Arc::new(maps)), light, end, share, is_first })
    }
}

/// Traces the photons of one pass, on all threads. Returns `None` if `gives_up` says to give up.
pub(super) fn maps_of(
    frame: &FrameScene,
    pass: u32,
    gives_up: &(dyn Fn() -> bool + Sync),
) -> Option<PhotonMaps> {
    Tracers::new().trace(frame, pass, &[PhotonPass::new(frame, pass)], gives_up)
}

/// What each thread traces photons with.
struct Tracers(Vec<Mutex<PhotonTracer>>);

impl Tracers {
    fn new() -> Self {
        Self((0..rayon::current_num_threads()).map(|_| Mutex::default()).collect())
    }

    /// Traces the photons of passes, on all threads.
    fn trace(
        &self,
        frame: &FrameScene,
        first: u32,
        passes: &[PhotonPass],
        gives_up: &(dyn Fn() -> bool + Sync),
    ) -> Option<PhotonMaps> {
        let pieces = |pass: PhotonPass| {
            let starts = (0..pass.paths()).step_by(PATHS_AT_ONCE as usize);
            starts.map(move |start| start..pass.paths().min(start + PATHS_AT_ONCE))
        };
        let work: Vec<_> = (0..)
            .zip(passes)
            .flat_map(|(number, &pass)| pieces(pass).map(move |range| (number, pass, range)))
            .collect();
        let traced: Option<Vec<_>> = work
            .into_par_iter()
            .map(|(number, pass, range)| {
                let thread = rayon::current_thread_index().unwrap_or(0);
                let mut tracer = lock(&self.0[thread]);
                let photons = tracer.trace(frame, pass, range, gives_up)?;
                Some((number, photons))
            })
            .collect();
        // Pieces come in their order, whoever traced them.
        let mut slabs: Vec<Vec<Vec<_>>> =
            passes.iter().map(|pass| vec![Vec::new(); pass.slabs() as usize]).collect();
        for (number, photons) in traced? {
            let slabs: &mut Vec<Vec<_>> = &mut slabs[number as usize];
            let count = slabs.len();
            for (time, photon) in photons {
                let slab = (time * count as f32) as usize;
                slabs[slab.min(count - 1)].push(photon);
            }
        }
        let map = |(number, slabs): (usize, Vec<Vec<_>>)| {
            let (pass, count) = (passes[number], slabs.len());
            let slabs = slabs.iter().map(|photons| Slab::new(photons)).collect();
            let paths = pass.paths() as f32 / count as f32;
            PhotonMap::new(slabs, paths, radius_share(first + number as u32))
        };
        let maps = slabs.into_par_iter().enumerate().map(map).collect();
        Some(PhotonMaps { first, maps })
    }
}
