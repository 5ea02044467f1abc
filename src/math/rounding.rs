//! Every rounding bound of slo-rt, each with its reason.

/// Half the distance from 1 to the next f32: the relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// Bound of the relative error of `n` rounded operations in a row.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms, lemma 3.1.
pub const fn gamma(n: u32) -> f32 {
    let ne = n as f32 * UNIT_ROUNDOFF;
    ne / (1.0 - ne)
}
