//! The irradiance cache: irradiance that was gathered at some points, for those between them.
//!
//! Sources: G. J. Ward, F. M. Rubinstein and R. D. Clear, "A Ray Tracing Solution for Diffuse
//! Interreflection" (1988); G. J. Ward and P. S. Heckbert, "Irradiance Gradients" (1992).

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::nearest::{Around, KdTree};
use crate::shading::lobe::pair;

/// What a ray of a hemisphere found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Radiance.
    pub light: Vec3,
    /// Distance of what it hit; infinite if it hit nothing.
    pub distance: f32,
}

/// The rays of a round: so many rings by so many sectors, all of the same share of irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// From the normal outward.
    pub rings: u32,
    /// About the normal.
    pub sectors: u32,
}

impl Grid {
    /// A grid of about so many rays, and not more.
    pub fn of(rays: u32) -> Self {
        let rings = ((rays as f32 / PI).sqrt() as u32).clamp(1, 12);
        Self { rings, sectors: (rays / rings).clamp(1, 40) }
    }

    /// Number of rays.
    pub fn rays(self) -> u32 {
        self.rings * self.sectors
    }

    /// Returns the direction of a ray about the z axis; `u` is a point of the unit square.
    pub fn direction(self, ray: u32, u: [f32; 2]) -> Vec3 {
        let (ring, sector) = (ray / self.sectors, ray % self.sectors);
        let square = ((ring as f32 + u[0]) / self.rings as f32).min(0.999_999);
        let (sine, cosine) = (square.sqrt(), (1.0 - square).sqrt());
        let turn = (sector as f32 + u[1]) / self.sectors as f32;
        let (s, c) = slo_accel::math::elementary::sin_cos_turns(turn);
        Vec3::new(sine * c, sine * s, cosine)
    }
}

/// Irradiance at a point, and how it changes about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CacheRecord {
    /// Where.
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Harmonic mean of the distances of what the rays hit, within bounds.
    pub radius: f32,
    /// Irradiance.
    pub light: Vec3,
    /// Its change with the turn of the normal, for each channel.
    turn: [Vec3; 3],
    /// Its change with the place, for each channel.
    shift: [Vec3; 3],
}

impl CacheRecord {
    /// Makes a record of the rays of some rounds, ray by ray. The radius is at least `least`.
    pub fn new(point: Vec3, normal: Vec3, least: f32, grid: Grid, rounds: &[&[Gathered]]) -> Self {
        let (x, y) = pair(normal);
        let (mut light, mut near) = (Vec3::ZERO, 0.0);
        let (mut turn, mut shift) = ([Vec3::ZERO; 3], [Vec3::ZERO; 3]);
        let Grid { rings, sectors } = grid;
        let about = |turns: f32| {
            let (s, c) = slo_accel::math::elementary::sin_cos_turns(turns - turns.floor());
            x * c + y * s
        };
        for round in rounds {
            let at = |ring: u32, sector: u32| round[(ring * sectors + sector) as usize];
            for sector in 0..sectors {
                let middle = (sector as f32 + 0.5) / sectors as f32;
                let (out, side) = (about(middle), about(middle + 0.25));
                let before_side = about(middle - 0.5 / sectors as f32 + 0.25);
                let before = (sector + sectors - 1) % sectors;
                for ring in 0..rings {
                    let here = at(ring, sector);
                    light += here.light;
                    near += 1.0 / here.distance;
                    let low = ring as f32 / rings as f32;
                    let high = (ring + 1) as f32 / rings as f32;
                    let square = ((ring as f32 + 0.5) / rings as f32).min(0.999);
                    let tangent = (square / (1.0 - square)).sqrt();
                    let left = at(ring, before);
                    let across = (high.sqrt() - low.sqrt()) / here.distance.min(left.distance);
                    let sideways = (here.light - left.light) * across;
                    let inner = at(ring.saturating_sub(1), sector);
                    let along = low.sqrt() * (1.0 - low) / here.distance.min(inner.distance);
                    let along = along * TAU / sectors as f32;
                    let outward = (here.light - inner.light) * along;
                    for channel in 0..3 {
                        turn[channel] += side * (tangent * here.light[channel]);
                        shift[channel] += before_side * sideways[channel] + out * outward[channel];
                    }
                }
            }
        }
        let count = (grid.rays() * rounds.len() as u32) as f32;
        let light = light * (PI / count);
        let turn = turn.map(|turn| turn * (PI / count));
        let shift = shift.map(|shift| shift * (1.0 / rounds.len() as f32));
        // Where irradiance changes fast, records lie closer together.
        let steepest = |channel: usize| light[channel] / shift[channel].length();
        let reach = [0, 1, 2].map(steepest).into_iter().fold(f32::INFINITY, f32::min);
        let mean = count / near;
        let radius = mean.min(reach).max(least);
        // A gradient that was not believed for the distance is not believed at all.
        let scale = (reach / radius).min(1.0);
        let scale = if scale.is_finite() { scale } else { 0.0 };
        let radius = if radius.is_finite() { radius } else { f32::MAX.sqrt() };
        Self { point, normal, radius, light, turn, shift: shift.map(|shift| shift * scale) }
    }

