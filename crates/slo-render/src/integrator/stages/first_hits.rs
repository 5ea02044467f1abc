//! What camera rays hit first, for compositors: places, and ids of objects and materials.
//!
//! Surfaces and lamps count that a ray passes through neither by chance nor because the camera does not
//! see them.

use glam::Vec3;

use slo_accel::math::columns::BATCH;
use slo_picture::film::{PlaceLayers, Wide};

use super::hits::Hits;
use super::points::Points;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::Batch;
use crate::integrator::work::Seen;

/// Exact sums of places, and the ids that samples saw; both empty if nobody asks for them.
#[derive(Debug, Default)]
pub(in crate::integrator) struct FirstHits {
    layers: PlaceLayers,
    has_ids: bool,
    /// Sums of the layers, slot by slot.
    places: Vec<Wide>,
    seen: Vec<Seen>,
}

impl FirstHits {
    /// Begins new work of so many slots.
    pub(in crate::integrator) fn reset(
        &mut self,
        layers: PlaceLayers,
        has_ids: bool,
        slots: usize,
    ) {
        (self.layers, self.has_ids) = (layers, has_ids);
        self.places.clear();
        self.places.resize(slots * layers.columns(), Wide::default());
        self.seen.clear();
    }

    /// Returns the sums of places, slot by slot, and the ids that samples saw.
    pub(in crate::integrator) fn get(&self) -> (&[Wide], &[Seen]) {
        (&self.places, &self.seen)
    }

    /// Adds what a batch of camera rays hits.
    pub(in crate::integrator) fn add(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        points: &Points,
    ) {
        if self.places.is_empty() && !self.has_ids {
            return;
        }
        let surfaces = &points.surfaces;
        for i in (0..surfaces.len.min(BATCH)).filter(|&i| points.passes[i] == 0) {
            self.push(frame, batch, hits, surfaces.ray[i] as usize, surfaces.point.get(i));
        }
        for i in hits.shaded.others(batch.len()) {
            if let Look::Light(light) = Look::of_word(hits.looks[i])
                && !frame.is_passable(light)
                && !frame.is_hidden(light)
            {
                let way = batch.rays.direction(i) * hits.found.hits.t[i];
                self.push(frame, batch, hits, i, batch.rays.origin(i) + way);
            }
        }
    }

    fn push(&mut self, frame: &FrameScene, batch: &Batch, hits: &Hits, ray: usize, point: Vec3) {
        let (slot, time) = (batch.labels.slot[ray], batch.labels.time[ray]);
        let columns = self.layers.columns();
        let start = slot as usize * columns;
        if let Some(sums) = self.places.get_mut(start..start + columns)
            && columns > 0
        {
            let place = frame.place_of(self.layers, (&hits.found, ray), point, time);
            self.layers.add(sums, &place);
        }
        if self.has_ids {
            self.seen.push(Seen { entry: slot, ids: frame.mask_ids(&hits.found, ray) });
        }
    }
}
