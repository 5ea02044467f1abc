//! The rays of the Standard Procedural Databases: a regular grid of rays from the eye, a ray to each light in front of a
//! hit, and all reflected and refracted rays up to a depth. Whatever the structure, they are the same rays.
//!
//! Two rules are not written down anywhere; these give the published numbers of rays: what transmits light reflects too,
//! and a surface that is seen from behind asks only for lights in front of it.

use slo_accel::glam::{DVec3, Vec3};
use slo_accel::study::{Any, Counting, Counts, Memory, Totals};

use crate::nff::{Scene, View};
use crate::objects::Ray;

/// Which rays are traced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Rays in a row, and rows.
    pub(crate) size: u32,
    /// Only every so many of them, in both directions.
    pub(crate) every: u32,
    /// Greatest number of rays on the way from the eye to the last hit.
    pub(crate) depth: u32,
    /// Whether rays to lights look for the nearest hit, not for any.
    pub(crate) nearest_shadows: bool,
}

/// What was counted, by kind of ray.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counted {
    pub(crate) primary: Totals,
    pub(crate) shadow: Totals,
    pub(crate) secondary: Totals,
}

impl Counted {
    pub(crate) fn add(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.secondary += other.secondary;
    }
}

/// A structure, or none.
pub(crate) enum Structure {
    /// Tests all of so many objects, in their order.
    Naive(u32),
    Study(Any),
}

impl Structure {
    /// See [`Any::walk`].
    fn walk<V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &slo_accel::study::Ray,
        memory: &mut Memory,
        counts: &mut Counts,
        mut visit: V,
    ) {
        match self {
            Self::Naive(objects) => {
                let mut t_max = ray.t_max;
                for object in 0..*objects {
                    counts.test();
                    t_max = visit(object, t_max);
                    if t_max < 0.0 {
                        return;
                    }
                }
            }
            Self::Study(study) => {
                study.walk(ray, memory, counts, visit);
            }
        }
    }
}

/// A scene with a structure over its objects.
pub(crate) struct Tracer<'a> {
    scene: &'a Scene,
    lights: &'a [DVec3],
    structure: &'a Structure,
    plan: Plan,
    /// Hits nearer than that, in units of the scene, are the point that a ray leaves.
    least: f64,
}

/// A hit.
struct Hit {
    object: usize,
    t: f64,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(
        scene: &'a Scene,
        lights: &'a [DVec3],
        structure: &'a Structure,
        plan: Plan,
        diagonal: f64,
    ) -> Self {
        Self { scene, lights, structure, plan, least: 1e-6 * diagonal }
    }

    /// Rows that are traced.
    pub(crate) fn rows(&self) -> Vec<u32> {
        (0..self.plan.size).step_by(self.plan.every as usize).collect()
    }

    /// Traces all that begins in a row.
    pub(crate) fn row(&self, view: &View, row: u32) -> Counted {
        let (mut counted, mut memory) = (Counted::default(), Memory::default());
        let forward = (view.target - view.eye).normalize();
        let right = forward.cross(view.up).normalize();
        let up = right.cross(forward);
        let half = libm::tan(view.angle / 2.0);
        let place = |i: u32| half * (2.0 * f64::from(i) / f64::from(self.plan.size - 1) - 1.0);
        for column in (0..self.plan.size).step_by(self.plan.every as usize) {
            let direction = forward + right * place(column) - up * place(row);
            let ray = Ray { origin: view.eye, direction: direction.normalize() };
            self.trace(ray, None, 1, &mut counted, &mut memory);
        }
        counted
    }

    /// Traces a ray and all that it spawns. `from` is an object that it can't hit again.
    fn trace(
        &self,
        ray: Ray,
        from: Option<usize>,
        depth: u32,
        counted: &mut Counted,
        memory: &mut Memory,
    ) {
        let (hit, counts) = self.nearest(&ray, from, memory);
        let kind = if depth == 1 { &mut counted.primary } else { &mut counted.secondary };
        kind.add(counts, hit.is_some());
        let Some(Hit { object, t }) = hit else { return };
        let point = ray.origin + ray.direction * t;
        let [flat, shaded] = self.scene.objects[object].shape.normals(point);
        let enters = flat.dot(ray.direction) < 0.0;
        // A ray that leaves a convex surface outward can't hit it again.
        let after = |direction: DVec3| (flat.dot(direction) > 0.0).then_some(object);
        for light in self.lights {
            let toward = *light - point;
            // Surfaces are lit from outside only, whichever side the ray comes from.
            if shaded.dot(toward) > 0.0 {
                let distance = toward.length();
                let ray = Ray { origin: point, direction: toward / distance };
                let (blocked, counts) = self.any(&ray, after(toward), distance, memory);
                counted.shadow.add(counts, blocked);
            }
        }
        if depth == self.plan.depth {
            return;
        }
        let fill = self.scene.objects[object].fill;
        // The normal on the side that the ray comes from.
        let normal = if shaded.dot(ray.direction) > 0.0 { -shaded } else { shaded };
        let cosine = -normal.dot(ray.direction);
        if fill.reflects || fill.transmits {
            let direction = ray.direction + normal * (2.0 * cosine);
            let reflected = Ray { origin: point, direction };
            self.trace(reflected, after(direction), depth + 1, counted, memory);
        }
        if fill.transmits {
            let ratio = match fill.ior {
                ior if ior <= 0.0 => 1.0,
                ior if enters => 1.0 / ior,
                ior => ior,
            };
            let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
            if rest >= 0.0 {
                let direction = ray.direction * ratio + normal * (ratio * cosine - rest.sqrt());
                let bent = Ray { origin: point, direction };
                self.trace(bent, after(direction), depth + 1, counted, memory);
            }
        }
    }

    fn nearest(
        &self,
        ray: &Ray,
        from: Option<usize>,
        memory: &mut Memory,
    ) -> (Option<Hit>, Counts) {
        let (mut counts, mut hit) = (Counts::default(), None::<Hit>);
        self.structure.walk(&single(ray, f32::INFINITY), memory, &mut counts, |object, t_max| {
            let object = object as usize;
            let most = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            match self.scene.objects[object].shape.hit(ray, self.least, most) {
                Some(t) if Some(object) != from => {
                    hit = Some(Hit { object, t });
                    (t as f32).min(t_max)
                }
                _ => t_max,
            }
        });
        (hit, counts)
    }

    /// Whether anything lies between a point and a light.
    fn any(
        &self,
        ray: &Ray,
        from: Option<usize>,
        distance: f64,
        memory: &mut Memory,
    ) -> (bool, Counts) {
        let (mut counts, mut blocked) = (Counts::default(), false);
        self.structure.walk(&single(ray, distance as f32), memory, &mut counts, |object, t_max| {
            let object = object as usize;
            match self.scene.objects[object].shape.hit(ray, self.least, distance) {
                Some(t) if Some(object) != from => {
                    blocked = true;
                    if self.plan.nearest_shadows { t_max.min(t as f32) } else { -1.0 }
                }
                _ => t_max,
            }
        });
        (blocked, counts)
    }
}

fn single(ray: &Ray, t_max: f32) -> slo_accel::study::Ray {
    let vector = |v: DVec3| -> Vec3 { v.as_vec3() };
    slo_accel::study::Ray { origin: vector(ray.origin), direction: vector(ray.direction), t_max }
}
