//! Linear interpolation.

/// `a` at 0 and `b` at 1, exactly; also exactly `a` all the way if both are equal.
pub fn mix(a: f64, b: f64, u: f64) -> f64 {
    if u == 1.0 { b } else { a + (b - a) * u }
}
