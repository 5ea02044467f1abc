//! Named samples: a random number is a pure function of (seed, frame, pixel, sample, dimension).
//!
//! No generator has a state. A [`Sampler`] holds the seed and the frame, and a [`PixelSeed`] adds
//! the pixel. Within a pixel a [`Key`] names one set of dimensions (the camera's, or one use at one
//! hit of one path), and `index` numbers the points of the set. Unless they are independent random
//! numbers (`Pseudo`), the points of one set fill the unit cube evenly. With `Quasi`, they also do
//! so jointly with the sets of the hits before them (`net`).

pub(crate) mod batch;
mod hash;
mod matrices;
mod names;
mod net;
mod sobol;
pub mod warp;

use hash::{hash2, mix, unit};
pub use names::{Hit, Key, PixelSeed, Purpose};
pub(crate) use names::{Use, next_path};
use slo_scene::Generator;

/// One camera sample. All numbers are in `[0, 1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSample {
    /// Position inside the pixel: x to the right, y downward.
    pub pixel: [f32; 2],
    /// Shutter time: 0 at opening, 1 at closing.
    pub time: f32,
    /// Point of the unit square, before the warp to the lens.
    pub lens: [f32; 2],
}

/// Generates the samples of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    generator: Generator,
    seed: u32,
}

impl Sampler {
    /// Creates the sampler of frame `frame` for a picture with seed `seed`.
    pub fn new(generator: Generator, seed: u64, frame: i64) -> Self {
        let words = [seed as u32, (seed >> 32) as u32, frame as u32, (frame >> 32) as u32];
        Self { generator, seed: words.into_iter().fold(0x5107_2011, hash2) }
    }

    /// Returns a sampler of the same kind whose numbers have other names.
    pub(crate) fn renamed(self, name: u32) -> Self {
        Self { seed: hash2(self.seed, name), ..self }
    }

    /// Returns the seed of the pixel in column `x` and row `y`, counted from the top left.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> PixelSeed {
        PixelSeed::new(self.seed, x, y)
    }

    /// Returns camera sample `index` of a pixel: five jointly stratified dimensions.
    #[inline(always)]
    pub fn camera(&self, pixel: PixelSeed, index: u32) -> CameraSample {
        let key = pixel.camera();
        let [lens_u, lens_v, time, x, y] = match self.generator {
            Generator::Quasi => net::camera::<32, true>(key, index),
            Generator::Pseudo => std::array::from_fn(|d| pseudo(key.word(), index, d)),
            Generator::ZeroTwo => {
                let lens = sobol::zero_two(index, mix(key.word() ^ 1));
                let pixel = sobol::zero_two(index, mix(key.word() ^ 2));
                let time = sobol::zero_two(index, mix(key.word() ^ 3))[0];
                [lens[0], lens[1], time, pixel[0], pixel[1]]
            }
        };
        CameraSample { pixel: [x, y], time, lens: [lens_u, lens_v] }
    }

    /// Returns point `index` of a three-dimensional set, in `[0, 1)^3`. The first two dimensions
    /// are the best stratified.
    #[inline(always)]
    pub fn point3(&self, key: Key, index: u32) -> [f32; 3] {
        match self.generator {
            Generator::Quasi => net::at_hit::<32>(key, index),
            Generator::Pseudo => std::array::from_fn(|d| pseudo(key.word(), index, d)),
            Generator::ZeroTwo => {
                let [u, v] = sobol::zero_two(index, key.word());
                [u, v, sobol::zero_two(index, mix(key.word() ^ 3))[0]]
            }
        }
    }

    /// Returns the first two coordinates of [`point3`](Self::point3).
    #[inline(always)]
    pub fn point2(&self, key: Key, index: u32) -> [f32; 2] {
        let [u, v, _] = self.point3(key, index);
        [u, v]
    }
}