    /// Returns the irradiance at another point.
    #[inline(always)]
    fn at(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let (way, axis) = (point - self.point, self.normal.cross(normal));
        let change = |channel: usize| way.dot(self.shift[channel]) + axis.dot(self.turn[channel]);
        (self.light + Vec3::new(change(0), change(1), change(2))).max(Vec3::ZERO)
    }
}

/// Records of about the same radius.
#[derive(Clone, Debug)]
struct Class {
    tree: KdTree,
    /// In the order of the tree.
    records: Vec<CacheRecord>,
    /// The largest distance at which one of them counts.
    reach: f32,
}

/// Records, to be looked up.
#[derive(Clone, Debug, Default)]
pub struct IrradianceCache {
    classes: Vec<Class>,
    /// The least weight of a record that counts: 1 over the error that is allowed.
    least_weight: f32,
    /// Whether records count that lie in front of a point.
    in_front: bool,
}

impl IrradianceCache {
    /// Makes a cache of records, for an error of at most `error`.
    pub fn new(records: &[CacheRecord], error: f32, in_front: bool) -> Self {
        let class_of = |record: &CacheRecord| record.radius.to_bits() >> 23;
        let mut sorted: Vec<&CacheRecord> = records.iter().collect();
        sorted.sort_by_key(|&record| class_of(record));
        let classes = sorted.chunk_by(|&a, &b| class_of(a) == class_of(b)).map(|chunk| {
            let places: Vec<Vec3> = chunk.iter().map(|record| record.point).collect();
            let (tree, order) = KdTree::new(&places);
            let records: Vec<CacheRecord> = order.iter().map(|&i| *chunk[i as usize]).collect();
            let radius = records.iter().fold(0.0f32, |most, record| most.max(record.radius));
            Class { tree, records, reach: radius * error }
        });
        Self { classes: classes.collect(), least_weight: 1.0 / error, in_front }
    }

    /// Returns the irradiance at a point on the side of a unit normal; `None` if no record counts there.
    #[inline(always)]
    pub fn light(&self, point: Vec3, normal: Vec3) -> Option<Vec3> {
        let (mut light, mut sum) = (Vec3::ZERO, 0.0);
        for Class { tree, records, reach } in &self.classes {
            let square = (reach * reach).min(f32::MAX);
            tree.near(Around { point, flat: Vec3::ZERO, square }, |number, distance| {
                let record = &records[number as usize];
                let bend = (1.0 - record.normal.dot(normal)).max(0.0).sqrt();
                let weight = 1.0 / (distance.sqrt() / record.radius + bend).max(1e-6);
                let height = (point - record.point).dot(record.normal + normal) * 0.5;
                // Flat surfaces are flat up to rounding.
                let is_behind = height < -0.01 * self.error() * record.radius;
                if weight > self.least_weight && (self.in_front || !is_behind) {
                    // Falls to 0 where the record ends.
                    let weight = weight - self.least_weight;
                    light += record.at(point, normal) * weight;
                    sum += weight;
                }
                square
            });
        }
        (sum > 0.0).then(|| light * (1.0 / sum))
    }

