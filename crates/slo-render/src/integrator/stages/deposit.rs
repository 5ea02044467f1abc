//! Photons of `PHOTON_MAP` where they meet rough surfaces.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};

use super::bsdfs::Bsdfs;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, marks};
use crate::photons::Deposit;
use crate::shading::light::receiver;

/// The photons of some light paths.
#[derive(Debug)]
pub(in crate::integrator) struct Deposits {
    /// Whether only photons count whose light is not brought otherwise.
    only_indirect: bool,
    is_rough: Column<u32>,
    found: Vec<Deposit>,
}

impl Default for Deposits {
    fn default() -> Self {
        Self { only_indirect: false, is_rough: [0; BATCH], found: Vec::new() }
    }
}

impl Deposits {
    /// Begins with no photons.
    pub(in crate::integrator) fn restart(&mut self, only_indirect: bool) {
        self.only_indirect = only_indirect;
        self.found.clear();
    }

    /// Stores the photons of a batch that are on rough surfaces.
    pub(in crate::integrator) fn store(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        points: &Points,
        bsdfs: &Bsdfs,
    ) {
        bsdfs.find_rough(frame, points, &mut self.is_rough);
        for i in 0..points.len() {
            let power = points.weight.get(i);
            let mark = batch.past.marks[points.surfaces.ray[i] as usize];
            // Rays to lamps bring what comes straight, and photons of caustics what passed something sharp.
            let is_caustic = mark & marks::SHARP != 0;
            let is_missing = mark & marks::ROUGH != 0
                || (is_caustic && !frame.sends_caustics(points.labels.slot[i]));
            let is_photon = self.is_rough[i] != 0 && marks::asked(mark) == 0;
            let counts = is_photon && (is_missing || !self.only_indirect);
            if counts && power != Vec3::ZERO && power.is_finite() {
                self.found.push(Deposit {
                    position: points.surfaces.point.get(i),
                    power,
                    normal: receiver::pack(points.surfaces.n_geo.get(i)),
                    path: points.labels.index[i],
                });
            }
        }
    }

    /// Returns the photons, in the order of their light paths.
    pub(in crate::integrator) fn take(&mut self) -> Vec<Deposit> {
        let mut found = std::mem::take(&mut self.found);
        found.sort_by_key(|deposit| deposit.path);
        found
    }
}
