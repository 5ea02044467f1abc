//! Light that photons brought to the hits of a batch.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};

use super::bsdfs::Bsdfs;
use super::continuation::{Continuation, Rays};
use super::hits::Hits;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Batch, marks};
use crate::photons::{Irradiance, Nearest, PhotonLight, Rule};
use crate::shading::bsdf::{Lobe, WithLobe};

/// What photons know of the points of a batch.
#[derive(Debug)]
pub(in crate::integrator) struct StoredLight {
    /// 1 for points where a ray that gathers light ends: photons know the light of all lobes but the
    /// sharp ones.
    is_end: Column<u32>,
    /// 1 for points whose diffuse lobes have all of their light from the cache.
    pub(super) is_cached: Column<u32>,
    /// Albedo of the diffuse lobes.
    diffuse: Vec3s,
    /// Albedo of all lobes that are not sharp.
    rough: Vec3s,
    /// Chance that a ray follows a sharp lobe.
    sharp: Column<f32>,
    /// Weighted radiance.
    pub(in crate::integrator) light: Vec3s,
    /// Weights of the points, while those of ends are hidden.
    weight: Vec3s,
    nearest: Nearest,
}

impl Default for StoredLight {
    fn default() -> Self {
        Self {
            is_end: [0; BATCH],
            is_cached: [0; BATCH],
            diffuse: Vec3s::default(),
            rough: Vec3s::default(),
            sharp: [0.0; BATCH],
            light: Vec3s::default(),
            weight: Vec3s::default(),
            nearest: Nearest::default(),
        }
    }
}

impl StoredLight {
    /// Finds the light of all points.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        light: &PhotonLight,
        (batch, hits): (&Batch, &Hits),
        points: &Points,
        bsdfs: &Bsdfs,
    ) {
        for i in 0..points.len() {
            let marks = batch.past.marks[points.surfaces.ray[i] as usize];
            self.is_end[i] = u32::from(marks & (marks::DIFFUSE | marks::TAKEN) != 0);
        }
        let Self { diffuse, rough, sharp, .. } = self;
        (*diffuse, *rough, *sharp) = (Vec3s::default(), Vec3s::default(), [0.0; BATCH]);
        bsdfs.bsdf.for_each(&mut AddAlbedos { frame, points, diffuse, rough, sharp });
        frame.isa.run(Read { frame, stored: light, batch, hits, points, to: self });
    }

    /// Keeps rays from following lobes whose light is known.
    pub(in crate::integrator) fn close(
        &self,
        frame: &FrameScene,
        points: &Points,
        bsdfs: &mut Bsdfs,
    ) {
        if self.is_cached[..points.len()].contains(&1) {
            bsdfs.close_diffuse(frame, points, &self.is_cached);
        }
    }

    /// Whether any point asks lamps.
    pub(in crate::integrator) fn any_open(&self, points: &Points) -> bool {
        self.is_end[..points.len()].contains(&0)
    }

    /// Whether any point sends a ray.
    pub(in crate::integrator) fn any_goes_on(&self, points: &Points) -> bool {
        self.any_open(points) || self.sharp[..points.len()].iter().any(|chance| *chance > 0.0)
    }

    /// Takes the weight of all ends, so that they ask no lamps.
    pub(in crate::integrator) fn hide_ends(&mut self, points: &mut Points) {
        for i in 0..points.len() {
            let weight = points.weight.get(i);
            self.weight.set(i, weight);
            points.weight.set(i, if self.is_end[i] == 1 { Vec3::ZERO } else { weight });
        }
    }

    /// Gives the weights back.
    pub(in crate::integrator) fn show_ends(&self, points: &mut Points) {
        for i in 0..points.len() {
            points.weight.set(i, self.weight.get(i));
        }
    }

    /// Keeps only those rays of ends that follow sharp lobes. They find no lamps whose light photons
    /// have brought already, and all of the light of others.
    pub(in crate::integrator) fn restrict(
        &self,
        frame: &FrameScene,
        points: &Points,
        rays: &mut Continuation,
    ) {
        let Continuation { rays: Rays { sent, past, .. }, chosen, .. } = rays;
        for i in 0..points.len() {
            if self.is_end[i] == 1 {
                if past.marks[i] & marks::SHARP == 0 {
                    sent.weight.set(i, Vec3::ZERO);
                }
                sent.density[i] = 0.0;
                past.marks[i] |= marks::TAKEN;
            }
        }
        let weight = &sent.weight;
        chosen.set(frame.isa, points.len(), |i| weight.get(i) != Vec3::ZERO);
    }
}

