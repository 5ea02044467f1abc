//! The sums of one pixel.

use std::ops::Range;

use super::fixed::Fixed;

/// Samples that every block takes first if the scene names no number: fewer give no error estimate.
pub const LEAST_FOR_NOISE: u32 = 8;

/// Sums of a pixel's samples, and how many there are.
///
/// Samples are taken in the order of their numbers. All sums are exact, so that sums of disjoint sets of
/// samples add up to the sums of one run. Sums that are larger than [`Fixed::MAX`] are that: the same
/// for all ways to add them up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pixel {
    /// Of all samples: red, green, blue.
    pub sum: [Fixed; 3],
    /// Of the samples with a number below the largest power of two below `samples`; 0 if there is at
    /// most one. The error is estimated from its distance to the rest.
    pub base: [Fixed; 3],
    /// Samples in the sum.
    pub samples: u32,
}

impl Pixel {
    /// Mean radiance; black without samples.
    #[inline]
    pub fn mean(&self) -> [f32; 3] {
        let samples = f64::from(self.samples.max(1));
        self.sum.map(|s| (s.to_f64() / samples) as f32)
    }

    /// Adds the next `count` samples. If a power of two lies between the old number of samples and the
    /// new one, split the samples there, or `base` is wrong: see [`split`].
    #[inline]
    pub fn add(&mut self, sum: [Fixed; 3], count: u32) {
        if self.samples.is_power_of_two() {
            self.base = self.sum;
        }
        self.add_later(sum, count);
    }

    /// Adds samples that do not belong to `base`.
    #[inline]
    pub fn add_later(&mut self, sum: [Fixed; 3], count: u32) {
        add(&mut self.sum, sum);
        self.samples += count;
    }

    /// Adds samples that belong to `base`.
    #[inline]
    pub fn add_base(&mut self, sum: [Fixed; 3], count: u32) {
        add(&mut self.base, sum);
        self.add_later(sum, count);
    }

    /// The sum of two disjoint sets of samples; `None` if there are too many.
    #[inline]
    pub fn checked_add(&self, other: &Self) -> Option<Self> {
        let mut result = Self { samples: self.samples.checked_add(other.samples)?, ..*self };
        add(&mut result.sum, other.sum);
        add(&mut result.base, other.base);
        Some(result)
    }

    /// Whether a channel is brighter than its sum can say.
    pub fn is_full(&self) -> bool {
        self.sum.contains(&Fixed::MAX)
    }

    /// Estimated standard error of the mean, by channel; `None` for less than two samples.
    ///
    /// The samples of `base` and the others are two estimates of the pixel. For independent samples
    /// the expected square is exact; for stratified ones it is too large, unless the second half sees
    /// nothing that the first has not seen.
    #[inline]
    pub fn error(&self) -> Option<[f32; 3]> {
        if self.samples < 2 {
            return None;
        }
        let halves = Halves::of(self.samples);
        Some([0, 1, 2].map(|c| halves.error(self.base[c].to_f64(), self.sum[c].to_f64())))
    }
}

/// Factors for the sums of a pixel whose samples `base` divides in two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves {
    of_all: f64,
    of_base: f64,
    of_rest: f64,
    scale: f64,
}

impl Halves {
    /// Of two samples or more.
    #[inline(always)]
    pub(super) fn of(samples: u32) -> Self {
        Self::new(f64::from(base_end(samples)), f64::from(samples))
    }

    /// Of `first` samples in `base` and `all`.
    #[inline(always)]
    pub(super) fn new(first: f64, all: f64) -> Self {
        let rest = all - first;
        let (of_all, of_base, of_rest) = (1.0 / all, 1.0 / first, 1.0 / rest);
        Self { of_all, of_base, of_rest, scale: (first * rest).sqrt() * of_all }
    }

    /// The mean of a channel.
    #[inline(always)]
    pub(super) fn mean(&self, sum: f64) -> f32 {
        (sum * self.of_all) as f32
    }

    /// See [`Pixel::error`].
    #[inline(always)]
    pub(super) fn error(&self, base: f64, sum: f64) -> f32 {
        (self.scale * (base * self.of_base - (sum - base) * self.of_rest).abs()) as f32
    }
}

/// The largest power of two below `samples`: the end of `base`. 0 for one sample or none.
pub fn base_end(samples: u32) -> u32 {
    if samples < 2 { 0 } else { samples.next_power_of_two() / 2 }
}

/// Splits samples `from..to` into one or two ranges after which `base` is right.
pub fn split(from: u32, to: u32) -> impl Iterator<Item = Range<u32>> {
    let middle = base_end(to).max(from);
    [from..middle, middle..to].into_iter().filter(|range| !range.is_empty())
}

fn add(to: &mut [Fixed; 3], more: [Fixed; 3]) {
    to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
}

/// The smallest and the largest sample of a pixel, by channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// [`Fixed::MAX`] without samples.
    pub least: [Fixed; 3],
    /// [`Fixed::ZERO`] without samples.
    pub most: [Fixed; 3],
}

