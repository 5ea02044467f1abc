//! Path tracing, one ray at a time, from docs/rendering.md.
//!
//! It knows scenes of `integrator PATH` with physical lamps and `material_principled`. Every
//! function returns light in the picture: the weight of the path is included.

use glam::DVec3;

use slo_render::sampling::{Hit as Vertex, Key, PixelSeed, Purpose, Sampler};
use slo_render::shading::light::receiver;
use slo_scene::material::Principled;
use slo_scene::{MaterialKind, SceneDescription};

use super::lamps::{Choice, Lamps, color};
use super::motion::camera_ray;
use super::points::next_path;
use super::solid::{Meeting, Ray};
use super::surface::{Facing, Lobe, lobes};
use super::world::{Look, Thing, World};

/// A scene prepared for plain path tracing.
pub(super) struct PathOracle<'a> {
    scene: &'a SceneDescription,
    world: World<'a>,
    lamps: Lamps<'a>,
    sampler: Sampler,
}

/// A ray of a path, and what it remembers of the hit that it left.
#[derive(Clone, Copy)]
struct Branch {
    seed: PixelSeed,
    path: u32,
    index: u32,
    /// Number of bounces.
    depth: u32,
    /// Weight of its radiance in the picture.
    weight: DVec3,
    /// Rays of the lobe per solid angle; 0 if only they find lamps.
    density: f64,
    /// The hit, and its normal as the tree of lights sees it.
    from: DVec3,
    receiver: u32,
}

/// A hit to be shaded.
struct Hit {
    point: DVec3,
    time: f64,
    facing: Facing,
    receiver: u32,
    lobes: Vec<Lobe>,
}

/// Weight of a path below which roulette decides whether it is followed.
const WEAK_PATH: f64 = 0.35;

/// Share of the way by which a ray that passes a lamp starts behind it.
const BEHIND: f64 = 1e-5;

/// Distance to the end of a ray to a glowing triangle within which the triangle itself is met: points
/// of triangles are in f32, and many rays meet them at a small angle.
const AT_END: f64 = 1e-4;

impl<'a> PathOracle<'a> {
    pub(super) fn new(scene: &'a SceneDescription, frame: i64) -> Self {
        let world = World::new(scene, frame);
        let lamps = Lamps::new(scene, &world);
        let sampler = Sampler::new(scene.settings.generator, scene.settings.seed, frame);
        Self { scene, world, lamps, sampler }
    }

