//! Plans how many samples a pixel takes, and which pixels and samples this run takes.

use std::ops::Range;

use slo_accel::Isa;
use slo_picture::film::{
    Area, BLOCK, Display, Film, Fixed, LEAST_FOR_NOISE, Pixel, Spread, Steps, TILE,
};
use slo_scene::{Contrast, SceneDescription, Settings};

/// Number of samples from which a block must reach the full demanded error. With fewer samples it
/// must reach less.
pub(super) const FULL_ERROR_AT: u32 = 256;

/// Error demanded by the first step that measures errors.
const FIRST_ERROR: f32 = 0.2;

/// When a pixel is done, and which of the picture's samples to take.
///
/// How many samples a pixel takes depends only on its own samples, or on the samples of its block.
/// It does not depend on the run that took them, or on other parts of the picture.
#[derive(Clone, Debug)]
pub struct Plan {
    least: u32,
    most: u32,
    rule: Rule,
    display: Display,
    part: Option<Part>,
    samples: Option<Range<u32>>,
    steps: Option<Steps>,
}

/// The reason for more samples after the first `least`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// No reason: all pixels take the same number.
    Uniform,
    /// A contrast above a limit.
    Contrast(Contrast, f32),
    /// An estimated error of the pixel's block at or above a [share](error_share) of a limit.
    Noise(f32),
}

/// A share of a picture: of its tiles, spread over all of it, or of the samples of each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Number of the share, from 1 to `of`.
    pub number: u32,
    /// Number of shares, 1 or more.
    pub of: u32,
}

impl Plan {
    /// Creates the plan of all samples of all pixels that the scene asks for.
    pub fn new(scene: &SceneDescription) -> Self {
        let settings = &scene.settings;
        let most = settings.image_samples.saturating_mul(settings.dof_samples).max(1);
        let least = settings.image_min_samples.saturating_mul(settings.dof_samples).clamp(1, most);
        let rule = rule(settings, least < most);
        let least = match rule {
            Rule::Uniform => most,
            // A noise level alone makes a picture adaptive.
            Rule::Noise(_) if least == most => LEAST_FOR_NOISE.min(most),
            _ => least,
        };
        let display = Display::of(scene.camera.film.output, scene.camera.film.look(settings));
        Self { least, most, rule, display, part: None, samples: None, steps: None }
    }

    /// Returns the fewest camera samples that a pixel takes.
    pub fn least(&self) -> u32 {
        // Step 0 is one sample, see `at_step`.
        if self.steps.is_some() { 1 } else { self.least }
    }

    /// Restricts the plan to a share of the tiles.
    #[must_use]
    pub fn of_part(self, part: Part) -> Self {
        Self { part: Some(part), ..self }
    }

    /// Restricts the plan to a share of each pixel's samples; `None` if their number depends on the
    /// picture.
    pub fn of_samples(self, part: Part) -> Option<Self> {
        let border =
            |k: u32| (u64::from(self.most) * u64::from(k) / u64::from(part.of.max(1))) as u32;
        let samples = border(part.number.saturating_sub(1))..border(part.number);
        (self.rule == Rule::Uniform).then_some(Self { samples: Some(samples), ..self })
    }

    /// Replaces the scene's rule: the plan exposes step by step up to `steps`.
    #[must_use]
    pub fn in_steps(self, steps: Steps) -> Self {
        let least = LEAST_FOR_NOISE.min(self.most);
        Self { steps: Some(steps), rule: Rule::Noise(FIRST_ERROR), least, ..self }
    }

    /// Returns the plan of one tile.
    pub(super) fn at(&self, tile: Area, width: u32, height: u32) -> Self {
        match self.steps {
            Some(steps) => self.at_step(steps.of(tile, width, height)),
            None => self.clone(),
        }
    }

