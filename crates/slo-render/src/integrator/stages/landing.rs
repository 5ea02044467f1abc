//! Photons where they meet a rough surface.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::bsdfs::Bsdfs;
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
    /// Stores the photons of a batch, after `depth` bounces, that are on rough surfaces.
    pub(in crate::integrator) fn store(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        points: &Points,
        bsdfs: &Bsdfs,
        depth: u32,
    ) {
        bsdfs.find_rough(frame, points, &mut self.is_rough);
        for i in 0..points.len() {
            let power = points.weight.get(i);
            if self.is_rough[i] == 0 || power == Vec3::ZERO || !power.is_finite() {
                continue;
            }
            let photon = Photon {
                position: points.surfaces.point.get(i),
                power,
                density: batch.density[points.surfaces.ray[i] as usize],
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
