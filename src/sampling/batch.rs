//! The same samples as [`Sampler`] names one by one, for whole batches.

use super::{CameraSample, Generator, PixelSeed, Sampler, Use, sobol, unit};
use crate::accel::{Isa, Lanewise};
use crate::math::columns::{BATCH, Column, lanes};

/// Dimensions of a camera sample.
const DIMENSIONS: usize = 5;

/// Samples `first..first + count` of one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) seed: PixelSeed,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// Camera samples in columns: lens u, v, time, pixel x, y.
#[derive(Debug)]
pub(crate) struct CameraSamples {
    numbers: [Column<f32>; DIMENSIONS],
    /// Digits of the points that were asked for so far.
    points: Points,
}

impl Default for CameraSamples {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; DIMENSIONS], points: Points::default() }
    }
}

/// Digits of the first points of the sequence, by dimension: every pixel scrambles the same ones.
#[derive(Debug, Default)]
struct Points([Vec<u32>; DIMENSIONS]);

impl Points {
    /// Beyond so many samples a pixel the digits are computed again for each pixel.
    const MOST: u32 = 1 << 16;

    fn reach(&mut self, end: u32) {
        for (dimension, digits) in self.0.iter_mut().enumerate() {
            let known = digits.len() as u32;
            digits.extend((known..end).map(|i| sobol::reversed_sobol(i, dimension)));
        }
    }
}

impl CameraSamples {
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> CameraSample {
        let [u, v, time, x, y] = &self.numbers;
        CameraSample { pixel: [x[i], y[i]], time: time[i], lens: [u[i], v[i]] }
    }

    pub(crate) fn time(&self) -> &Column<f32> {
        &self.numbers[2]
    }

    /// Fills in the samples of runs, one after the other; together a batch at most.
    pub(crate) fn take(&mut self, sampler: &Sampler, isa: Isa, runs: &[Run]) {
        let end = runs.iter().map(|run| run.first + run.count).max().unwrap_or(0);
        if sampler.generator == Generator::Quasi && end <= Points::MOST {
            self.points.reach(end);
            let Self { numbers, points } = self;
            isa.run(Quasi { runs, points, numbers });
            return;
        }
        let mut at = 0;
        for run in runs {
            for index in run.first..run.first + run.count {
                let CameraSample { pixel: [x, y], time, lens: [u, v] } =
                    sampler.camera(run.seed, index);
                for (column, number) in self.numbers.iter_mut().zip([u, v, time, x, y]) {
                    column[at] = number;
                }
                at += 1;
            }
        }
    }
}

struct Quasi<'a> {
    runs: &'a [Run],
    points: &'a Points,
    numbers: &'a mut [Column<f32>; DIMENSIONS],
}

impl Lanewise for Quasi<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (dimension, (digits, column)) in self.points.0.iter().zip(self.numbers).enumerate() {
            let mut rest = &mut column[..];
            for run in self.runs {
                let (now, later) = rest.split_at_mut(run.count as usize);
                let digits = &digits[run.first as usize..][..now.len()];
                let key = sobol::dimension_key(run.seed.camera().0, dimension);
                for (number, &digits) in now.iter_mut().zip(digits) {
                    *number = unit(sobol::scramble(digits, key));
                }
                rest = later;
            }
        }
    }
}

/// Points of sets of three dimensions, in columns.
#[derive(Debug)]
pub(crate) struct SetPoints {
    pub(crate) numbers: [Column<f32>; 3],
}

impl Default for SetPoints {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; 3] }
    }
}

/// Which point of which set, in columns.
pub(crate) struct SetNames<'a> {
    pub(crate) seed: &'a Column<u32>,
    pub(crate) path: &'a Column<u32>,
    pub(crate) index: &'a Column<u32>,
    pub(crate) purpose: Use,
    /// See [`place_of`].
    pub(crate) place: [u32; 2],
    pub(crate) len: usize,
}

/// Number of the `i`th of `count` rays of the same kind that one hit sends out, whose own ray has
/// number `index`.
#[inline(always)]
pub(crate) fn place_of(index: u32, [i, count]: [u32; 2]) -> u32 {
    index.wrapping_mul(count).wrapping_add(i)
}

impl SetPoints {
    /// The first `D` numbers of the named points.
    pub(crate) fn take<const D: usize>(
        &mut self,
        sampler: &Sampler,
        isa: Isa,
        names: &SetNames<'_>,
    ) {
        match sampler.generator {
            Generator::Quasi => isa.run(Take::<D, QUASI> { names, to: self }),
            Generator::Pseudo => isa.run(Take::<D, PSEUDO> { names, to: self }),
            Generator::ZeroTwo => isa.run(Take::<D, ZERO_TWO> { names, to: self }),
        }
    }
}

/// Generators as numbers, for which a loop is compiled each.
const QUASI: u8 = Generator::Quasi as u8;
const PSEUDO: u8 = Generator::Pseudo as u8;
const ZERO_TWO: u8 = Generator::ZeroTwo as u8;

struct Take<'a, const D: usize, const GENERATOR: u8> {
    names: &'a SetNames<'a>,
    to: &'a mut SetPoints,
}

impl<const D: usize, const GENERATOR: u8> Lanewise for Take<'_, D, GENERATOR> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        take::<D, GENERATOR>(self.names, self.to);
    }
}

#[inline(always)]
fn take<const D: usize, const GENERATOR: u8>(names: &SetNames<'_>, to: &mut SetPoints) {
    let generator = match GENERATOR {
        QUASI => Generator::Quasi,
        PSEUDO => Generator::Pseudo,
        _ => Generator::ZeroTwo,
    };
    let sampler = Sampler { generator, seed: 0 };
    let SetNames { seed, path, index, purpose, place, len } = *names;
    let [u, v, w] = &mut to.numbers;
    for i in lanes(len) {
        let key = PixelSeed::from_word(seed[i]).key_of(path[i], purpose);
        let numbers = sampler.point3(key, place_of(index[i], place));
        (u[i], v[i]) = (numbers[0], numbers[1]);
        if D > 2 {
            w[i] = numbers[2];
        }
    }
}
