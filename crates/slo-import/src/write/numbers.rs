//! Numbers as text.

use glam::DVec3;

/// A number, as short as it can be written.
pub(super) fn number(value: f64) -> String {
    let single = value as f32;
    if f64::from(single) == value { format!("{single}") } else { format!("{value}") }
}

pub(super) fn triple(values: [f64; 3]) -> String {
    let [x, y, z] = values.map(number);
    format!("{{ {x} {y} {z} }}")
}

pub(super) fn vector(v: DVec3) -> String {
    // Rounding that no one sees makes the text shorter.
    triple(v.to_array().map(rounded))
}

/// A number without what lies below a millionth, relative to one.
pub(super) fn rounded(value: f64) -> f64 {
    let rounded = (value * 1e7).round() / 1e7;
    if value.abs() > 1e3 || rounded == 0.0 && value.abs() > 1e-12 { value } else { rounded + 0.0 }
}

/// A number with seven significant digits, as many as single precision has.
pub(super) fn significant(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}
