//! Fixed-point numbers whose sums are exact.

use std::ops::{Add, AddAssign};

/// A multiple of 2^-24 in 64 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(i64);

/// 2^24
const ONE: f64 = (1u64 << 24) as f64;

impl Fixed {
    /// The largest number.
    pub const MAX: Self = Self(i64::MAX);
    /// The smallest number.
    pub const MIN: Self = Self(i64::MIN);
    /// Largest magnitude of one contribution.
    pub const LIMIT: f32 = (1 << 17) as f32;
    /// Contributions, of any sign, that fit into a sum.
    pub const MOST: u32 = (1 << 22) - 1;

    /// 0
    pub const ZERO: Self = Self(0);

    /// The nearest multiple of 2^-24; `None` for numbers that it can't [hold](Self::holds).
    #[inline]
    pub fn new(x: f32) -> Option<Self> {
        Self::holds(x).then(|| Self::clamped(x))
    }

    /// Whether a number is finite and not larger than [`LIMIT`](Self::LIMIT).
    #[inline(always)]
    pub fn holds(x: f32) -> bool {
        x.abs() <= Self::LIMIT
    }

    /// The nearest multiple of 2^-24: [`LIMIT`](Self::LIMIT), with its sign, for larger numbers, and 0
    /// for what is not a number.
    #[inline(always)]
    pub fn clamped(x: f32) -> Self {
        // Adding 1.5 * 2^52 rounds to a whole number, ties to even, and leaves it in the low bits.
        const MAGIC: f64 = 1.5 * (1u64 << 52) as f64;
        let x = if x.is_nan() { 0.0 } else { x.clamp(-Self::LIMIT, Self::LIMIT) };
        let shifted = f64::from(x) * ONE + MAGIC;
        Self((shifted.to_bits() as i64).wrapping_sub(MAGIC.to_bits() as i64))
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

impl Add for Fixed {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for Fixed {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
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
            (Fixed::LIMIT, 1 << 41),
        ] {
            assert_eq!(Fixed::new(x), Some(Fixed(units)), "{x}");
        }
    }

    #[test]
    fn what_can_not_be_summed_is_refused() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e6, -1e6] {
            assert_eq!(Fixed::new(x), None, "{x}");
        }
    }

    #[test]
    fn as_many_as_a_sum_holds() {
        for limit in [Fixed::LIMIT, -Fixed::LIMIT] {
            let one = Fixed::new(limit).unwrap();
            let most = one.units().checked_mul(Fixed::MOST.into()).map(Fixed::from_units).unwrap();
            assert!(most.to_f64().abs() > 5e11);
            let more = most.checked_add(one).and_then(|sum| sum.checked_add(one));
            assert_eq!(more, None);
        }
    }

    #[test]
    fn sums_do_not_depend_on_their_order() {
        let values: Vec<_> = (0..1000).map(|i| Fixed::new(1.0 / (i as f32 + 0.7))).collect();
        let sum = |it: &mut dyn Iterator<Item = &Option<Fixed>>| {
            it.fold(Fixed::default(), |a, b| a + b.unwrap())
        };
        assert_eq!(sum(&mut values.iter()), sum(&mut values.iter().rev()));
    }
}
