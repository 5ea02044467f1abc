//! Phong's highlight: the mirror image of lamps, spread.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column};
use slo_accel::math::elementary::power;

use super::lobe::{At, Lobe, Sampled, Scattered, Share};

/// k_s (E.R)^shininess, without a cosine. It shows lamps only. Its values are divided by pi, since
/// the thesis's lights give an irradiance of pi times their colour. Source: thesis 2.15.
#[derive(Debug)]
pub struct Highlight {
    share: Share,
    /// Exponents.
    pub shininess: Column<f32>,
}

impl Default for Highlight {
    fn default() -> Self {
        Self { share: Share::default(), shininess: [0.0; BATCH] }
    }
}

impl Lobe for Highlight {
    const IS_DIFFUSE: bool = true;
    const IS_FOLLOWED: bool = false;

    fn share(&self) -> &Share {
        &self.share
    }

    fn share_mut(&mut self) -> &mut Share {
        &mut self.share
    }

    #[inline(always)]
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered {
        let cos = at.n.dot(toward);
        let along = (2.0 * cos * at.n - toward).dot(at.eye).max(0.0);
        // x^0 is 1 for every x.
        let shininess = self.shininess[i];
        let spread = if shininess == 0.0 { 1.0 } else { power(along, shininess) };
        let is_lit = (cos > 0.0) & (at.n_geo.dot(toward) > 0.0);
        let value = self.share.weight.get(i) * (spread * std::f32::consts::FRAC_1_PI);
        Scattered { value: if is_lit { value } else { Vec3::ZERO }, density: 0.0 }
    }

    #[inline(always)]
    fn sample(&self, _i: usize, at: &At, _u: [f32; 3]) -> Sampled {
        Sampled { direction: at.n, weight: Vec3::ZERO, density: 0.0 }
    }
}
