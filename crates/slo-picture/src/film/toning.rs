//! What a screen gets of radiance before the transfer curve: exposure and tone map.

use slo_scene::{Look, ToneMap};

use super::agx::agx;

/// The exposure and the tone map of a [`Look`], ready to be applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toning {
    /// Factor of the exposure.
    pub(super) scale: f32,
    pub(super) map: ToneMap,
}

impl Toning {
    /// Of a look.
    pub fn of(look: Look) -> Self {
        // Whole stops are exact powers of two.
        Self { scale: libm::exp2f(look.exposure), map: look.tone_map }
    }

    /// Linear light of the screen for finite radiance: 1 is white. Brighter light stays brighter without a
    /// tone map, and nothing becomes infinite.
    #[inline]
    pub fn apply(&self, radiance: [f32; 3]) -> [f32; 3] {
        let exposed = radiance.map(|c| (c * self.scale).clamp(f32::MIN, f32::MAX));
        match self.map {
            ToneMap::None => exposed,
            ToneMap::Agx => agx(exposed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn toned(exposure: f32, tone_map: ToneMap, radiance: [f32; 3]) -> [f32; 3] {
        Toning::of(Look { exposure, tone_map, ..Look::default() }).apply(radiance)
    }

    #[test]
    fn stops_double_the_light() {
        let rgb = [0.1, 0.7, 3.0];
        assert_eq!(toned(0.0, ToneMap::None, rgb), rgb);
        assert_eq!(toned(2.0, ToneMap::None, rgb), rgb.map(|c| c * 4.0));
        assert_eq!(toned(-1.0, ToneMap::None, rgb), rgb.map(|c| c / 2.0));
        assert_eq!(toned(32.0, ToneMap::None, [f32::MAX; 3]), [f32::MAX; 3]);
    }

    #[test]
    fn light_is_exposed_before_it_is_mapped() {
        assert_eq!(toned(3.0, ToneMap::Agx, [0.25, 0.5, 1.0]), agx([2.0, 4.0, 8.0]));
    }
}
