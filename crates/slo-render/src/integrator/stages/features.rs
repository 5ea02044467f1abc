//! Surface features for denoisers: what rays see of surfaces, independent of light.
//!
//! Perfect mirrors and clear glass show the objects behind them, so rays of perfect lobes collect
//! features too, each with its weight. Rays after a rough lobe do not. If features are collected,
//! every sample has two slots: one for light along the camera ray and perfect lobes, and one,
//! behind the first slots of all samples, for light through a rough lobe. The two sums of light are
//! added up at the end.

use glam::Vec3;

use slo_accel::math::columns::BATCH;
use slo_picture::film::{Features, SignedFixed};

use super::hits::Hits;
use super::points::Points;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::Batch;
use crate::shading::Material;

/// Exact sums, one for each slot that is not for light through a rough lobe; empty if features are
/// not collected.
#[derive(Debug, Default)]
pub(in crate::integrator) struct FeatureSums(Vec<Features>);

impl FeatureSums {
    /// Resets to `len` sums of 0.
    pub(in crate::integrator) fn reset(&mut self, len: usize) {
        self.0.clear();
        self.0.resize(len, Features::default());
    }

    pub(in crate::integrator) fn get(&self) -> &[Features] {
        &self.0
    }

    /// Returns the first slot of light through a rough lobe; `None` if features are not collected.
    pub(in crate::integrator) fn first_behind(&self) -> Option<u32> {
        Some(self.0.len() as u32).filter(|slots| *slots > 0)
    }

    /// Whether features are collected.
    pub(in crate::integrator) fn are_wanted(&self) -> bool {
        !self.0.is_empty()
    }

    /// Adds the features that the rays of a batch see. `of` returns how a point looks by itself.
    pub(in crate::integrator) fn add(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        points: &Points,
        of: impl Fn(usize) -> Own,
    ) {
        if !self.are_wanted() {
            return;
        }
        for (i, &look) in hits.looks.iter().enumerate().take(batch.len()) {
            let color = match Look::of_word(look) {
                Look::Nothing => sky(frame, batch.rays.direction(i)),
                Look::Light(light) => {
                    let way = batch.rays.direction(i) * hits.found.hits.t[i];
                    frame.lights[light as usize].radiance(way)
                }
                Look::Material(_) => continue,
            };
            let albedo = batch.weight.get(i) * color.clamp(Vec3::ZERO, Vec3::ONE);
            self.add_to(batch.labels.slot[i], albedo, Vec3::ZERO);
        }
        let surfaces = &points.surfaces;
        for i in 0..surfaces.len.min(BATCH) {
            let (weight, own) = (points.weight.get(i), of(i));
            let normal = weight * own.share * surfaces.n_shade.get(i);
            self.add_to(points.labels.slot[i], weight * own.albedo, normal);
        }
    }

    fn add_to(&mut self, slot: u32, albedo: Vec3, normal: Vec3) {
        if let Some(sum) = self.0.get_mut(slot as usize) {
            let fixed = |v: Vec3| v.to_array().map(SignedFixed::clamped);
            *sum += Features { albedo: fixed(albedo), normal: fixed(normal) };
        }
    }
}

/// How a surface looks by itself, without what is seen through perfect lobes.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Own {
    /// Share of white light from everywhere that the surface returns, RGB.
    pub(in crate::integrator) albedo: Vec3,
    /// Share of the surface's appearance that is its own.
    pub(in crate::integrator) share: f32,
}

impl Own {
    /// Returns how a point of a Phong material looks.
    pub(in crate::integrator) fn of_phong(frame: &FrameScene, points: &Points, i: usize) -> Self {
        let surfaces = &points.surfaces;
        let material = &frame.materials[surfaces.material[i] as usize];
        Self { albedo: albedo(material, surfaces.tint.get(i)), share: own_share(material) }
    }
}

/// Returns the light of all that is infinitely far away in a direction.
fn sky(frame: &FrameScene, direction: Vec3) -> Vec3 {
    let skies = frame.skies.iter().map(|&sky| frame.lights[sky as usize].radiance(direction));
    Vec3::from(frame.settings.background) + skies.sum::<Vec3>()
}

/// Returns the share of white light from everywhere that a surface returns, without perfect lobes,
/// RGB.
fn albedo(material: &Material, tint: Vec3) -> Vec3 {
    let rough = |share: f32, inverse: f32| if inverse > 0.0 { share } else { 0.0 };
    let spread = rough(material.reflectance, material.reflection_lobe)
        + rough(material.refraction, material.refraction_lobe);
    ((material.ambient + material.diffuse) * tint + spread).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Returns the share of a surface's appearance that is not seen through perfect lobes.
fn own_share(material: &Material) -> f32 {
    let perfect = |share: f32, inverse: f32| if inverse > 0.0 { 0.0 } else { share };
    let passed_on = perfect(material.reflectance, material.reflection_lobe)
        + perfect(material.refraction, material.refraction_lobe);
    (1.0 - passed_on).max(0.0)
}
