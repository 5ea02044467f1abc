//! Hits on one material, seen from several directions.

use glam::{DVec3, Vec3};
use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Vec3s};

use crate::shading::bsdf::{At, Bsdf, Lobe, Sampled, WithLobe, principled};
use crate::shading::material::principled::Parameters;

/// A material with the defaults of the scene language.
pub(super) fn defaults() -> Box<Parameters> {
    let mut p = Box::<Parameters>::default();
    color(&mut p.base_color, [0.8; 3]);
    for white in [&mut p.specular_tint, &mut p.coat_tint, &mut p.sheen_tint] {
        color(white, [1.0; 3]);
    }
    p.roughness = [0.5; BATCH];
    p.ior = [1.5; BATCH];
    p.alpha = [1.0; BATCH];
    p.specular_ior_level = [0.5; BATCH];
    p.coat_roughness = [0.03; BATCH];
    p.coat_ior = [1.5; BATCH];
    p.sheen_roughness = [0.5; BATCH];
    p
}

/// The defaults, changed.
pub(super) fn material(change: impl FnOnce(&mut Parameters)) -> Box<Parameters> {
    let mut p = defaults();
    change(&mut p);
    p
}

/// Sets a colour at all hits.
pub(super) fn color(to: &mut Vec3s, rgb: [f32; 3]) {
    (to.x, to.y, to.z) = ([rgb[0]; BATCH], [rgb[1]; BATCH], [rgb[2]; BATCH]);
}

/// A unit direction at `degrees` to +z, `turn` of a turn about it.
pub(super) fn direction(degrees: f64, turn: f64) -> Vec3 {
    let (theta, phi) = (degrees.to_radians(), turn * std::f64::consts::TAU);
    let (sin, cos) = (libm::sin(theta), libm::cos(theta));
    DVec3::new(sin * libm::cos(phi), sin * libm::sin(phi), cos).as_vec3()
}

/// Hits on a plane, one for each eye.
pub(super) struct Hits {
    pub(super) bsdf: Box<Bsdf>,
    pub(super) at: Vec<At>,
}

impl Hits {
    pub(super) fn new(parameters: &Parameters, eyes: &[Vec3], outside: bool) -> Self {
        let (n, tangent) = (Vec3::Z, Vec3::X);
        Self::of(
            parameters,
            eyes.iter()
                .map(|&eye| At { eye, n, n_geo: n, floor: n, is_bent: false, tangent })
                .collect(),
            outside,
        )
    }

    pub(super) fn of(parameters: &Parameters, at: Vec<At>, outside: bool) -> Self {
        let mut bsdf = Box::<Bsdf>::default();
        let mut emitted = Box::<Vec3s>::default();
        let from_outside = [u32::from(outside); BATCH];
        bsdf.clear();
        let get = |i: usize| at[i.min(at.len() - 1)];
        let (isa, len) = (Isa::best(), at.len());
        principled(parameters, get, &from_outside, |_| true, len, isa, &mut bsdf, &mut emitted);
        Self { bsdf, at }
    }

    /// The share of light that hit `i` scatters in all, by `count` samples of each lobe. Light that
    /// passes counts by its flux instead of its radiance, and `eta` is the index beyond.
    pub(super) fn albedo(&self, i: usize, eta: f64, count: u32) -> DVec3 {
        struct Sum<'a>(&'a At, usize, f64, u32, DVec3);
        impl WithLobe for Sum<'_> {
            fn run<L: Lobe>(&mut self, lobe: &L) {
                let Self(at, i, eta, count, sum) = self;
                for k in 0..*count {
                    let Sampled { direction, weight, .. } = lobe.sample(*i, at, point(k, *count));
                    let flux = if direction.z < 0.0 { *eta * *eta } else { 1.0 };
                    *sum += weight.as_dvec3() * (flux / f64::from(*count));
                }
            }
        }
        let mut sum = Sum(&self.at[i], i, eta, count, DVec3::ZERO);
        self.bsdf.for_each(&mut sum);
        sum.4
    }
}

/// Point `k` of `count` well distributed ones in the unit cube.
pub(super) fn point(k: u32, count: u32) -> [f32; 3] {
    // The powers of the root of x³ = x + 1.
    let part = |root: f64| ((0.5 + f64::from(k) * root) % 1.0) as f32;
    let first = (f64::from(k) + 0.5) / f64::from(count);
    [part(0.754_877_666_246_692_8), part(0.569_840_290_998_053_3), (first as f32).min(0.999_999_9)]
}
