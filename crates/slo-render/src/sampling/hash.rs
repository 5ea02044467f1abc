//! Hash functions for integers.

/// Maps 32-bit words one to one, such that every input bit changes every output bit about half the
/// time.
///
/// Source: C. Wellons, "Prospecting for Hash Functions" (2018), constants of the exact-bias search
/// by T. Ettinger (bias 0.107).
#[inline(always)]
pub(super) fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0x735a_2d97);
    x ^ (x >> 15)
}

/// Hashes two words into one. Not symmetric in them.
#[inline(always)]
pub(super) fn hash2(a: u32, b: u32) -> u32 {
    mix(a.wrapping_mul(0x9e37_79b1) ^ mix(b.wrapping_add(0x7f4a_7c15)))
}

/// Converts the top 24 bits to a number in `[0, 1)`.
#[inline(always)]
pub(super) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_bit_changes_half_of_the_others() {
        let changed: u32 = (0..32u32)
            .flat_map(|bit| (0..256u32).map(move |i| (bit, i.wrapping_mul(0x0101_6b5d))))
            .map(|(bit, x)| (hash2(1, x) ^ hash2(1, x ^ (1 << bit))).count_ones())
            .sum();
        let mean = f64::from(changed) / (32.0 * 256.0);
        assert!((mean - 16.0).abs() < 0.25, "{mean}");
    }

    #[test]
    fn hashing_is_not_symmetric() {
        assert_ne!(hash2(1, 2), hash2(2, 1));
    }
}
