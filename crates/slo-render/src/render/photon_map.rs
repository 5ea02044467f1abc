//! The photons of `PHOTON_MAP`, before the first sample of a picture.

use std::sync::Mutex;

use rayon::prelude::*;

use super::lock::lock;
use super::photon_cache::irradiance_cache;
use crate::frame::FrameScene;
use crate::integrator::{Flux, PhotonTracer};
use crate::photons::{Deposit, FluxMap, IrradianceMap, PhotonCounts, PhotonLight, irradiance_at};

/// Light paths that a thread traces at a time.
const PATHS_AT_ONCE: u32 = 4096;

/// Light paths of the first round, and most of a later one.
const FIRST_PATHS: u32 = 1 << 16;
const MOST_PATHS: u32 = 1 << 21;

/// A map that does not fill gets no more than so many light paths for each photon.
const MOST_PATHS_A_PHOTON: u32 = 8;

/// Traces the photons of a frame, on the threads of the current rayon pool. Returns `None` if
/// `gives_up` says to give up.
pub(super) fn photon_light(
    frame: &FrameScene,
    gives_up: &(dyn Fn() -> bool + Sync),
) -> Option<PhotonLight> {
    let mut light = match frame.known_light.get() {
        Some(known) => known.clone(),
        None => stored_light(frame, gives_up)?,
    };
    if frame.baked.is_some() {
        // If another thread was faster, it has found the same.
        let _ = frame.known_light.set(light.clone());
    }
    let settings = &frame.settings;
    if frame.photon_lamps.is_some() && settings.gather && settings.cache_error > 0.0 {
        light.cache = irradiance_cache(frame, &light, gives_up)?;
    }
    Some(light)
}

/// A map of photons, and what it took.
struct Made {
    map: FluxMap,
    counts: PhotonCounts,
}

/// Finds the light of photons, without a cache.
fn stored_light(frame: &FrameScene, gives_up: &(dyn Fn() -> bool + Sync)) -> Option<PhotonLight> {
    let Some(lamps) = &frame.photon_lamps else { return Some(PhotonLight::default()) };
    let threads = rayon::current_num_threads();
    let maker =
        Maker { frame, tracers: (0..threads).map(|_| Mutex::default()).collect(), gives_up };
    let settings = &frame.settings;
    let (size, nearest) = (settings.photon_map_size, settings.photon_nearest);
    let all = maker.map(Flux::Everywhere, size, settings.photon_distance, nearest)?;
    let surfaces = IrradianceMap::new(&all.map, nearest, frame.isa, gives_up)?;
    let mut maps = Vec::new();
    for texels in frame.light_maps.all() {
        let points = frame.texel_middles(texels);
        maps.push(irradiance_at(&all.map, nearest, frame.isa, &points, gives_up)?);
    }
    let mut making = all.counts;
    making.memory += surfaces.memory();
    drop(all);
    let caustics = if lamps.aimed.is_some() {
        let (size, nearest) = (settings.caustic_map_size, settings.caustic_nearest);
        let made = maker.map(Flux::Caustics, size, settings.caustic_distance, nearest)?;
        making += PhotonCounts { memory: made.counts.memory + surfaces.memory(), ..made.counts };
        made.map
    } else {
        FluxMap::default()
    };
    let (surfaces, caustics, maps) = (surfaces.into(), caustics.into(), maps.into());
    Some(PhotonLight { surfaces, caustics, maps, making, ..PhotonLight::default() })
}

struct Maker<'a> {
    frame: &'a FrameScene,
    tracers: Vec<Mutex<PhotonTracer>>,
    gives_up: &'a (dyn Fn() -> bool + Sync),
}

impl Maker<'_> {
    /// Makes a map of the photons of the first light paths: of as many as `size` allows.
    fn map(&self, flux: Flux, size: u32, distance: Option<f32>, nearest: u32) -> Option<Made> {
        let most = size.saturating_mul(MOST_PATHS_A_PHOTON).max(PATHS_AT_ONCE);
        let (mut deposits, mut sent): (Vec<Deposit>, u32) = (Vec::new(), 0);
        while deposits.len() <= size as usize && sent < most {
            // As many as fill the map if the next ones leave as many photons as those before.
            let missing = size as f64 + 1.0 - deposits.len() as f64;
            let wanted = match deposits.len() {
                0 => f64::from(FIRST_PATHS.min(size)).max(2.0 * f64::from(sent)),
                len => missing * f64::from(sent) / len as f64 * 1.02,
            };
            let round = (wanted as u32).clamp(PATHS_AT_ONCE, MOST_PATHS).min(most - sent);
            let starts: Vec<u32> = (sent..sent + round).step_by(PATHS_AT_ONCE as usize).collect();
            let end = sent + round;
            let traced: Option<Vec<Vec<Deposit>>> = starts
                .into_par_iter()
                .map(|start| {
                    let thread = rayon::current_thread_index().unwrap_or(0);
                    let range = start..end.min(start + PATHS_AT_ONCE);
                    lock(&self.tracers[thread]).deposits(self.frame, flux, range, self.gives_up)
                })
                .collect();
            deposits.extend(traced?.into_iter().flatten());
            sent = end;
        }
        let paths = cut(&mut deposits, size as usize).unwrap_or(sent);
        let map = FluxMap::new(&deposits, paths as f32, distance, nearest);
        let counts = PhotonCounts {
            passes: 0,
            paths: u64::from(sent),
            photons: deposits.len() as u64,
            records: 0,
            memory: deposits.capacity() * size_of::<Deposit>() + map.memory(),
        };
        Some(Made { map, counts })
    }
}

/// Keeps the photons of the first light paths, as many as `size` allows. Returns the number of these
/// light paths; `None` if all fit.
fn cut(deposits: &mut Vec<Deposit>, size: usize) -> Option<u32> {
    let paths = deposits.get(size)?.path;
    let len = deposits.partition_point(|deposit| deposit.path < paths);
    // A single light path may leave more photons than that.
    deposits.truncate(if paths == 0 { size } else { len });
    Some(paths.max(1))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn maps_hold_whole_light_paths() {
        let of = |path| Deposit { position: Vec3::ZERO, power: Vec3::ONE, normal: 0, path };
        let all: Vec<Deposit> = [0, 0, 2, 2, 2, 5].map(of).into();
        let cut_to = |size| {
            let mut deposits = all.clone();
            let paths = cut(&mut deposits, size);
            (deposits.len(), paths)
        };
        assert_eq!(
            [1, 2, 4, 5].map(cut_to),
            [(1, Some(1)), (2, Some(2)), (2, Some(2)), (5, Some(5))]
        );
        assert_eq!([6, 9].map(cut_to), [(6, None); 2]);
    }
}
