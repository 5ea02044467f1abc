//! Building blocks of the sample points: the (0,2)-sequence, scrambles, shuffles.

use super::hash::{mix, unit};

/// Returns the digits of the second dimension of Sobol's sequence, given the digits of the first
/// (the digits of the index). It multiplies them by the matrix of binomial coefficients modulo 2,
/// which is a product of five sparse matrices. The lowest bit is the most significant digit.
///
/// Source: I. M. Sobol, "On the Distribution of Points in a Cube" (1967).
#[inline(always)]
pub(super) const fn second(first: u32) -> u32 {
    let mut x = first;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^ (x >> 16)
}

/// Scrambles binary digits by a nested uniform scramble, given the most significant digit in the
/// lowest bit. Whether a digit flips depends only on the more significant digits, so every
/// elementary interval keeps its number of points.
///
/// Source: B. Burley, "Practical Hash-based Owen Scrambling" (JCGT 2020), after S. Laine and T.
/// Karras (2011). The rounds are N. Vegdahl's (2021), which have better avalanche behaviour.
#[inline(always)]
pub(super) fn scramble(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Seed of the scramble of one dimension of the set `key`.
#[inline(always)]
pub(super) fn dimension_key(key: u32, dimension: usize) -> u32 {
    mix(key.wrapping_add((dimension as u32).wrapping_mul(0x68bc_21eb)))
}

/// Permutes indices by a key, mapping aligned blocks of 2^k indices to aligned blocks. Without a
/// shuffle, sets whose points have the same order would be correlated.
#[inline(always)]
pub(super) fn shuffle(index: u32, key: u32) -> u32 {
    scramble(index.reverse_bits(), mix(key ^ 0x02e5_be93))
}

/// Returns point `index` of the (0,2)-sequence of the set `key`: van der Corput's sequence and
/// Sobol's second dimension, each XORed with a random word. The order of the points is shuffled,
/// because the sets of one path would be correlated otherwise (the thesis does not say how it
/// avoids this).
///
/// Source: thesis, chapter 3.2; T. Kollig and A. Keller, "Efficient Multidimensional Sampling" (2002).
#[inline(always)]
pub(super) fn zero_two(index: u32, key: u32) -> [f32; 2] {
    let index = shuffle(index, key);
    let number = |digits: u32, d: u32| unit(digits.reverse_bits() ^ mix(key.wrapping_add(d)));
    [number(index, 0), number(second(index), 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u32) -> [f32; 2] {
        [index, second(index)].map(|digits| unit(digits.reverse_bits()))
    }

    #[test]
    fn the_first_dimension_is_the_thesis_example() {
        let first: Vec<f32> = (1..8).map(|i| point(i)[0]).collect();
        assert_eq!(first, [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
    }

    #[test]
    fn both_start_as_published() {
        // Points 1 to 4 of Joe and Kuo's program. It counts in Gray code, so its point i has the
        // index i ^ (i >> 1) here.
        let expected = [[0.5, 0.5], [0.75, 0.25], [0.25, 0.75], [0.375, 0.375]];
        for (i, expected) in (1u32..).zip(expected) {
            assert_eq!(point(i ^ (i >> 1)), expected, "point {i}");
        }
    }

    #[test]
    fn shuffling_permutes_aligned_blocks() {
        for key in 0..20 {
            let mut block: Vec<_> = (0..16).map(|i| shuffle(i, key)).collect();
            let base = block[0] & !15;
            block.sort_unstable();
            assert_eq!(block, (base..base + 16).collect::<Vec<_>>());
        }
    }
}
