//! Photons where they meet a rough surface.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::bsdfs::Bsdfs;
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::Batch;
use crate::photons::Photon;
use crate::shading::light::receiver;

/// The photons of some light paths.
#[derive(Debug)]
pub(in crate::integrator) struct Landing {
    is_rough: Column<u32>,
    /// With their times.
    found: Vec<(f32, Photon)>,
}

impl Default for Landing {
    fn default() -> Self {
        Self { is_rough: [0; BATCH], found: Vec::new() }
    }
}

impl Landing {
    /// Stores the photons of a batch, after `depth` bounces, that are on rough surfaces. The
    /// shutter is divided into so many `slabs` of time.
    pub(in crate::integrator) fn store(
        &mut self,
        frame: &FrameScene,
        (batch, hits): (&Batch, &Hits),
        points: &Points,
        bsdfs: &Bsdfs,
        (depth, slabs): (u32, u32),
    ) {
        bsdfs.find_rough(frame, points, &mut self.is_rough);
        for i in 0..points.len() {
            let power = points.weight.get(i);
            if self.is_rough[i] == 0 || power == Vec3::ZERO || !power.is_finite() {
                continue;
            }
            let ray = points.surfaces.ray[i] as usize;
            let photon = Photon {
                position: settled(frame, points, hits.found.instance[ray], i, slabs),
                power,
                density: batch.density[ray],
                toward: receiver::pack(-points.direction.get(i)),
                normal: receiver::pack(points.surfaces.n_geo.get(i)),
                light: points.labels.slot[i],
                bounces: depth,
            };
            self.found.push((points.labels.time[i], photon));
        }
    }

    /// Returns the photons.
    pub(in crate::integrator) fn take(&mut self) -> Vec<(f32, Photon)> {
        std::mem::take(&mut self.found)
    }
}

/// Returns where point `i`, of an instance, looks for photons, and where a photon there is stored: where
/// the surface is in the middle of its slab of time. Otherwise, a surface that moves along its normal
/// would leave the photons of other times behind. Motion along the surface is left out, since light
/// that stays where it is would be blurred by it.
pub(super) fn settled(
    frame: &FrameScene,
    points: &Points,
    instance: u32,
    i: usize,
    slabs: u32,
) -> Vec3 {
    let (point, time) = (points.surfaces.point.get(i), points.labels.time[i]);
    if slabs == 1 {
        return point;
    }
    let slab = ((time * slabs as f32) as u32).min(slabs - 1);
    let middle = (slab as f32 + 0.5) / slabs as f32;
    let n_geo = points.surfaces.n_geo.get(i);
    point + n_geo * n_geo.dot(frame.moved(instance, point, [time, middle]) - point)
}
