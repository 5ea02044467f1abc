//! Where light paths start: a lamp, a place on it, and a direction toward something sharp.
//!
//! All densities are per area and projected solid angle at the lamp (m² sr). Both are kept along
//! every light path through mirrors and glass, which makes the density of a path from the lamp
//! comparable with that of a path from the camera, wherever they meet.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use slo_accel::math::Bounds;

use super::targets::Target;
use crate::sampling::warp::{concentric_disc, cosine_power_lobe};
use crate::shading::Lights;
use crate::shading::light::{Lamp, LightBounds, Moving, Pose, WithLamp, cone};
use crate::shading::lobe::pair;

/// Row of a light that sends no photons.
const NONE: u32 = u32::MAX;

/// Which lamps send photons to which targets, and how many.
#[derive(Clone, Debug)]
pub struct Emission {
    targets: Vec<Target>,
    /// For each light, its row of chances.
    rows: Vec<u32>,
    /// For each row, its light.
    lamps: Vec<u32>,
    /// Chances of all targets, row by row.
    chances: Vec<f32>,
    /// Sums of the chances up to and including each.
    ends: Vec<f64>,
    /// A box about everything that rays can hit, and nothing in its sides.
    world: Bounds,
}

/// Random numbers of a light path where it starts, in `[0, 1)`.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Chooses lamp and target.
    pub choice: f32,
    /// A place on the lamp; a direction of a distant one.
    pub place: [f32; 2],
    /// A direction; a place on the target for a distant lamp.
    pub direction: [f32; 2],
    /// Time of the shutter.
    pub time: f32,
}

/// A light path where it starts.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// Where it starts.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Power, W, of a path that is the only one.
    pub power: Vec3,
    /// See [`Emission::density`].
    pub density: f32,
    /// Index of the lamp.
    pub light: u32,
}

impl Emission {
    /// Prepares the lamps of a frame that is seen from `eye`. `bounds` are the bounds of each during the
    /// shutter, and `world` those of everything that rays can hit. Returns `None` if no light path
    /// could start.
    ///
    /// A target is chosen by how large it looks, not by its area and not by its power: a glossy
    /// ground would take all photons otherwise. The lamp is chosen by the light that it sends there.
    pub fn new(
        lights: &Lights,
        bounds: &[LightBounds],
        targets: Vec<Target>,
        world: Bounds,
        eye: Vec3,
    ) -> Option<Self> {
        let mut rows = vec![NONE; lights.len()];
        let (mut lamps, mut chances) = (Vec::new(), Vec::new());
        for ((number, light), bounds) in (0u32..).zip(lights.iter()).zip(bounds) {
            if light.is_of_thesis() || light.is_shaded() {
                continue;
            }
            let row: Vec<f64> = targets.iter().map(|target| flux(bounds, target)).collect();
            if row.iter().any(|flux| *flux > 0.0) {
                rows[number as usize] = lamps.len() as u32;
                lamps.push(number);
                chances.extend(row);
            }
        }
        for (number, target) in targets.iter().enumerate() {
            let total: f64 = chances.iter().skip(number).step_by(targets.len()).sum();
            let distance = (target.center - eye).length().max(target.radius);
            let weight = f64::from(target.share * target.radius / distance);
            let scale = if total > 0.0 && total.is_finite() { weight / total } else { 0.0 };
            for chance in chances.iter_mut().skip(number).step_by(targets.len()) {
                *chance *= scale;
            }
        }
        let total: f64 = chances.iter().sum();
        if total.is_nan() || total <= 0.0 || total.is_infinite() {
            return None;
        }
        let chances: Vec<f32> = chances.iter().map(|chance| (chance / total) as f32).collect();
        let ends = chances.iter().scan(0.0, |sum, chance| {
            *sum += f64::from(*chance);
            Some(*sum)
        });
        let ends = ends.collect();
        let far = world.min.abs().max(world.max.abs()).max_element();
        let margin = Vec3::splat(far * 1e-5) + world.size() * 1e-3;
        let world = Bounds { min: world.min - margin, max: world.max + margin };
        Some(Self { targets, rows, lamps, chances, ends, world })
    }

    /// Starts a light path. Returns `None` if no light goes that way.
    pub fn start(&self, lights: &Lights, u: Numbers) -> Option<Emitted> {
        let at = f64::from(u.choice) * self.ends.last().copied().unwrap_or(0.0);
        let pair = self.ends.partition_point(|end| *end <= at).min(self.ends.len() - 1);
        let light = self.lamps[pair / self.targets.len()];
        let target = self.targets[pair % self.targets.len()];
        lights[light as usize].with(Start { emission: self, lights, light, target, u })
    }

