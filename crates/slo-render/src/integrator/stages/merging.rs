//! Light of photons near the hits of a batch.
//!
//! A photon and a path from the camera may find the same light path: lamp, sharp lobes, a rough lobe
//! at the hit. They share its light by the balance heuristic. Per projected solid angle at the hit,
//! rays that follow the rough lobe have the density `n c p / cos`; per area and projected solid angle
//! at the lamp, photons have the density `e`, and the hit finds those of `J` light paths that land in
//! the area `A`. Area times projected solid angle is the same at both ends of a light path, so the
//! photon counts `J A e / (J A e + n c p / cos)`. The factors of sharp lobes on the way are left out
//! on both sides: they nearly cancel, and shares that sum to 1 keep the mean whatever they are.
//!
//! Source: I. Georgiev et al., "Light Transport Simulation with Vertex Connection and Merging" (2012),
//! merging alone, as in P. Grittmann et al., "Efficient Caustic Rendering with Lightweight Photon
//! Mapping" (2018); with one balance heuristic for each rough lobe.

use std::f32::consts::PI;

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};

use super::bsdfs::Bsdfs;
use super::guiding::{Densities, Guiding, mixed};
use super::landing::settled;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::branching::continuations;
use crate::integrator::work::Job;
use crate::photons::{Photon, PhotonMap, PhotonMaps, Slab, pass_of};
use crate::shading::bsdf::{Lobe, WithLobe};
use crate::shading::light::receiver;

/// Radius of the first pass, in widths of a pixel's footprint.
const PIXELS: f32 = 2.0;

/// Least cosine between the normals of a photon's surface and of a hit for the photon to count.
const LEAST_COSINE: f32 = 0.5;

/// Photons at hits, one entry for each pair.
#[derive(Debug)]
pub(in crate::integrator) struct Merging {
    /// Indices of the points.
    point: Column<u32>,
    /// Unit directions toward where the photons came from.
    toward: Vec3s,
    /// Power of the photons, divided by the number of light paths and by the area that it is spread
    /// over.
    power: Vec3s,
    density: Column<f32>,
    light_of: Column<u32>,
    field: Densities,
    scattered: Vec3s,
    /// Weighted light.
    pub(in crate::integrator) light: Vec3s,
    pub(in crate::integrator) slot: Column<u32>,
    pub(in crate::integrator) len: usize,
    /// Whether a point has a rough lobe.
    is_rough: Column<u32>,
    radius: Column<f32>,
    /// The photons near a point that are not among the pairs yet, and the point.
    near: Vec<Photon>,
    next: usize,
}

impl Default for Merging {
    fn default() -> Self {
        Self {
            point: [0; BATCH],
            toward: Vec3s::default(),
            power: Vec3s::default(),
            density: [0.0; BATCH],
            light_of: [0; BATCH],
            field: Densities::default(),
            scattered: Vec3s::default(),
            light: Vec3s::default(),
            slot: [0; BATCH],
            len: 0,
            is_rough: [0; BATCH],
            radius: [0.0; BATCH],
            near: Vec::new(),
            next: 0,
        }
    }
}

/// Returns the map that a sample uses.
fn map_of<'a>(
    maps: &'a PhotonMaps,
    frame: &FrameScene,
    points: &Points,
    i: usize,
    depth: u32,
) -> Option<&'a PhotonMap> {
    let index = points.labels.index[i];
    // Rays of the same sample have numbers of their own once a hit has sent several.
    let split = if depth == 0 { 1 } else { continuations(&frame.settings, 0) };
    maps.get(pass_of(index / split))
}

impl Merging {
    /// Finds the radius of the queries of all points, after `depth` bounces.
    pub(in crate::integrator) fn reach(
        &mut self,
        frame: &FrameScene,
        maps: &PhotonMaps,
        points: &mut Points,
        depth: u32,
    ) {
        for i in 0..points.len() {
            let map = map_of(maps, frame, points, i, depth);
            let radius = map.map_or(0.0, |map| PIXELS * points.rough.width[i] * map.radius());
            self.radius[i] = radius;
            points.caught[i] = map.map_or(0.0, |map| map.paths() * PI * radius * radius);
        }
        self.next = 0;
        self.near.clear();
    }

