//! Surface features for denoisers: what rays see of surfaces, independent of light.
//!
//! Perfect mirrors and clear glass show the objects behind them, so rays of perfect lobes collect
//! features too, each with its weight. Rays after a rough lobe do not. If features are collected,
//! every sample has two slots: one for light along the camera ray and perfect lobes, and one,
//! behind the first slots of all samples, for light through a rough lobe. The two sums of light are
//! added up at the end.

use glam::Vec3;

use slo_accel::math::columns::BATCH;
use slo_picture::film::{Features, Fixed};

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

    /// Adds the features that the rays of a batch see.
    pub(in crate::integrator) fn add(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        points: &Points,
    ) {
        if self.0.is_empty() {
            return;
        }
        let background = Vec3::from(frame.settings.background);
        for (i, &look) in hits.looks.iter().enumerate().take(batch.len()) {
            let color = match Look::of_word(look) {
                Look::Nothing => background,
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
            let material = &frame.materials[surfaces.material[i] as usize];
            let weight = points.weight.get(i);
            let albedo = weight * albedo(material, surfaces.tint.get(i));
            let normal = weight * own_share(material) * surfaces.n_shade.get(i);
            self.add_to(points.labels.slot[i], albedo, normal);
        }
    }

    fn add_to(&mut self, slot: u32, albedo: Vec3, normal: Vec3) {
        if let Some(sum) = self.0.get_mut(slot as usize) {
            let fixed = |v: Vec3| v.to_array().map(Fixed::or_zero);
            *sum += Features { albedo: fixed(albedo), normal: fixed(normal) };
        }
    }
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
