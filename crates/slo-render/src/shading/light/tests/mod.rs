//! Tests of all kinds of lights together.

mod batches;
mod densities;
mod irradiance;
mod kinds;
mod moving;
mod shadow_rays;

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::*;
use slo_scene::shape;
use slo_scene::{Curve, light as scene};

/// A light of a kind, in a frame that begins at the origin.
fn light(kind: LightKind, textures: &[Arc<Texture>]) -> Light {
    let (name, key_frames, group) = ("l".into(), Vec::new(), None);
    let (camera_visible, solid) = (true, true);
    let light = slo_scene::Light {
        name,
        kind,
        key_frames,
        parent: None,
        repeat: None,
        camera_visible,
        solid,
        group,
    };
    Light::new(&light, DVec3::ZERO, textures, Skies { share: SkyShare::All, before: &[] })
}

pub(super) fn sphere(position: DVec3, radius: f64) -> Light {
    let lamp = scene::PointLamp { power: [7.0, 5.0, 3.0], position, radius };
    light(LightKind::PointLamp(lamp), &[])
}

pub(super) fn sun(direction: DVec3, angle_deg: f32) -> Light {
    let lamp = scene::SunLamp { irradiance: [7.0, 5.0, 3.0], direction, angle_deg };
    light(LightKind::SunLamp(lamp), &[])
}

pub(super) fn rectangle(vertices: [DVec3; 3], two_sided: bool) -> Light {
    let rectangle = shape::Rectangle { vertices };
    let lamp = scene::RectangleLamp { radiance: [7.0, 5.0, 3.0], rectangle, two_sided };
    light(LightKind::RectangleLamp(lamp), &[])
}

pub(super) fn disc(center: DVec3, normal: DVec3, radius: f64) -> Light {
    let radiance = [7.0, 5.0, 3.0];
    let lamp = scene::DiscLamp { radiance, center, normal, radius, two_sided: false };
    light(LightKind::DiscLamp(lamp), &[])
}

pub(super) fn spot_at(position: DVec3, axis: DVec3, radius: f64, angle_deg: f32) -> Light {
    let (power, blend) = ([7.0, 5.0, 3.0], 0.3);
    let lamp = scene::SpotLamp { power, position, radius, axis, angle_deg, blend };
    light(LightKind::SpotLamp(lamp), &[])
}

/// A light of the thesis: a rectangle, or a point in its first corner.
pub(super) fn of_thesis(vertices: [DVec3; 3], is_rectangle: bool) -> Light {
    let color = [7.0, 5.0, 3.0];
    let rectangle = shape::Rectangle { vertices };
    let kind = if is_rectangle {
        LightKind::Rectangle(scene::RectangleLight { color, rectangle })
    } else {
        LightKind::Point(scene::PointLight { color, position: vertices[0] })
    };
    light(kind, &[])
}

/// A sky with a bright spot, a dark half and noise.
pub(super) fn sky(width: u32, height: u32, turn_deg: f32) -> Light {
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let noise = i.wrapping_mul(2_654_435_761) >> 16;
        let value = if x < width / 2 { 0 } else { noise as u16 / 256 };
        if (x, y) == (width / 3, height / 4) { [60_000, 50_000, 40_000] } else { [value; 3] }
    };
    let texels = (0..width * height).flat_map(texel).collect();
    let texture =
        Texture::from_rgb16(width, height, texels).unwrap().with_encoding(Some(Curve::Raw));
    let lamp =
        scene::Environment { sky: Sky::Image(slo_scene::TextureId(0)), strength: 2.0, turn_deg };
    light(LightKind::Environment(lamp), &[Arc::new(texture)])
}

/// What a hit finds of a light: vector to a sampled point, radiance, density.
struct Sample(Vec3, [f32; 2]);

impl WithLamp for Sample {
    type Output = (Vec3, Vec3, f32);

    fn run<L: Lamp>(self, lamp: L) -> Self::Output {
        let way = lamp.way(self.0, self.1);
        (way, lamp.radiance(way), lamp.density(self.0, way))
    }
}

/// Points of the unit square, spread evenly.
pub(super) fn points(count: u32) -> impl Iterator<Item = [f32; 2]> {
    // Source: M. Roberts, the R2 sequence.
    let step = |a: f64, i: u32| {
        let x = 0.5 + a * f64::from(i);
        ((x - x.floor()) as f32).min(1.0 - f32::EPSILON / 2.0)
    };
    (0..count).map(move |i| [step(0.754_877_666_246_693, i), step(0.569_840_290_998_053_3, i)])
}

/// The irradiance by `count` sampled points on a surface with a unit normal; red.
fn irradiance(light: &Light, from: Vec3, normal: Vec3, count: u32) -> f64 {
    let one = |u| {
        let (way, radiance, density) = light.with(Sample(from, u));
        let cos = f64::from(way.dot(normal) / way.length()).max(0.0);
        let density = if density.is_finite() { f64::from(density) } else { 1.0 };
        f64::from(radiance.x) * cos / density
    };
    points(count).map(one).sum::<f64>() / f64::from(count)
}
