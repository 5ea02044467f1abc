//! Irradiance that was estimated in advance, at some of the photons.
//!
//! Source: P. H. Christensen, "Faster Photon Map Global Illumination" (1999).

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;
use slo_accel::{Isa, Lanewise};

use super::cache::IrradianceCache;
use super::counts::PhotonCounts;
use super::flux_map::{FLATNESS, FluxMap, Irradiance, LEAST_COSINE, Rule};
use super::nearest::{Around, KdTree, Nearest};
use crate::shading::light::receiver;

/// Estimates within the distance from which the photons of one come, about: more would know the same
/// photons.
const OVERLAPPING: u32 = 12;

/// Estimates that a thread makes at a time.
const AT_ONCE: usize = 512;

/// Number of estimates that [`IrradianceMap::smooth`] averages.
const SMOOTHED: usize = 6;

/// Where no estimate is near enough, one so many times as far away will do.
const FARTHER: f32 = 4.0;

/// Estimates of irradiance, to be looked up.
#[derive(Clone, Debug, Default)]
pub struct IrradianceMap {
    tree: KdTree,
    /// In the order of the tree.
    normals: Vec<u32>,
    estimates: Vec<Irradiance>,
    most_square: f32,
}

impl IrradianceMap {
    /// Estimates the irradiance at photons, on the threads of the current rayon pool. Returns `None` if
    /// `gives_up` says to give up.
    pub fn new(
        map: &FluxMap,
        nearest: u32,
        isa: Isa,
        gives_up: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        // A short distance holds fewer photons than `nearest`.
        let every = (map.usual_count(nearest) / OVERLAPPING).max(1);
        let chosen: Vec<u32> = (0..map.len() as u32)
            .filter(|&i| map.photon(i as usize).2.is_multiple_of(every))
            .collect();
        let estimated: Option<Vec<Vec<Irradiance>>> = chosen
            .par_chunks(AT_ONCE)
            .map(|chosen| (!gives_up()).then(|| isa.run(Estimate { map, nearest, chosen })))
            .collect();
        let estimated: Vec<Irradiance> = estimated?.into_iter().flatten().collect();
        let places: Vec<Vec3> = chosen.iter().map(|&i| map.photon(i as usize).0).collect();
        let (tree, order) = KdTree::new(&places);
        let normal = |&i: &u32| receiver::pack(map.photon(chosen[i as usize] as usize).1);
        let normals = order.iter().map(normal).collect();
        let estimates = order.iter().map(|&i| estimated[i as usize]).collect();
        Some(Self { tree, normals, estimates, most_square: map.most_square() })
    }

    /// Returns the estimate that is nearest to a point, on the side of a unit normal.
    #[inline(always)]
    pub fn near(&self, point: Vec3, normal: Vec3) -> Option<Irradiance> {
        self.nearest_of(point, normal, self.most_square).or_else(|| self.farther(point, normal))
    }

    #[cold]
    fn farther(&self, point: Vec3, normal: Vec3) -> Option<Irradiance> {
        self.nearest_of(point, normal, self.most_square * (FARTHER * FARTHER))
    }

    #[inline(always)]
    fn nearest_of(&self, point: Vec3, normal: Vec3, most_square: f32) -> Option<Irradiance> {
        let around = Around { point, flat: normal * FLATNESS, square: most_square };
        let (mut square, mut found) = (most_square, None);
        self.tree.near(around, |number, distance| {
            if self.fits(number, normal) {
                (square, found) = (distance, Some(number));
            }
            square
        });
        found.map(|number| self.estimates[number as usize])
    }

    /// Returns the irradiance between the estimates about a point.
    #[inline(always)]
    pub fn smooth(&self, point: Vec3, normal: Vec3, nearest: &mut Nearest) -> Vec3 {
        let around = Around { point, flat: normal * FLATNESS, square: self.most_square };
        nearest.restart(SMOOTHED + 1, self.most_square);
        self.tree.near(around, |number, distance| {
            if self.fits(number, normal) { nearest.add(number, distance) } else { nearest.square() }
        });
        nearest.cut();
        let (mut light, mut sum) = (Vec3::ZERO, 0.0);
        for (number, distance) in nearest.iter() {
            let share = 1.0 - distance / nearest.square();
            light += self.estimates[number as usize].light * share;
            sum += share;
        }
        if sum > 0.0 {
            return light * (1.0 / sum);
        }
        self.farther(point, normal).map_or(Vec3::ZERO, |estimate| estimate.light)
    }

    #[inline(always)]
    fn fits(&self, number: u32, normal: Vec3) -> bool {
        receiver::unpack(self.normals[number as usize]).dot(normal) > LEAST_COSINE
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        self.tree.memory() + size_of_val(&self.normals[..]) + size_of_val(&self.estimates[..])
    }
}

