//! Which pass of photons a sample uses. Every pass has a map of its own.
//!
//! The borders are functions of the number of a sample alone. Stopping, continuing, parts of the
//! samples and merging therefore use the same maps, whatever the number of samples in the end.

use std::ops::Range;

/// Most light paths of a pass, and so most photons of a slab: they are numbered by 32 bits, and take
/// 48 bytes each.
pub const MOST_PATHS: u64 = 1 << 23;

/// Samples of the first passes: one each.
const SINGLE: u32 = 8;
/// Samples up to which a pass serves two.
const PAIRED: u32 = 64;
/// Samples of each later pass.
const LATER: u32 = 4;

/// The first pass that serves more than one sample, and the first that serves [`LATER`].
const FIRST_PAIR: u32 = SINGLE;
const FIRST_LATER: u32 = FIRST_PAIR + (PAIRED - SINGLE) / 2;

/// Returns the pass whose map sample number `sample` of every pixel uses.
#[inline(always)]
pub fn pass_of(sample: u32) -> u32 {
    let pair = FIRST_PAIR + sample.saturating_sub(SINGLE) / 2;
    let later = FIRST_LATER + sample.saturating_sub(PAIRED) / LATER;
    let early = if sample < SINGLE { sample } else { pair };
    if sample < PAIRED { early } else { later }
}

/// Returns the numbers of the samples that a pass serves.
pub fn samples_of(pass: u32) -> Range<u32> {
    let (start, count) = match pass {
        _ if pass < FIRST_PAIR => (pass, 1),
        _ if pass < FIRST_LATER => (SINGLE + (pass - FIRST_PAIR) * 2, 2),
        _ => (PAIRED.saturating_add((pass - FIRST_LATER).saturating_mul(LATER)), LATER),
    };
    start..start.saturating_add(count)
}

/// Returns the radius of a pass as a share of that of the first.
///
/// After `n` samples the square is the product of `(j + 2/3) / (j + 1)` for `j` from 1 to `n`, which
/// makes noise and bias fall together.
///
/// Source: C. Knaus and M. Zwicker, "Progressive Photon Mapping: A Probabilistic Approach" (2011),
/// with samples in the place of passes.
pub fn radius_share(pass: u32) -> f32 {
    const ALPHA: f64 = 2.0 / 3.0;
    let n = f64::from(samples_of(pass).start);
    let log = libm::lgamma(n + 1.0 + ALPHA) - libm::lgamma(1.0 + ALPHA) - libm::lgamma(n + 2.0);
    libm::exp(0.5 * log) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_one_pass() {
        let mut next = 0;
        for pass in 0..200 {
            let samples = samples_of(pass);
            assert_eq!(samples.start, next, "pass {pass}");
            assert!(samples.clone().all(|sample| pass_of(sample) == pass), "pass {pass}");
            next = samples.end;
        }
        assert_eq!([0, 7, 8, 36, 37].map(|pass| samples_of(pass).len()), [1, 1, 2, 4, 4]);
        assert_eq!(pass_of(u32::MAX), pass_of(u32::MAX - 1));
    }

    #[test]
    fn radii_shrink_as_published() {
        let mut square = 1.0f64;
        for sample in 0..1000 {
            if sample > 0 {
                square *= (f64::from(sample) + 2.0 / 3.0) / (f64::from(sample) + 1.0);
            }
            if samples_of(pass_of(sample)).start == sample {
                let found = f64::from(radius_share(pass_of(sample)));
                assert!((found / square.sqrt() - 1.0).abs() < 1e-6, "sample {sample}: {found}");
            }
        }
    }
}