/// Adds up the albedos of lobes, each estimated by the sample in the middle of the lobe.
struct AddAlbedos<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    diffuse: &'a mut Vec3s,
    rough: &'a mut Vec3s,
    sharp: &'a mut Column<f32>,
}

impl WithLobe for AddAlbedos<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let Self { frame, points, diffuse, rough, sharp } = self;
            frame.isa.run(AddAlbedosOf { lobe, points, diffuse, rough, sharp });
        }
    }
}

struct AddAlbedosOf<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    diffuse: &'a mut Vec3s,
    rough: &'a mut Vec3s,
    sharp: &'a mut Column<f32>,
}

impl<L: Lobe> Lanewise for AddAlbedosOf<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, diffuse, rough, sharp } = self;
        for i in lanes(points.surfaces.len) {
            let is_sharp = lobe.is_sharp(i);
            let albedo = lobe.sample(i, &points.at(i), [0.5; 3]).weight;
            let albedo = if is_sharp { Vec3::ZERO } else { albedo };
            rough.set(i, rough.get(i) + albedo);
            if L::IS_DIFFUSE {
                diffuse.set(i, diffuse.get(i) + albedo);
            }
            sharp[i] += if is_sharp { lobe.share().chance[i] } else { 0.0 };
        }
    }
}

/// Looks up what photons know.
struct Read<'a> {
    frame: &'a FrameScene,
    stored: &'a PhotonLight,
    batch: &'a Batch,
    hits: &'a Hits,
    points: &'a Points,
    to: &'a mut StoredLight,
}

impl Read<'_> {
    /// Returns what is known of the irradiance at a point, estimated in advance.
    #[inline(always)]
    fn known(&self, i: usize) -> Option<Irradiance> {
        let Self { frame, stored, hits, points, .. } = self;
        let Points { surfaces, labels, .. } = points;
        let point = surfaces.point.get(i);
        let in_map = || {
            let (ray, outside) = (surfaces.ray[i] as usize, surfaces.from_outside[i] == 1);
            let place = (point, labels.time[i], outside);
            let (map, texel) = frame.texel_of(&hits.found, ray, place)?;
            stored.maps.get(map)?.get(texel).filter(|found| found.radius > 0.0).copied()
        };
        let from_map = if stored.maps.is_empty() { None } else { in_map() };
        from_map.or_else(|| stored.surfaces.near(point, surfaces.n_geo.get(i)))
    }
}

impl Lanewise for Read<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { frame, stored, batch, points, .. } = self;
        let rule = Rule {
            nearest: frame.settings.caustic_nearest,
            cone: frame.settings.caustic_filter == slo_scene::CausticFilter::Cone,
            ends: false,
        };
        let gathers = frame.settings.gather;
        for i in 0..points.surfaces.len {
            let (point, n_geo) = (points.surfaces.point.get(i), points.surfaces.n_geo.get(i));
            let (weight, mut irradiance, mut albedo) =
                (points.weight.get(i), Vec3::ZERO, Vec3::ZERO);
            if weight != Vec3::ZERO && self.to.is_end[i] == 1 {
                albedo = self.to.rough.get(i);
                if let Some(found) = self.known(i) {
                    let from = batch.past.from.get(points.surfaces.ray[i] as usize);
                    // Estimates that reach to where the ray comes from show no details there.
                    let is_near = (point - from).length_squared() < found.radius * found.radius;
                    self.to.is_end[i] = u32::from(!is_near);
                    irradiance = found.light;
                }
            }
            self.to.is_cached[i] = 0;
            if self.to.is_end[i] == 0 {
                (irradiance, albedo) = (Vec3::ZERO, self.to.diffuse.get(i));
                if weight * albedo != Vec3::ZERO {
                    if !stored.caustics.is_empty() {
                        let nearest = &mut self.to.nearest;
                        let found =
                            stored.caustics.irradiance(point, n_geo, rule, u32::MAX, nearest);
                        irradiance = found.light;
                    }
                    let n_shade = points.surfaces.n_shade.get(i);
                    if let Some(cached) = stored.cache.light(point, n_shade).filter(|_| gathers) {
                        irradiance += cached;
                        self.to.is_cached[i] = 1;
                    }
                    if !gathers {
                        irradiance += stored.surfaces.smooth(point, n_geo, &mut self.to.nearest);
                    }
                }
            }
            self.to.light.set(i, weight * albedo * irradiance * FRAC_1_PI);
        }
    }
}
