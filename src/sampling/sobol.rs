//! Sobol points, Owen-scrambled by hashing, and the thesis's XOR-scrambled (0,2)-sequence.

use super::hash::mix;
use super::unit;

/// How many dimensions are jointly stratified.
const DIMENSIONS: usize = 5;

/// Columns of the generator matrices, most significant bit first: `DIRECTIONS[d][b]` is what bit
/// `b` of the index adds to dimension `d`.
///
/// Source: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional
/// projections" (2008), their primitive polynomials and initial numbers.
const DIRECTIONS: [[u32; 32]; DIMENSIONS] = [
    van_der_corput(),
    sobol_directions(1, 0, [1, 0, 0]),
    sobol_directions(2, 1, [1, 3, 0]),
    sobol_directions(3, 1, [1, 3, 1]),
    sobol_directions(3, 2, [1, 1, 1]),
];

const fn van_der_corput() -> [u32; 32] {
    let mut v = [0; 32];
    let mut b = 0;
    while b < 32 {
        v[b] = 1 << (31 - b);
        b += 1;
    }
    v
}

/// The recurrence over the primitive polynomial of degree `degree` with inner coefficients `a`,
/// from the odd numbers `m`.
const fn sobol_directions(degree: usize, a: u32, m: [u32; 3]) -> [u32; 32] {
    let mut v = [0u32; 32];
    let mut b = 0;
    while b < 32 {
        if b < degree {
            v[b] = m[b] << (31 - b);
        } else {
            v[b] = v[b - degree] ^ (v[b - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if (a >> (degree - 1 - k)) & 1 == 1 {
                    v[b] ^= v[b - k];
                }
                k += 1;
            }
        }
        b += 1;
    }
    v
}

/// What each byte of the index adds to the digits of a dimension, digits in reverse order.
const BYTES: [[[u32; 256]; 4]; DIMENSIONS - 2] =
    [bytes_of(&DIRECTIONS[2]), bytes_of(&DIRECTIONS[3]), bytes_of(&DIRECTIONS[4])];

const fn bytes_of(directions: &[u32; 32]) -> [[u32; 256]; 4] {
    let mut table = [[0; 256]; 4];
    let mut place = 0;
    while place < 4 {
        let mut value = 1;
        while value < 256usize {
            // What the value without its lowest bit adds is known already.
            let bit = value.trailing_zeros() as usize;
            let rest = table[place][value & (value - 1)];
            table[place][value] = rest ^ directions[8 * place + bit].reverse_bits();
            value += 1;
        }
        place += 1;
    }
    table
}

/// Sobol point `index` in dimension `dimension`, as 32 binary digits, the most significant last.
#[inline(always)]
pub(super) fn reversed_sobol(index: u32, dimension: usize) -> u32 {
    match dimension {
        0 => index,
        // The matrix of binomial coefficients modulo 2 is a product of five sparse ones.
        1 => {
            let mut x = index;
            x ^= (x & 0xaaaa_aaaa) >> 1;
            x ^= (x & 0xcccc_cccc) >> 2;
            x ^= (x & 0xf0f0_f0f0) >> 4;
            x ^= (x & 0xff00_ff00) >> 8;
            x ^ (x >> 16)
        }
        _ => {
            let table = &BYTES[dimension - 2];
            let byte = |place: usize| table[place][(index >> (8 * place)) as usize & 255];
            byte(0) ^ byte(1) ^ byte(2) ^ byte(3)
        }
    }
}

/// Sobol point `index` in dimension `dimension`, as 32 binary digits.
#[inline(always)]
fn sobol(index: u32, dimension: usize) -> u32 {
    reversed_sobol(index, dimension).reverse_bits()
}

/// A nested uniform scramble of binary digits, given the most significant last: which digits flip
/// depends only on the digits above them, so that every elementary interval keeps its number of
/// points.
///
/// Source: B. Burley, "Practical Hash-based Owen Scrambling" (JCGT 2020), after S. Laine and
/// T. Karras (2011); the rounds are N. Vegdahl's (2021), which avalanche better.
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

/// Owen-scrambled Sobol point `index` of the set `key` in dimension `dimension`, in `[0, 1)`.
#[inline(always)]
pub(super) fn owen(index: u32, dimension: usize, key: u32) -> f32 {
    unit(scramble(reversed_sobol(index, dimension), dimension_key(key, dimension)))
}

/// Seed of the scramble of one dimension of the set `key`.
#[inline(always)]
pub(super) fn dimension_key(key: u32, dimension: usize) -> u32 {
    mix(key.wrapping_add((dimension as u32).wrapping_mul(0x68bc_21eb)))
}

/// A permutation of the indices, other for every key, that maps aligned blocks of 2^k indices to
/// aligned blocks: sets whose points have the same order would be correlated.
#[inline(always)]
pub(super) fn shuffle(index: u32, key: u32) -> u32 {
    scramble(index.reverse_bits(), mix(key ^ 0x02e5_be93))
}

/// Point `index` of the (0,2)-sequence of the set `key`: van der Corput and Sobol's second
/// dimension, each XORed with a random word. The order of the points is shuffled, because the
/// sets of one path would be correlated otherwise (the thesis does not say how it avoids that).
///
/// Source: thesis, chapter 3.2; T. Kollig and A. Keller, "Efficient Multidimensional Sampling" (2002).
#[inline(always)]
pub(super) fn zero_two(index: u32, key: u32) -> [f32; 2] {
    let index = shuffle(index, key);
    let number = |d| unit(sobol(index, d) ^ mix(key.wrapping_add(d as u32)));
    [number(0), number(1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn van_der_corput_is_the_thesis_example() {
        let first: Vec<f32> = (1..8).map(|i| unit(sobol(i, 0))).collect();
        assert_eq!(first, [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
    }

    #[test]
    fn sobol_starts_as_published() {
        // Points 1 to 4 of Joe and Kuo's own program.
        let expected = [
            [0.5, 0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25, 0.75],
            [0.25, 0.75, 0.75, 0.75, 0.25],
            [0.375, 0.375, 0.625, 0.875, 0.375],
        ];
        // That program counts in Gray code: its point i has our index i ^ (i >> 1).
        for (i, point) in (1u32..).zip(expected) {
            let index = i ^ (i >> 1);
            assert_eq!(std::array::from_fn(|d| unit(sobol(index, d))), point, "point {i}");
        }
    }

    #[test]
    fn digits_are_those_of_the_matrices() {
        for i in 0..10_000u32 {
            let index = i.wrapping_mul(0x9e37_79b1);
            for (dimension, directions) in DIRECTIONS.iter().enumerate() {
                let digits = (0..32).filter(|bit| index >> bit & 1 == 1);
                let digits = digits.fold(0, |digits, bit| digits ^ directions[bit]);
                assert_eq!(sobol(index, dimension), digits, "point {index}, dimension {dimension}");
            }
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
