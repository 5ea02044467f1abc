//! The irradiance cache of `PHOTON_MAP`: where its records lie.
//!
//! Records are placed in passes from a coarse grid of pixels to all of them. In each, points get a
//! record that the records of the passes before do not serve. A pass does not depend on how its points
//! are dealt to threads.

use std::sync::Mutex;

use rayon::prelude::*;

use super::lock::lock;
use crate::frame::FrameScene;
use crate::integrator::{HemisphereTracer, Probe, Work};
use crate::photons::{CacheRecord, IrradianceCache, PhotonLight};

/// Distance of the pixels of the first pass.
const FIRST_STEP: u32 = 16;

/// Pixels, and points, that a thread takes at a time.
const PIXELS_AT_ONCE: usize = 4096;
const PROBES_AT_ONCE: usize = 16;

/// Fills the cache of a frame. Returns `None` if `gives_up` says to give up.
pub(super) fn irradiance_cache(
    frame: &FrameScene,
    light: &PhotonLight,
    gives_up: &(dyn Fn() -> bool + Sync),
) -> Option<IrradianceCache> {
    let threads = rayon::current_num_threads();
    let tracers: Vec<Mutex<HemisphereTracer>> = (0..threads).map(|_| Mutex::default()).collect();
    let tracer = || lock(&tracers[rayon::current_thread_index().unwrap_or(0)]);
    let (error, in_front) = (frame.settings.cache_error, frame.settings.cache_in_front);
    let mut records: Vec<CacheRecord> = Vec::new();
    let mut cache = IrradianceCache::new(&records, error, in_front);
    let steps = std::iter::successors(Some(FIRST_STEP), |step| (step / 2 > 0).then(|| step / 2));
    for step in steps {
        for offset in offsets(step) {
            let work = pixels(frame, step, offset);
            let probes: Vec<Probe> = work
                .par_chunks(PIXELS_AT_ONCE)
                .flat_map_iter(|work| tracer().probes(frame, work).into_iter().flatten())
                .filter(|probe| cache.light(probe.point, probe.normal).is_none())
                .collect();
            let more: Option<Vec<Vec<CacheRecord>>> = probes
                .par_chunks(PROBES_AT_ONCE)
                .map(|probes| tracer().records(frame, light, probes, gives_up))
                .collect();
            let more = more?;
            if !more.is_empty() {
                records.extend(more.into_iter().flatten());
                cache = IrradianceCache::new(&records, error, in_front);
            }
        }
    }
    Some(cache)
}

/// The passes of a step: their pixels are twice as far apart as the step, so that few of them would have
/// served each other.
fn offsets(step: u32) -> Vec<[u32; 2]> {
    let all = [[0, 0], [step, step], [step, 0], [0, step]];
    // The first of these were pixels of the step before.
    if step == FIRST_STEP { all.to_vec() } else { all[1..].to_vec() }
}

/// The pixels of a pass: one sample of each.
fn pixels(frame: &FrameScene, step: u32, [left, top]: [u32; 2]) -> Vec<Work> {
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let apart = 2 * step as usize;
    let row = |y: u32| {
        let work = move |x: u32| Work { x, y, first: 0, count: 1 };
        (left..width).step_by(apart).map(work)
    };
    (top..height).step_by(apart).flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_have_each_pixel_of_their_grid_once() {
        let mut seen = vec![0; 64 * 64];
        let steps =
            std::iter::successors(Some(FIRST_STEP), |step| (step / 2 > 0).then(|| step / 2));
        for step in steps {
            for [left, top] in offsets(step) {
                for y in (top..64).step_by(2 * step as usize) {
                    for x in (left..64).step_by(2 * step as usize) {
                        seen[(y * 64 + x) as usize] += 1;
                    }
                }
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}
