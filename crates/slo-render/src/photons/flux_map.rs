//! Photons on rough surfaces, and the irradiance that they stand for.
//!
//! Source: H. W. Jensen, "Realistic Image Synthesis Using Photon Mapping" (2001).

use std::f32::consts::PI;

use glam::Vec3;
use slo_accel::math::Bounds;

use super::hull::area_of;
use super::nearest::{Around, KdTree, Nearest};
use crate::shading::light::receiver;
use crate::shading::lobe::pair;

/// A photon where it met a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit {
    /// Where it is, in render space.
    pub position: Vec3,
    /// Its power, W, if there was one light path.
    pub power: Vec3,
    /// Packed geometric normal of the surface, on the side that it came from.
    pub normal: u32,
    /// Number of its light path.
    pub path: u32,
}

/// Power and packed normal of a photon.
#[derive(Clone, Copy, Debug)]
struct Flux {
    power: Vec3,
    normal: u32,
}

/// Photons in a tree.
#[derive(Clone, Debug, Default)]
pub struct FluxMap {
    tree: KdTree,
    /// In the order of the tree.
    positions: Vec<Vec3>,
    flux: Vec<Flux>,
    /// Which number each had before.
    order: Vec<u32>,
    /// Photons are looked for within the root of this.
    most_square: f32,
}

/// How irradiance is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// Most photons that count.
    pub nearest: u32,
    /// Whether they count less with distance, in proportion to it.
    pub cone: bool,
    /// Whether the surface may end within the distance: its area is then estimated.
    pub ends: bool,
}

/// An estimate of irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// W/m^2
    pub light: Vec3,
    /// Distance from within which the photons are.
    pub radius: f32,
}

/// Least cosine between the normal of a photon's surface and that of a point for it to count there:
/// photons on the other side, or round a corner, don't.
pub(super) const LEAST_COSINE: f32 = 0.7;

/// Distances along the normal count so many times: the photons of a point lie in a flat disc.
pub(super) const FLATNESS: f32 = 4.0;

impl FluxMap {
    /// Puts photons in a tree; `paths` light paths were sent. Photons are looked for within a distance,
    /// if one is given, and otherwise within one in which surfaces that have photons have several
    /// times `nearest` of them.
    pub fn new(deposits: &[Deposit], paths: f32, distance: Option<f32>, nearest: u32) -> Self {
        let positions: Vec<Vec3> = deposits.iter().map(|deposit| deposit.position).collect();
        let (tree, order) = KdTree::new(&positions);
        let positions: Vec<Vec3> = order.iter().map(|&i| positions[i as usize]).collect();
        let flux = order.iter().map(|&i| {
            let Deposit { power, normal, .. } = deposits[i as usize];
            Flux { power: power * (1.0 / paths), normal }
        });
        let flux = flux.collect();
        let distance = distance.unwrap_or_else(|| usual_distance(&positions, nearest));
        Self { tree, positions, flux, order, most_square: distance * distance }
    }

    /// Number of photons.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Position and unit normal of photon `i`, and the number that it had before.
    pub fn photon(&self, i: usize) -> (Vec3, Vec3, u32) {
        (self.positions[i], receiver::unpack(self.flux[i].normal), self.order[i])
    }

    /// Square of the distance within which photons are looked for.
    pub fn most_square(&self) -> f32 {
        self.most_square
    }

    /// Number of photons, at most `nearest`, that all but a tenth of the photons find within the distance.
    pub fn usual_count(&self, nearest: u32) -> u32 {
        const PROBES: usize = 256;
        let mut found = Nearest::default();
        let count = |i: usize| {
            let (point, normal, _) = self.photon(i);
            found.restart(nearest as usize, self.most_square);
            let around = Around { point, flat: normal * FLATNESS, square: self.most_square };
            self.tree.near(around, |number, square| {
                let of = receiver::unpack(self.flux[number as usize].normal);
                if of.dot(normal) > LEAST_COSINE {
                    found.add(number, square)
                } else {
                    found.square()
                }
            });
            found.cut();
            found.len() as u32
        };
        let step = self.len().div_ceil(PROBES).max(1);
        let mut counts: Vec<u32> = (0..self.len()).step_by(step).map(count).collect();
        counts.sort_unstable();
        counts.get(counts.len() / 10).copied().unwrap_or(nearest)
    }

    /// Estimates the irradiance on the side of a unit normal. Photon `except` does not count.
    #[inline(always)]
    pub fn irradiance(
        &self,
        point: Vec3,
        normal: Vec3,
        rule: Rule,
        except: u32,
        nearest: &mut Nearest,
    ) -> Irradiance {
        // One more, which says how far the others reach.
        nearest.restart(rule.nearest as usize + 1, self.most_square);
        let around = Around { point, flat: normal * FLATNESS, square: self.most_square };
        self.tree.near(around, |number, square| {
            let fits =
                receiver::unpack(self.flux[number as usize].normal).dot(normal) > LEAST_COSINE;
            if fits && number != except { nearest.add(number, square) } else { nearest.square() }
        });
        nearest.cut();
        let len = nearest.len();
        let square = if nearest.is_full() { nearest.square() } else { self.most_square };
        let counted = if nearest.is_full() { len - 1 } else { len };
        if counted == 0 || square.is_nan() || square <= 0.0 {
            return Irradiance { light: Vec3::ZERO, radius: self.most_square.sqrt() };
        }
        let radius = square.sqrt();
        let (mut light, mut middle) = (Vec3::ZERO, Vec3::ZERO);
        // The area of a cap is that of a disc whose radius is the chord, so surfaces that bend away have
        // no larger discs for the weight of distances along the normal.
        let chord = |number: u32| (self.positions[number as usize] - point).length_squared();
        let farthest = nearest.iter().map(|(number, _)| chord(number)).fold(0.0, f32::max);
        let disc = PI * if nearest.is_full() { farthest.min(square) } else { square };
        for (number, square) in nearest.iter().take(counted) {
            let share = if rule.cone { 1.0 - square.sqrt() / radius } else { 1.0 };
            light += self.flux[number as usize].power * share;
            middle += self.positions[number as usize] - point;
        }
        let area = if rule.cone { disc * (1.0 / 3.0) } else { disc };
        // The mean of places that fill a disc is off its middle by as much as this, squared, in one of
        // seven cases.
        let off = middle * (1.0 / counted as f32);
        let is_cut = rule.ends && off.length_squared() > square / counted as f32;
        let area =
            if is_cut { self.cut_area(point, normal, nearest, counted).min(area) } else { area };
        Irradiance { light: light * (1.0 / area), radius }
    }

