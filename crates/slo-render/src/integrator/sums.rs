//! Exact sums of contributions, which are rounded once and then added as integers.

use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};
use slo_accel::{Isa, Lanewise};
use slo_picture::film::Fixed;

use super::work::SampleSum;

/// Exact sums, one for each slot, and working memory for adding to them.
#[derive(Debug)]
pub(super) struct Sums {
    sums: Vec<SampleSum>,
    rounded: [Column<u64>; 3],
}

impl Default for Sums {
    fn default() -> Self {
        Self { sums: Vec::new(), rounded: [[0; BATCH]; 3] }
    }
}

impl Sums {
    /// Resets to `len` sums of 0.
    pub(super) fn reset(&mut self, len: usize) {
        self.sums.clear();
        self.sums.resize(len, SampleSum::default());
    }

    /// Adds up the sums of each of `len` entries. The sums consist of `groups + 1` blocks of equal
    /// length, one for each group of lights, and a block consists of copies of the sums of all
    /// entries. Returns the sums of all light, and those of each group but the first.
    pub(super) fn fold(&mut self, len: usize, groups: usize) -> (&[SampleSum], &[SampleSum]) {
        let block = self.sums.len() / (groups + 1);
        // First the copies within each block.
        for group in 0..=groups {
            for copy in (len..block).step_by(len.max(1)) {
                for i in 0..len {
                    let more = self.sums[group * block + copy + i];
                    add(&mut self.sums[group * block + i], more);
                }
            }
        }
        for group in 1..=groups {
            for i in 0..len {
                let more = self.sums[group * block + i];
                add(&mut self.sums[i], more);
                self.sums[group * len + i] = more;
            }
        }
        self.sums.truncate((groups + 1) * len);
        self.sums.split_at(len.min(self.sums.len()))
    }

    /// Adds the first `len` radiances, each to its slot. Returns how many numbers
    /// were outside the film's range, and clamped, or no numbers, and left out.
    pub(super) fn add(
        &mut self,
        isa: Isa,
        radiance: &Vec3s,
        slot: &Column<u32>,
        len: usize,
    ) -> u64 {
        let refused = isa.run(Round { radiance, len, to: &mut self.rounded });
        let Self { sums, rounded: [red, green, blue] } = self;
        // Neighbours mostly share a slot, so their sum stays in registers.
        let mut at = 0;
        // That sum can't overflow: no number of a batch is larger than 2^48.
        let mut sum = [0u64; 3];
        for i in 0..len.min(BATCH) {
            let slot = slot[i] as usize;
            if slot != at {
                put(sums, at, std::mem::take(&mut sum));
                at = slot;
            }
            sum = [sum[0] + red[i], sum[1] + green[i], sum[2] + blue[i]];
        }
        put(sums, at, sum);
        refused
    }
}

#[inline(always)]
fn add(to: &mut SampleSum, more: SampleSum) {
    to.iter_mut().zip(more).for_each(|(to, more)| *to += more);
}

#[inline(always)]
fn put(sums: &mut [SampleSum], slot: usize, sum: [u64; 3]) {
    if let Some(to) = sums.get_mut(slot) {
        add(to, sum.map(Fixed::from_units));
    }
}

/// Rounds radiances. Numbers that are too large are clamped, what is not a number becomes 0, and
/// both are counted.
struct Round<'a> {
    radiance: &'a Vec3s,
    len: usize,
    to: &'a mut [Column<u64>; 3],
}

impl Lanewise for Round<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let len = self.len;
        let mut refused = 0;
        for (from, to) in self.radiance.columns().into_iter().zip(self.to) {
            refused += round(from, len, to);
        }
        refused
    }
}

#[inline(always)]
fn round(from: &Column<f32>, len: usize, to: &mut Column<u64>) -> u64 {
    for i in lanes(len) {
        to[i] = Fixed::clamped(from[i]).units();
    }
    let mut refused = 0;
    for x in &from[..len.min(BATCH)] {
        refused += u32::from(!Fixed::holds(*x));
    }
    u64::from(refused)
}
