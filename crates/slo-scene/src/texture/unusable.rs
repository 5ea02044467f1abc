//! Values of floating-point images that no use could make sense of.

/// What infinite values and overflows count as: the largest half float.
const OVERFLOW: f32 = 65504.0;
const OVERFLOW_HALF: u16 = 0x7bff;

/// What a value may be: its square is still far from the end of f32.
const MOST: f32 = 1e18;

/// Counts the values that were replaced.
#[derive(Debug, Default)]
pub(super) struct Unusable {
    nan: u64,
    negative: u64,
    overflow: u64,
    alpha: u64,
}

impl Unusable {
    /// The value, or what it counts as.
    pub(super) fn float(&mut self, value: f32) -> f32 {
        if value.is_nan() {
            self.nan += 1;
            return 0.0;
        }
        if value < 0.0 {
            self.negative += 1;
            return 0.0;
        }
        if value > MOST {
            self.overflow += 1;
            return OVERFLOW;
        }
        value.abs()
    }

    /// As [`float`](Self::float), of the bits of a half float.
    pub(super) fn half(&mut self, bits: u16) -> u16 {
        match bits {
            ..=OVERFLOW_HALF => bits,
            0x7c00 => {
                self.overflow += 1;
                OVERFLOW_HALF
            }
            0x8000 => 0,
            0x8001..=0xfc00 => {
                self.negative += 1;
                0
            }
            _ => {
                self.nan += 1;
                0
            }
        }
    }

    /// Alpha, or what it counts as.
    pub(super) fn float_alpha(&mut self, value: f32) -> f32 {
        if (0.0..=1.0).contains(&value) {
            return value;
        }
        self.alpha += 1;
        if value > 1.0 { 1.0 } else { 0.0 }
    }

    /// As [`float_alpha`](Self::float_alpha), of the bits of a half float.
    pub(super) fn half_alpha(&mut self, bits: u16) -> u16 {
        const ONE: u16 = 0x3c00;
        match bits {
            ..=ONE => bits,
            0x8000 => 0,
            _ => {
                self.alpha += 1;
                if bits <= 0x7c00 { ONE } else { 0 }
            }
        }
    }

    /// What to say, one line for each kind.
    pub(super) fn warnings(&self) -> Vec<String> {
        let line = |count: u64, what: &str, counts_as: &str| match count {
            0 => None,
            1 => Some(format!("1 value is {what} and counts as {counts_as}")),
            _ => Some(format!("{count} values are {what} and count as {counts_as}")),
        };
        let overflow = "65504, the largest half float";
        let mut warnings = Vec::new();
        warnings.extend(line(self.nan, "NaN", "0"));
        warnings.extend(line(self.negative, "negative", "0"));
        warnings.extend(line(self.overflow, "infinite or more than 1e18", overflow));
        warnings.extend(match self.alpha {
            0 => None,
            1 => Some("1 value of alpha is not from 0 to 1 and is clamped to that".to_owned()),
            n => Some(format!("{n} values of alpha are not from 0 to 1 and are clamped to that")),
        });
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::texels::half;

    #[test]
    fn half_floats_count_as_the_same_floats_do() {
        for bits in 0..=u16::MAX {
            let value = exr::prelude::f16::from_bits(bits).to_f32();
            let (mut halves, mut floats) = (Unusable::default(), Unusable::default());
            assert_eq!(
                half(halves.half(bits)).to_bits(),
                floats.float(value).to_bits(),
                "{bits:x}"
            );
            assert_eq!(half(halves.half_alpha(bits)), floats.float_alpha(value), "{bits:x}");
            assert_eq!(halves.warnings(), floats.warnings(), "{bits:x}");
        }
    }

    #[test]
    fn every_kind_is_counted() {
        let mut found = Unusable::default();
        let values = [1.0, -0.0, -1.0, f32::NAN, f32::INFINITY, 1e30, f32::NEG_INFINITY];
        let kept = values.map(|value| found.float(value));
        assert_eq!(kept, [1.0, 0.0, 0.0, 0.0, 65504.0, 65504.0, 0.0]);
        assert_eq!([0.5, 2.0, -1.0, f32::NAN].map(|a| found.float_alpha(a)), [0.5, 1.0, 0.0, 0.0]);
        insta::assert_snapshot!(found.warnings().join("\n"), @r"
        1 value is NaN and counts as 0
        2 values are negative and count as 0
        2 values are infinite or more than 1e18 and count as 65504, the largest half float
        3 values of alpha are not from 0 to 1 and are clamped to that
        ");
        assert!(Unusable::default().warnings().is_empty());
    }
}
