//! Rectangles as seen from a hit, sampled uniformly by solid angle.
//!
//! Source: C. Ureña, M. Fajardo and A. King, "An Area-Preserving Parametrization for Spherical
//! Rectangles" (2013). Their angles are not computed: sums of angles are products of complex
//! numbers, which keep more digits and cost less.

use std::f32::consts::TAU;

use slo_accel::math::elementary::{atan2_turns, sin_cos_turns};

/// Least solid angle, sr, that is sampled this way: with less, the digits do not suffice, and an
/// even density over the rectangle does as well.
const LEAST: f32 = 0.02;

/// Least height over the rectangle's plane, as a share of the sum of two sides.
const LEAST_HEIGHT: f32 = 1e-3;

/// A rectangle in coordinates along its sides and its normal, in which the hit is the origin and
/// the sum of two sides is 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalRectangle {
    /// First and last coordinates along the first side, and along the second side.
    x: [f32; 2],
    y: [f32; 2],
    /// Distance of the plane, and its square.
    height: f32,
    height2: f32,
    /// Distances of the corners (`x[0]`, `y[0]`) and (`x[0]`, `y[1]`).
    corners: [f32; 2],
    /// Solid angle in units of 2 pi.
    turns: f32,
}

impl SphericalRectangle {
    /// A rectangle whose first corner has the coordinates `x`, `y` and `height`.
    #[inline(always)]
    pub(super) fn new(x: f32, y: f32, height: f32, [width, depth]: [f32; 2]) -> Self {
        let (x, y, height) = ([x, x + width], [y, y + depth], height.abs());
        let height2 = height * height;
        let [xx, yy] = [x, y].map(|[a, b]| [a * a, a * b, b * b]);
        // Dot products of two corners: they share a coordinate, or are opposite.
        let dot = |i: usize, j: usize| xx[i] + yy[j] + height2;
        let [r00, r02, r22, r20] = [(0, 0), (0, 2), (2, 2), (2, 0)].map(|(i, j)| dot(i, j).sqrt());
        // The tangent of half the solid angle of each of two triangles is `volume / a`, `volume / b`.
        // Source: A. van Oosterom and J. Strackee, "The Solid Angle of a Plane Triangle" (1983).
        let volume = height * width * depth;
        let across = dot(1, 1);
        let a = r00 * r20 * r22 + dot(1, 0) * r22 + across * r20 + dot(2, 1) * r00;
        let b = r00 * r22 * r02 + across * r02 + dot(1, 2) * r00 + dot(0, 1) * r22;
        let half = atan2_turns((volume * (a + b)).abs(), a * b - volume * volume);
        Self { x, y, height, height2, corners: [r00, r02], turns: 2.0 * half }
    }

    /// Whether it may be sampled; false if anything is not a number.
    #[inline(always)]
    pub(super) fn is_large(&self) -> bool {
        (self.turns > LEAST / TAU) & (self.height > LEAST_HEIGHT)
    }

    /// The `pdf_solid_angle` of all its points.
    #[inline(always)]
    pub(super) fn density(&self) -> f32 {
        1.0 / (TAU * self.turns)
    }

