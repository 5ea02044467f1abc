//! The two-level structure: one tree over everything that is still, one tree over the boxes of
//! moving or stretched objects, and a tree of its own for each of these.

use std::collections::HashSet;
use std::sync::Arc;

use glam::Vec3;

use super::affine::Affine;
use super::crowd::{Crowd, ToPlace};
use super::instance::{Body, Instance, all_of};
use slo_accel::instances::{self, NO_INSTANCE};
use slo_accel::math::Bounds;
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
    /// Instances that are kept one by one: the first of all instances.
    pub(super) instances: Vec<Instance>,
    /// What the other instances are.
    pub(super) crowd: Crowd,
    /// Boxes of few instances.
    boxes: BoxTree,
    /// All instances, if they are many.
    pub(super) many: Option<Arc<Instances>>,
    isa: Isa,
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
    pub(super) accel: Scratch,
    /// Distance up to which each ray is followed.
    reach: Vec<f32>,
    boxes: BoxScratch,
    /// For each instance, the rays that enter its box.
    entering: Vec<Vec<u32>>,
    many: InstancesScratch,
    pub(super) local: Rays,
    local_times: Vec<f32>,
    local_hits: Hits,
    local_blocked: Vec<bool>,
}

impl World {
    /// # Errors
    /// If the crowd cannot be placed.
    pub(super) fn new(
        still: Arc<Structure>,
        instances: Vec<Instance>,
        mut crowd: Crowd,
        isa: Isa,
    ) -> Result<Self, instances::BuildError> {
        let many = match crowd.take() {
            Some(ToPlace::Placed(all)) => Some(all),
            Some(ToPlace::List(children, placements)) => {
                Some(Instances::build(children, placements, isa)?.into())
            }
            None if instances.len() < MANY => None,
            None => {
                let (children, placements) = all_of(&instances);
                Instances::build(children, placements, isa).ok().map(Arc::new)
            }
        };
        let boxes: Vec<_> = match many {
            Some(_) => Vec::new(),
            None => instances.iter().map(Instance::bounds).collect(),
        };
        Ok(Self { still, instances, crowd, boxes: BoxTree::new(&boxes), many, isa })
    }

