//! Fixed-point numbers for sums of lengths, which may be very large or very small.

use std::ops::AddAssign;

/// A multiple of 2^-60 in 128 bits, whose sums are exact: of lengths in units of the scene, of texture
/// coordinates, of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Wide(i128);

/// 2^60
const ONE: f64 = (1u64 << 60) as f64;

impl Wide {
    /// Largest magnitude of one contribution: 2^40.
    pub const LIMIT: f64 = (1u64 << 40) as f64;
    /// 1
    pub const ONE: Self = Self(1 << 60);

    /// The number without what is below 2^-60: [`LIMIT`](Self::LIMIT), with its sign, for larger numbers,
    /// and 0 for what is not a number.
    pub fn clamped(x: f64) -> Self {
        Self((x.clamp(-Self::LIMIT, Self::LIMIT) * ONE) as i128)
    }

    /// The number, rounded to f64.
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / ONE
    }

    /// The number as a count of 2^-60.
    pub fn units(self) -> i128 {
        self.0
    }

    /// That many times 2^-60.
    pub fn from_units(units: i128) -> Self {
        Self(units)
    }

    /// The exact sum; `None` on overflow.
    pub fn checked_add(self, other: Self) -> Option<Self> {
        self.0.checked_add(other.0).map(Self)
    }
}

impl AddAssign for Wide {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits() {
        for x in [0.0, 1.0, -1.0, 0.1, 1e10, -123_456.789, 1e-9, Wide::LIMIT] {
            let back = Wide::clamped(x).to_f64();
            assert!((back - x).abs() <= 1.0 / ONE, "{x}: {back}");
        }
        assert_eq!(Wide::clamped(1.0), Wide::ONE);
        for (x, clamped) in [(f64::NAN, 0.0), (f64::INFINITY, Wide::LIMIT), (-1e30, -Wide::LIMIT)] {
            assert_eq!(Wide::clamped(x), Wide::clamped(clamped), "{x}");
        }
    }

    #[test]
    fn sums_of_the_most_samples_fit() {
        let most = Wide::from_units(Wide::clamped(Wide::LIMIT).units() << 22);
        assert!(most.checked_add(most).is_some());
        assert_eq!(Wide::from_units(i128::MAX).checked_add(Wide::ONE), None);
    }
}
