//! One tile: samples of its pixels in blocks, until each pixel has enough.

use super::adaptive::{SamplePlan, Spread};
use crate::film::{Area, Pixel};
use crate::frame::FrameScene;
use crate::integrator::{SampleSum, Statistics, Wave, Work};

/// Camera samples traced in one go, at most: their sums stay in the second-level cache, and enough
/// of them are there to fill the batches of deep bounces.
const SAMPLES_AT_ONCE: u32 = 16 * 1024;

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(super) struct TileRenderer {
    wave: Wave,
    work: Vec<Work>,
    pixels: Vec<Pixel>,
    /// Of each pixel; empty where nobody asks.
    spreads: Vec<Spread>,
    statistics: Statistics,
}

impl TileRenderer {
    /// The pixels of one area, row by row, and what was traced for them.
    pub(super) fn render(&mut self, frame: &FrameScene, area: Area) -> (&[Pixel], Statistics) {
        self.statistics = Statistics::default();
        self.pixels.clear();
        self.pixels.resize(area.len(), Pixel::default());
        self.spreads.clear();
        let plan = SamplePlan::new(&frame.settings);
        if plan.is_adaptive() {
            self.spreads.resize(area.len(), Spread::default());
        }
        let mut active: Vec<u32> = patches(area);
        let mut done = 0;
        for end in plan.block_ends() {
            self.sample(frame, area, &active, done, end);
            done = end;
            if plan.is_adaptive() {
                let (pixels, spreads) = (&self.pixels, &self.spreads);
                active.retain(|&i| plan.needs_more(&pixels[i as usize], &spreads[i as usize]));
            }
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
                // Who looks at spreads needs every sample by itself.
                let entry = if self.spreads.is_empty() { count } else { 1 };
                self.work.clear();
                self.work.extend(pixels.iter().flat_map(|i| {
                    let (x, y) = (area.x0 + i % area.width(), area.y0 + i / area.width());
                    let firsts = (from..from + count).step_by(entry as usize);
                    firsts.map(move |first| Work { x, y, first, count: entry })
                }));
                let (sums, statistics) = self.wave.trace(frame, &self.work);
                self.statistics += statistics;
                let entries = (count / entry) as usize;
                for (&i, sums) in pixels.iter().zip(sums.chunks_exact(entries)) {
                    add_samples(&mut self.pixels[i as usize], sums, count);
                    if let Some(spread) = self.spreads.get_mut(i as usize) {
                        spread.add(sums);
                    }
                }
                from += count;
            }
        }
    }
}

fn add_samples(pixel: &mut Pixel, sums: &[SampleSum], samples: u32) {
    pixel.samples += samples;
    for sum in sums {
        for (channel, &value) in pixel.sum.iter_mut().zip(sum) {
            *channel += value;
        }
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
}
