//! The integral of one pixel, sample by sample and ray by ray, from docs/rendering.md.

use glam::{DVec2, DVec3};

use slo_render::sampling::{Hit as Vertex, Key, PixelSeed, Purpose, Sampler};
use slo_render::shading::Light as PreparedLight;
use slo_render::shading::light::{LightTree, NO_LIGHT, Skies, SkyShare, receiver};
use slo_scene::material::Phong;
use slo_scene::{
    Light, LightKind, LightSampling, Material, MaterialKind, SceneDescription, ShadowMode,
};

use super::lamps::color;
use super::motion::camera_ray;
use super::points::{lobe, next_path};
use super::solid::{Meeting, Ray};
use super::world::{Look, World};

/// A scene prepared for plain recursive rendering.
pub(super) struct Oracle<'a> {
    scene: &'a SceneDescription,
    world: World<'a>,
    sampler: Sampler,
    /// Chooses lights; it has tests of its own.
    tree: LightTree,
}

/// Identity of a ray of a pixel.
#[derive(Clone, Copy)]
struct Branch {
    seed: PixelSeed,
    path: u32,
    index: u32,
    depth: u32,
    /// Rays of the lobe per solid angle if rays to lamps sample the same light; 0 if none do.
    density: f64,
    /// Weight of its radiance in the picture.
    weight: f64,
}

/// Weight below which rays are left out at random.
const LEAST_WEIGHT: f64 = 1.0 / 256.0;

/// A light chosen to stand for all lights.
struct Choice {
    number: usize,
    chance: f64,
    /// The random number rescaled after the choice.
    rest: f64,
}

/// One of `tries` rays to a light.
struct Ask {
    number: usize,
    u: [f32; 2],
    tries: f64,
    /// Factor by which the light counts more, because it stands for others too.
    times: f64,
    /// Random number in `[0, 1)` that decides whether a weak ray is sent.
    survival: f64,
}

/// A hit to be shaded.
struct Hit<'a> {
    point: DVec3,
    /// Unit vector to the origin of the ray.
    eye: DVec3,
    time: f64,
    n_geo: DVec3,
    n_shade: DVec3,
    from_outside: bool,
    material: &'a Phong,
    tint: DVec3,
}

fn light_color(light: &Light) -> DVec3 {
    color(match &light.kind {
        LightKind::Point(light) => light.color,
        LightKind::Rectangle(light) => light.color,
        other => panic!("the oracle does not know {other:?}"),
    })
}

fn phong_of(material: &Material) -> &Phong {
    match &material.kind {
        MaterialKind::Phong(phong) => phong,
        other => panic!("the oracle does not know {other:?}"),
    }
}

impl<'a> Oracle<'a> {
    pub(super) fn new(scene: &'a SceneDescription, frame: i64) -> Self {
        let skies = Skies { share: SkyShare::All, before: &[] };
        let bounds = |light| PreparedLight::new(light, DVec3::ZERO, &[], skies).bounds();
        let bounds: Vec<_> = scene.lights.iter().map(bounds).collect();
        Self {
            scene,
            tree: LightTree::new(&bounds),
            world: World::new(scene, frame),
            sampler: Sampler::new(scene.settings.generator, scene.settings.seed, frame),
        }
    }

