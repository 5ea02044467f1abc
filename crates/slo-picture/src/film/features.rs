//! What a picture shows of surfaces, whatever light falls on them: for denoisers.

use std::ops::AddAssign;

use slo_scene::Layer;

use super::fixed::Fixed;

/// Sums of what a pixel's samples saw of surfaces; exact, as the sums of [`Pixel`](super::Pixel).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// See [`Layer::Albedo`]; red, green, blue.
    pub albedo: [Fixed; 3],
    /// See [`Layer::Normal`]; x, y, z.
    pub normal: [Fixed; 3],
}

impl Features {
    /// The sum of two; `None` on overflow.
    pub fn checked_add(&self, other: &Self) -> Option<Self> {
        let mut result = *self;
        for c in 0..3 {
            result.albedo[c] = self.albedo[c].checked_add(other.albedo[c])?;
            result.normal[c] = self.normal[c].checked_add(other.normal[c])?;
        }
        Some(result)
    }
}

impl AddAssign for Features {
    fn add_assign(&mut self, other: Self) {
        for c in 0..3 {
            self.albedo[c] += other.albedo[c];
            self.normal[c] += other.normal[c];
        }
    }
}

/// The least and the largest value.
fn range(layer: Layer) -> (f32, f32) {
    match layer {
        Layer::Albedo => (0.0, 1.0),
        Layer::Normal => (-1.0, 1.0),
    }
}

/// The mean of a pixel's samples.
pub(super) fn mean(layer: Layer, features: &Features, samples: u32) -> [f32; 3] {
    let sum = match layer {
        Layer::Albedo => features.albedo,
        Layer::Normal => features.normal,
    };
    let (low, high) = range(layer);
    let samples = f64::from(samples.max(1));
    sum.map(|sum| ((sum.to_f64() / samples) as f32).clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fixed(values: [f32; 3]) -> [Fixed; 3] {
        values.map(|value| Fixed::new(value).unwrap())
    }

    #[test]
    fn means_stay_in_their_range() {
        let mut sum = Features::default();
        for _ in 0..4 {
            let (albedo, normal) = (fixed([0.25, 2.0, 0.0]), fixed([-3.0, 0.5, 0.0]));
            sum += Features { albedo, normal };
        }
        assert_eq!(mean(Layer::Albedo, &sum, 4), [0.25, 1.0, 0.0]);
        assert_eq!(mean(Layer::Normal, &sum, 4), [-1.0, 0.5, 0.0]);
        assert_eq!(mean(Layer::Albedo, &Features::default(), 0), [0.0; 3]);
    }

    #[test]
    fn what_is_too_large_is_no_sum() {
        let mut huge = Features::default();
        huge.normal[2] = Fixed::MAX;
        assert_eq!(huge.checked_add(&Features::default()), Some(huge));
        let one = Features { normal: fixed([0.0, 0.0, 1.0]), ..Features::default() };
        assert_eq!(huge.checked_add(&one), None);
    }
}
