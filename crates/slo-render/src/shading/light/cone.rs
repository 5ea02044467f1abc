//! Directions in a cone: how lamps are sampled that look like discs, and where spots shine.
//!
//! All angles are given by versines, 1 - cos, which keep the digits of small angles.

use std::f32::consts::FRAC_1_PI;

use glam::{DVec3, Vec3};

use crate::sampling::warp::concentric_disc;
use crate::shading::lobe::pair;

/// Samples a direction, uniformly by solid angle, of the cone about unit `axis` whose rim has this
/// versine, by a point `u` of the unit square. Returns the unit direction and its own versine.
#[inline(always)]
pub(crate) fn about(axis: Vec3, rim: f32, u: [f32; 2]) -> (Vec3, f32) {
    let [a, b] = concentric_disc(u);
    let versine = (a * a + b * b) * rim;
    // The sine is sqrt(versine (2 - versine)); a and b share the root of a^2 + b^2.
    let sine = (rim * (2.0 - versine)).sqrt();
    let (x, y) = pair(axis);
    (x * (a * sine) + y * (b * sine) + axis * (1.0 - versine), versine)
}

/// Returns the `pdf_solid_angle` of [`about`].
#[inline(always)]
pub(crate) fn density(rim: f32) -> f32 {
    (0.5 * FRAC_1_PI) / rim
}

/// Returns the versine of an angle in degrees.
pub(super) fn versine_deg(angle: f64) -> f64 {
    let sine = libm::sin(angle.to_radians() * 0.5);
    2.0 * sine * sine
}

/// The directions in which a lamp shines: a cone, with a rim that may be soft; or all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    axis: Vec3,
    /// Versine of the rim.
    rim: f32,
    /// 1 over the difference of versines over which the light fades.
    steepness: f32,
}

impl Beam {
    /// All directions.
    pub(super) const ALL: Self = Self { axis: Vec3::Z, rim: 4.0, steepness: 1.0 };

    /// The cone about unit `axis` that spans `angle_deg`; it fades over the share `blend` of the
    /// difference of cosines. The versine of its rim comes with it.
    pub(super) fn cone(axis: DVec3, angle_deg: f32, blend: f32) -> (Self, f64) {
        let rim = versine_deg(f64::from(angle_deg) * 0.5);
        let steepness = (1.0 / (rim * f64::from(blend))).min(1e30);
        let axis = axis.as_vec3();
        (Self { axis, rim: rim as f32, steepness: steepness as f32 }, rim)
    }

    /// The axis, and the angle of the rim from it, radians.
    pub(super) fn bounds(&self) -> (Vec3, f32) {
        (self.axis, libm::acosf((1.0 - self.rim).max(-1.0)))
    }

    /// Returns the share of its light that the lamp sends in a unit direction.
    #[inline(always)]
    pub(super) fn share(&self, direction: Vec3) -> f32 {
        let versine = (direction - self.axis).length_squared() * 0.5;
        let x = ((self.rim - versine) * self.steepness).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}