    /// Whether there is nothing but what is still.
    fn is_still(&self) -> bool {
        self.instances.is_empty() && self.many.is_none()
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
        if self.is_still() {
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
            match &instance.body {
                Body::Still(structure) => {
                    structure.intersect(local, coherence, hits, accel);
                }
                Body::Bending(bending) => {
                    let times = &mut scratch.local_times;
                    times.clear();
                    times.extend(entering.iter().map(|&i| time[i as usize]));
                    bending.intersect(local, times, coherence, hits, accel);
                }
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
        if self.is_still() {
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
            match &instance.body {
                Body::Still(structure) => {
                    structure.occluded(local, coherence, found, accel);
                }
                Body::Bending(bending) => {
                    let times = &mut scratch.local_times;
                    times.clear();
                    times.extend(entering.iter().map(|&i| time[i as usize]));
                    bending.occluded(local, times, coherence, found, accel);
                }
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
        self.crowd.moving > 0 || self.instances.iter().any(|instance| instance.poses.len() > 1)
    }

    /// Returns the bounding box of everything.
    pub(super) fn bounds(&self) -> Bounds {
        let instances = self.instances.iter().map(Instance::bounds);
        let crowd = (!self.crowd.is_empty()).then_some(self.many.as_ref()).flatten();
        let crowd = crowd.map_or(Bounds::EMPTY, |all| all.bounds());
        instances.fold(self.still.bounds(), Bounds::union).union(crowd)
    }

    /// Returns the memory, in bytes, of all structures and poses.
    pub(super) fn memory(&self) -> usize {
        let of = |i: &Instance| size_of::<Instance>() + i.poses.len() * size_of::<Affine>();
        self.structures().map(|structure| structure.memory()).sum::<usize>()
            + self.bending().map(|bending| bending.memory()).sum::<usize>()
            + self.instances.iter().map(of).sum::<usize>()
            + self.many.as_ref().map_or(0, |all| all.memory())
            + self.crowd.memory()
    }

    /// Returns all structures, each once.
    pub(super) fn structures(&self) -> impl Iterator<Item = &Arc<Structure>> {
        let mut known = HashSet::new();
        let instances = self.instances.iter().filter_map(|instance| instance.body.structure());
        let all = [&self.still].into_iter().chain(instances).chain(self.crowd.structures());
        all.filter(move |structure| known.insert(Arc::as_ptr(structure)))
    }

    /// Returns everything that bends.
    pub(super) fn bending(&self) -> impl Iterator<Item = &Arc<Bending>> {
        self.instances.iter().filter_map(|instance| match &instance.body {
            Body::Still(_) => None,
            Body::Bending(bending) => Some(bending),
        })
    }

    /// Returns the number of the object that an instance belongs to.
    #[inline]
    pub(super) fn object_of(&self, instance: u32) -> u32 {
        match self.instances.get(instance as usize) {
            Some(instance) => instance.object,
            None => self.crowd.object_of(self.placed(), instance),
        }
    }

    /// Returns the primitives of an instance, and where their origin is in object space.
    #[inline]
    pub(super) fn body(&self, instance: u32) -> (&Body, Vec3, u32) {
        match self.instances.get(instance as usize) {
            Some(Instance { body, center, object, .. }) => (body, *center, *object),
            None => {
                let object = self.crowd.object_of(self.placed(), instance);
                let (body, center) = self.crowd.body(object);
                (body, center, object)
            }
        }
    }

    /// Returns `render_from_structure` of an instance at a time of the shutter in `[0, 1]`.
    #[inline]
    pub(super) fn pose(&self, instance: u32, time: f32) -> Affine {
        match self.instances.get(instance as usize) {
            Some(instance) => *instance.pose(time),
            None => self.crowd.pose(self.placed(), instance, time),
        }
    }

    /// As [`Affine::magnitude`], for an instance.
    #[inline]
    pub(super) fn magnitude(&self, instance: u32, time: f32, of: Vec3) -> Vec3 {
        match self.instances.get(instance as usize) {
            Some(instance) => instance.pose(time).magnitude(of),
            None => self.crowd.magnitude(self.placed(), instance, time, of),
        }
    }

    /// Returns the tint that the places of an instance give it; none if it is kept by itself.
    #[inline]
    pub(super) fn tint(&self, instance: u32) -> Option<Vec3> {
        let is_of_crowd = instance != STILL && instance as usize >= self.instances.len();
        is_of_crowd.then(|| self.crowd.tint(self.placed(), instance))
    }

    /// All instances; there is a crowd.
    fn placed(&self) -> &Instances {
        self.many.as_ref().expect("a crowd is placed")
    }
}

pub(super) fn push_local(local: &mut Rays, rays: &Rays, pose: &Affine, i: usize, t_max: f32) {
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
        let shape = |by: f32| {
            let triangle = |k: u32| {
                let at = Vec3::splat(0.02 * k as f32 - 0.5) + by * Vec3::new(0.3, -0.2, 0.1);
                [at, at + Vec3::X * 0.4, at + Vec3::Y * (0.3 + by)]
            };
            (0..50).map(triangle).collect::<Vec<_>>()
        };
        let shapes = [shape(0.0), shape(1.0), shape(0.5)];
        let bent = Arc::new(Bending::build(&shapes, &[0.0, 0.3, 1.0], Isa::best()));
        let mut instances = Vec::new();
        for object in 0..2 * MANY as u32 {
            let mut poses = Vec::new();
            for _ in 0..3 {
                let axis = vector(1.0).as_dvec3().normalize_or(DVec3::Z);
                let rotation = DMat3::from_axis_angle(axis, f64::from(object));
                let pose = DRigid { rotation, translation: vector(2.0).as_dvec3() };
                poses.push(Affine::relative(&DAffine::from(pose), DVec3::ZERO));
            }
            let body = match object % 4 {
                0 => Body::Bending(bent.clone()),
                _ => Body::Still(mesh.clone()),
            };
            instances.push(Instance { body, center: Vec3::ZERO, poses, object });
        }
        let many = World::new(still, instances, Crowd::default(), Isa::best()).unwrap();
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
        let bending = found.iter().filter(|(hit, _)| hit[4] != STILL && hit[4] % 4 == 0).count();
        assert!(of_instances > 100 && bending > 20, "{of_instances}, {bending}");
    }
}