    /// Adds up the light of a batch of photons, and returns whether there was any: the next call goes
    /// on with the photons that are left.
    pub(in crate::integrator) fn find(
        &mut self,
        job: &Job<'_>,
        maps: &PhotonMaps,
        points: &Points,
        (bsdfs, guiding): (&Bsdfs, &Guiding),
        (depth, stride): (u32, u32),
    ) -> bool {
        let frame = job.frame;
        if self.next == 0 && self.near.is_empty() {
            bsdfs.find_rough(frame, points, &mut self.is_rough);
        }
        self.len = 0;
        let most_bounces = frame.settings.recursion().saturating_sub(depth);
        loop {
            while let Some(photon) = self.near.pop() {
                self.push(points, self.next - 1, &photon);
                if self.len == BATCH {
                    break;
                }
            }
            if self.len == BATCH || self.next == points.len() {
                break;
            }
            let i = self.next;
            self.next += 1;
            if self.is_rough[i] == 0 || points.weight.get(i) == Vec3::ZERO {
                continue;
            }
            let Some(map) = map_of(maps, frame, points, i, depth) else { continue };
            frame.isa.run(Query {
                slab: map.slab(points.labels.time[i]),
                point: settled(frame, points, points.instance[i], i, map.slabs()),
                normal: points.surfaces.n_geo.get(i),
                radius: self.radius[i],
                most_bounces,
                to: &mut self.near,
            });
        }
        if self.len == 0 {
            return false;
        }
        self.scattered = Vec3s::default();
        let rays = continuations(&frame.settings, depth) as f32;
        let Self { point, toward, density, field, scattered, len, .. } = self;
        guiding.densities(job, toward, *len, |k| point[k] as usize, field);
        let field = &field.of;
        let pairs = Pairs { points, point, toward, density, field, len: *len, rays };
        bsdfs.bsdf.for_each(&mut Scatter { frame, guiding, pairs, to: scattered });
        frame.isa.run(Finish { points, to: self });
        if stride > 0 {
            for (slot, light) in self.slot[..self.len].iter_mut().zip(&self.light_of) {
                *slot += frame.group_of(*light) * stride;
            }
        }
        true
    }

    fn push(&mut self, points: &Points, i: usize, photon: &Photon) {
        let k = self.len;
        self.point[k] = i as u32;
        self.toward.set(k, receiver::unpack(photon.toward));
        self.power.set(k, photon.power * (1.0 / points.caught[i]));
        self.density[k] = photon.density;
        self.light_of[k] = photon.light;
        self.len += 1;
    }
}

/// Finds the photons that count at a point.
struct Query<'a> {
    slab: &'a Slab,
    point: Vec3,
    normal: Vec3,
    radius: f32,
    most_bounces: u32,
    to: &'a mut Vec<Photon>,
}

impl Lanewise for Query<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { slab, point, normal, radius, most_bounces, to } = self;
        slab.near(point, radius, |photon| {
            let cos = receiver::unpack(photon.normal).dot(normal).abs();
            if cos > LEAST_COSINE && photon.bounces <= most_bounces {
                to.push(*photon);
            }
        });
    }
}

#[derive(Clone, Copy)]
struct Pairs<'a> {
    points: &'a Points,
    point: &'a Column<u32>,
    toward: &'a Vec3s,
    density: &'a Column<f32>,
    /// Densities of the field.
    field: &'a Column<f32>,
    len: usize,
    /// Number of continuations of each hit.
    rays: f32,
}

/// Adds what each rough lobe makes of the photons.
struct Scatter<'a> {
    frame: &'a FrameScene,
    guiding: &'a Guiding,
    pairs: Pairs<'a>,
    to: &'a mut Vec3s,
}

impl WithLobe for Scatter<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let share = self.guiding.share(L::IS_DIFFUSE);
            self.frame.isa.run(ScatterOne { lobe, share, pairs: self.pairs, to: self.to });
        }
    }
}

struct ScatterOne<'a, L> {
    lobe: &'a L,
    /// Share of the field in the rays of the lobe.
    share: &'a Column<f32>,
    pairs: Pairs<'a>,
    to: &'a mut Vec3s,
}

impl<L: Lobe> Lanewise for ScatterOne<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, share: shares, pairs, to } = self;
        let Pairs { points, point, toward, density, field, len, rays } = pairs;
        let chance = &lobe.share().chance;
        for k in lanes(len) {
            let i = (point[k] as usize).min(BATCH - 1);
            let (at, toward) = (points.at(i), toward.get(k));
            let scattered = lobe.evaluate(i, &at, toward);
            let cos = at.n_geo.dot(toward).abs().max(f32::MIN_POSITIVE);
            let both = mixed(scattered.density, field[k], shares[i]);
            let by_lobe = rays * chance[i] * both / cos;
            let share = 1.0 / (1.0 + by_lobe / (points.caught[i] * density[k]));
            let value = scattered.value * (share / cos);
            let counts = !lobe.is_sharp(i) & at.is_real(toward);
            to.set(k, to.get(k) + if counts { value } else { Vec3::ZERO });
        }
    }
}

/// Weights the light.
struct Finish<'a> {
    points: &'a Points,
    to: &'a mut Merging,
}

impl Lanewise for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, to } = self;
        for k in lanes(to.len) {
            let i = (to.point[k] as usize).min(BATCH - 1);
            to.light.set(k, points.weight.get(i) * to.scattered.get(k) * to.power.get(k));
            to.slot[k] = points.labels.slot[i];
        }
    }
}

#[cfg(test)]
mod tests;