    /// Returns the colour of the pixel in column `x` and row `y`.
    pub(super) fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let settings = &self.scene.settings;
        let samples = settings.image_samples * settings.dof_samples;
        let seed = self.sampler.pixel(x, y);
        let radiance = |index| {
            let sample = self.sampler.camera(seed, index);
            let ray = camera_ray(self.scene, &self.world.shutter, [x, y], &sample);
            self.radiance(
                &ray,
                Branch { seed, path: 0, index, depth: 0, density: 0.0, weight: 1.0 },
            )
        };
        (0..samples).map(radiance).sum::<DVec3>() / f64::from(samples)
    }

    fn radiance(&self, ray: &Ray, branch: Branch) -> DVec3 {
        let Some((thing, meeting)) = self.world.nearest(ray, None) else {
            return color(self.scene.settings.background);
        };
        match thing.look {
            Look::Light(light) => {
                let way = ray.direction * meeting.t;
                light_color(&self.scene.lights[light]) * self.lobe_share(light, way, branch)
            }
            Look::Material(material) => {
                let hit = self.hit(ray, phong_of(&self.scene.materials[material]), &meeting);
                let ambient = color(hit.material.info.ambient) * hit.tint;
                let lobes = self.lobes(&hit, branch.depth);
                let bounces = lobes.iter().map(|lobe| self.glossy(&hit, branch, lobe));
                ambient + self.lights(&hit, branch, &lobes) + bounces.sum::<DVec3>()
            }
        }
    }

    fn hit(&self, ray: &Ray, material: &'a Phong, meeting: &Meeting) -> Hit<'a> {
        let toward = |n: DVec3, side: DVec3| if n.dot(side) < 0.0 { -n } else { n };
        let eye = -ray.direction;
        let n_geo = toward(meeting.outward, eye);
        Hit {
            point: ray.at(meeting.t),
            eye,
            time: ray.time,
            n_geo,
            n_shade: meeting.smooth.map_or(n_geo, |n| toward(n.normalize(), n_geo)),
            from_outside: meeting.outward.dot(eye) > 0.0,
            material,
            tint: self.tint(material, meeting.uv),
        }
    }

    /// Returns the image at uv. It repeats, v grows upward, and between the centres of texels it is
    /// linear.
    fn tint(&self, material: &Phong, uv: DVec2) -> DVec3 {
        let Some(used) = material.texture else { return DVec3::ONE };
        let image = &self.scene.textures[used.texture.0 as usize];
        let size = DVec2::new(f64::from(image.width()), f64::from(image.height()));
        let scale = DVec2::from_array(used.scale.map(f64::from));
        let at = uv * scale * size - 0.5;
        let texel = |x: f64, y: f64| {
            let column = x.rem_euclid(size.x) as u32;
            color(image.texel(column, image.height() - 1 - y.rem_euclid(size.y) as u32))
        };
        let (low, part) = (at.floor(), at - at.floor());
        let row = |y| texel(low.x, y) * (1.0 - part.x) + texel(low.x + 1.0, y) * part.x;
        row(low.y) * (1.0 - part.y) + row(low.y + 1.0) * part.y
    }

    /// Returns the number of rays from a hit to a light, and its mean.
    fn tries(&self, number: usize, depth: u32) -> (u32, f64) {
        let settings = &self.scene.settings;
        let one = settings.light_sampling() == LightSampling::One;
        let area = matches!(self.scene.lights[number].kind, LightKind::Rectangle(_));
        let many = depth == 0 && (one || area);
        let count = if many { settings.soft_shadow_samples } else { 1 };
        let among = if one { self.scene.lights.len() } else { 1 };
        (count, f64::from(count) / among as f64)
    }

    /// Returns the sample set of the `count` rays for a purpose.
    fn key(&self, branch: Branch, purpose: Purpose, count: u32) -> Key {
        let settings = &self.scene.settings;
        let glossy = settings.diffuse_reflection_samples.max(settings.diffuse_refraction_samples);
        let split = count > 1 || (branch.depth > 0 && glossy > 1);
        branch.seed.key(Vertex { path: branch.path, depth: branch.depth, split }, purpose)
    }

    fn lights(&self, hit: &Hit<'_>, branch: Branch, lobes: &[Glossy]) -> DVec3 {
        let lights = &self.scene.lights;
        if self.scene.settings.light_sampling() == LightSampling::One {
            let (count, tries) = self.tries(0, branch.depth);
            let key = self.key(branch, Purpose::AnyLight, count);
            let one = |i| {
                let [u, v, choice] = self.sampler.point3(key, branch.index * count + i);
                let Choice { number, chance, rest } = self.choose(hit, f64::from(choice));
                if chance == 0.0 {
                    return DVec3::ZERO;
                }
                let times = 1.0 / (chance * lights.len() as f64);
                let ask = Ask { number, u: [u, v], tries, times, survival: rest };
                self.light(hit, branch, &ask, lobes)
            };
            return (0..count).map(one).sum();
        }
        let all = |number: usize| {
            let (count, tries) = self.tries(number, branch.depth);
            let key = self.key(branch, Purpose::Light(number as u32), count);
            let sample = |i| {
                let [u, v, w] = self.sampler.point3(key, branch.index * count + i);
                let survival = f64::from(w);
                let ask = Ask { number, u: [u, v], tries, times: 1.0, survival };
                self.light(hit, branch, &ask, lobes)
            };
            (0..count).map(sample).sum::<DVec3>()
        };
        (0..lights.len()).map(all).sum()
    }

    /// Chooses a light by a number in `[0, 1)`, as the tree of lights does.
    fn choose(&self, hit: &Hit<'_>, u: f64) -> Choice {
        let rough = |m: &Material| {
            let info = &phong_of(m).info;
            info.refraction > 0.0 && info.diffuse_refraction > 0.0
        };
        let through = self.combines() && self.scene.materials.iter().any(rough);
        let normal = if through { receiver::ANY } else { receiver::pack(hit.n_geo.as_vec3()) };
        let chosen = self.tree.choose(hit.point.as_vec3(), normal, u as f32);
        if chosen.light == NO_LIGHT {
            return Choice { number: 0, chance: 0.0, rest: 0.0 };
        }
        let (chance, rest) = (f64::from(chosen.chance), f64::from(chosen.rest));
        Choice { number: chosen.light as usize, chance, rest }
    }

    /// Returns one of `tries` estimates of the light that arrives from a light and is reflected to
    /// the eye: (2.15), and its share of the light that glossy lobes receive.
    fn light(&self, hit: &Hit<'_>, branch: Branch, ask: &Ask, lobes: &[Glossy]) -> DVec3 {
        let &Ask { number, u, tries, times, survival } = ask;
        let light = &self.scene.lights[number];
        let target = match &light.kind {
            LightKind::Point(light) => light.position,
            LightKind::Rectangle(light) => {
                let [a, b, c] = light.rectangle.vertices;
                a + (b - a) * f64::from(u[0]) + (c - b) * f64::from(u[1])
            }
            other => panic!("the oracle does not know {other:?}"),
        };
        let way = target - hit.point;
        let l = way.normalize();
        let by_light = tries * density_of_light(light, way);
        let glossy = |lobe: &Glossy| {
            let density = lobe.density(l);
            let combined = self.combines() && density > 0.0 && by_light < f64::INFINITY;
            let rays = f64::from(lobe.samples);
            if combined { lobe.weight * density / (by_light + rays * density) } else { 0.0 }
        };
        let lobes = DVec3::splat(lobes.iter().map(glossy).sum());
        let color = light_color(light);
        let sent = (phong(hit, l) / tries + lobes) * color * times;
        if sent == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let least = LEAST_WEIGHT * color.max_element().min(1.0);
        let chance = match branch.depth {
            0 => 1.0,
            _ => (branch.weight * sent.max_element() / least).min(1.0),
        };
        if chance < 1.0 && survival >= chance {
            return DVec3::ZERO;
        }
        let ray = Ray { origin: hit.point, direction: l, time: hit.time };
        sent * self.passed(ray, way.length(), number) / chance
    }

    /// Whether rays to lamps also sample the light that lobes receive: if both kinds of rays end at
    /// the same objects.
    fn combines(&self) -> bool {
        self.scene.settings.shadow == ShadowMode::Opaque
    }

    /// Returns the weight of a lobe's ray that hits a lamp.
    fn lobe_share(&self, light: usize, way: DVec3, branch: Branch) -> f64 {
        if branch.density == 0.0 || !self.combines() {
            return 1.0;
        }
        let (_, tries) = self.tries(light, branch.depth - 1);
        let by_light = tries * density_of_light(&self.scene.lights[light], way);
        branch.density / (branch.density + by_light)
    }

    /// Returns the share of light that passes between a hit and a point of a light.
    fn passed(&self, ray: Ray, distance: f64, light: usize) -> f64 {
        let Some((thing, meeting)) = self.world.nearest(&ray, Some(light)) else { return 1.0 };
        if meeting.t >= distance {
            return 1.0;
        }
        let Look::Material(material) = thing.look else { return 0.0 };
        let refraction = f64::from(phong_of(&self.scene.materials[material]).info.refraction);
        if self.scene.settings.shadow == ShadowMode::Opaque || refraction == 0.0 {
            return 0.0;
        }
        let share = if thing.open { refraction } else { refraction.sqrt() };
        let behind = Ray { origin: ray.at(meeting.t), ..ray };
        share * self.passed(behind, distance - meeting.t, light)
    }

    /// Returns the light that a hit reflects and refracts.
    fn lobes(&self, hit: &Hit<'_>, depth: u32) -> Vec<Glossy> {
        let settings = &self.scene.settings;
        if depth == settings.recursion() {
            return Vec::new();
        }
        let material = &hit.material.info;
        let [k_r, k_t] = [material.reflectance, material.refraction].map(f64::from);
        let refracted = refracted(hit).filter(|_| k_t > 0.0);
        let samples =
            |spread: f32, samples: u32| if depth == 0 && spread > 0.0 { samples } else { 1 };
        let spread = material.diffuse_reflection;
        let mirror = Glossy {
            axis: -hit.eye + 2.0 * hit.eye.dot(hit.n_shade) * hit.n_shade,
            side: hit.n_geo,
            spread,
            weight: if refracted.is_none() { k_r + k_t } else { k_r },
            samples: samples(spread, settings.diffuse_reflection_samples),
            purpose: Purpose::Reflection,
        };
        let spread = material.diffuse_refraction;
        let clear = refracted.map(|axis| Glossy {
            axis,
            side: -hit.n_geo,
            spread,
            weight: k_t,
            samples: samples(spread, settings.diffuse_refraction_samples),
            purpose: Purpose::Refraction,
        });
        [Some(mirror), clear].into_iter().flatten().filter(|lobe| lobe.weight > 0.0).collect()
    }

    /// Returns the weighted light from the directions about an axis.
    fn glossy(&self, hit: &Hit<'_>, branch: Branch, glossy: &Glossy) -> DVec3 {
        let count = glossy.samples;
        let key = self.key(branch, glossy.purpose, count);
        let sample = |i| {
            let index = branch.index * count + i;
            let [u, v, chosen] = self.sampler.point3(key, index).map(f64::from);
            let weight = branch.weight * glossy.weight / f64::from(count);
            let chance = (weight / LEAST_WEIGHT).min(1.0);
            if chance < 1.0 && chosen >= chance {
                return DVec3::ZERO;
            }
            let w = lobe(glossy.axis, f64::from(glossy.spread), [u, v]);
            let below = w.dot(glossy.side).min(0.0);
            let direction = w - 2.0 * below * glossy.side;
            let ray = Ray { origin: hit.point, direction, time: hit.time };
            let path = next_path(branch.path, glossy.purpose);
            let density = f64::from(count) * glossy.density(direction);
            let depth = branch.depth + 1;
            let weight = weight / chance;
            self.radiance(&ray, Branch { path, index, depth, density, weight, ..branch }) / chance
        };
        (0..count).map(sample).sum::<DVec3>() * (glossy.weight / f64::from(count))
    }
}

