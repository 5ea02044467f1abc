//! How much light surfaces of microfacets reflect: exact for dielectrics, and as artists set it.

use glam::Vec3;

/// The share of unpolarised light that the border of two dielectrics reflects, at cosine `cos >= 0`
/// of the angle to the normal. `eta` is the index of refraction beyond the border divided by the
/// one on this side. It is 1 beyond the critical angle, and 0 if `eta` is 1.
#[inline(always)]
pub(super) fn dielectric(cos: f32, eta: f32) -> f32 {
    let cos_t = cos_refracted(cos, eta);
    let part = |a: f32, b: f32| (a - b) / (a + b).max(f32::MIN_POSITIVE);
    let (s, p) = (part(cos, eta * cos_t), part(eta * cos, cos_t));
    0.5 * (s * s + p * p)
}

/// The cosine of the refracted ray's angle to the normal; 0 beyond the critical angle.
#[inline(always)]
pub(super) fn cos_refracted(cos: f32, eta: f32) -> f32 {
    ((eta - 1.0) * (eta + 1.0) + cos * cos).max(0.0).sqrt() / eta
}

/// [`dielectric`] along the normal.
#[inline(always)]
pub(super) fn normal_incidence(eta: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    root * root
}

/// The index that reflects a share of `f0` along the normal: at least 1.
#[inline(always)]
pub(super) fn index_of(f0: f32) -> f32 {
    let root = f0.clamp(0.0, 0.99).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// Where the reflection of a dielectric is between that along the normal, 0, and that at grazing
/// angles, 1.
#[inline(always)]
pub(super) fn between(cos: f32, eta: f32) -> f32 {
    let f0 = normal_incidence(eta);
    ((dielectric(cos, eta) - f0) / (1.0 - f0)).clamp(0.0, 1.0)
}

/// The reflection of a metal by the F82 tint model: Schlick's curve from `f0`, bent so that it is
/// multiplied by `tint` at a cosine of 1/7.
///
/// Source: N. Hoffman, "Generalization of Adobe's Fresnel Model" (2023).
#[derive(Clone, Copy, Debug)]
pub(super) struct Metal {
    /// Reflection along the normal.
    pub(super) f0: Vec3,
    /// Factor of the bend.
    pub(super) bend: Vec3,
}

impl Metal {
    #[inline(always)]
    pub(super) fn new(f0: Vec3, tint: Vec3) -> Self {
        // At a cosine of 1/7: (1 - 1/7)^5, and 7 / (1 - 1/7)^6.
        const FIFTH: f32 = 7776.0 / 16807.0;
        const BEND: f32 = 7.0 * 117_649.0 / 46_656.0;
        let there = f0 + (Vec3::ONE - f0) * FIFTH;
        Self { f0, bend: there * (Vec3::ONE - tint) * BEND }
    }

    #[inline(always)]
    pub(super) fn at(self, cos: f32) -> Vec3 {
        let left = (1.0 - cos).max(0.0);
        let square = left * left;
        let fifth = square * square * left;
        let bent = self.f0 + (Vec3::ONE - self.f0) * fifth - self.bend * (cos * fifth * left);
        bent.max(Vec3::ZERO).min(Vec3::ONE)
    }

    /// The mean over all directions, weighted by the cosine.
    #[inline(always)]
    pub(super) fn mean(self) -> Vec3 {
        let mean = self.f0 + (Vec3::ONE - self.f0) * (1.0 / 21.0) - self.bend * (1.0 / 126.0);
        mean.max(Vec3::ZERO).min(Vec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cos(degrees: f64) -> f32 {
        libm::cos(degrees.to_radians()) as f32
    }

    #[test]
    fn dielectrics() {
        for (degrees, expected) in [(0.0, 0.04), (60.0, 0.089_187), (80.0, 0.387_704)] {
            let found = dielectric(cos(degrees), 1.5);
            assert!((found - expected).abs() < 2e-6, "{degrees}: {found} is not {expected}");
        }
        assert_eq!(dielectric(0.0, 1.5), 1.0);
        // From inside, beyond the critical angle of 41.8 degrees.
        assert_eq!(dielectric(cos(42.0), 1.0 / 1.5), 1.0);
        assert!(dielectric(cos(41.0), 1.0 / 1.5) < 0.4);
        for c in [0.0, 1e-6, 0.3, 1.0] {
            assert!(dielectric(c, 1.0) < 1e-6);
            assert!(between(c, 1.0) < 1e-6);
        }
    }

    #[test]
    fn an_index_reflects_what_it_should() {
        for f0 in [0.0, 0.02, 0.04, 0.5] {
            assert!((normal_incidence(index_of(f0)) - f0).abs() < 1e-6);
        }
    }

    #[test]
    fn metals_are_tinted_near_grazing_angles() {
        let (f0, tint) = (Vec3::new(0.9, 0.5, 0.1), Vec3::new(0.5, 1.0, 0.6));
        let metal = Metal::new(f0, tint);
        let schlick = f0 + (Vec3::ONE - f0) * (7776.0 / 16807.0);
        assert!((metal.at(1.0 / 7.0) - schlick * tint).abs().max_element() < 1e-5);
        assert!((metal.at(1.0) - f0).abs().max_element() < 1e-6);
        assert!((metal.at(0.0) - Vec3::ONE).abs().max_element() < 1e-6);
        let mean = (0..1000).map(|i| {
            let cos = (i as f32 + 0.5) / 1000.0;
            metal.at(cos) * (2.0 * cos / 1000.0)
        });
        assert!((mean.sum::<Vec3>() - metal.mean()).abs().max_element() < 1e-4);
    }
}
