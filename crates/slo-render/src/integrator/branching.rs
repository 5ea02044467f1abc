//! How many rays a hit sends out, by the settings and the number of bounces before it.

use slo_accel::math::columns::BATCH;
use slo_scene::{LightSampling, Settings};

use crate::frame::FrameScene;
use crate::sampling::Purpose;
use crate::shading::Light;

/// Most bounces that the hits of one batch of camera rays may queue.
const MOST_BOUNCES_WAITING: usize = 512 * BATCH;

/// Returns the number of rays from a hit to a light, or to randomly chosen lights.
pub(super) fn rays_to(frame: &FrameScene, light: &Light, depth: u32) -> u32 {
    let one = frame.settings.light_sampling() == LightSampling::One;
    if depth == 0 && (one || light.is_area()) { frame.settings.soft_shadow_samples } else { 1 }
}

/// Returns the mean number of rays from a hit to a light.
pub(super) fn mean_rays_to(frame: &FrameScene, light: &Light, depth: u32) -> f32 {
    let rays = rays_to(frame, light, depth) as f32;
    match frame.settings.light_sampling() {
        LightSampling::All => rays,
        LightSampling::One => rays / frame.lights.len() as f32,
    }
}

/// Returns the number of rays of a glossy lobe: from a first hit as many as the settings say, from
/// a later hit one.
pub(super) fn glossy_samples(settings: &Settings, purpose: Purpose, depth: u32) -> u32 {
    match purpose {
        _ if depth > 0 => 1,
        Purpose::Refraction => settings.diffuse_refraction_samples,
        Purpose::Reflection => settings.diffuse_reflection_samples,
        Purpose::Light(_)
        | Purpose::AnyLight
        | Purpose::Continuation
        | Purpose::Survival
        | Purpose::Surface
        | Purpose::Departure
        | Purpose::Heading => 1,
    }
}

/// Returns the number of rays that continue the path of a hit.
pub(super) fn continuations(settings: &Settings, depth: u32) -> u32 {
    let samples = settings.diffuse_reflection_samples.max(settings.diffuse_refraction_samples);
    if depth == 0 { samples } else { 1 }
}

/// Returns the most camera rays of a batch. Its hits queue all their bounces before any of them is
/// traced.
pub(super) fn most_camera_rays(settings: &Settings) -> usize {
    let sent: usize = [Purpose::Reflection, Purpose::Refraction]
        .map(|purpose| glossy_samples(settings, purpose, 0) as usize)
        .iter()
        .sum();
    (MOST_BOUNCES_WAITING / sent).clamp(1, BATCH)
}