    /// Returns the colour of the pixel in column `x` and row `y`.
    pub(super) fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let settings = &self.scene.settings;
        let samples = settings.image_samples * settings.dof_samples;
        let seed = self.sampler.pixel(x, y);
        let radiance = |index| {
            let sample = self.sampler.camera(seed, index);
            let ray = camera_ray(self.scene, &self.world.shutter, [x, y], &sample);
            let branch = Branch {
                seed,
                path: 0,
                index,
                depth: 0,
                weight: DVec3::ONE,
                density: 0.0,
                from: ray.origin,
                receiver: receiver::ANY,
            };
            self.light(&ray, branch)
        };
        (0..samples).map(radiance).sum::<DVec3>() / f64::from(samples)
    }

    /// Returns the light that arrives along a ray.
    fn light(&self, ray: &Ray, branch: Branch) -> DVec3 {
        match self.world.nearest(ray, None) {
            None => self.sky(ray, branch),
            Some((Thing { look: Look::Light(light), .. }, meeting)) => {
                self.lamp(ray, *light, meeting.t, branch)
            }
            Some((thing, meeting)) => self.surface(ray, thing, &meeting, branch),
        }
    }

    fn sky(&self, ray: &Ray, branch: Branch) -> DVec3 {
        let background = color(self.scene.settings.background);
        let seen = self.lamps.skies().filter(|sky| !self.lamps.is_hidden(*sky, branch.depth));
        let light =
            |sky| self.lamps.radiance(sky, ray.direction) * self.share(sky, ray.direction, branch);
        branch.weight * (background + seen.map(light).sum::<DVec3>())
    }

    /// Returns the light of a lamp that a ray meets at `t`, and of what lies behind it if the ray
    /// passes.
    fn lamp(&self, ray: &Ray, light: usize, t: f64, branch: Branch) -> DVec3 {
        let hidden = self.lamps.is_hidden(light, branch.depth);
        let dark = hidden || self.lamps.encloses(light, ray.origin);
        let way = ray.at(t) - branch.from;
        let own = match dark {
            true => DVec3::ZERO,
            false => self.lamps.radiance(light, way) * self.share(light, way, branch),
        };
        let behind = match self.lamps.is_passed(light, branch.depth) {
            true => self.pass(ray, ray.at(t * (1.0 + BEHIND)), branch),
            false => DVec3::ZERO,
        };
        branch.weight * own + behind
    }

    /// Returns the light along a ray that passes something unbent, and starts again at `origin`.
    fn pass(&self, ray: &Ray, origin: DVec3, branch: Branch) -> DVec3 {
        let path = next_path(branch.path, Purpose::Surface);
        self.light(&Ray { origin, ..*ray }, Branch { path, ..branch })
    }

    /// Returns the weight of a ray that hits a light against the rays to this light from the hit
    /// that the ray left.
    fn share(&self, light: usize, way: DVec3, branch: Branch) -> f64 {
        if branch.depth == 0 || branch.density == 0.0 {
            return 1.0;
        }
        let rays = f64::from(self.rays_to(light, branch.depth - 1));
        let chance = self.lamps.chance(light, branch.from, branch.receiver);
        let by_light = rays * chance * self.lamps.density(light, branch.from, way);
        branch.density / (branch.density + by_light)
    }

    fn surface(
        &self,
        ray: &Ray,
        thing: &Thing<'a>,
        meeting: &Meeting,
        mut branch: Branch,
    ) -> DVec3 {
        let Look::Material(mixed) = thing.look else { return DVec3::ZERO };
        let u = self.point(branch, Purpose::Surface, [0, 1])[0];
        let (material, u) = self.part(mixed, f64::from(u));
        let eye = -ray.direction;
        let from_outside = meeting.outward.dot(eye) > 0.0;
        let n = if from_outside { meeting.outward } else { -meeting.outward };
        let is_glass = material.transmission.value > 0.0;
        if is_glass && !from_outside {
            branch.weight *= absorbed(material, meeting.t);
        }
        let point = ray.at(meeting.t);
        if u >= f64::from(material.alpha.value) {
            return self.pass(ray, point, branch);
        }
        let emitted =
            color(material.emission_color.value) * f64::from(material.emission_strength.value);
        let share = match self.lamps.of_object(thing.number, meeting.part) {
            Some(light) => self.share(light, point - branch.from, branch),
            None => 1.0,
        };
        let own = branch.weight * emitted * share;
        if branch.depth > self.scene.settings.recursion() {
            return own;
        }
        let facing = Facing { eye, n, from_outside };
        let receiver = if is_glass { receiver::ANY } else { receiver::pack(n.as_vec3()) };
        let lobes = lobes(material, facing);
        let hit = Hit { point, time: ray.time, facing, receiver, lobes };
        own + self.lights(&hit, branch) + self.bounces(&hit, branch)
    }

    /// Chooses one of the materials that a material mixes by a number in `[0, 1)`. Returns it, and
    /// the number rescaled.
    fn part(&self, mut material: usize, mut u: f64) -> (&'a Principled, f64) {
        loop {
            match &self.scene.materials[material].kind {
                MaterialKind::Principled(principled) => return (principled, u),
                MaterialKind::Mix(mix) => {
                    let factor = f64::from(mix.factor.value);
                    let (part, rest) = match u < factor {
                        true => (mix.second, u / factor),
                        false => (mix.first, (u - factor) / (1.0 - factor)),
                    };
                    (material, u) = (part.0 as usize, rest);
                }
                other => panic!("the oracle does not know {other:?}"),
            }
        }
    }

    /// Returns the share of light that a material lets through, mixed or not.
    fn passing(&self, material: usize) -> f64 {
        match &self.scene.materials[material].kind {
            MaterialKind::Principled(principled) => 1.0 - f64::from(principled.alpha.value),
            MaterialKind::Mix(mix) => {
                let factor = f64::from(mix.factor.value);
                let [first, second] = [mix.first, mix.second].map(|m| self.passing(m.0 as usize));
                first * (1.0 - factor) + second * factor
            }
            other => panic!("the oracle does not know {other:?}"),
        }
    }

    /// Returns point number `i` of the `count` points of a hit for a purpose.
    fn point(&self, branch: Branch, purpose: Purpose, [i, count]: [u32; 2]) -> [f32; 3] {
        self.sampler.point3(self.key(branch, purpose, count), branch.index * count + i)
    }

    fn key(&self, branch: Branch, purpose: Purpose, count: u32) -> Key {
        let was_split = branch.depth > 0 && self.continuations(0) > 1;
        let alone = matches!(purpose, Purpose::Surface | Purpose::Survival);
        let split = count > 1 || was_split || alone;
        branch.seed.key(Vertex { path: branch.path, depth: branch.depth, split }, purpose)
    }

    /// Returns the number of rays that continue the path of a hit.
    fn continuations(&self, depth: u32) -> u32 {
        let settings = &self.scene.settings;
        let all = settings.diffuse_reflection_samples.max(settings.diffuse_refraction_samples);
        if depth == 0 { all } else { 1 }
    }

    /// Returns the number of rays from a hit to a light.
    fn rays_to(&self, light: usize, depth: u32) -> u32 {
        let many =
            depth == 0 && (self.lamps.asked_always().is_empty() || self.lamps.is_area(light));
        if many { self.scene.settings.soft_shadow_samples } else { 1 }
    }

    /// Returns the light of lamps by rays to them.
    fn lights(&self, hit: &Hit, branch: Branch) -> DVec3 {
        let depth = branch.depth;
        let each = self.lamps.asked_always().map(|light| {
            let count = self.rays_to(light, depth);
            let choice = Choice { light, chance: 1.0 };
            let one = |i| {
                let [u, v, _] = self.point(branch, Purpose::Light(light as u32), [i, count]);
                self.ask(hit, branch, choice, [u, v], count)
            };
            (0..count).map(one).sum::<DVec3>()
        });
        let each = each.sum::<DVec3>();
        if !self.lamps.has_choice() {
            return each;
        }
        let count = self.rays_to(self.lamps.asked_always().end, depth);
        let chosen = |i| {
            let [u, v, w] = self.point(branch, Purpose::AnyLight, [i, count]);
            let choice = self.lamps.choose(hit.point, hit.receiver, w)?;
            Some(self.ask(hit, branch, choice, [u, v], count))
        };
        each + (0..count).filter_map(chosen).sum::<DVec3>()
    }

    /// Returns what one of `count` rays to lights brings.
    fn ask(
        &self,
        hit: &Hit,
        branch: Branch,
        Choice { light, chance }: Choice,
        u: [f32; 2],
        count: u32,
    ) -> DVec3 {
        let way = self.lamps.way(light, hit.point, u);
        let toward = way.normalize();
        let tries = chance * f64::from(count);
        let is_delta = self.lamps.is_delta(light);
        let by_light =
            if is_delta { tries } else { tries * self.lamps.density(light, hit.point, way) };
        let rays = f64::from(self.continuations(branch.depth));
        let scattered = |lobe: &Lobe| {
            let (value, density) = lobe.evaluate(hit.facing, toward);
            let by_lobe = if is_delta { 0.0 } else { rays * lobe.chance * density };
            value / (by_light + by_lobe)
        };
        let scattered: DVec3 = hit.lobes.iter().map(scattered).sum();
        let light_sent = branch.weight * scattered * self.lamps.radiance(light, way);
        if light_sent == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let distance = if self.lamps.is_distant(light) { f64::INFINITY } else { way.length() };
        let ray = Ray { origin: hit.point, direction: toward, time: hit.time };
        light_sent * self.unblocked(&ray, distance, light)
    }

    /// Returns the share of light that passes between a hit and a point of a light.
    fn unblocked(&self, ray: &Ray, distance: f64, light: usize) -> f64 {
        let met = self.world.nearest(ray, self.lamps.surface(light));
        let Some((thing, meeting)) = met.filter(|(_, m)| m.t < distance - AT_END) else {
            return 1.0;
        };
        let share = match thing.look {
            Look::Light(other) => f64::from(u8::from(!self.lamps.is_solid(other))),
            Look::Material(material) => self.passing(material),
        };
        if share == 0.0 {
            return 0.0;
        }
        let behind = Ray { origin: ray.at(meeting.t), ..*ray };
        share * self.unblocked(&behind, distance - meeting.t, light)
    }

    /// Returns the light that rays along lobes bring.
    fn bounces(&self, hit: &Hit, branch: Branch) -> DVec3 {
        let count = self.continuations(branch.depth);
        (0..count).map(|i| self.bounce(hit, branch, [i, count])).sum()
    }

    fn bounce(&self, hit: &Hit, branch: Branch, place: [u32; 2]) -> DVec3 {
        let [u, v, w] = self.point(branch, Purpose::Continuation, place).map(f64::from);
        let mut start = 0.0;
        let lobe = hit.lobes.iter().find(|lobe| {
            start += lobe.chance;
            w < start
        });
        let Some(lobe) = lobe else { return DVec3::ZERO };
        let rest = (w - (start - lobe.chance)) / lobe.chance;
        let sampled = lobe.sample(hit.facing, [u, v, rest]);
        let rays = lobe.chance * f64::from(place[1]);
        let mut weight = branch.weight * sampled.weight / rays;
        let strength = weight.max_element() * f64::from(place[1]) / WEAK_PATH;
        if branch.depth > 0 && strength < 1.0 {
            let survival = self.point(branch, Purpose::Survival, place)[0];
            let is_followed = f64::from(survival) < strength;
            weight = if is_followed { weight / strength } else { DVec3::ZERO };
        }
        if weight.max_element() <= 0.0 {
            return DVec3::ZERO;
        }
        let ray = Ray { origin: hit.point, direction: sampled.direction, time: hit.time };
        let next = Branch {
            path: next_path(branch.path, Purpose::Continuation),
            index: branch.index * place[1] + place[0],
            depth: branch.depth + 1,
            weight,
            density: sampled.density * rays,
            from: hit.point,
            receiver: hit.receiver,
            ..branch
        };
        self.light(&ray, next)
    }
}

/// Returns what is left of light after a way inside a material: Beer's law.
fn absorbed(material: &Principled, way: f64) -> DVec3 {
    if material.absorption_distance == 0.0 {
        return DVec3::ONE;
    }
    let lengths = way / material.absorption_distance;
    DVec3::from_array(material.absorption_color.map(|left| libm::pow(f64::from(left), lengths)))
}
