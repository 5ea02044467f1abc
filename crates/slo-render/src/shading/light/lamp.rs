//! The interface of lights to the integrator, whatever their kind.

use glam::Vec3;

use super::bounds::LightBounds;
use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

/// A sampled point of a light, as a hit sees it.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// See [`Lamp::way`].
    pub way: Vec3,
    /// See [`Lamp::radiance`].
    pub radiance: Vec3,
    /// See [`Lamp::density`].
    pub density: f32,
}

/// [`Sampled`] points of a light for a batch of hits, in columns.
#[derive(Debug)]
pub struct Samples {
    /// See [`Sampled::way`].
    pub way: Vec3s,
    /// See [`Sampled::radiance`].
    pub radiance: Vec3s,
    /// See [`Sampled::density`].
    pub density: Column<f32>,
    /// Working memory of images: where they show the points, and of which cell of their tables.
    pub(super) uv: [Column<f32>; 2],
    pub(super) cell: [Column<u32>; 2],
}

impl Samples {
    /// Returns sample `i`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Sampled {
        let (way, radiance) = (self.way.get(i), self.radiance.get(i));
        Sampled { way, radiance, density: self.density[i] }
    }
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            way: Vec3s::default(),
            radiance: Vec3s::default(),
            density: [0.0; BATCH],
            uv: [[0.0; BATCH]; 2],
            cell: [[0; BATCH]; 2],
        }
    }
}

/// A light of one kind, in render space. All functions but [`bounds`](Self::bounds) are free of
/// branches, for use on whole columns of hits.
pub trait Lamp: Copy {
    /// Whether the light has an area, so that several rays to different points of it reduce noise.
    const IS_AREA: bool;

    /// Whether no ray can hit the light. [`radiance`](Self::radiance) of such a light is the
    /// irradiance on a surface that faces it.
    const IS_DELTA: bool;

    /// Whether it is one of the thesis's lights, whose light does not fall off with distance.
    const IS_OF_THESIS: bool = false;

    /// Whether the light is infinitely far away. Vectors from hits to its points are then unit
    /// directions, and rays to it have no end.
    const IS_DISTANT: bool = false;

    /// Whether its surface encloses a body, and emits light to the outside only.
    const IS_CLOSED: bool = false;

    /// Whether its functions look up tables, so that loops over them do not become vector code.
    const LOOKS_UP: bool = false;

    /// Whether the material of its surface tells its radiance where rays to it arrive.
    const IS_SHADED: bool = false;

    /// Returns the radiance that reaches a hit from a point of the light if nothing blocks it;
    /// `way` is the vector from the hit to the point.
    fn radiance(&self, way: Vec3) -> Vec3;

    /// Samples a point of the light for a hit at `from`, by a point `u` of the unit square; for a
    /// distant light, a unit direction.
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3;

    /// Returns the vector from a hit at `from` to the point of the light that
    /// [`point`](Self::point) samples; for a distant light, the unit direction.
    #[inline(always)]
    fn way(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.point(from, u) - from
    }

    /// Returns the `pdf_solid_angle`, as seen from a hit at `from`, with which
    /// [`point`](Self::point) samples the point of the light at the end of the vector `way` from
    /// the hit. It is infinite for a light that no ray can hit, and for a hit that lies inside the
    /// light and gets nothing of it.
    fn density(&self, from: Vec3, way: Vec3) -> f32;

    /// Samples a point of the light, and returns its radiance and density too.
    #[inline(always)]
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Sampled {
        let way = self.way(from, u);
        Sampled { way, radiance: self.radiance(way), density: self.density(from, way) }
    }

    /// Returns the radiance and the density of the point of the light at the end of the vector
    /// `way` from a hit.
    #[inline(always)]
    fn found(&self, from: Vec3, way: Vec3) -> (Vec3, f32) {
        (self.radiance(way), self.density(from, way))
    }

    /// [`sample`](Self::sample) for those of `len` hits that ask, by points `u`. The others keep what
    /// they have. Lights that look up tables do this step by step, so that many look-ups are under
    /// way at the same time.
    fn sample_each(
        &self,
        isa: Isa,
        (hits, len): (&Vec3s, usize),
        u: [&Column<f32>; 2],
        asks: impl Fn(usize) -> bool,
        to: &mut Samples,
    ) {
        let _ = isa;
        for i in (0..len.min(BATCH)).filter(|i| asks(*i)) {
            let sampled = self.sample(hits.get(i), u.map(|column| column[i]));
            to.way.set(i, sampled.way);
            to.radiance.set(i, sampled.radiance);
            to.density[i] = sampled.density;
        }
    }

    /// [`found`](Self::found) for `len` hits, with `way` of the samples.
    fn found_each(&self, isa: Isa, hits: &Vec3s, len: usize, to: &mut Samples) {
        let _ = isa;
        for i in 0..len.min(BATCH) {
            let (radiance, density) = self.found(hits.get(i), to.way.get(i));
            to.radiance.set(i, radiance);
            to.density[i] = density;
        }
    }

    /// Returns the direction of a shadow ray from `from` to a `point` of the light, not normalized,
    /// and the t at which it ends: 1, minus a margin that keeps it from hitting the light's own
    /// surface. A ray to a distant light goes in the direction `point` without an end.
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32);

    /// Whether a point lies inside the light, from where nothing of it can be seen.
    fn encloses(&self, _point: Vec3) -> bool {
        false
    }

    /// Returns the area of its surface; 0 for a light without one.
    fn area(&self) -> f32 {
        0.0
    }

    /// Returns a point of its surface, uniformly by area, by a point `u` of the unit square. Means
    /// nothing for a distant light.
    fn place(&self, u: [f32; 2]) -> Vec3 {
        self.point(Vec3::ZERO, u)
    }

    /// Returns the unit normal of its surface at a point of it; of a flat light, on the front.
    fn normal(&self, _point: Vec3) -> Vec3 {
        Vec3::Z
    }

    /// Returns where the light is, where it shines, and how much.
    fn bounds(&self) -> LightBounds;
}

/// Returns how bright a colour looks: its luminance.
#[inline(always)]
pub(super) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
