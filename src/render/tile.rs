//! One tile: samples of its pixels in blocks, until each pixel has enough.

use crate::film::{Area, Fixed, Pixel};
use crate::frame::FrameScene;
use crate::integrator::{SampleSum, Statistics, Wave, Work};
use crate::scene::{Contrast, Settings};

/// Camera samples traced in one go, at most: their sums stay in the second-level cache, and enough
/// of them are there to fill the batches of deep bounces.
const SAMPLES_AT_ONCE: u32 = 16 * 1024;

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(super) struct TileRenderer {
    wave: Wave,
    work: Vec<Work>,
    pixels: Vec<Pixel>,
    ranges: Vec<SampleRange>,
    statistics: Statistics,
}

/// Smallest and largest value of a pixel's samples so far, by channel.
#[derive(Clone, Copy, Debug)]
struct SampleRange {
    least: [Fixed; 3],
    most: [Fixed; 3],
}

impl TileRenderer {
    /// The pixels of one area, row by row, and what was traced for them.
    pub(super) fn render(&mut self, frame: &FrameScene, area: Area) -> (&[Pixel], Statistics) {
        self.statistics = Statistics::default();
        self.pixels.clear();
        self.pixels.resize(area.len(), Pixel::default());
        self.ranges.clear();
        let settings = &frame.settings;
        let all = settings.image_samples.saturating_mul(settings.dof_samples);
        let least = settings.image_min_samples.saturating_mul(settings.dof_samples).clamp(1, all);
        let adaptive = least < all;
        if adaptive {
            let none = SampleRange { least: [Fixed::MAX; 3], most: [Fixed::MIN; 3] };
            self.ranges.resize(area.len(), none);
        }
        let mut active: Vec<u32> = patches(area);
        let (mut done, mut next) = (0, least);
        while !active.is_empty() {
            self.sample(frame, area, &active, done, next);
            if next == all {
                break;
            }
            active.retain(|&i| self.needs_more(settings, i as usize));
            (done, next) = (next, next.saturating_mul(2).min(all));
        }
        (&self.pixels, self.statistics)
    }

    /// Takes samples `first..end` of the given pixels.
    fn sample(&mut self, frame: &FrameScene, area: Area, active: &[u32], first: u32, end: u32) {
        let at_once = (SAMPLES_AT_ONCE / (end - first)).max(1) as usize;
        for pixels in active.chunks(at_once) {
            // One pixel's samples may be too many for one go by themselves.
            let mut from = first;
            while from < end {
                let count = (end - from).min(SAMPLES_AT_ONCE);
                self.work.clear();
                self.work.extend(pixels.iter().map(|i| Work {
                    x: area.x0 + i % area.width(),
                    y: area.y0 + i / area.width(),
                    first: from,
                    count,
                }));
                let (sums, statistics) = self.wave.trace(frame, &self.work);
                self.statistics += statistics;
                for (&i, sums) in pixels.iter().zip(sums.chunks_exact(count as usize)) {
                    add_samples(&mut self.pixels[i as usize], sums);
                    if let Some(range) = self.ranges.get_mut(i as usize) {
                        range.add(sums);
                    }
                }
                from += count;
            }
        }
    }

    /// The thesis's test: whether the contrast of any sample with the mean exceeds the limit, in
    /// any channel. All three contrasts are largest for the smallest or the largest sample.
    fn needs_more(&self, settings: &Settings, i: usize) -> bool {
        let (mean, range) = (self.pixels[i].mean(), &self.ranges[i]);
        (0..3).any(|channel| {
            [range.least[channel], range.most[channel]].into_iter().any(|sample| {
                let sample = sample.to_f64() as f32;
                contrast(settings.contrast, sample, mean[channel]) > settings.image_contrast_limit
            })
        })
    }
}

impl SampleRange {
    fn add(&mut self, sums: &[SampleSum]) {
        for sum in sums {
            for (channel, &value) in sum.iter().enumerate() {
                self.least[channel] = self.least[channel].min(value);
                self.most[channel] = self.most[channel].max(value);
            }
        }
    }
}

fn add_samples(pixel: &mut Pixel, sums: &[SampleSum]) {
    pixel.samples += sums.len() as u32;
    for sum in sums {
        for (channel, &value) in pixel.sum.iter_mut().zip(sum) {
            *channel += value;
        }
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

/// The pixels of an area by patches of 4 x 4, so that neighbours in a batch are neighbours in the
/// picture.
fn patches(area: Area) -> Vec<u32> {
    let (width, height) = (area.width(), area.height());
    let mut order = Vec::with_capacity(area.len());
    for (y0, x0) in (0..height).step_by(4).flat_map(|y| (0..width).step_by(4).map(move |x| (y, x)))
    {
        for y in y0..(y0 + 4).min(height) {
            order.extend((x0..(x0 + 4).min(width)).map(|x| y * width + x));
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_hold_every_pixel_once() {
        let area = Area { x0: 5, y0: 7, x1: 5 + 31, y1: 7 + 10 };
        let mut order = patches(area);
        assert_eq!(order[..6], [0, 1, 2, 3, 31, 32]);
        order.sort_unstable();
        assert_eq!(order, (0..310).collect::<Vec<_>>());
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
}
