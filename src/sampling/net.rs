//! The points of `QUASI`: groups of dimensions that are well distributed each, with the others, and
//! with those of the pixels around, for every number of samples.
//!
//! A group of two dimensions is Sobol's (0,2)-sequence, its index multiplied by a matrix. The
//! matrices are upper triangular with ones on the diagonal, so that each aligned block of 2^k
//! indices stays a (0, k, 2)-net; which they are decides how well groups go with each other.
//! Sobol's own dimensions leave the later pairs badly distributed for some hundreds of points;
//! sets that are shuffled independently (padding) know nothing of each other. The ones here
//! were found by `scripts/sample_matrices.py`, by a figure of merit over the groups that meet in an
//! integral, as in L. Paulin et al., "MatBuilder" (2022), and by its variance for Owen-scrambled
//! nets: A. Owen, "Scrambled Net Variance for Integrals of Smooth Functions" (1997).
//!
//! All pixels of a block of 8 x 8 share one Owen scramble, and each XORs a mask to the digits
//! before, chosen such that the points of neighbours fill the gaps between each other's. Their
//! errors then cancel where pixels see the same: noise over the screen is blue (E. Heitz and L.
//! Belcour 2019; A. Ahmed and P. Wonka 2020 get there by an index that needs to know the number
//! of samples beforehand, which a picture that goes on later does not).

use super::hash::Key;
use super::matrices::{MASKS, MATRICES};
use super::sobol::{dimension_key, scramble, second, shuffle};
use super::unit;

/// Pixels of a block whose samples belong together: 8 x 8.
pub(super) const BLOCK: u32 = 64;

/// Numbers of all groups: lens u and v, time, pixel x and y, then u, v and w at each of
/// [`HITS`] hits.
const DIMENSIONS: usize = CAMERA + HITS * AT_HIT;

/// Dimensions of a camera sample.
pub(super) const CAMERA: usize = 5;

/// Hits of a path that have groups of their own.
const HITS: usize = 3;

/// Dimensions of a hit.
pub(super) const AT_HIT: usize = 3;

/// First dimension of the hit after `depth` bounces; those beyond the last share its own.
#[inline(always)]
pub(super) fn first_dimension(depth: u32) -> usize {
    CAMERA + (depth as usize).min(HITS - 1) * AT_HIT
}

/// Whether the hit after `depth` bounces has a group of its own.
#[inline(always)]
pub(super) fn has_group(depth: u32) -> bool {
    (depth as usize) < HITS
}

/// By dimension, what each bit of the index adds to the digits.
const COLUMNS: [[u32; 32]; DIMENSIONS] = columns();

/// By dimension and place in the block, what is XORed to the digits.
static MASK: [[u32; BLOCK as usize]; DIMENSIONS] = masks();

/// Row of [`MATRICES`] of a dimension, and whether it is the second of its group.
const fn place(dimension: usize) -> (usize, bool) {
    match dimension {
        0 | 1 => (0, dimension == 1),
        2 => (1, false),
        3 | 4 => (2, dimension == 4),
        _ => {
            let (hit, of_hit) = ((dimension - CAMERA) / AT_HIT, (dimension - CAMERA) % AT_HIT);
            (3 + 2 * hit + of_hit / 2, of_hit == 1)
        }
    }
}

const fn columns() -> [[u32; 32]; DIMENSIONS] {
    let mut all = [[0; 32]; DIMENSIONS];
    let mut d = 0;
    while d < DIMENSIONS {
        let (group, is_second) = place(d);
        let mut bit = 0;
        while bit < 32 {
            let first = if bit < MATRICES[group].len() {
                MATRICES[group][bit]
            } else {
                any_column(group as u32, bit as u32)
            };
            all[d][bit] = if is_second { second(first) } else { first };
            bit += 1;
        }
        d += 1;
    }
    all
}

/// A column for so many points that no search is worth it.
const fn any_column(group: u32, bit: u32) -> u32 {
    let word = (group * 32 + bit).wrapping_mul(0x9e37_79b1);
    let word = (word ^ (word >> 15)).wrapping_mul(0x735a_2d97);
    (word ^ (word >> 15)) & ((1 << bit) - 1) | (1 << bit)
}

const fn masks() -> [[u32; BLOCK as usize]; DIMENSIONS] {
    let mut all = [[0; BLOCK as usize]; DIMENSIONS];
    let mut d = 0;
    while d < DIMENSIONS {
        let (group, is_second) = place(d);
        let mut at = 1;
        while at < BLOCK as usize {
            let bit = at.trailing_zeros() as usize;
            let first = MASKS[group][bit];
            all[d][at] = all[d][at & (at - 1)] ^ if is_second { second(first) } else { first };
            at += 1;
        }
        d += 1;
    }
    all
}

/// So many points of a set change places with each other; a power of two.
pub(super) const SHUFFLED: u32 = 1 << 10;

/// Which point of its dimensions point `index` of a set is. Sets whose points do not belong to those
/// of the same number elsewhere come in an order of their own.
#[inline(always)]
pub(super) fn order(key: Key, index: u32) -> u32 {
    let low = SHUFFLED - 1;
    let shuffled = shuffle(index, key.set) & low | index & !low;
    if key.joint { index } else { shuffled }
}

