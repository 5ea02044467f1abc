//! The choice of one light of many.

use glam::Vec3;

/// Chooses lights.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    count: u32,
}

/// A light that was chosen at random.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// Index of the light; `u32::MAX` if no light can reach the hit.
    pub light: u32,
    /// Its probability.
    pub chance: f32,
    /// The random number, rescaled after the choice to be uniform again.
    pub rest: f32,
}

impl LightTree {
    /// Arranges `count` lights.
    pub fn new(count: usize) -> Self {
        Self { count: count as u32 }
    }

    /// Chooses a light for a hit at `from` with a packed normal, by a random number.
    #[inline(always)]
    pub fn choose(&self, _from: Vec3, _normal: u32, u: f32) -> Chosen {
        let scaled = u * self.count as f32;
        let light = (scaled as u32).min(self.count.wrapping_sub(1));
        Chosen { light, chance: 1.0 / self.count as f32, rest: scaled - light as f32 }
    }

    /// Returns the probability with which [`choose`](Self::choose) chooses a light.
    #[inline(always)]
    pub fn chance(&self, _light: u32, _from: Vec3, _normal: u32) -> f32 {
        1.0 / self.count as f32
    }
}
