//! Random primitives and rays, and the answers of any structure about them.

use glam::Vec3;
use rand::{RngExt, SeedableRng, rngs::StdRng};

use super::interface::SpatialIndex;
use crate::primitives::{Curved, Triangle};
use crate::rays::{Coherence, Hits, LANES, Rays};

/// What a structure answers.
pub(crate) struct Answers {
    pub(crate) hits: Hits,
    pub(crate) blocked: Vec<bool>,
}

impl Answers {
    pub(crate) fn of<I: SpatialIndex>(index: &I, rays: &Rays, coherence: Coherence) -> Self {
        let mut scratch = I::Scratch::default();
        let (mut hits, mut blocked) =
            (Hits::default(), vec![false; rays.len().next_multiple_of(LANES)]);
        hits.reset(rays.len());
        index.intersect(rays, coherence, &mut hits, &mut scratch);
        index.occluded(rays, coherence, &mut blocked, &mut scratch);
        Self { hits, blocked }
    }

    /// Bits of a hit, so that comparisons forgive nothing; and whether the ray is blocked.
    pub(crate) fn bits(&self, i: usize) -> ([u32; 4], bool) {
        let Hits { t, u, v, primitive } = &self.hits;
        ([t[i].to_bits(), u[i].to_bits(), v[i].to_bits(), primitive[i]], self.blocked[i])
    }
}

/// A source of random scenes and rays.
pub(crate) struct Random(pub(crate) StdRng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(StdRng::seed_from_u64(seed))
    }

    pub(crate) fn vector(&mut self, scale: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.0.random_range(-1.0..1.0) * scale))
    }

    pub(crate) fn triangles(&mut self, n: usize, size: f32) -> Vec<Triangle> {
        (0..n)
            .map(|_| {
                let p = self.vector(1.0);
                [p, p + self.vector(size), p + self.vector(size)]
            })
            .collect()
    }

    pub(crate) fn curved(&mut self, n: usize, size: f32) -> Vec<Curved> {
        (0..n)
            .map(|i| {
                let (center, radius) = (self.vector(1.0), size * self.0.random_range(0.1..1.0));
                let other = center + self.vector(2.0 * size);
                match i % 3 {
                    0 => Curved::Sphere { center, radius },
                    1 => Curved::Cylinder { base: center, top: other, radius },
                    _ => Curved::Cone { base: center, apex: other, radius },
                }
            })
            .collect()
    }

    /// Rays through a scene of some size: from outside and inside, slanted and along axes, long
    /// and short, aimed at corners of the grid that flat scenes are made of.
    pub(crate) fn rays(&mut self, n: usize, scale: f32) -> Rays {
        let mut rays = Rays::with_capacity(n);
        for i in 0..n {
            let (mut origin, target) = (self.vector(1.5 * scale), self.vector(0.7 * scale));
            if i % 5 == 2 || i % 5 == 3 {
                origin[i % 3] = target[i % 3];
            }
            let mut direction = target - origin;
            match i % 5 {
                1 => {
                    origin = (origin * (4.0 / scale)).round() * (scale / 4.0);
                    direction = (direction * (4.0 / scale)).round() * (scale / 4.0);
                }
                2 => direction[i % 3] = if i % 2 == 0 { 0.0 } else { -0.0 },
                3 => direction[i % 3] = if i % 2 == 0 { 1e-40 } else { -1e-12 * scale },
                _ => {}
            }
            if direction == Vec3::ZERO {
                direction = Vec3::splat(scale);
            }
            let t_max = if i % 7 == 0 { self.0.random_range(0.1..1.5) } else { f32::INFINITY };
            rays.push(origin, direction, t_max);
        }
        rays
    }

    /// Bundles of rays that go nearly the same way, as the samples of a pixel do, from one point or
    /// from a lens; now and then one ends early, or goes elsewhere.
    pub(crate) fn bundles(&mut self, n: usize, scale: f32) -> Rays {
        let mut rays = Rays::with_capacity(n);
        while rays.len() < n {
            let (origin, target) = (self.vector(1.5 * scale), self.vector(0.7 * scale));
            let spread = scale * [0.0, 1e-3, 0.1][rays.len() / 16 % 3];
            let lens = scale * [0.0, 0.05][rays.len() / 48 % 2];
            for i in 0..self.0.random_range(9..17) {
                let from = origin + self.vector(lens);
                let to = if i == 7 { self.vector(scale) } else { target + self.vector(spread) };
                let t_max = if i % 5 == 3 { self.0.random_range(0.1..1.5) } else { f32::INFINITY };
                rays.push(from, to - from, t_max);
            }
        }
        rays
    }
}