/// Digits of point `index` in a dimension, the most significant the lowest bit.
#[inline(always)]
pub(super) fn digits(dimension: usize, index: u32) -> u32 {
    let (mut rest, mut digits) = (index, 0);
    while rest != 0 {
        digits ^= COLUMNS[dimension][rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    digits
}

/// By place in the block, what is XORed to the digits of a dimension.
#[inline(always)]
pub(super) fn masks_of(dimension: usize) -> &'static [u32; BLOCK as usize] {
    &MASK[dimension]
}

/// The number in `[0, 1)` that masked digits become in the set `set`.
#[inline(always)]
pub(super) fn number(digits: u32, dimension: usize, set: u32) -> f32 {
    unit(scramble(digits, dimension_key(set, dimension)))
}

/// Digits of the first points, by dimension: all sets and pixels scramble the same ones.
#[derive(Debug, Default)]
pub(crate) struct Digits {
    /// All of the same length.
    dimensions: [Vec<u32>; DIMENSIONS],
}

impl Digits {
    /// Beyond so many points the digits are computed again for each use.
    pub(super) const MOST: u32 = 1 << 16;

    /// Makes sure that those of the points below `end` are there, if it is not beyond
    /// [`MOST`](Self::MOST).
    pub(super) fn reach(&mut self, end: u32) {
        for (dimension, known) in self.dimensions.iter_mut().enumerate() {
            let start = known.len() as u32;
            known.extend((start..end.min(Self::MOST)).map(|index| digits(dimension, index)));
        }
    }

    /// Those of a dimension.
    #[inline(always)]
    pub(super) fn of(&self, dimension: usize) -> &[u32] {
        &self.dimensions[dimension]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(dimension: usize) -> impl Iterator<Item = u32> {
        (0..32).map(move |bit| COLUMNS[dimension][bit])
    }

    #[test]
    fn matrices_are_upper_triangular_with_ones_on_the_diagonal() {
        for dimension in 0..DIMENSIONS {
            for (bit, column) in bits(dimension).enumerate() {
                assert_eq!(column.ilog2() as usize, bit, "dimension {dimension}");
            }
        }
    }

    #[test]
    fn groups_of_two_are_nets_for_every_power_of_two() {
        let planes = [[0, 1], [3, 4], [5, 6], [8, 9], [11, 12]];
        for ([a, b], samples) in planes.into_iter().flat_map(|p| (0..12).map(move |k| (p, k))) {
            for in_a in 0..=samples {
                let in_b = samples - in_a;
                let cell = |index| {
                    let cells = [(digits(a, index), in_a), (digits(b, index), in_b)];
                    cells.map(|(digits, count)| digits & ((1 << count) - 1))
                };
                let mut cells: Vec<_> = (0..1 << samples).map(cell).collect();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), 1 << samples, "dimensions {a} and {b}, {in_a} digits");
            }
        }
    }

    /// What two points have in common in a dimension, whose digits differ by `digits`.
    fn kernel(digits: u32) -> f64 {
        let part = |scale: u32| 1.0 / (1u64 << scale) as f64;
        let equal = digits.trailing_zeros();
        1.0 + (1.0 - part(equal) - part(equal + 1)) / 2.0
    }

    /// Variance of an Owen-scrambled set of points in some dimensions over that of independent
    /// ones: for an integrand whose part at scale 2^-k has the variance 2^-k in each dimension.
    fn variance(dimensions: &[usize], words: &[Vec<u32>]) -> f64 {
        let n = words[0].len();
        let sum: f64 = (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| {
                dimensions.iter().map(|&d| kernel(words[d][i] ^ words[d][j])).product::<f64>()
            })
            .sum();
        let independent = dimensions.iter().map(|_| 1.5).product::<f64>() - 1.0;
        (sum / (n * n) as f64 - 1.0) / (independent / n as f64)
    }

    /// As [`variance`], of the first `2^log` points: of a net one row of the table is enough.
    fn variance_of_net(dimensions: [usize; 2], log: u32) -> f64 {
        let values = (0..1 << log).map(|i| dimensions.map(|d| kernel(digits(d, i))));
        let sum: f64 = values.map(|[a, b]| a * b).sum();
        (sum - f64::from(1u32 << log)) / (1.5 * 1.5 - 1.0)
    }

    #[test]
    fn no_two_dimensions_are_bad_together() {
        let pairs = (0..DIMENSIONS).flat_map(|a| (0..a).map(move |b| [b, a]));
        for (pair, log) in pairs.flat_map(|pair| (3..=12).map(move |log| (pair, log))) {
            let most = if log < 8 { 1.75 } else { 0.5 };
            let figure = variance_of_net(pair, log);
            assert!(figure < most, "{pair:?}, 2^{log} samples: {figure}");
        }
    }

    #[test]
    fn groups_are_good_together_and_with_neighbours() {
        let of = |samples: u32, pixels: u32| -> Vec<Vec<u32>> {
            let words = |d: usize| {
                let all = (0..samples).flat_map(|i| (0..pixels).map(move |at| (i, at)));
                all.map(|(i, at)| digits(d, i) ^ MASK[d][at as usize]).collect()
            };
            (0..DIMENSIONS).map(words).collect()
        };
        // Pixel and light, lens and light, time and pixel.
        for together in [&[3, 4, 5, 6][..], &[0, 1, 5, 6], &[2, 3, 4]] {
            for samples in [4, 16, 64] {
                let figure = variance(together, &of(samples, 1));
                assert!(figure < 0.75, "{together:?}, {samples} samples: {figure}");
            }
        }
        for (alone, samples) in [[5, 6], [0, 1]].into_iter().flat_map(|d| [(d, 1), (d, 4), (d, 16)])
        {
            for pixels in [4, 16, 64] {
                let one = variance(&alone, &of(samples, 1));
                let figure = variance(&alone, &of(samples, pixels)) / one;
                assert!(figure < 0.8, "{alone:?}, {samples} samples, {pixels} pixels: {figure}");
            }
        }
    }
}
