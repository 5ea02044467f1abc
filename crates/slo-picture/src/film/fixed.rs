//! Fixed-point numbers whose sums do not depend on their order.

use std::ops::{Add, AddAssign};

/// Light: a multiple of 2^-24 in 64 bits without a sign. Sums are exact up to [`MAX`](Self::MAX) and
/// end there: a sum is the lesser of the true sum and `MAX`, in any order, because no number is
/// negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(u64);

/// 2^24
const ONE: f64 = (1u64 << 24) as f64;

impl Fixed {
    /// The largest number, almost 2^40: 65535 times [`LIMIT`](Self::LIMIT) is less.
    pub const MAX: Self = Self(u64::MAX);
    /// The largest contribution.
    pub const LIMIT: f32 = (1 << 24) as f32;
    /// 0
    pub const ZERO: Self = Self(0);

    /// The nearest multiple of 2^-24; `None` for numbers that it can't [hold](Self::holds).
    #[inline]
    pub fn new(x: f32) -> Option<Self> {
        Self::holds(x).then(|| Self::clamped(x))
    }

    /// Whether a number lies between 0 and [`LIMIT`](Self::LIMIT).
    #[inline(always)]
    pub fn holds(x: f32) -> bool {
        (0.0..=Self::LIMIT).contains(&x)
    }

    /// The nearest multiple of 2^-24: [`LIMIT`](Self::LIMIT) for larger numbers, and 0 for negative
    /// ones and for what is not a number.
    #[inline(always)]
    pub fn clamped(x: f32) -> Self {
        let x = if x > 0.0 { x } else { 0.0 };
        Self(rounded(if x < Self::LIMIT { x } else { Self::LIMIT }) as u64)
    }

    /// The number, rounded to f64.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / ONE
    }

    /// The number as a count of 2^-24.
    #[inline]
    pub fn units(self) -> u64 {
        self.0
    }

    /// That many times 2^-24.
    #[inline]
    pub fn from_units(units: u64) -> Self {
        Self(units)
    }

    /// The difference; 0 if `other` is larger.
    #[inline]
    pub fn less(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Add for Fixed {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Fixed {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// What is no light and may be negative, such as parts of normals: a multiple of 2^-24 in 64 bits,
/// whose sums are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SignedFixed(i64);

impl SignedFixed {
    /// The largest number.
    pub const MAX: Self = Self(i64::MAX);
    /// Largest magnitude of one contribution.
    pub const LIMIT: f32 = (1 << 17) as f32;

    /// The nearest multiple of 2^-24: [`LIMIT`](Self::LIMIT), with its sign, for larger numbers, and 0
    /// for what is not a number.
    #[inline(always)]
    pub fn clamped(x: f32) -> Self {
        let x = if x.is_nan() { 0.0 } else { x.clamp(-Self::LIMIT, Self::LIMIT) };
        Self(rounded(x))
    }

    /// The number, rounded to f64.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / ONE
    }

    /// The number as a count of 2^-24.
    #[inline]
    pub fn units(self) -> i64 {
        self.0
    }

    /// That many times 2^-24.
    #[inline]
    pub fn from_units(units: i64) -> Self {
        Self(units)
    }

    /// The exact sum; `None` on overflow.
    #[inline]
    pub fn checked_add(self, other: Self) -> Option<Self> {
        self.0.checked_add(other.0).map(Self)
    }
}

impl AddAssign for SignedFixed {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

/// Returns 2^24 times a number below 2^26, rounded to a whole number, ties to even.
#[inline(always)]
fn rounded(x: f32) -> i64 {
    // Adding 1.5 * 2^52 rounds to a whole number and leaves it in the low bits.
    const MAGIC: f64 = 1.5 * (1u64 << 52) as f64;
    let shifted = f64::from(x) * ONE + MAGIC;
    (shifted.to_bits() as i64).wrapping_sub(MAGIC.to_bits() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_to_nearest() {
        let step = 1.0 / ONE as f32;
        for (x, units) in [
            (0.0, 0),
            (1.0, 1 << 24),
            (-1.0, -(1 << 24)),
            (step * 0.75, 1),
            (step * 0.25, 0),
            (-step * 0.75, -1),
            (131_072.0, 1 << 41),
        ] {
            assert_eq!(SignedFixed::clamped(x), SignedFixed(units), "{x}");
            let light = u64::try_from(units).ok().map(Fixed);
            assert_eq!(Fixed::new(x), light, "{x}");
        }
        assert_eq!(Fixed::new(1e7), Some(Fixed(10_000_000 << 24)));
        assert_eq!(Fixed::new(Fixed::LIMIT), Some(Fixed(1 << 48)));
    }

    #[test]
    fn what_can_not_be_summed_is_refused() {
        for (x, clamped) in [
            (f32::NAN, 0.0),
            (f32::INFINITY, Fixed::LIMIT),
            (f32::NEG_INFINITY, 0.0),
            (2e7, Fixed::LIMIT),
            (-1e6, 0.0),
        ] {
            assert_eq!(Fixed::new(x), None, "{x}");
            assert_eq!(Some(Fixed::clamped(x)), Fixed::new(clamped), "{x}");
        }
    }

    #[test]
    fn the_brightest_samples_fit() {
        let sum = |value: f32, count| {
            let one = Fixed::new(value).unwrap();
            (0..count).fold(Fixed::ZERO, |sum, _| sum + one)
        };
        assert_eq!(sum(1e7, 65_535).to_f64(), 1e7 * 65_535.0);
        assert!(sum(Fixed::LIMIT, 65_535) < Fixed::MAX);
        assert_eq!(sum(Fixed::LIMIT, 65_536), Fixed::MAX);
    }

    #[test]
    fn sums_do_not_depend_on_their_order() {
        for scale in [1.0, 1e12] {
            let values: Vec<_> =
                (0..200_000).map(|i| Fixed::clamped(scale / (i as f32 + 0.7))).collect();
            let sum = |it: &mut dyn Iterator<Item = &Fixed>| it.fold(Fixed::ZERO, |a, b| a + *b);
            let forward = sum(&mut values.iter());
            let halves = values.split_at(77_777);
            assert_eq!(forward, sum(&mut values.iter().rev()));
            assert_eq!(forward, sum(&mut halves.1.iter()) + sum(&mut halves.0.iter()));
            assert_eq!(forward == Fixed::MAX, scale > 1.0);
        }
    }
}
