//! Elementary functions of f32 without branches and without the platform's math library: they give
//! the same bits everywhere, and loops over them become SIMD code.
//!
//! The tests measure the stated errors against f64 over the stated domains.

/// (sin, cos) of `turns` full turns, for `|turns| < 2^20`; absolute error below 2e-7.
#[inline(always)]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let (quadrant, q) = round(turns * 4.0);
    let x = (turns - quadrant * 0.25) * std::f32::consts::TAU;
    let (s, c) = sin_cos_octant(x);
    let (s, c) = if q & 1 == 1 { (c, s) } else { (s, c) };
    (if q & 2 == 2 { -s } else { s }, if q.wrapping_add(1) & 2 == 2 { -c } else { c })
}

/// (sin, cos) of `x` radians, for `|x| <= pi / 4`; absolute error below 1.5e-7.
///
/// A Taylor series, up to the term that is below rounding.
#[inline(always)]
pub fn sin_cos_octant(x: f32) -> (f32, f32) {
    let y = x * x;
    let s = x
        * (1.0
            + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362_880.0)))));
    let c = 1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40_320.0))));
    (s, c)
}

/// The angle of the direction (x, y) in full turns from the x axis toward the y axis, from -0.5 to
/// 0.5; absolute error below 4e-8. 0 if both are 0; its sign is that of `y`, also for y = -0.
///
/// `x` and `y` are finite.
#[inline(always)]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    // The octant of (x, y) is turned into the first, and its upper half by another eighth.
    let (ax, ay) = (x.abs(), y.abs());
    let (low, high) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let q = low / high.max(f32::MIN_POSITIVE);
    let is_upper = q > 0.414_213_57;
    let t = if is_upper { (q - 1.0) / (q + 1.0) } else { q };
    let offset = if is_upper { 0.125 } else { 0.0 };
    let z = t * t;
    // atan t / t by minimax, for |t| <= tan(pi / 8).
    let series =
        1.0 + z * (-0.333_329_5 + z * (0.199_777_1 + z * (-0.138_776_86 + z * 0.080_537_45)));
    let angle = offset + t * series * (0.5 * std::f32::consts::FRAC_1_PI);
    let angle = if ax < ay { 0.25 - angle } else { angle };
    let angle = if x < 0.0 { 0.5 - angle } else { angle };
    angle.copysign(y)
}

/// The nearest whole number, ties to even, for `|x| < 2^22`. Also returns it as a word of which the
/// low 22 bits count: a conversion to an integer would keep loops from becoming SIMD code.
#[inline(always)]
fn round(x: f32) -> (f32, u32) {
    const MAGIC: f32 = 1.5 * (1u32 << 23) as f32;
    let shifted = x + MAGIC;
    (shifted - MAGIC, shifted.to_bits())
}

/// Logarithm to base 2 of a positive, normal number; absolute error below 2e-7 + 1e-7 |log2 x|.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    // x = 2^exponent m, m in [sqrt(1/2), sqrt(2)); log2 m by the series of artanh.
    let bits = x.to_bits();
    let offset = bits.wrapping_sub(0x3f35_04f3);
    let exponent = (offset as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((exponent as u32) << 23));
    let z = (m - 1.0) / (m + 1.0);
    let y = z * z;
    let series = 2.0
        + y * (2.0 / 3.0 + y * (2.0 / 5.0 + y * (2.0 / 7.0 + y * (2.0 / 9.0 + y * (2.0 / 11.0)))));
    exponent as f32 + z * series * std::f32::consts::LOG2_E
}

/// 2 to the power of `x`; relative error below 3e-7 for `-126 <= x < 127`, 0 below that domain,
/// about 2^127 above it.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let clamped = x.clamp(-126.0, 127.0);
    let (whole, word) = round(clamped);
    let y = (clamped - whole) * std::f32::consts::LN_2;
    let series = 1.0
        + y * (1.0
            + y * (0.5
                + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0))))));
    let scaled = f32::from_bits(word.wrapping_add(127) << 23) * series;
    if x < -126.0 { 0.0 } else { scaled }
}

/// `x` to the power of `y`, for `0 <= x` and `0 < y`; 0 for `x` below the smallest normal number.
#[inline(always)]
pub fn power(x: f32, y: f32) -> f32 {
    let result = exp2(y * log2(x.max(f32::MIN_POSITIVE)));
    if x < f32::MIN_POSITIVE { 0.0 } else { result }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: f64, to: f64) -> impl Iterator<Item = f32> {
        (0..=20_000).map(move |i| (from + (to - from) * f64::from(i) / 20_000.0) as f32)
    }

    #[test]
    fn sine_and_cosine() {
        for turns in steps(-3.0, 3.0) {
            let (s, c) = sin_cos_turns(turns);
            let x = f64::from(turns) * std::f64::consts::TAU;
            assert!((f64::from(s) - libm::sin(x)).abs() < 2e-7, "sin {turns}: {s}");
            assert!((f64::from(c) - libm::cos(x)).abs() < 2e-7, "cos {turns}: {c}");
        }
    }

    #[test]
    fn angles() {
        let mut worst = 0.0_f64;
        for turns in steps(-0.5, 0.5) {
            for length in [1e-30, 1e-3, 1.0, 7.0, 1e30] {
                let angle = f64::from(turns) * std::f64::consts::TAU;
                let (x, y) =
                    ((length * libm::cos(angle)) as f32, (length * libm::sin(angle)) as f32);
                let expected = libm::atan2(f64::from(y), f64::from(x)) / std::f64::consts::TAU;
                worst = worst.max((f64::from(atan2_turns(y, x)) - expected).abs());
            }
        }
        assert!(worst < 4e-8, "{worst}");
        assert_eq!(atan2_turns(0.0, 0.0), 0.0);
        assert_eq!(atan2_turns(0.0, 1.0), 0.0);
        assert_eq!(atan2_turns(1.0, 0.0), 0.25);
        assert_eq!(atan2_turns(0.0, -1.0), 0.5);
        assert_eq!(atan2_turns(-0.0, -1.0), -0.5);
        assert_eq!(atan2_turns(-2.0, 0.0), -0.25);
        assert_eq!(atan2_turns(3.0, 3.0), 0.125);
        assert_eq!(atan2_turns(f32::MAX, f32::MIN_POSITIVE), 0.25);
    }

    #[test]
    fn logarithm() {
        for exponent in steps(-125.0, 125.0) {
            let x = libm::exp2(f64::from(exponent)) as f32;
            let expected = libm::log2(f64::from(x));
            let error = (f64::from(log2(x)) - expected).abs();
            assert!(error < 2e-7 + 1e-7 * expected.abs(), "log2 {x}: {error}");
        }
        assert_eq!(log2(1.0), 0.0);
    }

    #[test]
    fn exponential() {
        for x in steps(-126.0, 127.0) {
            let expected = libm::exp2(f64::from(x));
            assert!((f64::from(exp2(x)) / expected - 1.0).abs() < 3e-7, "exp2 {x}");
        }
        assert_eq!(exp2(-1000.0), 0.0);
        assert!(exp2(1000.0).is_finite());
    }

    #[test]
    fn powers() {
        assert_eq!(power(0.0, 3.0), 0.0);
        assert_eq!(power(1.0, 1e6), 1.0);
        for x in steps(0.01, 1.0) {
            let expected = libm::pow(f64::from(x), 20.0);
            let relative = (f64::from(power(x, 20.0)) - expected).abs() / expected.max(1e-30);
            assert!(relative < 2e-5, "{x}^20: {relative}");
        }
    }
}
