//! What a hit adds to the picture, and the rays that it sends out.

use glam::Vec3;

use super::queue::{QueuedRay, ShadowRay};
use super::wave::Wave;
use crate::frame::{FrameScene, Surface};
use crate::sampling::{Purpose, next_path};
use crate::scene::LightSampling;
use crate::shading::{Light, Material, lobe};

/// A hit that is to be shaded.
#[derive(Clone, Copy, Debug)]
pub(super) struct HitPoint {
    pub(super) surface: Surface,
    pub(super) material: u32,
    /// Unit direction of the ray that came here.
    pub(super) direction: Vec3,
    pub(super) time: f32,
    pub(super) weight: Vec3,
    pub(super) slot: u32,
    pub(super) path: u32,
    pub(super) index: u32,
}

impl Wave {
    /// Shades the hits of one batch, `depth` bounces behind the camera.
    pub(super) fn shade(&mut self, frame: &FrameScene, depth: u32) {
        let points = std::mem::take(&mut self.points);
        for point in &points {
            let ambient = frame.materials[point.material as usize].ambient;
            self.add(point.slot, point.weight * ambient * point.surface.tint);
        }
        match frame.settings.light_sampling {
            LightSampling::All => {
                for (number, light) in frame.lights.iter().enumerate() {
                    self.ask_light(frame, &points, light, number as u32, depth);
                }
            }
            LightSampling::One => self.ask_any_light(frame, &points, depth),
        }
        if depth < frame.settings.recursion {
            for point in &points {
                self.bounce(frame, point, depth);
            }
        }
        self.points = points;
    }

    /// Shadow rays of all hits toward one light.
    fn ask_light(
        &mut self,
        frame: &FrameScene,
        points: &[HitPoint],
        light: &Light,
        number: u32,
        depth: u32,
    ) {
        let shadow_samples = frame.settings.soft_shadow_samples;
        let count = if depth == 0 && light.is_area() { shadow_samples } else { 1 };
        for i in 0..count {
            for point in points {
                let seed = self.seeds[point.slot as usize];
                let key = seed.key(point.path, Purpose::Light(number));
                let index = point.index.wrapping_mul(count).wrapping_add(i);
                let u = frame.sampler.point2(key, index);
                self.ask(frame, point, light, u, 1.0 / count as f32, depth);
            }
        }
    }

    /// Shadow rays of all hits, each toward a light at random.
    fn ask_any_light(&mut self, frame: &FrameScene, points: &[HitPoint], depth: u32) {
        let lights = frame.lights.len();
        if lights == 0 {
            return;
        }
        let count = if depth == 0 { frame.settings.soft_shadow_samples } else { 1 };
        let share = lights as f32 / count as f32;
        for i in 0..count {
            for point in points {
                let seed = self.seeds[point.slot as usize];
                let key = seed.key(point.path, Purpose::AnyLight);
                let index = point.index.wrapping_mul(count).wrapping_add(i);
                let [u, v, choice] = frame.sampler.point3(key, index);
                let number = ((choice * lights as f32) as usize).min(lights - 1);
                self.ask(frame, point, &frame.lights[number], [u, v], share, depth);
            }
        }
    }

    /// One shadow ray, unless its light could add nothing.
    #[inline]
    fn ask(
        &mut self,
        frame: &FrameScene,
        point: &HitPoint,
        light: &Light,
        u: [f32; 2],
        share: f32,
        depth: u32,
    ) {
        let surface = &point.surface;
        let target = light.point(u);
        let toward = (target - surface.point).normalize_or_zero();
        // Lit from behind the surface itself, whatever the interpolated normal says.
        if toward.dot(surface.n_geo) <= 0.0 {
            return;
        }
        let material = &frame.materials[point.material as usize];
        let phong = material.phong(surface.n_shade, toward, -point.direction, surface.tint);
        let light_added = phong * light.color * point.weight * share;
        if light_added == Vec3::ZERO {
            return;
        }
        let origin = surface.leave(toward);
        let (direction, t_max) = light.shadow_ray(origin, target);
        self.shadows[usize::from(depth > 0)].push(ShadowRay {
            origin,
            direction,
            t_max,
            time: point.time,
            light: light_added,
            slot: point.slot,
        });
    }

    /// The reflected and refracted rays of one hit.
    fn bounce(&mut self, frame: &FrameScene, point: &HitPoint, depth: u32) {
        let material = &frame.materials[point.material as usize];
        let refracted = if material.refraction > 0.0 { refracted(material, point) } else { None };
        // What total internal reflection keeps inside.
        let kept = if refracted.is_none() { material.refraction } else { 0.0 };
        let reflected = material.reflectance + kept;
        if reflected > 0.0 {
            let axis = lobe::reflect(point.direction, point.surface.n_shade);
            let lobe = Lobe {
                axis,
                side: point.surface.n_geo,
                inverse: material.reflection_lobe,
                weight: reflected,
                samples: frame.settings.diffuse_reflection_samples,
                purpose: Purpose::Reflection,
            };
            self.send(frame, point, &lobe, depth);
        }
        if let Some(axis) = refracted {
            let lobe = Lobe {
                axis,
                side: -point.surface.n_geo,
                inverse: material.refraction_lobe,
                weight: material.refraction,
                samples: frame.settings.diffuse_refraction_samples,
                purpose: Purpose::Refraction,
            };
            self.send(frame, point, &lobe, depth);
        }
    }

    fn send(&mut self, frame: &FrameScene, point: &HitPoint, lobe: &Lobe, depth: u32) {
        let count = if depth == 0 && lobe.inverse > 0.0 { lobe.samples } else { 1 };
        let key = self.seeds[point.slot as usize].key(point.path, lobe.purpose);
        let path = next_path(point.path, lobe.purpose);
        let weight = point.weight * (lobe.weight / count as f32);
        for i in 0..count {
            let index = point.index.wrapping_mul(count).wrapping_add(i);
            let u = if lobe.inverse > 0.0 { frame.sampler.point2(key, index) } else { [0.0; 2] };
            let w = lobe::to_side(lobe::about(lobe.axis, lobe.inverse, u), lobe.side);
            self.bounces_at(depth as usize + 1).push(QueuedRay {
                origin: point.surface.leave(w),
                direction: w,
                time: point.time,
                weight,
                slot: point.slot,
                path,
                index,
            });
        }
    }
}

/// Directions that a hit sends rays to.
struct Lobe {
    /// The perfect direction.
    axis: Vec3,
    /// Unit normal of the side that the rays stay on.
    side: Vec3,
    /// `1 / (n + 1)`; 0: perfect.
    inverse: f32,
    weight: f32,
    samples: u32,
    purpose: Purpose,
}

/// The perfectly refracted direction; `None` where all is reflected inside.
fn refracted(material: &Material, point: &HitPoint) -> Option<Vec3> {
    let surface = &point.surface;
    let index = material.refraction_index;
    let eta = if surface.from_outside { 1.0 / index } else { index };
    // An interpolated normal may look away from a ray that grazes the surface.
    let facing = surface.n_shade.dot(point.direction) < 0.0;
    let n = if facing { surface.n_shade } else { surface.n_geo };
    lobe::refract(point.direction, n, eta)
}
