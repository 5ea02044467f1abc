//! Weighted rays in columns.

use slo_accel::Rays;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

/// Data of a ray besides its geometry.
#[derive(Clone, Debug)]
pub(super) struct Labels {
    /// Shutter time in `[0, 1]`.
    pub(super) time: Column<f32>,
    /// Index of the sum that the ray's light is added to.
    pub(super) slot: Column<u32>,
    /// Hash of the branches that led here.
    pub(super) path: Column<u32>,
    /// Sample number of the ray: its number among the rays of the same path in all samples of the
    /// pixel.
    pub(super) index: Column<u32>,
}

impl Default for Labels {
    fn default() -> Self {
        Self { time: [0.0; BATCH], slot: [0; BATCH], path: [0; BATCH], index: [0; BATCH] }
    }
}

/// What a ray of a path remembers of the hit that it left.
#[derive(Debug)]
pub(super) struct Past {
    /// Where the ray left the surface.
    pub(super) from: Vec3s,
    /// Packed normal of the surface; see [`receiver`](crate::shading::light::receiver).
    pub(super) normal: Column<u32>,
    /// See [`marks`].
    pub(super) marks: Column<u32>,
    /// How this path and photons share what it finds; means nothing in a frame without photons.
    pub(super) rough: RoughStart,
}

/// What a path remembers of the last rough lobe that it left, for sharing light with photons; see
/// [`Merging`](super::stages::merging::Merging).
#[derive(Debug)]
pub(super) struct RoughStart {
    /// Density of the path where it left the lobe, per projected solid angle, divided by the number of
    /// light paths whose photon the hit would have found. 0: it has left none.
    pub(super) rival: Column<f32>,
    /// Width of the pixel's footprint where the ray starts.
    pub(super) width: Column<f32>,
    /// By how much the footprint grows with distance.
    pub(super) spread: Column<f32>,
    /// Whether the frame has photons, so that queues keep the columns.
    pub(super) is_kept: bool,
}

impl RoughStart {
    pub(super) fn columns(&self) -> [&Column<f32>; 3] {
        [&self.rival, &self.width, &self.spread]
    }

    pub(super) fn columns_mut(&mut self) -> [&mut Column<f32>; 3] {
        [&mut self.rival, &mut self.width, &mut self.spread]
    }
}

impl Default for RoughStart {
    fn default() -> Self {
        let zeros = [0.0; BATCH];
        Self { rival: zeros, width: zeros, spread: zeros, is_kept: false }
    }
}

/// Bits of [`Past::marks`].
pub(super) mod marks {
    /// The ray follows a diffuse lobe.
    pub(in crate::integrator) const DIFFUSE: u32 = 1;
    /// The ray follows a sharp lobe.
    pub(in crate::integrator) const SHARP: u32 = 2;
    /// Light that the ray finds of lamps is known already: of a ray that follows a diffuse lobe, all of
    /// it; of a ray that follows a sharp one, what photons of caustics bring.
    pub(in crate::integrator) const TAKEN: u32 = 4;
    /// Of a light path: it left a rough lobe.
    pub(in crate::integrator) const ROUGH: u32 = TAKEN;
    /// One more surface that the ray passed through since it left.
    pub(in crate::integrator) const PASS: u32 = 8;
    /// Most surfaces in a row that a ray passes through.
    pub(in crate::integrator) const MOST_PASSES: u32 = 256;
    /// The ray asks a light that is shaded where the ray arrives: the light's number among these,
    /// plus 1, in the bits from here on.
    const ASK: u32 = PASS << 9;
    const _: () = assert!(crate::shading::light::MOST_SHADED <= u32::MAX / ASK);

    /// Returns the marks of a ray that asks a light.
    #[inline(always)]
    pub(in crate::integrator) fn asking(number: u32) -> u32 {
        (number + 1) * ASK
    }

    /// Returns the number of the light that a ray asks, plus 1; 0 if it asks none.
    #[inline(always)]
    pub(in crate::integrator) fn asked(marks: u32) -> u32 {
        marks / ASK
    }

    /// Returns the number of surfaces that the ray passed through.
    #[inline(always)]
    pub(in crate::integrator) fn passed(marks: u32) -> u32 {
        marks % ASK / PASS
    }
}

impl Default for Past {
    fn default() -> Self {
        Self {
            from: Vec3s::default(),
            normal: [0; BATCH],
            marks: [0; BATCH],
            rough: RoughStart::default(),
        }
    }
}

/// Rays taken from a queue to be traced.
#[derive(Debug)]
pub(super) struct Batch {
    /// The rays, with capacity for [`BATCH`].
    pub(super) rays: Rays,
    /// Weight of the radiance that arrives along each ray. For a ray to a light: the weighted light
    /// that arrives if nothing blocks the ray.
    pub(super) weight: Vec3s,
    /// See [`Sent::density`].
    pub(super) density: Column<f32>,
    pub(super) labels: Labels,
    /// Of rays of paths.
    pub(super) past: Past,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            rays: Rays::with_capacity(BATCH),
            weight: Vec3s::default(),
            density: [0.0; BATCH],
            labels: Labels::default(),
            past: Past::default(),
        }
    }
}

impl Batch {
    /// Returns the number of rays, at most [`BATCH`].
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.rays.len().min(BATCH)
    }
}

/// Rays that the hits of a batch send out. Entry `i` is the ray of hit `i`.
#[derive(Debug)]
pub(super) struct Sent {
    pub(super) origin: Vec3s,
    /// Unit direction for bounces; vector from hit to light for rays to lights.
    pub(super) direction: Vec3s,
    pub(super) t_max: Column<f32>,
    /// See [`Batch::weight`]. If it is 0, no ray is sent.
    pub(super) weight: Vec3s,
    /// `pdf_solid_angle` of the rays of this lobe, times their number, if rays to lamps sample the
    /// same light; 0 otherwise.
    pub(super) density: Column<f32>,
}

impl Default for Sent {
    fn default() -> Self {
        Self {
            origin: Vec3s::default(),
            direction: Vec3s::default(),
            t_max: [0.0; BATCH],
            weight: Vec3s::default(),
            density: [0.0; BATCH],
        }
    }
}

impl Sent {
    /// Whether ray `i` can be traced: its coordinates are finite, and it has a direction.
    #[inline(always)]
    pub(super) fn is_ray(&self, i: usize) -> bool {
        let (o, d) = (self.origin.get(i), self.direction.get(i));
        let size = d.length_squared();
        let sum = (o.x + o.y + o.z) + size;
        sum.abs() < f32::INFINITY && size > 0.0
    }
}
