//! Russian roulette: rays that could add next to nothing are left out at random, and the weight of
//! the others is raised, so that the mean stays the same.
//!
//! Source: J. Arvo and D. Kirk, "Particle Transport and Image Synthesis" (1990).

use glam::Vec3;

use crate::frame::FrameScene;

/// Rays of less weight are subject to roulette. They can change a channel of a PNG by about one
/// step, but cost as much as any other ray.
const LEAST_WEIGHT: f32 = 1.0 / 256.0;

/// Returns the weight below which rays of a frame are subject to roulette; 0 if no ray is.
pub(super) fn least_weight(frame: &FrameScene) -> f32 {
    if frame.clever { LEAST_WEIGHT } else { 0.0 }
}

/// Returns `weight` if its largest component is at least `least`. Otherwise it returns `weight`
/// scaled up to a largest component of `least`, with the probability that keeps the mean, or else
/// 0. `u` is a uniform random number.
#[inline(always)]
pub(super) fn roulette(weight: Vec3, least: f32, u: f32) -> Vec3 {
    let chance = weight.max_element() / least;
    let heavier = if u < chance { weight * (1.0 / chance) } else { Vec3::ZERO };
    if chance < 1.0 { heavier } else { weight }
}

/// Weight of a path below which roulette decides whether it is followed. Found by the time
/// that a room with one lamp takes to a given noise: 1 takes 1.4 times as long, 0.125 takes 1.2
/// times.
const WEAK_PATH: f32 = 0.35;

/// Returns the weight of one of `count` rays that continue a path, or 0 if it is not followed. Rays
/// are followed with a probability in proportion to their weight, if it is small. `u` is a uniform
/// random number.
#[inline(always)]
pub(super) fn follows(weight: Vec3, count: f32, u: f32) -> Vec3 {
    let chance = weight.max_element() * count * (1.0 / WEAK_PATH);
    let heavier = if u < chance { weight * (1.0 / chance) } else { Vec3::ZERO };
    if chance < 1.0 { heavier } else { weight }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_keeps_the_mean() {
        let weight = Vec3::new(0.01, 0.005, 0.0);
        let kept = |i: u16| roulette(weight, 0.04, (f32::from(i) + 0.5) / 1000.0);
        let mean = (0..1000).map(kept).sum::<Vec3>() / 1000.0;
        assert!((mean - weight).length() < 1e-6, "{mean}");
        assert_eq!(kept(999), Vec3::ZERO);
        assert!((kept(0) - Vec3::new(0.04, 0.02, 0.0)).length() < 1e-6);
        assert_eq!(roulette(weight, 0.01, 0.999), weight);
        assert_eq!(roulette(weight, 0.0, 0.999), weight);
        assert_eq!(roulette(Vec3::ZERO, 0.0, 0.0), Vec3::ZERO);
    }
}
