//! Triangles and rays.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::glam::Vec3;
use slo_accel::{Rays, Triangle};

/// A source of random triangles and rays.
pub(crate) struct Random(StdRng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(StdRng::seed_from_u64(seed))
    }

    fn vector(&mut self, scale: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.0.random_range(-1.0..1.0) * scale))
    }

    pub(crate) fn triangles(&mut self, n: usize, size: f32) -> Vec<Triangle> {
        let triangle = |_| {
            let p = self.vector(1.0);
            [p, p + self.vector(size), p + self.vector(size)]
        };
        (0..n).map(triangle).collect()
    }

    /// Rays from outside and inside, slanted and along axes or nearly so, long and short.
    pub(crate) fn rays(&mut self, n: usize, scale: f32) -> Rays {
        let mut rays = Rays::with_capacity(n);
        for i in 0..n {
            let (mut origin, target) = (self.vector(1.5 * scale), self.vector(0.7 * scale));
            let axis = i / 5 % 3;
            if i % 5 >= 2 {
                origin[axis] = target[axis];
            }
            let mut direction = target - origin;
            match i % 5 {
                2 => direction[axis] = if i % 2 == 0 { 0.0 } else { -0.0 },
                3 => direction[axis] = if i % 2 == 0 { 1e-40 } else { -1e-12 * scale },
                4 => direction = Vec3::AXES[axis] * if i % 2 == 0 { scale } else { -scale },
                _ => {}
            }
            let t_max = if i % 7 == 0 { self.0.random_range(0.1..1.5) } else { f32::INFINITY };
            rays.push(origin, direction, t_max);
        }
        rays
    }

    /// Rays between points with small whole coordinates.
    pub(crate) fn raster_rays(&mut self, n: usize, size: i32) -> Rays {
        let mut rays = Rays::with_capacity(n);
        while rays.len() < n {
            let point = |random: &mut Self| {
                let mut number = |most: i32| random.0.random_range(-1..=most) as f32;
                Vec3::new(number(size + 1), number(size + 1), number(5))
            };
            let (origin, target) = (point(self), point(self));
            if origin != target {
                rays.push(origin, target - origin, f32::INFINITY);
            }
        }
        rays
    }

    /// Rays that leave points of triangles.
    pub(crate) fn rays_from(&mut self, triangles: &[Triangle], n: usize) -> Rays {
        let mut rays = Rays::with_capacity(n);
        for _ in 0..n {
            let [a, b, c] = triangles[self.0.random_range(0..triangles.len())];
            let (u, v) = (self.0.random_range(0.0..1.0f32), self.0.random_range(0.0..0.5f32));
            let origin = a + 0.5 * u * (b - a) + v * (c - a);
            let direction = self.vector(1.0);
            rays.push(origin, direction, f32::INFINITY);
        }
        rays
    }
}

/// A ball, closed, of `4 n n` triangles, some of which are long at the poles.
pub(crate) fn ball(n: u32, radius: f32) -> Vec<Triangle> {
    let point = |i: u32, j: u32| {
        // Stereographic, so that no function of the platform is needed.
        let t = i as f32 / n as f32 * 2.0 - 1.0;
        let s = (1.0 - t * t).max(0.0).sqrt();
        let turn = (j % (2 * n)) as f32 / n as f32 - 1.0;
        let w = turn.abs() * 4.0 - 2.0;
        let (x, y) = ((4.0 - w * w) / (4.0 + w * w), 4.0 * w / (4.0 + w * w));
        let side = if turn < 0.0 { -1.0 } else { 1.0 };
        radius * Vec3::new(s * y, s * x * side, t)
    };
    let cells = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
    let two = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    two.collect()
}

/// Hills on a raster of `n` by `n` cells with whole coordinates, some of them flat.
pub(crate) fn hills(n: i32) -> Vec<Triangle> {
    let point = |x: i32, y: i32| Vec3::new(x as f32, y as f32, ((x * 7 + y * 5) % 4) as f32);
    let cells = (0..n).flat_map(|x| (0..n).map(move |y| (x, y)));
    let two = cells.flat_map(|(x, y)| {
        let [a, b] = [point(x, y), point(x + 1, y + 1)];
        [[a, point(x + 1, y), b], [a, b, point(x, y + 1)]]
    });
    two.collect()
}