    /// Returns the plan of a tile at a step, see [`Steps`].
    pub(super) fn at_step(&self, step: u32) -> Self {
        let (least, most, rule) = match step {
            0..=3 => {
                let samples = self.most.min(1 << step);
                (samples, samples, Rule::Uniform)
            }
            _ => {
                let (whole, half) = ((step - 4) / 2, (step - 4) % 2);
                let error = FIRST_ERROR / (1u32 << whole.min(31)) as f32;
                let error = if half == 1 { error * std::f32::consts::FRAC_1_SQRT_2 } else { error };
                (LEAST_FOR_NOISE.min(self.most), self.most, Rule::Noise(error))
            }
        };
        Self { least, most, rule, steps: None, ..self.clone() }
    }

    /// Returns the range of the numbers of each pixel's samples if the plan takes a share of them.
    pub fn samples(&self) -> Option<Range<u32>> {
        self.samples.clone()
    }

    /// Whether the film must record the smallest and the largest sample of each pixel.
    pub fn needs_spreads(&self) -> bool {
        matches!(self.rule, Rule::Contrast(..))
    }

    /// Returns the display that errors of this picture are measured for.
    pub fn display(&self) -> Display {
        self.display
    }

    /// Returns the number of samples of every pixel if it is the same for all and known in advance.
    pub(super) fn uniform(&self) -> Option<u32> {
        (self.rule == Rule::Uniform).then(|| match &self.samples {
            Some(range) => range.len() as u32,
            None => self.most,
        })
    }

    /// Returns the most samples that a pixel takes, including other shares.
    pub fn most(&self) -> u32 {
        self.most
    }

    /// Returns up to which number of samples, of those of this run, pixels go on that have `taken`
    /// samples, before it is decided which of them need more.
    pub(super) fn next_border(&self, taken: u32) -> u32 {
        self.uniform().unwrap_or_else(|| self.rung_after(taken))
    }

    /// Whether this run takes a tile.
    pub(super) fn includes(&self, tile: Area, width: u32) -> bool {
        self.part.is_none_or(|Part { number, of }| {
            let columns = u64::from(width.div_ceil(TILE));
            let index = u64::from(tile.y0 / TILE) * columns + u64::from(tile.x0 / TILE);
            index % u64::from(of.max(1)) == u64::from(number.saturating_sub(1))
        })
    }

    /// Returns the side, in pixels, of the squares that take the same number of samples.
    pub(super) fn group_side(&self) -> u32 {
        if matches!(self.rule, Rule::Noise(_)) { BLOCK } else { 1 }
    }

    /// Returns the total number of samples that a group of pixels takes next; `None` if it is done.
    ///
    /// `group` holds indices of pixels of `film`.
    pub(super) fn next(
        &self,
        isa: Isa,
        film: &Film,
        group: &[u32],
        quarters: &[Range<usize>],
    ) -> Option<u32> {
        let first = group[0] as usize;
        let pixel = &film.pixels()[first];
        let taken = pixel.samples;
        if let Some(all) = self.uniform() {
            return (taken < all).then_some(all);
        }
        if taken >= self.most {
            return None;
        }
        let goes_on = !self.is_rung(taken)
            || match self.rule {
                Rule::Uniform => false,
                Rule::Contrast(kind, limit) => {
                    stands_out(kind, limit, pixel, &film.spreads()[first])
                }
                Rule::Noise(error) => {
                    self.error(isa, film, group, quarters) >= f64::from(error) * error_share(taken)
                }
            };
        goes_on.then(|| self.rung_after(taken))
    }

    /// Whether a pixel may be done after this number of samples.
    fn is_rung(&self, samples: u32) -> bool {
        samples == self.least || (samples > self.least && self.rung_after(samples - 1) == samples)
    }

    fn rung_after(&self, samples: u32) -> u32 {
        if samples < self.least {
            return self.least;
        }
        let next = match self.rule {
            Rule::Noise(_) => {
                let power = 1 << samples.max(1).ilog2();
                let middle = power + power / 2;
                if power > 1 && samples < middle { middle } else { power.saturating_mul(2) }
            }
            _ => {
                let doubled =
                    std::iter::successors(Some(self.least), |n| Some(n.saturating_mul(2)));
                doubled.take(33).find(|n| *n > samples).unwrap_or(u32::MAX)
            }
        };
        next.min(self.most)
    }

