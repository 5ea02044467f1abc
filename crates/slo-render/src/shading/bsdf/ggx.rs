//! Surfaces of microfacets whose normals are distributed by GGX, with Smith's height-correlated
//! masking, in frames whose z axis is the surface's normal.
//!
//! Sources: E. Heitz, "Understanding the Masking-Shadowing Function" (JCGT 2014); J. Dupuy and
//! A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps" (2023).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use slo_accel::math::elementary::sin_cos_turns;

use crate::shading::lobe::pair;

/// Below this roughness a lobe is perfect.
pub(super) const LEAST_ROUGHNESS: f32 = 0.01;

/// The smallest width of lobes that are not perfect, for the digits of f32.
const LEAST_ALPHA: f32 = 1e-4;

/// The widths of the lobes of a roughness, along and across the tangent; 0 for perfect lobes.
#[inline(always)]
pub(super) fn widths(roughness: f32, anisotropic: f32) -> [f32; 2] {
    let alpha = roughness * roughness;
    let aspect = (1.0 - 0.9 * anisotropic.clamp(0.0, 1.0)).sqrt();
    let width = |alpha: f32| {
        if roughness < LEAST_ROUGHNESS { 0.0 } else { alpha.clamp(LEAST_ALPHA, 4.0) }
    };
    [width(alpha / aspect), width(alpha * aspect)]
}

/// Three unit vectors, perpendicular to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    /// A frame with any x axis.
    #[inline(always)]
    pub(super) fn about(z: Vec3) -> Self {
        let (x, y) = pair(z);
        Self { x, y, z }
    }

    /// The frame of two of its axes.
    #[inline(always)]
    pub(super) fn of(x: Vec3, z: Vec3) -> Self {
        Self { x, y: z.cross(x), z }
    }

    #[inline(always)]
    pub(super) fn to_local(self, w: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(w), self.y.dot(w), self.z.dot(w))
    }

    #[inline(always)]
    pub(super) fn to_world(self, w: Vec3) -> Vec3 {
        self.x * w.x + self.y * w.y + self.z * w.z
    }
}

/// The microfacets of a surface, as seen from a direction above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    alpha: [f32; 2],
    /// The unit direction of the eye.
    pub(super) eye: Vec3,
    /// [`slant`] of `eye`.
    slant: f32,
}

/// The square root of z² + (alpha_x x)² + (alpha_y y)²: z (1 + 2 Lambda) of Smith's masking.
#[inline(always)]
fn slant(w: Vec3, [x, y]: [f32; 2]) -> f32 {
    let (a, b) = (w.x * x, w.y * y);
    (w.z * w.z + a * a + b * b).sqrt()
}

impl Seen {
    /// Prepares the view from `eye`; `alpha` above 0.
    #[inline(always)]
    pub(super) fn new(eye: Vec3, alpha: [f32; 2]) -> Self {
        let eye = Vec3::new(eye.x, eye.y, eye.z.max(1e-6));
        Self { alpha, eye, slant: slant(eye, alpha) }
    }

    /// Samples a normal of the visible microfacets.
    #[inline(always)]
    pub(super) fn sample(self, u: [f32; 2]) -> Vec3 {
        let [ax, ay] = self.alpha;
        let stretched = Vec3::new(self.eye.x * ax, self.eye.y * ay, self.eye.z) / self.slant;
        let (s, c) = sin_cos_turns(u[0]);
        let z = 1.0 - u[1] * (1.0 + stretched.z);
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let h = Vec3::new(sin * c, sin * s, z) + stretched;
        let h = Vec3::new(h.x * ax, h.y * ay, h.z.max(1e-12));
        h * (1.0 / h.length())
    }

    /// How densely unit normals lie about `h`, per area of the surface and solid angle: GGX.
    #[inline(always)]
    fn distribution(self, h: Vec3) -> f32 {
        let [ax, ay] = self.alpha;
        let (x, y) = (h.x / ax, h.y / ay);
        let t = x * x + y * y + h.z * h.z;
        let d = FRAC_1_PI / (ax * ay * t * t);
        if h.z > 0.0 { d } else { 0.0 }
    }

    /// The density with which [`sample`](Self::sample) finds `h`, divided by the cosine of the eye
    /// to `h`.
    #[inline(always)]
    pub(super) fn density(self, h: Vec3) -> f32 {
        2.0 * self.distribution(h) / (self.eye.z + self.slant)
    }

    /// The share of the visible microfacets that direction `w` sees too, where `z` is the height
    /// of `w` above its own side of the surface.
    #[inline(always)]
    pub(super) fn passed(self, w: Vec3, z: f32) -> f32 {
        let z = z.max(0.0);
        let both = z * self.slant + self.eye.z * slant(w, self.alpha);
        z * (self.eye.z + self.slant) / both.max(f32::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_keep_vectors() {
        let frame = Frame::of(Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.8, 0.0, 0.6));
        let w = Vec3::new(0.2, -0.5, 0.7);
        assert!((frame.to_world(frame.to_local(w)) - w).length() < 1e-6);
        assert!((Frame::about(Vec3::Z).to_local(w).z - w.z).abs() < 1e-6);
    }
}
