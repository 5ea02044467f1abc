//! What rays see of surfaces, whatever the light: for denoisers.
//!
//! Perfect mirrors and clear glass show what is behind them: rays of perfect lobes go on looking,
//! each with its weight. Rough lobes end that. Where features are wanted every sample has two slots:
//! one for what comes along the camera ray and rays of perfect lobes, and, behind those of all
//! samples, one for what comes through a rough lobe. Their sums of light are added up in the end.

use glam::Vec3;

use super::bounces::Lobe;
use super::points::Points;
use super::queue::{Batch, Labels};
use crate::frame::{FrameScene, Look};
use crate::shading::Material;
use slo_accel::math::columns::{BATCH, Column};
use slo_picture::film::{Features, Fixed};

/// Exact sums, one for each slot that is not behind a rough lobe; none where nobody wants them.
#[derive(Debug, Default)]
pub(super) struct FeatureSums(Vec<Features>);

impl FeatureSums {
    /// `len` sums of nothing.
    pub(super) fn reset(&mut self, len: usize) {
        self.0.clear();
        self.0.resize(len, Features::default());
    }

    pub(super) fn get(&self) -> &[Features] {
        &self.0
    }

    /// Whether anybody wants them.
    pub(super) fn are_wanted(&self) -> bool {
        !self.0.is_empty()
    }

    /// Gives rays of rough lobes the slot of what comes through one.
    pub(super) fn leave(&self, lobe: &Lobe, len: usize, labels: &mut Labels) {
        let first_behind = self.0.len() as u32;
        for (slot, inverse) in labels.slot[..len].iter_mut().zip(&lobe.inverse.0) {
            if *inverse > 0.0 && *slot < first_behind {
                *slot += first_behind;
            }
        }
    }

    /// Adds what the rays of a batch see; `looks` are words of [`Look`].
    pub(super) fn add(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        looks: &Column<u32>,
        points: &Points,
    ) {
        let background = Vec3::from(frame.settings.background);
        for (i, &look) in looks.iter().enumerate().take(batch.rays.len()) {
            let color = match Look::of_word(look) {
                Look::Nothing => background,
                Look::Light(light) => frame.lights[light as usize].color,
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

/// What a surface sends back of white light from everywhere, but for what perfect lobes bring.
fn albedo(material: &Material, tint: Vec3) -> Vec3 {
    let rough = |share: f32, inverse: f32| if inverse > 0.0 { share } else { 0.0 };
    let spread = rough(material.reflectance, material.reflection_lobe)
        + rough(material.refraction, material.refraction_lobe);
    ((material.ambient + material.diffuse) * tint + spread).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The share of what a surface shows that is its own, and not that of perfect lobes.
fn own_share(material: &Material) -> f32 {
    let perfect = |share: f32, inverse: f32| if inverse > 0.0 { 0.0 } else { share };
    let passed_on = perfect(material.reflectance, material.reflection_lobe)
        + perfect(material.refraction, material.refraction_lobe);
    (1.0 - passed_on).max(0.0)
}
