//! The two-level structure: one tree over everything that is still, one tree over the boxes of
//! moving or stretched objects, and a tree of its own for each of these.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::Vec3;

use super::affine::Affine;
use slo_accel::instances::{self, Child, NO_INSTANCE, Placements};
use slo_accel::math::Bounds;
use slo_accel::math::rounding::gamma;
use slo_accel::{
    Bending, BoxScratch, BoxTree, Coherence, Hits, Instances, InstancesScratch, Isa, LANES, NO_HIT,
    Rays, Scratch, Structure,
};

/// Instance number of a hit on a still object.
pub(crate) const STILL: u32 = NO_INSTANCE;

/// Fewer instances are asked one after the other, each about all rays that enter its box. More find
/// their rays by a hierarchy. Hits are the same.
const MANY: usize = 16;

/// Everything that rays can hit during one shutter, in render space.
#[derive(Debug)]
pub(crate) struct World {
    pub(super) still: Arc<Structure>,
    pub(super) instances: Vec<Instance>,
    /// Boxes of few instances.
    boxes: BoxTree,
    /// All instances, if they are many.
    many: Option<Instances>,
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
    many: InstancesScratch,
    local: Rays,
    local_times: Vec<f32>,
    local_hits: Hits,
    local_blocked: Vec<bool>,
}

impl World {
    pub(super) fn new(still: Arc<Structure>, instances: Vec<Instance>, isa: Isa) -> Self {
        let any_bends = instances.iter().any(|instance| instance.bending.is_some());
        let are_few = instances.len() < MANY || any_bends;
        let many = if are_few { None } else { all_of(&instances, isa) };
        let boxes: Vec<_> = match many {
            Some(_) => Vec::new(),
            None => instances.iter().map(Instance::bounds).collect(),
        };
        Self { still, instances, boxes: BoxTree::new(&boxes), many, isa }
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
        scratch.reach.resize(rays.len().next_multiple_of(LANES), -1.0);
        if let Some(many) = &self.many {
            let WorldHits { hits, instance } = found;
            let WorldScratch { reach, many: scratch, .. } = scratch;
            let alike =
                many.intersect_within(rays, time, reach, coherence, hits, instance, scratch);
            return self.found(coherence, alike);
        }
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
        scratch.reach.resize(rays.len().next_multiple_of(LANES), -1.0);
        if let Some(many) = &self.many {
            let WorldScratch { reach, many: scratch, .. } = scratch;
            let alike = many.occluded_within(rays, time, reach, coherence, blocked, scratch);
            return self.found(coherence, alike);
        }
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

    /// Returns how coherent rays are: in the still structure, unless there is nothing in it.
    fn found(&self, still: Coherence, instances: Coherence) -> Coherence {
        let is_empty = self.still.triangle_count() + self.still.curved().len() == 0;
        if is_empty { instances } else { still }
    }

    /// Lists, for each instance, the rays that enter its box within their reach, in order.
    fn gather(&self, rays: &Rays, scratch: &mut WorldScratch) {
        let WorldScratch { reach, boxes, entering, .. } = scratch;
        entering.resize_with(self.instances.len(), Vec::new);
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
            size_of::<Instance>() + bending + i.poses.len() * size_of::<Affine>()
        };
        self.structures().map(|structure| structure.memory()).sum::<usize>()
            + self.instances.iter().map(of).sum::<usize>()
            + self.many.as_ref().map_or(0, Instances::memory)
    }

    /// Returns all structures, each once.
    pub(super) fn structures(&self) -> impl Iterator<Item = &Arc<Structure>> {
        let mut known = HashSet::new();
        let all = [&self.still].into_iter().chain(self.instances.iter().map(|i| &i.structure));
        all.filter(move |structure| known.insert(Arc::as_ptr(structure)))
    }
}

