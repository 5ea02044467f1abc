//! Warps: map points of the unit square to other domains.

use glam::Vec3;

use slo_accel::math::elementary::{power, sin_cos_octant, sin_cos_turns};

/// Maps the unit square to the unit disc. Area is preserved up to a constant factor, and neighbours
/// stay neighbours.
///
/// Source: P. Shirley and K. Chiu, "A Low Distortion Map Between Disk and Square" (1997).
#[inline(always)]
pub fn concentric_disc(u: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let swap = a.abs() < b.abs();
    let (r, other) = if swap { (b, a) } else { (a, b) };
    let ratio = if r == 0.0 { 0.0 } else { other / r };
    let (s, c) = sin_cos_octant(ratio * std::f32::consts::FRAC_PI_4);
    if swap { [r * s, r * c] } else { [r * c, r * s] }
}

/// Returns a unit direction about +z, distributed with `pdf_solid_angle = (n + 1) / (2 pi) cos^n`,
/// where `n >= 0` and `inverse` is `1 / (n + 1)`.
#[inline(always)]
pub fn cosine_power_lobe(u: [f32; 2], inverse: f32) -> Vec3 {
    // 1 - u is never 0, so the direction never lies exactly in the plane.
    let cos = power(1.0 - u[0], inverse);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = sin_cos_turns(u[1]);
    Vec3::new(sin * c, sin * s, cos)
}

/// Returns `1 / (n + 1)` of the cos^n lobe with spread `sigma`, where n = 1 / sigma^2; 0 for a
/// perfect mirror.
pub fn lobe_inverse(sigma: f32) -> f32 {
    let s2 = sigma * sigma;
    s2 / (1.0 + s2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chi-square statistic of `counts` against equal expectation, in standard deviations above its
    /// mean.
    fn deviation(counts: &[u32]) -> f64 {
        let expected = f64::from(counts.iter().sum::<u32>()) / counts.len() as f64;
        let chi2: f64 =
            counts.iter().map(|&c| (f64::from(c) - expected).powi_2() / expected).sum::<f64>();
        let freedom = (counts.len() - 1) as f64;
        (chi2 - freedom) / (2.0 * freedom).sqrt()
    }

    trait Square {
        fn powi_2(self) -> f64;
    }
    impl Square for f64 {
        fn powi_2(self) -> f64 {
            self * self
        }
    }

    fn uniform(i: u32) -> [f32; 2] {
        let sampler = crate::sampling::Sampler::new(crate::sampling::Generator::Pseudo, 5, 0);
        sampler.camera(sampler.pixel(i, 0), 0).lens
    }

    /// Chi-square deviation over 16 rings of equal probability times 16 sectors.
    fn check(cell: impl Fn([f32; 2]) -> (f64, f64)) -> f64 {
        let mut counts = [0; 256];
        for i in 0..100_000 {
            let (ring, sector) = cell(uniform(i));
            let at = |x: f64| ((x * 16.0) as usize).min(15);
            counts[at(ring) * 16 + at(sector)] += 1;
        }
        deviation(&counts)
    }

    fn turn(x: f32, y: f32) -> f64 {
        libm::atan2(f64::from(y), f64::from(x)) / std::f64::consts::TAU + 0.5
    }

    #[test]
    fn the_disc_is_uniform() {
        let d = check(|u| {
            let [x, y] = concentric_disc(u);
            (f64::from(x * x + y * y), turn(x, y))
        });
        assert!(d < 5.0, "{d}");
        // A planted bias, points squeezed toward the centre, must be detected.
        let planted = check(|u| {
            let [x, y] = concentric_disc(u);
            (f64::from((x * x + y * y) * 0.97), turn(x, y))
        });
        assert!(planted > 5.0, "{planted}");
    }

    #[test]
    fn lobes_have_their_density() {
        for sigma in [1.0f32, 0.5, 0.1] {
            let n = f64::from(1.0 / (sigma * sigma));
            let d = check(|u| {
                let w = cosine_power_lobe(u, lobe_inverse(sigma));
                assert!((w.length() - 1.0).abs() < 1e-5);
                // The distribution function of cos^n over the hemisphere is 1 - cos^(n+1).
                (1.0 - libm::pow(f64::from(w.z), n + 1.0), turn(w.x, w.y))
            });
            assert!(d < 5.0, "sigma {sigma}: {d}");
        }
    }
}