    /// Returns the density with which light paths start at a light in `point`, in unit `direction`, at
    /// a time of the shutter: per area and projected solid angle. It is infinite for a light that no
    /// ray can hit, and 0 where no path starts.
    pub fn density(
        &self,
        lights: &Lights,
        light: u32,
        time: f32,
        point: Vec3,
        direction: Vec3,
    ) -> f32 {
        let row = self.rows[light as usize];
        if row == NONE {
            return 0.0;
        }
        let pose = lights.pose(light, time);
        lights[light as usize].with(Density { emission: self, pose, row, point, direction })
    }

    /// Whether light paths start at a light.
    pub fn sends(&self, light: u32) -> bool {
        self.rows[light as usize] != NONE
    }

    /// Returns how far a ray from inside the world goes before it leaves it.
    fn reach(&self, from: Vec3, direction: Vec3) -> f32 {
        let exit = |axis: usize| {
            let wall = if direction[axis] > 0.0 { self.world.max } else { self.world.min };
            let t = (wall[axis] - from[axis]) / direction[axis];
            if t.is_finite() { t.max(0.0) } else { f32::INFINITY }
        };
        let reach = exit(0).min(exit(1)).min(exit(2));
        if reach.is_finite() { reach } else { 0.0 }
    }
}

/// An estimate of the power that a light sends to a target. It is 0 only if none can arrive.
fn flux(light: &LightBounds, target: &Target) -> f64 {
    let Target { center, radius, .. } = *target;
    let area = f64::from(PI * radius * radius);
    let energy = f64::from(light.energy);
    if light.is_distant {
        return energy * area;
    }
    let (middle, half) = ((light.min + light.max) * 0.5, (light.max - light.min) * 0.5);
    let way = center - middle;
    let (distance, reach) = (way.length(), radius + half.length());
    if distance <= reach {
        return energy * f64::from(PI);
    }
    // The least angle between a direction in which the light shines most and one to the target.
    let cos = (way.dot(light.axis) / distance).clamp(-1.0, 1.0);
    let cos = if light.two_sided { cos.abs() } else { cos };
    let off = libm::acosf(cos) - libm::asinf(reach / distance) - light.spread - 1e-3;
    let cosine = if light.is_flat { libm::cosf(off.clamp(0.0, PI)) } else { f32::from(off <= 0.0) };
    energy * area / f64::from(distance * distance) * f64::from(cosine.max(0.0))
}

/// The density, per solid angle, of directions from a point to a target that it lies outside of; `None`
/// if it lies inside. The versine of the target's rim, and the way to its middle, come with it.
#[inline(always)]
fn toward(target: &Target, point: Vec3) -> Option<(f32, Vec3)> {
    let way = target.center - point;
    let sin2 = target.radius * target.radius / way.length_squared().max(f32::MIN_POSITIVE);
    (sin2 < 1.0).then(|| (sin2 / (1.0 + (1.0 - sin2).sqrt()), way))
}

/// The density per solid angle of directions from a point to a target; `None` if it lies inside, where
/// all directions lead to the target.
#[inline(always)]
fn to_target(target: &Target, point: Vec3, direction: Vec3) -> Option<f32> {
    let (rim, way) = toward(target, point)?;
    let along = way.dot(direction);
    let across2 = (way - direction * along).length_squared();
    let is_hit = (along > 0.0) & (across2 <= target.radius * target.radius);
    Some(if is_hit { cone::density(rim) } else { 0.0 })
}

/// The density per area of parallel rays that go to a target.
#[inline(always)]
fn to_disc(target: &Target, point: Vec3, direction: Vec3) -> f32 {
    let way = target.center - point;
    let across2 = (way - direction * way.dot(direction)).length_squared();
    let square = target.radius * target.radius;
    if across2 <= square { FRAC_1_PI / square } else { 0.0 }
}

/// All directions of a point.
const ALL_ROUND: f32 = 0.25 * FRAC_1_PI;

