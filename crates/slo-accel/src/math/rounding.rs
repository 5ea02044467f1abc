//! Rounding: bounds of errors, and f64 rounded down and up to f32.

/// Half the distance from 1 to the next f32: the relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// Bound of the relative error of `n` rounded operations in a row.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms, lemma 3.1.
#[inline]
pub const fn gamma(n: u32) -> f32 {
    let ne = n as f32 * UNIT_ROUNDOFF;
    ne / (1.0 - ne)
}

/// The largest f32 that is not above `x`; finite for finite `x`.
#[inline]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    let below = if f64::from(nearest) > x { nearest.next_down() } else { nearest };
    below.clamp(-f32::MAX, f32::MAX)
}

/// The smallest f32 that is not below `x`; finite for finite `x`.
#[inline]
pub fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_encloses() {
        for x in [0.0, 1.0, 0.1, -0.1, 1e-300, -1e-300, 16_777_217.0] {
            assert!(f64::from(round_down(x)) <= x && x <= f64::from(round_up(x)), "{x}");
            assert!(round_down(x).next_up() >= round_up(x), "{x}");
        }
        assert_eq!(round_up(1e300), f32::MAX);
        assert_eq!(round_down(1e300), f32::MAX);
    }
}
