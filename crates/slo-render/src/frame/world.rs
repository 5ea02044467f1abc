//! The two-level structure: one tree over everything that is still, one tree over the boxes of
//! moving or stretched objects, and a tree of its own for each of these.

use std::sync::Arc;

use glam::Vec3;

use super::affine::Affine;
use slo_accel::math::Bounds;
use slo_accel::math::rounding::gamma;
use slo_accel::{
    Bending, BoxScratch, BoxTree, Coherence, Hits, Isa, LANES, NO_HIT, Rays, Scratch, Structure,
};

/// Instance number of a hit on a still object.
pub(crate) const STILL: u32 = u32::MAX;

/// Everything that rays can hit during one shutter, in render space.
#[derive(Debug)]
pub(crate) struct World {
    pub(super) still: Arc<Structure>,
    pub(super) instances: Vec<Instance>,
    boxes: BoxTree,
    isa: Isa,
}

/// An object that moves within the shutter, or a curved one that is stretched.
#[derive(Debug)]
pub(crate) struct Instance {
    /// Its primitives, in object space translated by `-center`.
    pub(super) structure: Arc<Structure>,
    /// Its triangles if they bend, in the same space. `structure` is empty then.
    pub(super) bending: Option<Bending>,
    /// Middle of the object in object space. Coordinates relative to it are small and keep their
    /// precision.
    pub(super) center: Vec3,
    /// `render_from_structure`, evenly spaced over the shutter. A ray uses the pose nearest to its
    /// time.
    pub(super) poses: Vec<Affine>,
    /// Index of the object.
    pub(super) object: u32,
}

impl Instance {
    /// Returns `render_from_structure` at a time of the shutter in `[0, 1]`.
    ///
    /// Source: thesis 5.3, with rounding to the nearest pose.
    #[inline]
    pub(super) fn pose(&self, time: f32) -> &Affine {
        let last = self.poses.len() - 1;
        &self.poses[((time * last as f32 + 0.5) as usize).min(last)]
    }

    /// Returns the bounding box of all poses.
    pub(super) fn bounds(&self) -> Bounds {
        let bounds = match &self.bending {
            Some(bending) => bending.bounds(),
            None => self.structure.bounds(),
        };
        let corners = bounds.corners();
        let at = |pose: &Affine| Bounds::of_points(corners.map(|c| pose.point(c)));
        let bounds = self.poses.iter().map(at).fold(Bounds::EMPTY, Bounds::union);
        // Rays are transformed to object space with rounding errors of their own.
        let far = bounds.min.abs().max(bounds.max.abs());
        let stretched = self.poses.iter().filter(|pose| !pose.is_rigid);
        let size = stretched
            .fold(far.max_element(), |size, pose| size.max(pose.round_trip(far).max_element()));
        let margin = Vec3::splat(size * gamma(16));
        Bounds { min: bounds.min - margin, max: bounds.max + margin }
    }
}

/// The first hits of a batch of rays, and their instances.
#[derive(Debug, Default)]
pub(crate) struct WorldHits {
    /// The hits. Primitive ids are relative to the structure that was hit.
    pub(crate) hits: Hits,
    /// Instance numbers; [`STILL`] for the still structure.
    pub(crate) instance: Vec<u32>,
}

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(crate) struct WorldScratch {
    accel: Scratch,
    /// Distance up to which each ray is followed.
    reach: Vec<f32>,
    boxes: BoxScratch,
    /// For each instance, the rays that enter its box.
    entering: Vec<Vec<u32>>,
    local: Rays,
    local_times: Vec<f32>,
    local_hits: Hits,
    local_blocked: Vec<bool>,
}

impl World {
    pub(super) fn new(still: Arc<Structure>, instances: Vec<Instance>, isa: Isa) -> Self {
        let boxes: Vec<_> = instances.iter().map(Instance::bounds).collect();
        Self { still, instances, boxes: BoxTree::new(&boxes), isa }
    }