impl Emission {
    /// Returns the density with which light paths start at a lamp in `point`, in unit `direction`: per
    /// area and projected solid angle; of a lamp without an area, per solid angle; of one without a
    /// size on the sky, per area.
    fn of_lamp<L: Lamp>(&self, lamp: &L, row: u32, point: Vec3, direction: Vec3) -> f32 {
        let count = self.targets.len();
        let chances = &self.chances[row as usize * count..][..count];
        let targets = self.targets.iter().zip(chances);
        if L::IS_DISTANT {
            let of = |(target, chance): (&Target, &f32)| chance * to_disc(target, point, direction);
            let sum: f32 = targets.map(of).sum();
            return if L::IS_DELTA { sum } else { sum * lamp.density(point, -direction) };
        }
        let cos = lamp.normal(point).dot(direction);
        let cos = match () {
            () if L::IS_DELTA => 1.0,
            () if L::IS_CLOSED => cos.max(0.0),
            () => cos.abs(),
        };
        let from_inside = if L::IS_DELTA { ALL_ROUND } else { cos * (0.5 * FRAC_1_PI) };
        let of = |(target, chance): (&Target, &f32)| {
            chance * to_target(target, point, direction).unwrap_or(from_inside)
        };
        let sum: f32 = targets.map(of).sum();
        let area = lamp.area() * cos;
        match () {
            () if L::IS_DELTA => sum,
            () if area > 0.0 => sum / area,
            () => 0.0,
        }
    }
}

/// A density from which a light path cannot differ, for lamps that no ray can hit.
fn as_density<L: Lamp>(of_lamp: f32) -> f32 {
    if L::IS_DELTA && of_lamp > 0.0 { f32::INFINITY } else { of_lamp }
}

struct Density<'a> {
    emission: &'a Emission,
    pose: Pose,
    row: u32,
    point: Vec3,
    direction: Vec3,
}

impl WithLamp for Density<'_> {
    type Output = f32;

    fn run<L: Lamp>(self, lamp: L) -> f32 {
        let Self { emission, pose, row, point, direction } = self;
        let lamp = Moving { lamp, pose };
        as_density::<L>(emission.of_lamp(&lamp, row, point, direction))
    }
}

struct Start<'a> {
    emission: &'a Emission,
    lights: &'a Lights,
    light: u32,
    target: Target,
    u: Numbers,
}

impl WithLamp for Start<'_> {
    type Output = Option<Emitted>;

    fn run<L: Lamp>(self, lamp: L) -> Option<Emitted> {
        let Self { emission, lights, light, target, u } = self;
        let lamp = Moving { lamp, pose: lights.pose(light, u.time) };
        let (origin, direction) = if L::IS_DISTANT {
            let way = lamp.way(target.center, u.place);
            let ([a, b], (x, y)) = (concentric_disc(u.direction), pair(way));
            let on_disc = target.center + (x * a + y * b) * target.radius;
            (on_disc + way * emission.reach(on_disc, way), -way)
        } else {
            let origin = lamp.place(u.place);
            let direction = match toward(&target, origin) {
                Some((rim, way)) => cone::about(way * (1.0 / way.length()), rim, u.direction).0,
                None if L::IS_DELTA => all_round(u.direction),
                None => both_sides(lamp.normal(origin), u.direction),
            };
            (origin, direction)
        };
        let direction = direction * (1.0 / direction.length());
        let row = emission.rows[light as usize];
        let of_lamp = emission.of_lamp(&lamp, row, origin, direction);
        let power = lamp.radiance(-direction) / of_lamp;
        let density = as_density::<L>(of_lamp);
        // Off the lamp, as far as rays to it end before it.
        let origin = if L::IS_DELTA || L::IS_DISTANT {
            origin
        } else {
            let from = origin + direction * (target.center - origin).length().max(target.radius);
            let (back, end) = lamp.shadow_ray(from, origin);
            from + back * end
        };
        let is_sent = power.max_element() > 0.0 && power.is_finite();
        is_sent.then_some(Emitted { origin, direction, power, density, light })
    }
}

/// Samples all directions uniformly.
fn all_round(u: [f32; 2]) -> Vec3 {
    cone::about(Vec3::Z, 2.0, u).0
}

/// Samples directions on both sides of a surface, by the cosine.
pub(super) fn both_sides(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (side, u) = if u < 0.5 { (1.0, 2.0 * u) } else { (-1.0, 2.0 * u - 1.0) };
    let local = cosine_power_lobe([u, v], 0.5);
    let (x, y) = pair(normal);
    x * local.x + y * local.y + normal * (local.z * side)
}