    /// Samples a point, by a point `u` of the unit square: returns the shares of the sides. They are
    /// from 0 to 1 for rectangles that are large.
    #[inline(always)]
    pub(super) fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        let Self { x, y, height, height2, corners, turns } = *self;
        let root = |a: f32| (a * a + height2).sqrt();
        let (to_y, to_end, to_x) = (root(y[0]), root(y[1]), root(x[0]));
        let inverse = 1.0 / (to_y * to_end * (to_x * to_x));
        // The rectangle's angles at its first and last corners along x = x[0], without their
        // divisors, and minus the sum of both.
        let [first, last] =
            [[-x[0] * y[0], height * corners[0]], [x[0] * y[1], height * corners[1]]];
        let cos_start = (first[0] * last[0] - first[1] * last[1]) * inverse;
        let sin_start = height * x[0] * (corners[1] * y[0] - corners[0] * y[1]) * inverse;
        let (sin, cos) = sin_cos_turns(u[0] * turns);
        let sin_all = sin_start * cos + cos_start * sin;
        let cos_all = cos_start * cos - sin_start * sin;
        // The plane through the hit that cuts off the share u[0] on the side of x[0].
        let lean = -y[0] / to_y * cos_all - y[1] / to_end;
        let rise = sin_all * height / to_y;
        let across = ((lean - rise) * (lean + rise)).max(f32::MIN_POSITIVE).sqrt();
        let at = (sin_all * height).copysign(sin_all * lean) / across;
        let at = at.max(x[0]).min(x[1]);
        // Along that plane, the height on the unit sphere is uniform.
        let near2 = at * at + height2;
        let [low, high] = y.map(|y| y / (y * y + near2).sqrt());
        let sine = low + (high - low) * u[1];
        let cosine = (1.0 - sine * sine).max(1e-12).sqrt();
        let up = (sine * near2.sqrt() / cosine).max(y[0]).min(y[1]);
        let share =
            |at: f32, [start, end]: [f32; 2]| ((at - start) / (end - start)).clamp(0.0, 1.0);
        [share(at, x), share(up, y)]
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    /// The solid angle of the rectangle from `x[0]`, `y[0]` to `x[1]`, `y[1]`.
    fn solid_angle(x: [f64; 2], y: [f64; 2], z: f64) -> f64 {
        let corner = |x: f64, y: f64| libm::atan2(x * y, z * (x * x + y * y + z * z).sqrt());
        corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
    }

    /// A sample is as far along each side as the share of solid angle below it says: near and far,
    /// over the rectangle and beside it, almost in its plane, and of any slimness.
    #[test]
    fn samples_divide_the_solid_angle() {
        let mut rng = StdRng::seed_from_u64(13);
        let (mut large, mut worst, mut sum) = (0u16, 0.0f64, 0.0);
        for _ in 0..60_000 {
            let mut number = |low: f64, high: f64| rng.random_range(low..high);
            let width = 1.0 / (1.0 + libm::exp2(number(-5.0, 5.0)));
            let size = [width, 1.0 - width];
            let height = libm::exp2(number(-11.0, 4.0));
            let [x, y] = size.map(|side| side * number(-2.0, 1.0) * libm::exp2(number(-2.0, 4.0)));
            let u = [number(0.0, 1.0), number(0.0, 1.0)];
            let [x, y, height, width, depth] =
                [x, y, height, size[0], size[1]].map(|number| number as f32);
            let seen = SphericalRectangle::new(x, y, height, [width, depth]);
            let [x, y, z, width, depth] = [x, y, height, width, depth].map(f64::from);
            let all = solid_angle([x, x + width], [y, y + depth], z);
            if !seen.is_large() {
                assert!(all < 0.0201 || z < 0.0011, "{seen:?}");
                continue;
            }
            let off = (all * f64::from(seen.density()) - 1.0).abs();
            assert!(off < 3e-3, "{off}: {seen:?}");
            let [s, t] = seen.sample(u.map(|u| u as f32)).map(f64::from);
            let (at, up) = (x + s * width, y + t * depth);
            let first = solid_angle([x, at], [y, y + depth], z) / all;
            let sine = |y: f64| y / (at * at + y * y + z * z).sqrt();
            let second = (sine(up) - sine(y)) / (sine(y + depth) - sine(y));
            let error = (first - u[0]).abs().max((second - u[1]).abs());
            (large, worst, sum) = (large + 1, worst.max(error), sum + error);
        }
        let mean = sum / f64::from(large);
        assert!(large > 10_000 && worst < 3e-3 && mean < 1e-5, "{large}: {worst}, {mean}");
    }

    #[test]
    fn what_is_no_rectangle_is_not_sampled() {
        for (x, y, height, size) in [
            (f32::NAN, 0.0, 1.0, [0.5; 2]),
            (0.0, 0.0, f32::NAN, [0.5; 2]),
            (0.0, 0.0, 0.1, [f32::NAN; 2]),
            (-0.5, -0.5, 0.0, [0.5; 2]),
            (1e30, 1e30, 1e30, [0.5; 2]),
            (-0.5, -0.5, 0.1, [1.0, 0.0]),
        ] {
            let seen = SphericalRectangle::new(x, y, height, size);
            assert!(!seen.is_large(), "{seen:?}");
        }
    }
}