    /// Estimates the area of the surface that found photons are on.
    fn cut_area(&self, point: Vec3, normal: Vec3, nearest: &Nearest, counted: usize) -> f32 {
        let (x, y) = pair(normal);
        let place = |(number, _): (u32, f32)| {
            let way = self.positions[number as usize] - point;
            [way.dot(x), way.dot(y)]
        };
        area_of(nearest.iter().take(counted).map(place)).unwrap_or(f32::INFINITY)
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        self.tree.memory()
            + size_of_val(&self.positions[..])
            + size_of_val(&self.flux[..])
            + size_of_val(&self.order[..])
    }
}

/// A distance in which there are several times `nearest` photons if they are spread evenly over their
/// box.
fn usual_distance(positions: &[Vec3], nearest: u32) -> f32 {
    const TIMES: f32 = 4.0;
    let bounds = Bounds::of_points(positions.iter().copied());
    let size = (bounds.max - bounds.min).max(Vec3::ZERO);
    let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let area = if area > 0.0 { area } else { size.length_squared().max(f32::MIN_POSITIVE) };
    (TIMES * nearest as f32 * area / (PI * positions.len().max(1) as f32)).sqrt()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    /// Photons on a square of side 2 that faces z, of a power that makes an irradiance of 1.
    fn square(count: u32) -> Vec<Deposit> {
        let mut rng = StdRng::seed_from_u64(5);
        let power = Vec3::splat(4.0 / count as f32);
        let normal = receiver::pack(Vec3::Z);
        let mut at = || rng.random_range(-1.0..1.0f32);
        (0..count)
            .map(|path| Deposit { position: Vec3::new(at(), at(), 0.0), power, normal, path })
            .collect()
    }

    fn mean(map: &FluxMap, rule: Rule, points: &[Vec3]) -> f32 {
        let mut nearest = Nearest::default();
        let of = |p: &Vec3| map.irradiance(*p, Vec3::Z, rule, u32::MAX, &mut nearest).light.x;
        points.iter().map(of).sum::<f32>() / points.len() as f32
    }

    #[test]
    fn irradiance_is_right_in_the_middle_for_any_number_of_photons() {
        let map = FluxMap::new(&square(100_000), 1.0, None, 200);
        let points: Vec<Vec3> = (0..2500)
            .map(|i| Vec3::new((i % 50) as f32, (i / 50) as f32, 0.0) * 0.02 - 0.5)
            .map(|p| Vec3::new(p.x, p.y, 0.0))
            .collect();
        // With one photon, the variance of the estimate is infinite.
        for (nearest, bound) in [(1, 0.3), (3, 0.05), (20, 0.02), (200, 0.02)] {
            for cone in [false, true] {
                let rule = Rule { nearest, cone, ends: false };
                let found = mean(&map, rule, &points);
                assert!((found - 1.0).abs() < bound, "{nearest}, {cone}: {found}");
            }
        }
    }

    #[test]
    fn edges_and_corners_of_surfaces_are_as_bright_as_their_middles() {
        let map = FluxMap::new(&square(100_000), 1.0, None, 200);
        let edge: Vec<Vec3> =
            (0..500).map(|i| Vec3::new(-0.5 + i as f32 * 0.002, -1.0, 0.0)).collect();
        let rule = Rule { nearest: 200, cone: false, ends: true };
        let found = mean(&map, rule, &edge);
        assert!((found - 1.0).abs() < 0.04, "edge: {found}");
        let corner = Vec3::new(-0.999, -0.999, 0.0);
        let found = mean(&map, rule, &[corner]);
        assert!((found - 1.0).abs() < 0.3, "corner: {found}");
        let unaware = mean(&map, Rule { ends: false, ..rule }, &edge);
        assert!((unaware - 0.5).abs() < 0.05, "half of the disc is empty: {unaware}");
    }

    #[test]
    fn photons_of_other_surfaces_do_not_count() {
        let mut deposits = square(10_000);
        for deposit in &mut deposits {
            deposit.normal =
                receiver::pack(if deposit.path % 2 == 0 { Vec3::NEG_Z } else { Vec3::X });
        }
        let map = FluxMap::new(&deposits, 1.0, None, 200);
        let rule = Rule { nearest: 50, cone: false, ends: false };
        assert_eq!(mean(&map, rule, &[Vec3::ZERO]), 0.0);
    }
}
