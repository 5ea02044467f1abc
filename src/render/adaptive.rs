//! How many samples a pixel takes: blocks that double, and the tests after each block.

use crate::film::{Fixed, Pixel};
use crate::integrator::SampleSum;
use crate::scene::{Contrast, Settings};

/// First block where only a noise level is asked for: fewer samples tell no variance.
const LEAST_FOR_NOISE: u32 = 16;

/// When a pixel is done.
#[derive(Clone, Copy, Debug)]
pub(super) struct SamplePlan {
    least: u32,
    most: u32,
    rule: Option<Rule>,
}

/// What makes a pixel go on.
#[derive(Clone, Copy, Debug)]
enum Rule {
    /// A contrast above a limit.
    Contrast(Contrast, f32),
    /// An estimated standard error above a limit.
    Noise(f32),
}

impl SamplePlan {
    pub(super) fn new(settings: &Settings) -> Self {
        let most = settings.image_samples.saturating_mul(settings.dof_samples).max(1);
        let least = settings.image_min_samples.saturating_mul(settings.dof_samples).clamp(1, most);
        let rule = match settings.noise {
            Some(error) => Some(Rule::Noise(error)),
            None if least < most => {
                Some(Rule::Contrast(settings.contrast, settings.image_contrast_limit))
            }
            None => None,
        };
        // A noise level alone makes a picture adaptive.
        let least = if settings.noise.is_some() && least == most {
            LEAST_FOR_NOISE.min(most)
        } else {
            least
        };
        Self { least, most, rule }
    }

    /// Whether pixels may take different numbers of samples.
    pub(super) fn is_adaptive(&self) -> bool {
        self.rule.is_some() && self.least < self.most
    }

    /// Number of samples that a pixel has after each block.
    pub(super) fn block_ends(&self) -> impl Iterator<Item = u32> + use<> {
        let (least, most) = (self.least, self.most);
        let next = move |&end: &u32| (end < most).then(|| end.saturating_mul(2).min(most));
        std::iter::successors(Some(least), next)
    }

    /// Whether a pixel wants another block.
    ///
    /// Source: thesis 5.12 to 5.14, in each channel. Every contrast is largest for the smallest or
    /// the largest sample, so that these two stand for all.
    pub(super) fn needs_more(&self, pixel: &Pixel, spread: &Spread) -> bool {
        match self.rule {
            None => false,
            Some(Rule::Noise(error)) => spread.standard_error(pixel) > f64::from(error),
            Some(Rule::Contrast(kind, limit)) => {
                let mean = pixel.mean();
                (0..3).any(|channel| {
                    [spread.least[channel], spread.most[channel]]
                        .into_iter()
                        .any(|sample| contrast(kind, sample.to_f64() as f32, mean[channel]) > limit)
                })
            }
        }
    }
}

/// How far a pixel's samples lie apart, by channel; exact, so that it does not depend on the order
/// of the samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    least: [Fixed; 3],
    most: [Fixed; 3],
    /// Sum of the squares, in units of 2^-48.
    squares: [i128; 3],
}

impl Default for Spread {
    fn default() -> Self {
        Self { least: [Fixed::MAX; 3], most: [Fixed::MIN; 3], squares: [0; 3] }
    }
}

impl Spread {
    /// Adds samples.
    pub(super) fn add(&mut self, sums: &[SampleSum]) {
        for sum in sums {
            for (channel, &value) in sum.iter().enumerate() {
                self.least[channel] = self.least[channel].min(value);
                self.most[channel] = self.most[channel].max(value);
                self.squares[channel] += value.squared();
            }
        }
    }

    /// Estimated standard error of the mean of the pixel that these samples are of, in the worst
    /// channel, as if its samples were independent: an upper bound for stratified ones.
    fn standard_error(&self, pixel: &Pixel) -> f64 {
        let n = f64::from(pixel.samples);
        let variance = |channel: usize| {
            let mean = pixel.sum[channel].to_f64() / n;
            let square = self.squares[channel] as f64 / (1u64 << 48) as f64 / n;
            (square - mean * mean).max(0.0) / (n - 1.0).max(1.0)
        };
        (0..3).map(variance).fold(0.0, f64::max).sqrt()
    }
}

/// Contrast of a sample with the mean; 0 where both are 0. Source: thesis 5.12 to 5.14.
fn contrast(kind: Contrast, sample: f32, mean: f32) -> f32 {
    let difference = (sample - mean).abs();
    if difference == 0.0 {
        return 0.0;
    }
    match kind {
        Contrast::Difference => difference,
        Contrast::Weber => difference / mean,
        Contrast::Michelson => difference / (sample + mean),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums(values: &[f32]) -> (Pixel, Spread) {
        let (mut pixel, mut spread) = (Pixel::default(), Spread::default());
        for &value in values {
            let sum = [Fixed::new(value).unwrap(); 3];
            spread.add(&[sum]);
            pixel.samples += 1;
            (0..3).for_each(|c| pixel.sum[c] += sum[c]);
        }
        (pixel, spread)
    }

    #[test]
    fn contrasts_are_those_of_the_thesis() {
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} {b}");
        close(contrast(Contrast::Difference, 0.75, 0.5), 0.25);
        close(contrast(Contrast::Weber, 0.75, 0.5), 0.5);
        close(contrast(Contrast::Michelson, 0.75, 0.5), 0.2);
        for kind in [Contrast::Difference, Contrast::Weber, Contrast::Michelson] {
            close(contrast(kind, 0.0, 0.0), 0.0);
        }
    }

    #[test]
    fn blocks_double_up_to_all_samples() {
        let settings = Settings {
            image_samples: 50,
            image_min_samples: 4,
            dof_samples: 2,
            ..Settings::default()
        };
        let plan = SamplePlan::new(&settings);
        assert_eq!(plan.block_ends().collect::<Vec<_>>(), [8, 16, 32, 64, 100]);
        let plan = SamplePlan::new(&Settings { image_min_samples: 50, ..settings });
        assert_eq!(plan.block_ends().collect::<Vec<_>>(), [100]);
        assert!(!plan.is_adaptive());
    }

    #[test]
    fn a_pixel_goes_on_while_a_sample_stands_out() {
        let settings =
            Settings { image_min_samples: 4, image_contrast_limit: 0.3, ..Settings::default() };
        let plan = SamplePlan::new(&settings);
        let goes_on = |values: &[f32]| {
            let (pixel, spread) = sums(values);
            plan.needs_more(&pixel, &spread)
        };
        assert!(!goes_on(&[0.5, 0.5, 0.5, 0.5]));
        assert!(!goes_on(&[0.5, 0.5, 0.5, 0.7]));
        assert!(goes_on(&[0.5, 0.5, 0.5, 1.0]));
        assert!(goes_on(&[0.5, 0.5, 0.5, 0.0]));
    }

    #[test]
    fn noise_is_the_standard_error_of_the_mean() {
        let values: Vec<f32> = (0..100).map(|i| (i % 2) as f32).collect();
        let (pixel, spread) = sums(&values);
        // Variance 1/4, of the mean 1/4 / 99.
        assert!((spread.standard_error(&pixel) - (0.25f64 / 99.0).sqrt()).abs() < 1e-9);
        let plan = |noise| {
            SamplePlan::new(&Settings {
                noise: Some(noise),
                image_samples: 64,
                ..Settings::default()
            })
        };
        assert!(plan(0.04).needs_more(&pixel, &spread));
        assert!(!plan(0.06).needs_more(&pixel, &spread));
        assert!(plan(0.06).is_adaptive());
    }
}
