//! Weighted rays that wait to be traced.

use glam::Vec3;

use crate::accel::Rays;

/// Rays answered by one call of a structure.
pub(super) const BATCH: usize = 1024;

/// Rays and what their hits are worth.
#[derive(Debug, Default)]
pub(super) struct RayQueue {
    pub(super) rays: Rays,
    /// Time in the shutter, `[0, 1]`.
    pub(super) time: Vec<f32>,
    /// What radiance that arrives along the ray is multiplied with.
    pub(super) weight: Vec<Vec3>,
    /// Camera sample that the radiance is added to.
    pub(super) slot: Vec<u32>,
    /// Code of the branches that led here.
    pub(super) path: Vec<u32>,
    /// Number of the ray among those of the same path in the pixel's samples.
    pub(super) index: Vec<u32>,
}

/// One ray of a queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueuedRay {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) time: f32,
    pub(super) weight: Vec3,
    pub(super) slot: u32,
    pub(super) path: u32,
    pub(super) index: u32,
}

impl RayQueue {
    pub(super) fn len(&self) -> usize {
        self.time.len()
    }

    pub(super) fn push(&mut self, ray: QueuedRay) {
        self.rays.push(ray.origin, ray.direction, f32::INFINITY);
        self.time.push(ray.time);
        self.weight.push(ray.weight);
        self.slot.push(ray.slot);
        self.path.push(ray.path);
        self.index.push(ray.index);
    }

    pub(super) fn clear(&mut self) {
        self.rays.set_len(0);
        self.time.clear();
        self.weight.clear();
        self.slot.clear();
        self.path.clear();
        self.index.clear();
    }

    /// Moves the last rays, a batch at most, to `batch`, their order kept.
    pub(super) fn take_batch(&mut self, batch: &mut Self) {
        let start = self.len().saturating_sub(BATCH);
        batch.clear();
        self.rays.split_off_into(start, &mut batch.rays);
        batch.time.extend(self.time.drain(start..));
        batch.weight.extend(self.weight.drain(start..));
        batch.slot.extend(self.slot.drain(start..));
        batch.path.extend(self.path.drain(start..));
        batch.index.extend(self.index.drain(start..));
    }
}

/// Rays toward lights, each with the light that it brings if nothing blocks it.
#[derive(Debug, Default)]
pub(super) struct ShadowQueue {
    /// From hit to light: `t` = 1 is the light.
    pub(super) rays: Rays,
    /// Time in the shutter, `[0, 1]`.
    pub(super) time: Vec<f32>,
    /// What is added to the slot.
    pub(super) light: Vec<Vec3>,
    /// Camera sample that the light is added to.
    pub(super) slot: Vec<u32>,
}

/// One ray of a queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) t_max: f32,
    pub(super) time: f32,
    pub(super) light: Vec3,
    pub(super) slot: u32,
}

impl ShadowQueue {
    pub(super) fn len(&self) -> usize {
        self.time.len()
    }

    pub(super) fn push(&mut self, ray: ShadowRay) {
        self.rays.push(ray.origin, ray.direction, ray.t_max);
        self.time.push(ray.time);
        self.light.push(ray.light);
        self.slot.push(ray.slot);
    }

    pub(super) fn clear(&mut self) {
        self.rays.set_len(0);
        self.time.clear();
        self.light.clear();
        self.slot.clear();
    }

    /// Moves the last rays, a batch at most, to `batch`, their order kept.
    pub(super) fn take_batch(&mut self, batch: &mut Self) {
        let start = self.len().saturating_sub(BATCH);
        batch.clear();
        self.rays.split_off_into(start, &mut batch.rays);
        batch.time.extend(self.time.drain(start..));
        batch.light.extend(self.light.drain(start..));
        batch.slot.extend(self.slot.drain(start..));
    }
}
