//! Physical lamps and glowing triangles: what they shine, from docs/rendering.md.
//!
//! Which point of a lamp a sample point means, how dense these points are, and which light of many
//! a hit asks are the renderer's: each has tests of its own, against closed forms.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use slo_render::shading::light::{LightTree, NO_LIGHT, Skies, SkyShare, Triangle};
use slo_render::shading::{Lamp, Light, WithLamp};
use slo_scene::light::Sky;
use slo_scene::{LightKind, LightSampling, MaterialKind, SceneDescription};

use super::world::{Look, World, triangles};

/// The lights of a scene, those of its description first, then glowing triangles.
pub(super) struct Lamps<'a> {
    scene: &'a SceneDescription,
    lights: Vec<Light>,
    /// Radiance of the triangles.
    glowing: Vec<DVec3>,
    /// For each object, the light that its first triangle is.
    first_light: Vec<Option<usize>>,
    /// Chooses among the lights from `first_chosen` on.
    tree: LightTree,
    first_chosen: usize,
}

/// A light that a hit asks, and its chance to be chosen.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    pub(super) light: usize,
    pub(super) chance: f64,
}

pub(super) fn color(rgb: [f32; 3]) -> DVec3 {
    DVec3::from_array(rgb.map(f64::from))
}

impl<'a> Lamps<'a> {
    pub(super) fn new(scene: &'a SceneDescription, world: &World<'_>) -> Self {
        let skies = Skies { share: SkyShare::All, before: &[] };
        let prepared = |light| Light::new(light, DVec3::ZERO, &[], skies);
        let mut lights: Vec<Light> = scene.lights.iter().map(prepared).collect();
        let first_chosen = match scene.settings.light_sampling() {
            LightSampling::All => lights.len(),
            LightSampling::One => 0,
        };
        let (mut glowing, mut first_light) = (Vec::new(), vec![None; scene.objects.len()]);
        for thing in &world.things {
            let Look::Material(material) = thing.look else { continue };
            let radiance = glow(&scene.materials[material].kind);
            let is_asked = scene.objects[thing.number].sampled;
            let Some(radiance) = radiance.filter(|_| is_asked) else { continue };
            first_light[thing.number] = Some(lights.len());
            for corners in triangles(thing) {
                let corners = corners.map(|corner| corner.as_vec3());
                lights.push(Light::Triangle(Triangle::new(corners, radiance.as_vec3())));
                glowing.push(radiance);
            }
        }
        let bounds: Vec<_> = lights[first_chosen..].iter().map(Light::bounds).collect();
        let tree = LightTree::new(&bounds);
        Self { scene, lights, glowing, first_light, tree, first_chosen }
    }

    /// The lights that every hit asks, without a choice.
    pub(super) fn asked_always(&self) -> std::ops::Range<usize> {
        0..self.first_chosen
    }

    pub(super) fn has_choice(&self) -> bool {
        self.first_chosen < self.lights.len()
    }

    /// Returns the number of the light that part of an object is.
    pub(super) fn of_object(&self, object: usize, part: usize) -> Option<usize> {
        self.first_light[object].map(|first| first + part)
    }

    /// Returns a light of the scene that has a surface of its own; `None` for a glowing triangle.
    pub(super) fn surface(&self, light: usize) -> Option<usize> {
        (light < self.scene.lights.len()).then_some(light)
    }

    /// Lights that rays see which hit nothing.
    pub(super) fn skies(&self) -> impl Iterator<Item = usize> {
        (0..self.scene.lights.len())
            .filter(|&light| self.is_distant(light) && !self.is_delta(light))
    }

    /// Whether rays after `depth` bounces pass through a lamp.
    pub(super) fn is_passed(&self, light: usize, depth: u32) -> bool {
        let light = &self.scene.lights[light];
        !light.solid || (depth == 0 && !light.camera_visible)
    }

    pub(super) fn is_hidden(&self, light: usize, depth: u32) -> bool {
        depth == 0 && !self.scene.lights[light].camera_visible
    }

    pub(super) fn is_solid(&self, light: usize) -> bool {
        self.scene.lights[light].solid
    }

    /// Chooses a light by a number in `[0, 1)`.
    pub(super) fn choose(&self, from: DVec3, receiver: u32, u: f32) -> Option<Choice> {
        let chosen = self.tree.choose(from.as_vec3(), receiver, u);
        let light = self.first_chosen + chosen.light as usize;
        let choice = Choice { light, chance: f64::from(chosen.chance) };
        (chosen.light != NO_LIGHT).then_some(choice)
    }