/// Returns an independent uniform number for every (key, index, dimension).
#[inline(always)]
fn pseudo(key: u32, index: u32, dimension: usize) -> f32 {
    unit(mix(hash2(hash2(key, index), dimension as u32)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GENERATORS: [Generator; 3] = [Generator::Pseudo, Generator::ZeroTwo, Generator::Quasi];

    /// Whether each of the `n` boxes of every shape `2^-a x 2^-b`, `a + b = log2 n`, holds exactly
    /// one point.
    fn is_zero_two_net(points: &[[f32; 2]]) -> bool {
        let bits = points.len().ilog2();
        (0..=bits).all(|a| {
            let (columns, rows) = (1usize << a, 1usize << (bits - a));
            let mut seen = vec![false; points.len()];
            points.iter().all(|p| {
                let cell = (p[0] * columns as f32) as usize * rows + (p[1] * rows as f32) as usize;
                !std::mem::replace(&mut seen[cell], true)
            })
        })
    }

    #[test]
    fn quasi_and_zero_two_sets_are_nets_and_pseudo_sets_are_not() {
        for generator in GENERATORS {
            let sampler = Sampler::new(generator, 7, 3);
            let pixel = sampler.pixel(11, 5);
            let lens: Vec<_> = (0..64).map(|i| sampler.camera(pixel, i).lens).collect();
            let key = pixel.key(Hit { path: 9, depth: 1, split: true }, Purpose::Light(2));
            let light: Vec<_> = (0..64).map(|i| sampler.point2(key, i)).collect();
            let expected = generator != Generator::Pseudo;
            assert_eq!(is_zero_two_net(&lens), expected, "{generator:?} lens");
            assert_eq!(is_zero_two_net(&light), expected, "{generator:?} light");
        }
    }

    #[test]
    fn every_dimension_is_stratified_over_a_power_of_two_of_quasi_samples() {
        let sampler = Sampler::new(Generator::Quasi, 0, 0);
        let pixel = sampler.pixel(0, 0);
        let samples: Vec<_> = (0..128).map(|i| sampler.camera(pixel, i)).collect();
        let dimensions: [fn(&CameraSample) -> f32; 5] =
            [|s| s.pixel[0], |s| s.pixel[1], |s| s.time, |s| s.lens[0], |s| s.lens[1]];
        for (d, of) in dimensions.iter().enumerate() {
            let mut cells: Vec<_> = samples.iter().map(|s| (of(s) * 128.0) as usize).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..128).collect::<Vec<_>>(), "dimension {d}");
        }
    }

    #[test]
    fn different_uses_are_uncorrelated() {
        for generator in GENERATORS {
            let sampler = Sampler::new(generator, 1, 0);
            let n = 4096;
            // Correlation over pixels at a fixed sample, which determines the noise of neighbouring
            // pixels.
            let correlation = |of: &dyn Fn(u32) -> (f32, f32)| {
                (0..n).map(of).map(|(a, b)| (a - 0.5) * (b - 0.5) * 12.0).sum::<f32>() / n as f32
            };
            // Five standard deviations of the mean, which are 1/64 each.
            let bound = 5.0 / 64.0;
            // With QUASI, points are correlated within a block of pixels but not between blocks.
            let pixels = correlation(&|i| {
                let s = |x| sampler.camera(sampler.pixel(x, 0), 0).time;
                (s(i), s(i + 8))
            });
            let uses = correlation(&|i| {
                let pixel = sampler.pixel(i, 9);
                let hit = Hit { path: 0, depth: 0, split: false };
                let of = |purpose| sampler.point2(pixel.key(hit, purpose), 3)[0];
                (of(Purpose::Reflection), of(Purpose::Refraction))
            });
            let frames = correlation(&|i| {
                let of = |frame| {
                    let sampler = Sampler::new(generator, 1, frame);
                    sampler.camera(sampler.pixel(i, 0), 0).lens[0]
                };
                (of(0), of(1))
            });
            for value in [pixels, uses, frames] {
                assert!(value.abs() < bound, "{generator:?}: {value}");
            }
        }
    }

    /// Root mean square error, over many pixels, of an integral estimated with `samples` points.
    fn error(
        generator: Generator,
        samples: u32,
        f: &dyn Fn(&CameraSample, [f32; 2]) -> f32,
    ) -> f32 {
        let sampler = Sampler::new(generator, 5, 0);
        let hit = Hit { path: 0, depth: 0, split: false };
        let square = |x: u32| {
            let pixel = sampler.pixel(8 * x, 0);
            let key = pixel.key(hit, Purpose::Light(0));
            let value = |i| f(&sampler.camera(pixel, i), sampler.point2(key, i));
            let error = (0..samples).map(value).sum::<f32>() / samples as f32;
            error * error
        };
        ((0..500).map(square).sum::<f32>() / 500.0).sqrt()
    }

    #[test]
    fn smooth_integrals_converge_fast() {
        let light = |_: &CameraSample, [u, v]: [f32; 2]| u * u * v + v * v - 0.5;
        let both = |s: &CameraSample, [u, v]: [f32; 2]| (s.pixel[0] + u) * (s.pixel[1] + v) - 1.0;
        let gain = |generator, f: &dyn Fn(&CameraSample, [f32; 2]) -> f32| {
            error(generator, 8, f) / error(generator, 128, f)
        };
        // With 16 times the samples, the error falls by a factor of 4 if it is proportional to
        // N^-1/2 and by a factor of 64 if proportional to N^-3/2.
        assert!(gain(Generator::Pseudo, &light) < 5.0);
        assert!(gain(Generator::Quasi, &light) > 40.0, "{}", gain(Generator::Quasi, &light));
        assert!(gain(Generator::Quasi, &both) > 25.0, "{}", gain(Generator::Quasi, &both));
        let separate = gain(Generator::ZeroTwo, &both);
        assert!(separate < gain(Generator::Quasi, &both), "{separate}");
    }

    #[test]
    fn numbers_are_below_one() {
        assert!(unit(u32::MAX) < 1.0);
        assert_eq!(unit(0), 0.0);
    }
}