    /// Returns the error of a block as the viewer sees it: the root mean square over the pixels and
    /// channels of its worst quarter, so that small details are not lost in their surroundings.
    fn error(&self, isa: Isa, film: &Film, block: &[u32], quarters: &[Range<usize>]) -> f64 {
        let pixels = block.iter().map(|&i| &film.pixels()[i as usize]);
        let squares = self.display.squared_errors(isa, pixels);
        let mean = |quarter: &Range<usize>| {
            squares[quarter.clone()].iter().sum::<f64>() / quarter.len() as f64
        };
        quarters.iter().map(mean).fold(0.0, f64::max).sqrt()
    }
}

/// Returns the share of the demanded error that a block with `samples` per pixel must be below to
/// be done.
///
/// Equal error everywhere is not the least total error for a given time. One more sample reduces
/// the squared error by about the squared error divided by the number of samples. If this quotient
/// is equal everywhere, no sample would reduce the error more elsewhere. So a block with few
/// samples must reach a smaller error, proportional to the root of their number. Nowhere may the
/// error exceed the demanded one.
fn error_share(samples: u32) -> f64 {
    (f64::from(samples.min(FULL_ERROR_AT)) / f64::from(FULL_ERROR_AT)).sqrt()
}

fn rule(settings: &Settings, is_adaptive: bool) -> Rule {
    match settings.noise {
        Some(error) => Rule::Noise(error),
        None if is_adaptive => Rule::Contrast(settings.contrast, settings.image_contrast_limit),
        None => Rule::Uniform,
    }
}

/// Whether a sample of a pixel differs too much from the pixel's mean.
///
/// Source: thesis 5.12 to 5.14, in each channel. Every contrast is largest for the smallest or the
/// largest sample, so it is enough to test these two.
fn stands_out(kind: Contrast, limit: f32, pixel: &Pixel, spread: &Spread) -> bool {
    let mean = pixel.mean();
    let above = |sample: Fixed, c: usize| contrast(kind, sample.to_f64() as f32, mean[c]) > limit;
    (0..3).any(|c| above(spread.least[c], c) || above(spread.most[c], c))
}