/// Returns the local light: (2.15).
fn phong(hit: &Hit<'_>, l: DVec3) -> DVec3 {
    let cos = hit.n_shade.dot(l);
    if cos <= 0.0 || hit.n_geo.dot(l) <= 0.0 {
        return DVec3::ZERO;
    }
    let material = &hit.material.info;
    let mirrored = 2.0 * cos * hit.n_shade - l;
    let highlight = libm::pow(hit.eye.dot(mirrored).max(0.0), f64::from(material.shininess));
    color(material.diffuse) * hit.tint * cos + color(material.specular) * highlight
}

/// Returns the `pdf_solid_angle` of the point of a light at the end of the vector `way` from a hit,
/// sampled uniformly by area.
fn density_of_light(light: &Light, way: DVec3) -> f64 {
    let [a, b, c] = match &light.kind {
        LightKind::Point(_) => return f64::INFINITY,
        LightKind::Rectangle(light) => light.rectangle.vertices,
        other => panic!("the oracle does not know {other:?}"),
    };
    // Twice the area of the triangle is the area of the rectangle, along its normal.
    let normal = (b - a).cross(c - b);
    way.length_squared() * way.length() / way.dot(normal).abs()
}

/// A direction and a lobe about it.
struct Glossy {
    axis: DVec3,
    /// Unit normal of the side that rays stay on.
    side: DVec3,
    spread: f32,
    /// Factor of the light that arrives.
    weight: f64,
    samples: u32,
    purpose: Purpose,
}

