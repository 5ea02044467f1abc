//! What pilot paths remember of the rough lobes that they left.

use glam::{DVec3, Vec3};

use super::continuation::Continuation;
use super::points::Points;
use crate::guiding::Record;
use crate::integrator::batch::marks;
use crate::integrator::work::SampleSum;

/// The rough lobes that pilot paths left. Each path is an entry of the work. Light that it finds after
/// `n` bounces belongs to slot `n * stride` plus the number of the entry, so the light that a hit
/// received is the sum of all later slots of its path.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Pilot {
    stride: u32,
    left: Vec<Left>,
}

/// A rough lobe that a path left.
#[derive(Clone, Copy, Debug)]
struct Left {
    /// Slot of the hit.
    slot: u32,
    /// Weight of the light that left the hit, over the number of rays.
    weight: Vec3,
    record: Record,
}

impl Pilot {
    /// Begins with so many paths.
    pub(in crate::integrator) fn restart(&mut self, paths: usize) {
        self.stride = paths as u32;
        self.left.clear();
    }

    /// Remembers the rays that leave points, `count` from each if they did not belong to pilot paths, and
    /// moves them to the slots of the next bounce.
    pub(in crate::integrator) fn remember(
        &mut self,
        points: &Points,
        continuation: &mut Continuation,
        count: u32,
    ) {
        for i in 0..points.len() {
            let (weight, mark) =
                (continuation.rays.sent.weight.get(i), continuation.rays.past.marks[i]);
            let slot = &mut continuation.labels.slot[i];
            *slot += self.stride;
            if weight == Vec3::ZERO || mark & marks::SHARP != 0 {
                continue;
            }
            let slot = *slot;
            let guided = continuation.guided();
            let record = Record {
                place: points.surfaces.point.get(i),
                toward: guided.toward(i),
                value: 0.0,
                own: guided.own[i],
                field: guided.field.of[i],
                mixed: guided.mixed[i],
                is_diffuse: mark & marks::DIFFUSE != 0,
            };
            let weight = points.weight.get(i) * (1.0 / count as f32);
            self.left.push(Left { slot, weight, record });
        }
    }

    /// Appends what the paths found to records. `sums` are the light of the slots after one bounce, those
    /// after two, and so on.
    pub(in crate::integrator) fn report(&self, sums: &[SampleSum], to: &mut Vec<Record>) {
        let stride = self.stride as usize;
        let mut later: Vec<[u64; 3]> =
            sums.iter().map(|sum| sum.map(|channel| channel.units())).collect();
        for slot in (stride..later.len()).rev() {
            let more = later[slot];
            for (light, more) in later[slot - stride].iter_mut().zip(more) {
                *light = light.saturating_add(more);
            }
        }
        for left in &self.left {
            let Some(light) = later.get(left.slot as usize - stride) else { continue };
            let light = DVec3::from(light.map(|units| units as f64 / f64::from(1 << 24)));
            let weight = left.weight.as_dvec3();
            let found = DVec3::select(weight.cmpgt(DVec3::ZERO), light / weight, DVec3::ZERO);
            let value = (found.element_sum() / 3.0) as f32;
            if value > 0.0 && value < f32::INFINITY {
                to.push(Record { value, ..left.record });
            }
        }
    }
}
