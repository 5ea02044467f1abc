//! What a picture shows of surfaces, whatever light falls on them: for denoisers.

use std::ops::AddAssign;

use super::fixed::SignedFixed;

/// Sums of what a pixel's samples saw of surfaces; exact, as the sums of [`Pixel`](super::Pixel).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// See [`Layer::Albedo`](slo_scene::Layer::Albedo); red, green, blue.
    pub albedo: [SignedFixed; 3],
    /// See [`Layer::Normal`](slo_scene::Layer::Normal); x, y, z.
    pub normal: [SignedFixed; 3],
}

impl Features {
    /// The mean of the albedo, of so many samples.
    pub(super) fn mean_albedo(&self, samples: u32) -> [f32; 3] {
        mean(self.albedo, samples, [0.0, 1.0])
    }

    /// The mean of the normal, of so many samples.
    pub(super) fn mean_normal(&self, samples: u32) -> [f32; 3] {
        mean(self.normal, samples, [-1.0, 1.0])
    }

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

/// The mean of so many samples, in a range.
fn mean(sum: [SignedFixed; 3], samples: u32, [least, most]: [f32; 2]) -> [f32; 3] {
    let samples = f64::from(samples.max(1));
    sum.map(|sum| ((sum.to_f64() / samples) as f32).clamp(least, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fixed(values: [f32; 3]) -> [SignedFixed; 3] {
        values.map(SignedFixed::clamped)
    }

    #[test]
    fn means_stay_in_their_range() {
        let mut sum = Features::default();
        for _ in 0..4 {
            let (albedo, normal) = (fixed([0.25, 2.0, 0.0]), fixed([-3.0, 0.5, 0.0]));
            sum += Features { albedo, normal };
        }
        assert_eq!(sum.mean_albedo(4), [0.25, 1.0, 0.0]);
        assert_eq!(sum.mean_normal(4), [-1.0, 0.5, 0.0]);
        assert_eq!(Features::default().mean_albedo(0), [0.0; 3]);
    }

    #[test]
    fn what_is_too_large_is_no_sum() {
        let mut huge = Features::default();
        huge.normal[2] = SignedFixed::MAX;
        assert_eq!(huge.checked_add(&Features::default()), Some(huge));
        let one = Features { normal: fixed([0.0, 0.0, 1.0]), ..Features::default() };
        assert_eq!(huge.checked_add(&one), None);
    }
}
