//! The same samples as [`Sampler`] names one by one, for whole batches.

pub(crate) use super::net::Digits;
use super::net::{self, BLOCK, CAMERA};
use super::{CameraSample, Generator, Hit, Key, PixelSeed, Sampler, Use};
use crate::accel::{Isa, Lanewise};
use crate::math::columns::{BATCH, Column, lanes};

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
    numbers: [Column<f32>; CAMERA],
    looked: Looked,
}

impl Default for CameraSamples {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; CAMERA], looked: Looked::default() }
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
    pub(crate) fn take(&mut self, sampler: &Sampler, isa: Isa, runs: &[Run], digits: &mut Digits) {
        let end = runs.iter().map(|run| run.first + run.count).max().unwrap_or(0);
        if sampler.generator == Generator::Quasi && end <= Digits::MOST {
            digits.reach(end);
            self.take_quasi(isa, runs, digits);
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

    /// Runs of adaptive pictures are short: numbers are looked up run by run, and scrambled all
    /// together.
    fn take_quasi(&mut self, isa: Isa, runs: &[Run], digits: &Digits) {
        let Self { numbers, looked } = self;
        let mut len = 0;
        for run in runs {
            let end = len + run.count as usize;
            looked.set[len..end].fill(run.seed.camera().set);
            len = end;
        }
        for (dimension, to) in numbers.iter_mut().enumerate() {
            isa.run(LookUpRuns { dimension, runs, digits, to: &mut looked.digits });
            isa.run(Scramble { dimension, len, looked, to });
        }
    }
}

/// Looks up one dimension of the samples of runs.
struct LookUpRuns<'a> {
    dimension: usize,
    runs: &'a [Run],
    digits: &'a Digits,
    to: &'a mut Column<u32>,
}

impl Lanewise for LookUpRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { dimension, runs, digits, to } = self;
        let (digits, masks) = (digits.of(dimension), net::masks_of(dimension));
        let mut rest = &mut to[..];
        for run in runs {
            let (now, later) = rest.split_at_mut(run.count as usize);
            let mask = masks[run.seed.camera().at as usize];
            for (to, &digits) in now.iter_mut().zip(&digits[run.first as usize..]) {
                *to = digits ^ mask;
            }
            rest = later;
        }
    }
}

/// Points of sets of three dimensions, in columns.
#[derive(Debug)]
pub(crate) struct SetPoints {
    pub(crate) numbers: [Column<f32>; 3],
    looked: Looked,
}

impl Default for SetPoints {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; 3], looked: Looked::default() }
    }
}

/// What is looked up in tables, in a loop of its own, and what for.
#[derive(Debug)]
struct Looked {
    index: Column<u32>,
    set: Column<u32>,
    digits: Column<u32>,
}

impl Default for Looked {
    fn default() -> Self {
        Self { index: [0; BATCH], set: [0; BATCH], digits: [0; BATCH] }
    }
}

impl Looked {
    fn look_up(&mut self, dimension: usize, names: &SetNames<'_>, digits: &Digits) {
        let (digits, masks) = (digits.of(dimension), net::masks_of(dimension));
        for i in 0..names.len.min(BATCH) {
            self.digits[i] =
                digits[self.index[i] as usize] ^ masks[(names.seed[i] % BLOCK) as usize];
        }
    }
}

/// Which point of which set, in columns.
pub(crate) struct SetNames<'a> {
    pub(crate) seed: &'a Column<u32>,
    pub(crate) path: &'a Column<u32>,
    pub(crate) index: &'a Column<u32>,
    /// Bounces behind all of them.
    pub(crate) depth: u32,
    /// See [`Hit::split`].
    pub(crate) split: bool,
    pub(crate) purpose: Use,
    /// See [`place_of`].
    pub(crate) place: [u32; 2],
    pub(crate) len: usize,
}

impl SetNames<'_> {
    #[inline(always)]
    fn key(&self, i: usize) -> Key {
        let hit = Hit { path: self.path[i], depth: self.depth, split: self.split };
        PixelSeed::from_word(self.seed[i]).key_of(hit, self.purpose)
    }

    #[inline(always)]
    fn number(&self, i: usize) -> u32 {
        place_of(self.index[i], self.place)
    }

    /// One more than the highest number.
    fn end(&self) -> u32 {
        let highest = lanes(self.len).map(|i| if i < self.len { self.number(i) } else { 0 }).max();
        highest.map_or(0, |number| number.saturating_add(1))
    }
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
        digits: &mut Digits,
    ) {
        if sampler.generator == Generator::Quasi {
            let end = isa.run(End(names)).next_multiple_of(net::SHUFFLED);
            if end <= Digits::MOST {
                digits.reach(end);
                self.take_quasi::<D>(isa, names, digits);
                return;
            }
        }
        isa.run(Take::<D> { sampler, names, to: self });
    }

    fn take_quasi<const D: usize>(&mut self, isa: Isa, names: &SetNames<'_>, digits: &Digits) {
        let Self { numbers, looked } = self;
        isa.run(Order { names, to: looked });
        let first = net::first_dimension(names.depth);
        for (dimension, to) in (first..).zip(numbers).take(D) {
            looked.look_up(dimension, names, digits);
            isa.run(Scramble { dimension, len: names.len, looked, to });
        }
    }
}

struct End<'a>(&'a SetNames<'a>);

impl Lanewise for End<'_> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        self.0.end()
    }
}

/// Which point of its dimensions each named point is, and the word of its set.
struct Order<'a> {
    names: &'a SetNames<'a>,
    to: &'a mut Looked,
}

impl Lanewise for Order<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { names, to } = self;
        for i in lanes(names.len) {
            let key = names.key(i);
            to.index[i] = net::order(key, names.number(i));
            to.set[i] = key.set;
        }
    }
}

/// Scrambles what was looked up for one dimension.
struct Scramble<'a> {
    dimension: usize,
    len: usize,
    looked: &'a Looked,
    to: &'a mut Column<f32>,
}

impl Lanewise for Scramble<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { dimension, len, looked, to } = self;
        for i in lanes(len) {
            to[i] = net::number(looked.digits[i], dimension, looked.set[i]);
        }
    }
}

/// Any generator, any number of points.
struct Take<'a, const D: usize> {
    sampler: &'a Sampler,
    names: &'a SetNames<'a>,
    to: &'a mut SetPoints,
}

impl<const D: usize> Lanewise for Take<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sampler, names, to } = self;
        for i in lanes(names.len) {
            let numbers = sampler.point3(names.key(i), names.number(i));
            for (column, number) in to.numbers.iter_mut().zip(numbers).take(D) {
                column[i] = number;
            }
        }
    }
}
