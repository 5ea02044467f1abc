//! The points of `QUASI`. Each group of dimensions is well distributed by itself, together with the
//! other groups, and together with the groups of the pixels around, for every number of samples.
//!
//! A group of two dimensions is Sobol's (0,2)-sequence with its index multiplied by a matrix. The
//! matrices are upper triangular with ones on the diagonal, so each aligned block of 2^k indices
//! stays a (0, k, 2)-net. The choice of matrices determines how well groups combine. With Sobol's
//! own dimensions, the later pairs stay badly distributed for some hundreds of points; sets that
//! are shuffled independently (padding) are not stratified jointly at all.
//! `scripts/sample_matrices.py` searched for the matrices used here. It minimizes a figure of merit
//! over the groups that meet in an integral, as in L. Paulin et al., "MatBuilder" (2022), with the
//! variance for Owen-scrambled nets: A. Owen, "Scrambled Net Variance for Integrals of Smooth
//! Functions" (1997).
//!
//! All pixels of a block of 8 x 8 share one Owen scramble. Before it, each pixel XORs a mask of its
//! own into the digits. The masks are chosen such that the points of neighbours fill each other's
//! gaps. The errors of neighbours then cancel wherever they see the same thing, so the noise over
//! the screen is blue (E. Heitz and L. Belcour 2019). A. Ahmed and P. Wonka (2020) achieve this
//! with an index that depends on the final number of samples, which is unknown if a picture may be
//! continued later.

use super::hash::unit;
use super::matrices::{MASKS, MATRICES};
use super::names::{HITS, Key};
use super::sobol::{dimension_key, scramble, second, shuffle};

/// Dimensions of a camera sample: lens u and v, time, pixel x and y.
pub(super) const CAMERA: usize = 5;

/// Groups of a camera sample: lens, time, pixel.
const CAMERA_GROUPS: usize = 3;

/// Dimensions of a hit: u, v and w. The third is a group of its own.
pub(super) const AT_HIT: usize = 3;

const GROUPS: usize = CAMERA_GROUPS + 2 * HITS;

/// Number of the hit whose groups serve a hit after `depth` bounces. All hits beyond the last share
/// its groups.
#[inline(always)]
fn hit_of(depth: u32) -> usize {
    (depth as usize).min(HITS - 1)
}

/// For each group and bit of the index, the digits that a set bit XORs into the first dimension.
static COLUMNS: [[u32; 32]; GROUPS] = columns();

const fn columns() -> [[u32; 32]; GROUPS] {
    let mut all = [[0; 32]; GROUPS];
    let mut group = 0;
    while group < GROUPS {
        let mut bit = 0;
        while bit < 32 {
            all[group][bit] = if bit < MATRICES[group].len() {
                MATRICES[group][bit]
            } else {
                any_column(group as u32, bit as u32)
            };
            bit += 1;
        }
        group += 1;
    }
    all
}

/// A pseudo-random column of an upper triangular matrix, for bits of such large indices that a
/// search is not worthwhile.
const fn any_column(group: u32, bit: u32) -> u32 {
    let word = (group * 32 + bit).wrapping_mul(0x9e37_79b1);
    let word = (word ^ (word >> 15)).wrapping_mul(0x735a_2d97);
    (word ^ (word >> 15)) & ((1 << bit) - 1) | (1 << bit)
}

/// Points in a block within which an independent set is shuffled; a power of two.
pub(super) const SHUFFLED: u32 = 1 << 10;

/// Returns the place, in the order of the sequence, of point `index` of a set. A set that is not
/// stratified jointly with earlier hits is shuffled by its key.
#[inline(always)]
fn order(key: Key, index: u32) -> u32 {
    let low = SHUFFLED - 1;
    let shuffled = shuffle(index, key.set) & low | index & !low;
    if key.joint { index } else { shuffled }
}

/// Returns the five dimensions of point `index < 2^BITS` of a set of camera samples. Without
/// `LENS`, the lens dimensions are 0. Free of branches, so that loops over many points are
/// vectorized.
#[inline(always)]
pub(super) fn camera<const BITS: u32, const LENS: bool>(key: Key, index: u32) -> [f32; CAMERA] {
    let lens = if LENS { digits::<BITS>(0, index, key.at) } else { 0 };
    let time = digits::<BITS>(1, index, key.at);
    let pixel = digits::<BITS>(2, index, key.at);
    let number = |dimension, digits| number(digits, dimension, key.set);
    let [u, v] = if LENS { [number(0, lens), number(1, second(lens))] } else { [0.0; 2] };
    [u, v, number(2, time), number(3, pixel), number(4, second(pixel))]
}

