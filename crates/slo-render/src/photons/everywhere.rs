//! Where light paths start that are not aimed at anything: all light that lamps send.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;
use slo_accel::math::Bounds;

use super::emission::{Emitted, Numbers, both_sides};
use crate::sampling::warp::concentric_disc;
use crate::shading::Lights;
use crate::shading::light::{Lamp, LightBounds, Moving, WithLamp, cone};
use crate::shading::lobe::pair;

/// Lamps, chosen by their power.
#[derive(Clone, Debug)]
pub struct Everywhere {
    /// Lamps that send light, each with its chance, and the sum of the chances up to and including it.
    lamps: Vec<(u32, f32, f64)>,
    /// The sphere about everything that rays can hit, which light of distant lamps passes.
    middle: Vec3,
    radius: f32,
}

impl Everywhere {
    /// Prepares the lamps of a frame. `bounds` are the bounds of each during the shutter, and `world`
    /// those of everything that rays can hit. Returns `None` if no light path could start.
    pub fn new(lights: &Lights, bounds: &[LightBounds], world: Bounds) -> Option<Self> {
        let radius = (world.max - world.min).length() * 0.5 * 1.001;
        let middle = (world.min + world.max) * 0.5;
        let sends = |(light, _): &(u32, f64)| !lights[*light as usize].is_of_thesis();
        let flux: Vec<(u32, f64)> = (0u32..)
            .zip(bounds.iter().map(|bounds| power(bounds, radius)))
            .filter(sends)
            .filter(|(_, power)| *power > 0.0 && power.is_finite())
            .collect();
        let total: f64 = flux.iter().map(|(_, power)| power).sum();
        let mut end = 0.0;
        let lamps: Vec<_> = flux
            .into_iter()
            .map(|(light, power)| {
                let chance = (power / total) as f32;
                end += f64::from(chance);
                (light, chance, end)
            })
            .collect();
        let any = total.is_finite() && !lamps.is_empty() && radius.is_finite();
        any.then_some(Self { lamps, middle, radius })
    }

    /// Starts a light path. Returns `None` if no light goes that way. The power of one from a light that
    /// is shaded where rays arrive is that of a radiance of 1.
    pub fn start(&self, lights: &Lights, u: Numbers) -> Option<Emitted> {
        let at = f64::from(u.choice) * self.lamps.last()?.2;
        let place = self.lamps.partition_point(|lamp| lamp.2 <= at).min(self.lamps.len() - 1);
        let (light, chance, _) = self.lamps[place];
        lights[light as usize].with(Start { from: self, lights, light, chance, u })
    }
}

/// An estimate of the power that a lamp sends into a sphere; 0 only if it sends none.
fn power(bounds: &LightBounds, radius: f32) -> f64 {
    let share = match () {
        () if bounds.is_distant => PI * radius * radius,
        () if bounds.is_flat => PI * if bounds.two_sided { 2.0 } else { 1.0 },
        () => TAU * versine(bounds.spread),
    };
    f64::from(bounds.energy) * f64::from(share)
}

/// Returns 1 - cos of an angle.
fn versine(angle: f32) -> f32 {
    let sine = libm::sinf(angle * 0.5);
    2.0 * sine * sine
}

struct Start<'a> {
    from: &'a Everywhere,
    lights: &'a Lights,
    light: u32,
    chance: f32,
    u: Numbers,
}

impl WithLamp for Start<'_> {
    type Output = Option<Emitted>;

    fn run<L: Lamp>(self, lamp: L) -> Option<Emitted> {
        let Self { from: &Everywhere { middle, radius, .. }, lights, light, chance, u } = self;
        let lamp = Moving { lamp, pose: lights.pose(light, u.time) };
        let bounds = lamp.bounds();
        // With the density of the origin and the direction.
        let (origin, direction, density) = if L::IS_DISTANT {
            let way = lamp.way(middle, u.place);
            let ([a, b], (x, y)) = (concentric_disc(u.direction), pair(way));
            let on_disc = middle + (x * a + y * b) * radius;
            let by_way = if L::IS_DELTA { 1.0 } else { lamp.density(middle, way) };
            let area = PI * radius * radius;
            (on_disc + way * radius, -way, by_way / area)
        } else if L::IS_DELTA {
            let rim = versine(bounds.spread);
            (lamp.place(u.place), cone::about(bounds.axis, rim, u.direction).0, cone::density(rim))
        } else {
            let place = lamp.place(u.place);
            let normal = lamp.normal(place);
            let (direction, sides) = match () {
                () if bounds.two_sided && !L::IS_CLOSED => (both_sides(normal, u.direction), 2.0),
                () => (by_cosine(normal, u.direction), 1.0),
            };
            // Per projected solid angle.
            (place, direction, FRAC_1_PI / (sides * lamp.area()))
        };
        let direction = direction * (1.0 / direction.length());
        let density = chance * density;
        let power = lamp.radiance(-direction) / density;
        let origin = if L::IS_DELTA || L::IS_DISTANT {
            origin
        } else {
            // Off the lamp, as far as rays to it end before it.
            let out = origin + direction * radius;
            let (back, end) = lamp.shadow_ray(out, origin);
            out + back * end
        };
        let is_sent = power.max_element() > 0.0 && power.is_finite() && origin.is_finite();
        is_sent.then_some(Emitted { origin, direction, power, density, light })
    }
}

/// Samples directions about a normal by the cosine.
fn by_cosine(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    both_sides(normal, [u * 0.5, v])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_what_lamps_send() {
        let point = LightBounds::all_round([Vec3::ZERO; 2], 3.0);
        assert!((power(&point, 5.0) - f64::from(4.0 * PI * 3.0)).abs() < 1e-4);
        let flat = LightBounds::flat(&[Vec3::ZERO, Vec3::ONE], Vec3::Z, true, 3.0);
        assert!((power(&flat, 5.0) - f64::from(2.0 * PI * 3.0)).abs() < 1e-4);
        let sun = LightBounds { is_distant: true, ..point };
        assert!((power(&sun, 2.0) - f64::from(PI * 4.0 * 3.0)).abs() < 1e-4);
    }
}