impl Glossy {
    /// Returns the `pdf_solid_angle` of its rays: the density of the lobe, plus the density of the
    /// part that is mirrored to its side.
    fn density(&self, w: DVec3) -> f64 {
        let below = w.dot(self.side);
        if self.spread == 0.0 || below <= 0.0 {
            return 0.0;
        }
        let n = 1.0 / f64::from(self.spread * self.spread);
        let power = |w: DVec3| libm::pow(self.axis.dot(w).max(0.0), n);
        let sum = power(w) + power(w - 2.0 * below * self.side);
        sum * (n + 1.0) / std::f64::consts::TAU
    }
}

/// Refracts by Snell's law, (2.13) and (2.14); `None` under total internal reflection.
fn refracted(hit: &Hit<'_>) -> Option<DVec3> {
    let index = f64::from(hit.material.info.refraction_index);
    let eta = if hit.from_outside { 1.0 / index } else { index };
    // An interpolated normal that faces away from the ray cannot refract it.
    let n = if hit.n_shade.dot(hit.eye) > 0.0 { hit.n_shade } else { hit.n_geo };
    let cos = n.dot(hit.eye);
    let square = 1.0 - eta * eta * (1.0 - cos * cos);
    (square >= 0.0).then(|| n * (eta * cos - square.sqrt()) - hit.eye * eta)
}