/// Returns a hierarchy over instances, which share the structures that they have in common; `None`
/// if it cannot be built.
fn all_of(instances: &[Instance], isa: Isa) -> Option<Instances> {
    let mut numbers = HashMap::new();
    let mut children = Vec::new();
    let mut placements = Placements::with_capacity(instances.len());
    let mut poses = Vec::new();
    for instance in instances {
        let child = *numbers.entry(Arc::as_ptr(&instance.structure)).or_insert_with(|| {
            children.push(Child::Structure(instance.structure.clone()));
            children.len() as u32 - 1
        });
        let pose = |pose: &Affine| instances::Affine {
            matrix: pose.linear,
            translation: pose.translation,
        };
        poses.clear();
        poses.extend(instance.poses.iter().map(pose));
        placements.push(child, &poses);
    }
    Instances::build(children, placements, isa).ok()
}

fn push_local(local: &mut Rays, rays: &Rays, pose: &Affine, i: usize, t_max: f32) {
    let origin = pose.inverse_point(rays.origin(i));
    local.push(origin, pose.inverse_vector(rays.direction(i)), t_max);
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use slo_accel::Accelerator;
    use slo_scene::animation::{DAffine, DRigid};

    use super::*;

    /// Hits of a batch in a world, as bits, and which rays are blocked.
    fn ask(world: &World, rays: &Rays, time: &[f32]) -> Vec<([u32; 5], bool)> {
        let (mut found, mut blocked) = (WorldHits::default(), Vec::new());
        let scratch = &mut WorldScratch::default();
        world.intersect(rays, time, Coherence::Incoherent, &mut found, scratch);
        world.occluded(rays, time, Coherence::Incoherent, &mut blocked, scratch);
        let WorldHits { hits: Hits { t, u, v, primitive, .. }, instance } = &found;
        let answer = |i: usize| {
            let [t, u, v] = [t[i], u[i], v[i]].map(f32::to_bits);
            ([t, u, v, primitive[i], instance[i]], blocked[i])
        };
        (0..rays.len()).map(answer).collect()
    }

    #[test]
    fn many_instances_are_hit_as_few_are() {
        let mut rng = StdRng::seed_from_u64(1);
        let mut vector =
            |size: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)));
        let mut structure = |count: usize, size: f32| {
            let triangle = |_| {
                let p = vector(size);
                [p, p + vector(0.3), p + vector(0.3)]
            };
            let triangles: Vec<_> = (0..count).map(triangle).collect();
            Arc::new(Structure::build(Accelerator::Bvh, triangles, Isa::best()))
        };
        let (still, mesh) = (structure(20, 2.0), structure(30, 0.5));
        let mut vector =
            |size: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)));
        let mut instances = Vec::new();
        for object in 0..2 * MANY as u32 {
            let mut poses = Vec::new();
            for _ in 0..3 {
                let axis = vector(1.0).as_dvec3().normalize_or(DVec3::Z);
                let rotation = DMat3::from_axis_angle(axis, f64::from(object));
                let pose = DRigid { rotation, translation: vector(2.0).as_dvec3() };
                poses.push(Affine::relative(&DAffine::from(pose), DVec3::ZERO));
            }
            let structure = mesh.clone();
            let (bending, center) = (None, Vec3::ZERO);
            instances.push(Instance { structure, bending, center, poses, object });
        }
        let many = World::new(still, instances, Isa::best());
        assert!(many.many.is_some());
        let mut rays = Rays::default();
        for _ in 0..1000 {
            rays.push(vector(3.0), vector(1.0), f32::INFINITY);
        }
        let time: Vec<f32> = (0..1000).map(|i| i as f32 / 1000.0).collect();
        let found = ask(&many, &rays, &time);
        let boxes: Vec<_> = many.instances.iter().map(Instance::bounds).collect();
        let few = World { many: None, boxes: BoxTree::new(&boxes), ..many };
        assert_eq!(found, ask(&few, &rays, &time));
        let of_instances = found.iter().filter(|(hit, _)| hit[4] != STILL).count();
        assert!(of_instances > 100, "{of_instances}");
    }
}
