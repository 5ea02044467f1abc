//! The interface of lobes to the integrator, whatever their kind.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::bend::is_kept;

/// Width below which a lobe is sharp: photons follow it, and paths from the camera rarely find small
/// lamps in it. It decides how the work is shared, not what is found.
pub use slo_scene::material::SHARP;

/// One kind of lobe at the hits of a batch. Its functions are free of branches, for use on whole
/// columns of hits, and give finite results for hits that do not have the lobe.
pub trait Lobe {
    /// Whether the lobe spreads light so widely that only PATH follows it with rays, and that the
    /// thesis's lights, which do not fall off with distance, reach it by rays to lamps only.
    const IS_DIFFUSE: bool;

    /// Whether rays follow the lobe. If not, it shows lamps only, by rays to them.
    const IS_FOLLOWED: bool = true;

    /// Whether the lobe shows lamps without an area.
    const SHOWS_POINTS: bool = true;

    /// Whether the lobe of hit `i` is so narrow that photons follow it, instead of ending there; see
    /// [`SHARP`].
    fn is_sharp(&self, _i: usize) -> bool {
        false
    }

    /// Returns the weight of a photon that came from the eye of hit `i` and follows a sample of the lobe
    /// to a unit direction, as a share of the weight of light that goes the other way. Radiance is
    /// compressed where the index of refraction grows, for example, and power is not.
    fn of_photon(&self, _i: usize, _at: &At, _direction: Vec3) -> f32 {
        1.0
    }

    /// Returns the weights and chances of the lobe.
    fn share(&self) -> &Share;

    /// Returns the weights and chances of the lobe.
    fn share_mut(&mut self) -> &mut Share;

    /// Evaluates the lobe of hit `i` for light that arrives from unit direction `toward`. The value
    /// is 0 for a perfect lobe, and on the sides of the surface that the lobe does not serve.
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> Scattered;

    /// Samples the direction that light arrives from at hit `i`, by a point `u` of the unit cube.
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled;
}

/// The directions of a hit. All but the tangent are unit vectors.
#[derive(Clone, Copy, Debug)]
pub struct At {
    /// From the hit to where the ray came from.
    pub eye: Vec3,
    /// Shading normal, on the side of `n_geo`.
    pub n: Vec3,
    /// Geometric normal, on the side of `eye`.
    pub n_geo: Vec3,
    /// Normal of the plane above which light arrives that the surface reflects, on the side of
    /// `eye`: `n_geo`, or a normal near `n` on coarse smooth meshes.
    pub floor: Vec3,
    /// Whether an image bends `n`.
    pub is_bent: bool,
    /// Where anisotropic surfaces have their long axis: any length, not along `n`. If it is 0, an
    /// arbitrary one is taken.
    pub tangent: Vec3,
}

impl At {
    /// Whether lobes use the same normal for light from `toward` to the eye as for a photon that goes the
    /// other way: no normal is bent. Photons leave all other light to paths from the camera.
    #[inline(always)]
    pub fn is_two_way(&self, toward: Vec3) -> bool {
        let Self { eye, n, n_geo, .. } = *self;
        is_kept(eye, n, n_geo) & is_kept(toward, n, n_geo) & self.is_real(toward)
    }

    /// Whether light from `toward` arrives on the same side of the surface as of the plane above which
    /// it counts. Photons arrive at the surface itself, and leave all other light to paths.
    #[inline(always)]
    pub fn is_real(&self, toward: Vec3) -> bool {
        (self.n_geo.dot(toward) > 0.0) == (self.floor.dot(toward) > 0.0)
    }
}

/// What a lobe makes of light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// BSDF times cosine, including the lobe's weight.
    pub value: Vec3,
    /// `pdf_solid_angle` with which the lobe samples the direction.
    pub density: f32,
}

/// A direction sampled by a lobe.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// Unit direction that the light arrives from.
    pub direction: Vec3,
    /// BSDF times cosine over the density, including the lobe's weight. 0 if the sample failed.
    pub weight: Vec3,
    /// `pdf_solid_angle` of the direction; 0 for a perfect lobe.
    pub density: f32,
}

/// What all kinds of lobes have at each hit.
#[derive(Debug)]
pub struct Share {
    /// Multiplies the lobe's value; 0 at hits that do not have the lobe.
    pub weight: Vec3s,
    /// While the lobes of hits are set up: an estimate of the share of light that the lobe
    /// scatters, including its weight. Afterwards: the chance that a ray follows the lobe.
    pub chance: Column<f32>,
    /// Whether any hit has the lobe.
    pub is_present: bool,
}

impl Default for Share {
    fn default() -> Self {
        Self { weight: Vec3s::default(), chance: [0.0; BATCH], is_present: false }
    }
}