impl Default for Spread {
    fn default() -> Self {
        Self { least: [Fixed::MAX; 3], most: [Fixed::ZERO; 3] }
    }
}

impl Spread {
    /// Adds one sample.
    #[inline]
    pub fn add(&mut self, sample: [Fixed; 3]) {
        self.unite(&Self { least: sample, most: sample });
    }

    /// Adds the samples of another.
    pub fn unite(&mut self, other: &Self) {
        for c in 0..3 {
            self.least[c] = self.least[c].min(other.least[c]);
            self.most[c] = self.most[c].max(other.most[c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(value: f32) -> [Fixed; 3] {
        [Fixed::new(value).unwrap(); 3]
    }

    /// Samples 0.5, 1.5, 2.5, ... one by one.
    fn ramp(samples: u32) -> Pixel {
        let mut pixel = Pixel::default();
        (0..samples).for_each(|i| pixel.add(gray(i as f32 + 0.5), 1));
        pixel
    }

    #[test]
    fn base_is_the_sum_below_the_last_power_of_two() {
        // 0.5 + 1.5 + ... of k numbers is k^2 / 2.
        for (samples, base) in [(0, 0), (1, 0), (2, 1), (3, 2), (4, 2), (5, 4), (8, 4), (9, 8)] {
            let expected = gray((base * base) as f32 / 2.0);
            assert_eq!(ramp(samples).base, expected, "{samples} samples");
        }
    }

    #[test]
    fn one_by_one_is_as_many_at_once() {
        let sum = |range: &Range<u32>| range.clone().map(|i| i as f32 + 0.5).sum::<f32>();
        for (from, to) in
            [(0, 1), (0, 7), (0, 64), (1, 2), (2, 3), (3, 17), (8, 9), (8, 16), (9, 12)]
        {
            let mut pixel = ramp(from);
            for range in split(from, to) {
                pixel.add(gray(sum(&range)), range.len() as u32);
            }
            assert_eq!(pixel, ramp(to), "{from}..{to}");
        }
    }

    #[test]
    fn parts_add_up() {
        // Seven samples: base is the first four.
        let (mut first, mut last) = (Pixel::default(), Pixel::default());
        first.add_base(gray(0.5 + 1.5 + 2.5), 3);
        last.add_base(gray(3.5), 1);
        last.add_later(gray(4.5 + 5.5 + 6.5), 3);
        assert_eq!(first.checked_add(&last), Some(ramp(7)));
        let huge = Pixel { samples: u32::MAX, ..first };
        assert_eq!(huge.checked_add(&first), None);
    }

    #[test]
    fn full_pixels_add_up_too() {
        let brightest = gray(Fixed::LIMIT);
        let run = |from: u32, to: u32| {
            let mut part = Pixel::default();
            for i in from..to {
                match i < base_end(70_000) {
                    true => part.add_base(brightest, 1),
                    false => part.add_later(brightest, 1),
                }
            }
            part
        };
        let mut whole = Pixel::default();
        (0..70_000).for_each(|_| whole.add(brightest, 1));
        assert!(whole.is_full() && !run(0, 65_535).is_full());
        for middle in [1, 40_000, 65_536, 69_999] {
            let (first, last) = (run(0, middle), run(middle, 70_000));
            assert_eq!(first.checked_add(&last), Some(whole), "{middle}");
            assert_eq!(last.checked_add(&first), Some(whole), "{middle}");
        }
        assert!(whole.error().unwrap()[0].is_finite());
    }

    #[test]
    fn the_mean_divides_at_the_end() {
        let third = Fixed::new(1.0 / 3.0).unwrap();
        let pixel = Pixel { sum: [third + third + third; 3], samples: 3, ..Pixel::default() };
        assert!((pixel.mean()[0] - 1.0 / 3.0).abs() < 1e-7);
    }

    #[test]
    fn the_error_of_coin_tosses_is_that_of_the_mean() {
        // Heads and tails at random: variance 1/4, so the error of 24 tosses is sqrt(1/96).
        let mut state = 1u32;
        let mut toss = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 31) as f32
        };
        let square = |_| {
            let mut pixel = Pixel::default();
            (0..24).for_each(|_| pixel.add(gray(toss()), 1));
            f64::from(pixel.error().unwrap()[0]) * f64::from(pixel.error().unwrap()[0])
        };
        let mean = (0..4000).map(square).sum::<f64>() / 4000.0;
        assert!((mean * 96.0 - 1.0).abs() < 0.08, "{}", mean * 96.0);
        assert_eq!(ramp(1).error(), None);
        assert_eq!(ramp(2).error(), Some([0.5; 3]));
    }

    #[test]
    fn spreads_hold_every_sample() {
        let mut spread = Spread::default();
        [0.5, 1.0, 0.25].into_iter().for_each(|value| spread.add(gray(value)));
        assert_eq!((spread.least, spread.most), (gray(0.25), gray(1.0)));
    }
}
