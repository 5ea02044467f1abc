//! Samples for whole batches: the same numbers that [`Sampler`] computes one by one.

use super::net::{self, AT_HIT, CAMERA};
use super::{CameraSample, Generator, Hit, Key, PixelSeed, Sampler, Use};
use slo_accel::math::columns::{BATCH, Column, lanes};
use slo_accel::{Isa, Lanewise};

/// Camera samples in columns: lens u, v, time, pixel x, y.
#[derive(Debug)]
pub(crate) struct CameraSamples {
    numbers: [Column<f32>; CAMERA],
}

impl Default for CameraSamples {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; CAMERA] }
    }
}

/// Names of camera samples, in columns.
pub(crate) struct CameraNames<'a> {
    /// Seed of each sample's pixel, as given by [`PixelSeed::word`].
    pub(crate) seed: &'a Column<u32>,
    pub(crate) index: &'a Column<u32>,
    /// Highest index plus one.
    pub(crate) end: u32,
    /// Whether the lens dimensions are needed. If not, they may be 0.
    pub(crate) lens: bool,
    pub(crate) len: usize,
}

impl CameraNames<'_> {
    #[inline(always)]
    fn name(&self, i: usize) -> (PixelSeed, u32) {
        (PixelSeed::from_word(self.seed[i]), self.index[i])
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

    /// Computes the named samples.
    pub(crate) fn take(&mut self, sampler: &Sampler, isa: Isa, names: &CameraNames<'_>) {
        if sampler.generator != Generator::Quasi {
            isa.run(TakeCamera { sampler, names, to: self });
            return;
        }
        match (bits_of(names.end), names.lens) {
            (4, false) => isa.run(TakeCameraQuasi::<4, false> { names, to: self }),
            (4, true) => isa.run(TakeCameraQuasi::<4, true> { names, to: self }),
            (8, false) => isa.run(TakeCameraQuasi::<8, false> { names, to: self }),
            (8, true) => isa.run(TakeCameraQuasi::<8, true> { names, to: self }),
            (12, _) => isa.run(TakeCameraQuasi::<12, true> { names, to: self }),
            (16, _) => isa.run(TakeCameraQuasi::<16, true> { names, to: self }),
            _ => isa.run(TakeCameraQuasi::<32, true> { names, to: self }),
        }
    }
}

/// Number of index bits (4, 8, 12, 16 or 32) of the shortest loop that handles every number below
/// `end`.
fn bits_of(end: u32) -> u32 {
    let bits = u32::BITS - end.saturating_sub(1).leading_zeros();
    if bits > 16 { 32 } else { bits.next_multiple_of(4).max(4) }
}

/// Computes camera samples of `QUASI` whose indices are below `2^BITS`.
struct TakeCameraQuasi<'a, const BITS: u32, const LENS: bool> {
    names: &'a CameraNames<'a>,
    to: &'a mut CameraSamples,
}

impl<const BITS: u32, const LENS: bool> Lanewise for TakeCameraQuasi<'_, BITS, LENS> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { names, to } = self;
        let [u, v, time, x, y] = &mut to.numbers;
        for i in lanes(names.len) {
            let (seed, index) = names.name(i);
            [u[i], v[i], time[i], x[i], y[i]] = net::camera::<BITS, LENS>(seed.camera(), index);
        }
    }
}

/// Computes camera samples of any generator.
struct TakeCamera<'a> {
    sampler: &'a Sampler,
    names: &'a CameraNames<'a>,
    to: &'a mut CameraSamples,
}

impl Lanewise for TakeCamera<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sampler, names, to } = self;
        let [u, v, time, x, y] = &mut to.numbers;
        for i in lanes(names.len) {
            let (seed, index) = names.name(i);
            let sample = sampler.camera(seed, index);
            ([u[i], v[i]], [x[i], y[i]]) = (sample.lens, sample.pixel);
            time[i] = sample.time;
        }
    }
}

/// Three-dimensional sample points, in columns.
#[derive(Debug)]
pub(crate) struct SetPoints {
    pub(crate) numbers: [Column<f32>; AT_HIT],
}

impl Default for SetPoints {
    fn default() -> Self {
        Self { numbers: [[0.0; BATCH]; AT_HIT] }
    }
}

/// Names of sample points, in columns: a set, and the number of a point in it.
pub(crate) struct SetNames<'a> {
    pub(crate) seed: &'a Column<u32>,
    pub(crate) path: &'a Column<u32>,
    pub(crate) index: &'a Column<u32>,
    /// Number of bounces before the hits, the same for all.
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
    fn hit(&self, path: u32) -> Hit {
        Hit { path, depth: self.depth, split: self.split }
    }

    #[inline(always)]
    fn key(&self, i: usize) -> Key {
        PixelSeed::from_word(self.seed[i]).key_of(self.hit(self.path[i]), self.purpose)
    }

    #[inline(always)]
    fn number(&self, i: usize) -> u32 {
        place_of(self.index[i], self.place)
    }

    /// Returns an upper bound, exclusive, of the places of the points in the order of their sets.
    fn end(&self, isa: Isa) -> u32 {
        let end = isa.run(End(self));
        if self.hit(0).is_joint() { end } else { end.max(net::SHUFFLED) }
    }
}