    fn error(&self) -> f32 {
        1.0 / self.least_weight
    }

    /// Whether there are no records.
    pub fn is_empty(&self) -> bool {
        self.classes.is_empty()
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.classes.iter().map(|class| class.records.len()).sum()
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        let of = |class: &Class| class.tree.memory() + size_of_val(&class.records[..]);
        self.classes.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record at a place below a ceiling at height 1 that glows where x > 0.
    fn record(x: f32, normal: Vec3) -> CacheRecord {
        let grid = Grid { rings: 64, sectors: 200 };
        let (a, b) = pair(normal);
        let rays: Vec<Gathered> = (0..grid.rays())
            .map(|ray| {
                let local = grid.direction(ray, [0.5; 2]);
                let way = a * local.x + b * local.y + normal * local.z;
                let distance = if way.z > 0.0 { 1.0 / way.z } else { f32::INFINITY };
                let is_lit = way.z > 0.0 && x + way.x * distance > 0.0;
                Gathered { light: Vec3::splat(if is_lit { 1.0 } else { 0.0 }), distance }
            })
            .collect();
        CacheRecord::new(Vec3::new(x, 0.0, 0.0), normal, 0.01, grid, &[&rays])
    }

    #[test]
    fn gradients_are_differences() {
        let here = record(0.0, Vec3::Z);
        assert!((here.light.x - 0.5 * PI).abs() < 0.01, "{}", here.light);
        // The irradiance under a half plane is pi / 2 (1 + x / sqrt(x² + h²)).
        assert!((here.shift[0].x - 0.5 * PI).abs() < 0.1, "{}", here.shift[0]);
        assert!(here.shift[0].y.abs() < 0.02, "{}", here.shift[0]);
        let close = here.at(Vec3::X * 0.1, Vec3::Z).x;
        let expected = 0.5 * PI * (1.0 + 0.1 / 1.01f32.sqrt());
        assert!((close - expected).abs() < 0.02, "{close}, expected {expected}");
        let turned = Vec3::new(0.1, 0.0, 1.0).normalize();
        let found = here.at(Vec3::ZERO, turned).x;
        let expected = record(0.0, turned).light.x;
        assert!((found - expected).abs() < 0.03, "{found}, expected {expected}");
    }

    #[test]
    fn records_count_within_the_error() {
        let mut far = record(0.0, Vec3::Z);
        far.radius = 1.0;
        let cache = IrradianceCache::new(&[far], 0.2, false);
        assert_eq!(cache.len(), 1);
        assert!(cache.light(Vec3::X * 0.19, Vec3::Z).is_some());
        assert!(cache.light(Vec3::X * 0.21, Vec3::Z).is_none());
        assert!(cache.light(Vec3::ZERO, Vec3::X).is_none());
        // The record lies in front of a point behind it.
        let behind = Vec3::new(0.0, 0.0, -0.1);
        assert!(cache.light(behind, Vec3::Z).is_none());
        assert!(IrradianceCache::new(&[far], 0.2, true).light(behind, Vec3::Z).is_some());
        assert!(IrradianceCache::default().light(behind, Vec3::Z).is_none());
    }

    #[test]
    fn grids_have_no_more_rays_than_asked_for() {
        for rays in [1, 2, 7, 100, 252, 1024] {
            let grid = Grid::of(rays);
            assert!(grid.rays() <= rays && grid.rays() * 3 >= rays.min(480), "{rays}: {grid:?}");
        }
    }
}