    /// Returns the chance that a hit asks a light.
    pub(super) fn chance(&self, light: usize, from: DVec3, receiver: u32) -> f64 {
        match light.checked_sub(self.first_chosen) {
            None => 1.0,
            Some(chosen) => f64::from(self.tree.chance(chosen as u32, from.as_vec3(), receiver)),
        }
    }

    /// Whether the light is infinitely far away. Ways to it are unit directions.
    pub(super) fn is_distant(&self, light: usize) -> bool {
        self.lights[light].is_distant()
    }

    /// Whether no ray can hit the light.
    pub(super) fn is_delta(&self, light: usize) -> bool {
        self.lights[light].is_delta()
    }

    pub(super) fn is_area(&self, light: usize) -> bool {
        self.lights[light].is_area()
    }

    /// Returns the way from a hit to the point of a light that a sample point means.
    pub(super) fn way(&self, light: usize, from: DVec3, u: [f32; 2]) -> DVec3 {
        struct Way(Vec3, [f32; 2]);
        impl WithLamp for Way {
            type Output = Vec3;

            fn run<L: Lamp>(self, lamp: L) -> Vec3 {
                lamp.way(self.0, self.1)
            }
        }
        self.lights[light].with(Way(from.as_vec3(), u)).as_dvec3()
    }

    /// Returns the `pdf_solid_angle` of the end of a way to a light.
    pub(super) fn density(&self, light: usize, from: DVec3, way: DVec3) -> f64 {
        f64::from(self.lights[light].density(from.as_vec3(), way.as_vec3()))
    }

    /// Whether a point lies inside a lamp.
    pub(super) fn encloses(&self, light: usize, point: DVec3) -> bool {
        match &self.scene.lights[light].kind {
            LightKind::PointLamp(lamp) => lamp.position.distance(point) < lamp.radius,
            _ => false,
        }
    }

    /// Returns the radiance of a light at the end of a way to it; the irradiance on what faces it if
    /// no ray can hit it.
    pub(super) fn radiance(&self, light: usize, way: DVec3) -> DVec3 {
        let Some(light) = self.scene.lights.get(light) else {
            return self.glowing[light - self.scene.lights.len()];
        };
        // 1 on the side that a normal points to.
        let front = |normal: DVec3, both| f64::from(u8::from(both || way.dot(normal) < 0.0));
        match &light.kind {
            LightKind::PointLamp(lamp) if lamp.radius > 0.0 => {
                color(lamp.power) / (4.0 * PI * PI * lamp.radius * lamp.radius)
            }
            LightKind::PointLamp(lamp) => color(lamp.power) / (4.0 * PI * way.length_squared()),
            LightKind::SpotLamp(lamp) => {
                assert!(lamp.radius == 0.0, "the oracle knows spots without a radius");
                let rim = 1.0 - libm::cos(f64::from(lamp.angle_deg).to_radians() / 2.0);
                let versine = 1.0 + way.normalize().dot(lamp.axis);
                let x =
                    ((rim - versine) / (rim * f64::from(lamp.blend)).max(1e-30)).clamp(0.0, 1.0);
                let share = x * x * (3.0 - 2.0 * x);
                color(lamp.power) * share / (TAU * rim * way.length_squared())
            }
            LightKind::SunLamp(lamp) if lamp.angle_deg == 0.0 => color(lamp.irradiance),
            LightKind::SunLamp(lamp) => {
                let half = f64::from(lamp.angle_deg).to_radians() / 2.0;
                let sine = libm::sin(half);
                let is_in = way.normalize().dot(-lamp.direction) >= libm::cos(half);
                color(lamp.irradiance) * f64::from(u8::from(is_in)) / (PI * sine * sine)
            }
            LightKind::RectangleLamp(lamp) => {
                let [a, b, c] = lamp.rectangle.vertices;
                color(lamp.radiance) * front((b - a).cross(c - b), lamp.two_sided)
            }
            LightKind::DiscLamp(lamp) => color(lamp.radiance) * front(lamp.normal, lamp.two_sided),
            LightKind::Environment(lamp) => match lamp.sky {
                Sky::Even(radiance) => color(radiance) * f64::from(lamp.strength),
                Sky::Image(_) => panic!("the oracle knows no images of skies"),
            },
            other => panic!("the oracle does not know {other:?}"),
        }
    }
}

/// Returns what a material emits.
fn glow(material: &MaterialKind) -> Option<DVec3> {
    let MaterialKind::Principled(of) = material else { return None };
    let radiance = color(of.emission_color.value) * f64::from(of.emission_strength.value);
    (radiance != DVec3::ZERO).then_some(radiance)
}