/// Returns the contrast of a sample with the mean; 0 if both are 0. Source: thesis 5.12 to 5.14.
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
    use slo_scene::{Look, OutputFormat};

    use super::*;

    fn plan(least: u32, most: u32, rule: Rule) -> Plan {
        let display = Display::of(OutputFormat::Png8, Look::default());
        Plan { least, most, rule, display, part: None, samples: None, steps: None }
    }

    fn rungs(plan: &Plan) -> Vec<u32> {
        let next = |&n: &u32| (n < plan.most).then(|| plan.rung_after(n));
        std::iter::successors(Some(plan.rung_after(0)), next).collect()
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
    fn rungs_go_up_to_all_samples() {
        let contrast = Rule::Contrast(Contrast::Difference, 0.1);
        assert_eq!(rungs(&plan(8, 100, contrast)), [8, 16, 32, 64, 100]);
        assert_eq!(rungs(&plan(5, 5, contrast)), [5]);
        assert_eq!(rungs(&plan(16, 100, Rule::Noise(0.1))), [16, 24, 32, 48, 64, 96, 100]);
        assert_eq!(rungs(&plan(20, 64, Rule::Noise(0.1))), [20, 24, 32, 48, 64]);
        assert_eq!(rungs(&plan(1, 8, Rule::Noise(0.1))), [1, 2, 3, 4, 6, 8]);
        for rule in [contrast, Rule::Noise(0.1)] {
            let plan = plan(7, 1000, rule);
            let found: Vec<u32> = (7..=1000).filter(|&n| plan.is_rung(n)).collect();
            assert_eq!(found, rungs(&plan));
        }
    }

    fn film(values: &[f32]) -> Film {
        let mut film = Film::new(Area::whole(1, 1), true).unwrap();
        let (pixel, spread) = film.at_mut(0);
        let spread = spread.unwrap();
        for &value in values {
            let sum = [Fixed::new(value).unwrap(); 3];
            pixel.add(sum, 1);
            spread.add(sum);
        }
        film
    }

    #[test]
    fn a_pixel_goes_on_while_a_sample_stands_out() {
        let plan = plan(4, 16, Rule::Contrast(Contrast::Difference, 0.3));
        let next = |values: &[f32]| plan.next(Isa::Portable, &film(values), &[0], &[]);
        assert_eq!(next(&[0.5, 0.5, 0.5, 0.5]), None);
        assert_eq!(next(&[0.5, 0.5, 0.5, 0.7]), None);
        assert_eq!(next(&[0.5, 0.5, 0.5, 1.0]), Some(8));
        assert_eq!(next(&[0.5, 0.5, 0.5, 0.0]), Some(8));
        assert_eq!(next(&[0.5, 0.5, 0.5]), Some(4), "before the first decision");
        assert_eq!(next(&[0.5, 0.5, 0.5, 0.5, 0.5]), Some(8), "between two decisions");
        assert_eq!(next(&[0.0; 16]), None);
    }

    #[test]
    fn a_block_goes_on_while_its_worst_quarter_is_noisy() {
        let mut film = Film::new(Area::whole(8, 8), false).unwrap();
        let group: Vec<u32> = (0..64).collect();
        let quarters = [0..16, 16..32, 32..48, 48..64];
        for i in 0..64 {
            // One quarter flickers between 0.4 and 0.6, an error of 0.1 before clamping.
            for value in if i >= 48 { [0.4, 0.6] } else { [0.5, 0.5] } {
                film.at_mut(i).0.add([Fixed::new(value).unwrap(); 3], 1);
            }
        }
        let asked = |error: f64| (error / error_share(2)) as f32;
        let next = |error| {
            plan(2, 64, Rule::Noise(asked(error))).next(Isa::Portable, &film, &group, &quarters)
        };
        assert_eq!(next(0.099), Some(3));
        assert_eq!(next(0.101), None);
    }

    #[test]
    fn what_costs_little_gets_cleaner_and_nothing_stays_above_the_error() {
        let shares: Vec<f64> = [1, 4, 64, 256, 257, 4096].map(error_share).to_vec();
        assert_eq!(shares, [1.0 / 16.0, 1.0 / 8.0, 0.5, 1.0, 1.0, 1.0]);
        // Below the full share, the squared error divided by the number of samples is the same
        // everywhere.
        let quotient = |n: u32| error_share(n) * error_share(n) / f64::from(n);
        assert!((8..=256).all(|n| (quotient(n) / quotient(8) - 1.0).abs() < 1e-12));
    }

    #[test]
    fn each_step_goes_on_from_the_one_before() {
        let plan = plan(50, 50, Rule::Uniform).in_steps(Steps::default());
        let at = |step| plan.at_step(step);
        let samples: Vec<_> = (0..4).map(|step| at(step).uniform().unwrap()).collect();
        assert_eq!(samples, [1, 2, 4, 8]);
        let errors: Vec<f32> = (4..=Steps::LAST)
            .map(|step| match at(step).rule {
                Rule::Noise(error) => error,
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!((errors[0], errors[2], errors[4]), (0.2, 0.1, 0.05));
        assert!(errors.windows(2).all(|w| w[1] < w[0] && w[1] > 0.7 * w[0]), "{errors:?}");
    }

    #[test]
    fn shares_of_samples_cover_all_of_them() {
        let plan = plan(50, 50, Rule::Uniform);
        let share =
            |number| plan.clone().of_samples(Part { number, of: 7 }).unwrap().samples().unwrap();
        let all: Vec<u32> = (1..=7).flat_map(share).collect();
        assert_eq!(all, (0..50).collect::<Vec<_>>());
        assert!(
            super::tests::plan(1, 50, Rule::Noise(0.1))
                .of_samples(Part { number: 1, of: 2 })
                .is_none()
        );
    }
}
