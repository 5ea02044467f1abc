//! Sampling of paths over one shutter: the number of samples and their times.

use slo_scene::animation::Shutter;

/// Most samples of one path over one shutter. An object that crosses the whole height of a picture
/// of 8192 pixels once needs this many. Faster motion is not sampled more finely.
pub(super) const MAX_SAMPLES: usize = 16384;

/// Returns the shutter time, in `[0, 1]`, of sample `k` of `count`.
pub(super) fn time_of(k: usize, count: usize) -> f64 {
    k as f64 / (count - 1) as f64
}

pub(super) fn least_count(shutter: &Shutter, samples_per_ms: f64) -> usize {
    let asked = (samples_per_ms * shutter.duration() * 1e3).ceil();
    (asked as usize).clamp(2, MAX_SAMPLES)
}