    /// Finds the first hit of every ray at its own time in `[0, 1]`. Returns how coherent the rays
    /// turned out to be in the still structure.
    pub(crate) fn intersect(
        &self,
        rays: &Rays,
        time: &[f32],
        coherence: Coherence,
        found: &mut WorldHits,
        scratch: &mut WorldScratch,
    ) -> Coherence {
        let coherence = self.still.intersect(rays, coherence, &mut found.hits, &mut scratch.accel);
        found.instance.clear();
        found.instance.resize(rays.len(), STILL);
        if self.instances.is_empty() {
            return coherence;
        }
        let reach = |t: f32, i: usize| t.min(rays.t_max[i]);
        scratch.reach.clear();
        scratch.reach.extend((0..rays.len()).map(|i| reach(found.hits.t[i], i)));
        self.gather(rays, scratch);
        for (number, instance) in self.instances.iter().enumerate() {
            let entering = &scratch.entering[number];
            if entering.is_empty() {
                continue;
            }
            let local = &mut scratch.local;
            local.set_len(0);
            for &i in entering {
                let t_max = reach(found.hits.t[i as usize], i as usize);
                push_local(local, rays, instance.pose(time[i as usize]), i as usize, t_max);
            }
            let (hits, accel) = (&mut scratch.local_hits, &mut scratch.accel);
            if let Some(bending) = &instance.bending {
                let times = &mut scratch.local_times;
                times.clear();
                times.extend(entering.iter().map(|&i| time[i as usize]));
                bending.intersect(local, times, coherence, hits, accel);
            } else {
                instance.structure.intersect(local, coherence, hits, accel);
            }
            for (j, &i) in entering.iter().enumerate() {
                let i = i as usize;
                if hits.primitive[j] != NO_HIT {
                    found.hits.t[i] = hits.t[j];
                    found.hits.u[i] = hits.u[j];
                    found.hits.v[i] = hits.v[j];
                    found.hits.primitive[i] = hits.primitive[j];
                    found.instance[i] = number as u32;
                }
            }
        }
        coherence
    }

    /// Finds whether anything blocks each ray at its own time in `[0, 1]`. Returns how coherent the
    /// rays turned out to be in the still structure.
    pub(crate) fn occluded(
        &self,
        rays: &Rays,
        time: &[f32],
        coherence: Coherence,
        blocked: &mut Vec<bool>,
        scratch: &mut WorldScratch,
    ) -> Coherence {
        let coherence = self.still.occluded(rays, coherence, blocked, &mut scratch.accel);
        if self.instances.is_empty() {
            return coherence;
        }
        let reach = |i: usize| if blocked[i] { -1.0 } else { rays.t_max[i] };
        scratch.reach.clear();
        scratch.reach.extend((0..rays.len()).map(reach));
        self.gather(rays, scratch);
        for (number, instance) in self.instances.iter().enumerate() {
            let entering = &mut scratch.entering[number];
            entering.retain(|&i| !blocked[i as usize]);
            if entering.is_empty() {
                continue;
            }
            let local = &mut scratch.local;
            local.set_len(0);
            for &i in &*entering {
                let i = i as usize;
                push_local(local, rays, instance.pose(time[i]), i, rays.t_max[i]);
            }
            let (found, accel) = (&mut scratch.local_blocked, &mut scratch.accel);
            if let Some(bending) = &instance.bending {
                let times = &mut scratch.local_times;
                times.clear();
                times.extend(entering.iter().map(|&i| time[i as usize]));
                bending.occluded(local, times, coherence, found, accel);
            } else {
                instance.structure.occluded(local, coherence, found, accel);
            }
            for (&i, &hit) in entering.iter().zip(&*found) {
                blocked[i as usize] |= hit;
            }
        }
        coherence
    }

    /// Lists, for each instance, the rays that enter its box within their reach, in order.
    fn gather(&self, rays: &Rays, scratch: &mut WorldScratch) {
        let WorldScratch { reach, boxes, entering, .. } = scratch;
        entering.resize_with(self.instances.len(), Vec::new);
        reach.resize(rays.len().next_multiple_of(LANES), -1.0);
        self.boxes.gather(self.isa, rays, reach, entering, boxes);
    }

    /// Whether anything moves within the shutter.
    pub(super) fn moves(&self) -> bool {
        self.instances.iter().any(|instance| instance.poses.len() > 1)
    }

    /// Returns the bounding box of everything.
    pub(super) fn bounds(&self) -> Bounds {
        self.instances.iter().map(Instance::bounds).fold(self.still.bounds(), Bounds::union)
    }

    /// Returns the memory, in bytes, of all structures and poses.
    pub(super) fn memory(&self) -> usize {
        let of = |i: &Instance| {
            let bending = i.bending.as_ref().map_or(0, Bending::memory);
            i.structure.memory() + bending + i.poses.len() * size_of::<Affine>()
        };
        self.still.memory() + self.instances.iter().map(of).sum::<usize>()
    }
}

fn push_local(local: &mut Rays, rays: &Rays, pose: &Affine, i: usize, t_max: f32) {
    let origin = pose.inverse_point(rays.origin(i));
    local.push(origin, pose.inverse_vector(rays.direction(i)), t_max);
}