/// Sample number of ray `i` of the `count` rays of one kind that a hit sends out. `index` is the
/// sample number of the ray that led to the hit.
#[inline(always)]
pub(crate) fn place_of(index: u32, [i, count]: [u32; 2]) -> u32 {
    index.wrapping_mul(count).wrapping_add(i)
}

impl SetPoints {
    /// Computes the first `D` coordinates of the named points.
    pub(crate) fn take<const D: usize>(
        &mut self,
        sampler: &Sampler,
        isa: Isa,
        names: &SetNames<'_>,
    ) {
        if sampler.generator != Generator::Quasi {
            isa.run(Take::<D> { sampler, names, to: self });
            return;
        }
        match bits_of(names.end(isa)) {
            4 => isa.run(TakeQuasi::<D, 4> { names, to: self }),
            8 => isa.run(TakeQuasi::<D, 8> { names, to: self }),
            12 => isa.run(TakeQuasi::<D, 12> { names, to: self }),
            16 => isa.run(TakeQuasi::<D, 16> { names, to: self }),
            _ => isa.run(TakeQuasi::<D, 32> { names, to: self }),
        }
    }
}

/// Finds the highest number of the named points, plus one.
struct End<'a>(&'a SetNames<'a>);

impl Lanewise for End<'_> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let names = self.0;
        let number = |i| if i < names.len { names.number(i) } else { 0 };
        lanes(names.len).map(number).max().map_or(0, |number| number.saturating_add(1))
    }
}

/// Computes points of `QUASI` whose places in the order of their sets are below `2^BITS`.
struct TakeQuasi<'a, const D: usize, const BITS: u32> {
    names: &'a SetNames<'a>,
    to: &'a mut SetPoints,
}

impl<const D: usize, const BITS: u32> Lanewise for TakeQuasi<'_, D, BITS> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { names, to } = self;
        let [u, v, w] = &mut to.numbers;
        for i in lanes(names.len) {
            let numbers = net::at_hit::<BITS>(names.key(i), names.number(i));
            (u[i], v[i]) = (numbers[0], numbers[1]);
            if D > 2 {
                w[i] = numbers[2];
            }
        }
    }
}

/// Computes points of any generator.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_hold_all_numbers() {
        for (end, bits) in [(0, 4), (1, 4), (16, 4), (17, 8), (256, 8), (257, 12), (4096, 12)] {
            assert_eq!(bits_of(end), bits, "{end}");
        }
        assert_eq!([4097, 65536, 65537, u32::MAX].map(bits_of), [16, 16, 32, 32]);
    }

    #[test]
    fn batches_hold_the_samples_that_are_named_one_by_one() {
        for generator in [Generator::Pseudo, Generator::ZeroTwo, Generator::Quasi] {
            for first in [0, 9, 250, 4090, 65530] {
                let sampler = Sampler::new(generator, 3, 5);
                let seed: Column<u32> =
                    std::array::from_fn(|i| sampler.pixel(i as u32 / 3, 7).word());
                let index: Column<u32> = std::array::from_fn(|i| first + i as u32 % 3);
                let path: Column<u32> = std::array::from_fn(|i| i as u32 % 2);
                let (mut samples, mut points) = (CameraSamples::default(), SetPoints::default());
                for isa in Isa::available() {
                    let (end, len) = (first + 3, BATCH);
                    let names = CameraNames { seed: &seed, index: &index, end, lens: true, len };
                    samples.take(&sampler, isa, &names);
                    let hit = |i: usize| Hit { path: path[i], depth: 1, split: false };
                    let purpose = crate::sampling::Purpose::Light(2);
                    let names = SetNames {
                        seed: &seed,
                        path: &path,
                        index: &index,
                        depth: 1,
                        split: false,
                        purpose: purpose.into(),
                        place: [0, 1],
                        len,
                    };
                    points.take::<3>(&sampler, isa, &names);
                    for i in 0..BATCH {
                        let pixel = PixelSeed::from_word(seed[i]);
                        assert_eq!(samples.get(i), sampler.camera(pixel, index[i]), "{isa}, {i}");
                        let point = sampler.point3(pixel.key(hit(i), purpose), index[i]);
                        assert_eq!(points.numbers.each_ref().map(|column| column[i]), point);
                    }
                }
            }
        }
    }
}