/// Returns the dimensions of point `index` of a set at a hit. Its place in the set's [order] is
/// below `2^BITS`. Free of branches.
#[inline(always)]
pub(super) fn at_hit<const BITS: u32>(key: Key, index: u32) -> [f32; AT_HIT] {
    let (index, hit) = (order(key, index), hit_of(key.depth));
    let (group, dimension) = (CAMERA_GROUPS + 2 * hit, CAMERA + AT_HIT * hit);
    let point = digits::<BITS>(group, index, key.at);
    let choice = digits::<BITS>(group + 1, index, key.at);
    let number = |dimension, digits| number(digits, dimension, key.set);
    [number(dimension, point), number(dimension + 1, second(point)), number(dimension + 2, choice)]
}

/// Returns the digits of point `index < 2^BITS` in the first dimension of a group, for the pixel at
/// place `at` of its block. The lowest bit is the most significant digit.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "iterators keep loops over points from being vector code"
)]
fn digits<const BITS: u32>(group: usize, index: u32, at: u32) -> u32 {
    let (columns, masks) = (&COLUMNS[group], &MASKS[group]);
    let mut digits = 0;
    for bit in 0..BITS as usize {
        digits ^= (index >> bit & 1).wrapping_neg() & columns[bit];
    }
    for bit in 0..masks.len() {
        digits ^= (at >> bit & 1).wrapping_neg() & masks[bit];
    }
    digits
}

/// Scrambles digits by the set `set` and converts them to a number in `[0, 1)`.
#[inline(always)]
fn number(digits: u32, dimension: usize, set: u32) -> f32 {
    unit(scramble(digits, dimension_key(set, dimension)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMENSIONS: usize = CAMERA + HITS * AT_HIT;

    /// Digits of a point in any dimension, for the pixel at place `at` of its block.
    fn digits_at(dimension: usize, index: u32, at: u32) -> u32 {
        let (group, is_second) = match dimension {
            0 | 1 => (0, dimension == 1),
            2 => (1, false),
            3 | 4 => (2, dimension == 4),
            _ => {
                let (hit, of_hit) = ((dimension - CAMERA) / AT_HIT, (dimension - CAMERA) % AT_HIT);
                (CAMERA_GROUPS + 2 * hit + of_hit / 2, of_hit == 1)
            }
        };
        let first = super::digits::<32>(group, index, at);
        if is_second { second(first) } else { first }
    }

    fn digits(dimension: usize, index: u32) -> u32 {
        digits_at(dimension, index, 0)
    }

    #[test]
    fn matrices_are_upper_triangular_with_ones_on_the_diagonal() {
        for dimension in 0..DIMENSIONS {
            for bit in 0..32 {
                assert_eq!(digits(dimension, 1 << bit).ilog2(), bit, "dimension {dimension}");
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

    #[test]
    fn fewer_bits_are_enough_for_fewer_points() {
        let key = Key { set: 77, at: 45, depth: 1, joint: false };
        for index in [0, 1, 9, 15] {
            assert_eq!(camera::<4, true>(key, index), camera::<32, true>(key, index));
            let [_, _, rest @ ..] = camera::<32, true>(key, index);
            assert_eq!(camera::<8, false>(key, index)[2..], rest);
        }
        for index in [0, 15, 900, 4000] {
            assert_eq!(at_hit::<12>(key, index), at_hit::<32>(key, index));
        }
    }

    /// Correlation kernel of two points in a dimension in which their digits differ by `digits`.
    fn kernel(digits: u32) -> f64 {
        let part = |scale: u32| 1.0 / (1u64 << scale) as f64;
        let equal = digits.trailing_zeros();
        1.0 + (1.0 - part(equal) - part(equal + 1)) / 2.0
    }

    /// Variance of an Owen-scrambled set of points in some dimensions, divided by the variance of
    /// as many independent points. The integrand has a part of variance 2^-k at each scale 2^-k in
    /// each dimension.
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

    /// Like [`variance`], for the first `2^log` points. In a net all points are equivalent, so one
    /// row of the table of pairs suffices.
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
                all.map(|(i, at)| digits_at(d, i, at)).collect()
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