/// Estimates the irradiance at points of surfaces with unit normals, on the threads of the current rayon
/// pool; nothing where there is no point. Returns `None` if `gives_up` says to give up.
pub fn irradiance_at(
    map: &FluxMap,
    nearest: u32,
    isa: Isa,
    points: &[Option<[Vec3; 2]>],
    gives_up: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Irradiance>> {
    let at_once = |points| (!gives_up()).then(|| isa.run(EstimateAt { map, nearest, points }));
    let estimated: Option<Vec<Vec<Irradiance>>> = points.par_chunks(AT_ONCE).map(at_once).collect();
    Some(estimated?.into_iter().flatten().collect())
}

struct EstimateAt<'a> {
    map: &'a FluxMap,
    nearest: u32,
    points: &'a [Option<[Vec3; 2]>],
}

impl Lanewise for EstimateAt<'_> {
    type Output = Vec<Irradiance>;

    #[inline(always)]
    fn run(self) -> Vec<Irradiance> {
        let Self { map, nearest, points } = self;
        let rule = Rule { nearest, cone: false, ends: true };
        let mut found = Nearest::default();
        let of = |place: &Option<[Vec3; 2]>| match *place {
            Some([point, normal]) => map.irradiance(point, normal, rule, u32::MAX, &mut found),
            None => Irradiance::default(),
        };
        points.iter().map(of).collect()
    }
}

struct Estimate<'a> {
    map: &'a FluxMap,
    nearest: u32,
    chosen: &'a [u32],
}

impl Lanewise for Estimate<'_> {
    type Output = Vec<Irradiance>;

    #[inline(always)]
    fn run(self) -> Vec<Irradiance> {
        let Self { map, nearest, chosen } = self;
        let rule = Rule { nearest, cone: false, ends: true };
        let mut found = Nearest::default();
        let of = |&i: &u32| {
            let (point, normal, _) = map.photon(i as usize);
            map.irradiance(point, normal, rule, i, &mut found)
        };
        chosen.iter().map(of).collect()
    }
}

/// The light of a frame that photons brought.
#[derive(Clone, Debug, Default)]
pub struct PhotonLight {
    /// Irradiance of light that comes from surfaces; if rays gather it, of all light.
    pub(crate) surfaces: Arc<IrradianceMap>,
    /// Photons that came through sharp lobes.
    pub(crate) caustics: Arc<FluxMap>,
    /// The same as `surfaces`, for each texel of each light map of the frame, row by row. The radius is 0
    /// where a texel is not on the surface.
    pub(crate) maps: Arc<[Vec<Irradiance>]>,
    /// Irradiance of light that comes from surfaces, gathered by rays; empty without a cache.
    pub(crate) cache: IrradianceCache,
    /// What its photons took while it was made.
    pub(crate) making: PhotonCounts,
}

impl PhotonLight {
    /// What it took.
    pub fn counts(&self) -> PhotonCounts {
        let records = self.cache.len() as u64;
        let memory = self.making.memory.max(self.memory());
        PhotonCounts { records, memory, ..self.making }
    }

    /// Memory in bytes.
    fn memory(&self) -> usize {
        let maps: usize = self.maps.iter().map(|map| size_of_val(&map[..])).sum();
        self.surfaces.memory() + self.caustics.memory() + self.cache.memory() + maps
    }
}

#[cfg(test)]
mod tests {
    use super::super::flux_map::Deposit;
    use super::*;

    #[test]
    fn a_short_distance_leaves_no_holes() {
        const SIDE: u32 = 100;
        let normal = receiver::pack(Vec3::Z);
        let place = |i: u32| {
            let jitter = |k: u32| (i.wrapping_mul(k) >> 16 & 1023) as f32 / 1024.0;
            let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
            Vec3::new(x + jitter(0x9e37_79b1), y + jitter(0x85eb_ca77), 0.0) / SIDE as f32
        };
        let power = Vec3::splat(1.0 / (SIDE * SIDE) as f32);
        let deposits: Vec<Deposit> = (0..SIDE * SIDE)
            .map(|path| Deposit { position: place(path), power, normal, path })
            .collect();
        // About 78 of 500 photons lie within the distance.
        let map = FluxMap::new(&deposits, 1.0, Some(0.05), 500);
        let estimates = IrradianceMap::new(&map, 500, Isa::best(), &|| false).expect("it goes on");
        let mut found = Nearest::default();
        for i in 0..400u32 {
            let point = Vec3::new((i % 20) as f32, (i / 20) as f32, 0.0) * (0.8 / 19.0) + 0.1;
            let point = Vec3::new(point.x, point.y, 0.0);
            let light = estimates.smooth(point, Vec3::Z, &mut found).x;
            assert!((0.8..1.2).contains(&light), "{light} at {point}");
            assert!(estimates.near(point, Vec3::Z).is_some(), "{point}");
        }
    }
}
