//! The interface of lights to the integrator, whatever their kind.

use glam::Vec3;

/// A light of one kind, in render space. All functions are free of branches, for use on whole
/// columns of hits.
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

    /// Returns the radiance that reaches a hit from a point of the light if nothing blocks it;
    /// `way` is the vector from the hit to the point.
    fn radiance(&self, way: Vec3) -> Vec3;

    /// Samples a point of the light for a hit at `from`, by a point `u` of the unit square.
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3;

    /// Returns the vector from a hit at `from` to the point of the light that
    /// [`point`](Self::point) samples; for a distant light, the unit direction.
    #[inline(always)]
    fn way(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.point(from, u) - from
    }

    /// Returns the `pdf_solid_angle`, as seen from a hit, with which [`point`](Self::point) samples
    /// the point of the light at the end of the vector `way` from the hit; infinite for a light
    /// without an area.
    fn density(&self, way: Vec3) -> f32;

    /// Estimates how much light the hit receives: the luminance of the light times the cosine at
    /// its middle, plus a little, since a highlight or a lobe may receive more. Returns 0 if the
    /// whole light lies behind the surface, unless light from behind counts (`through`). The
    /// normals are the shading normal and the geometric normal, in this order.
    fn expected(&self, hit: Vec3, normals: [Vec3; 2], through: bool) -> f32;

    /// Returns the direction of a shadow ray from `from` to a `point` of the light, not normalized,
    /// and the t at which it ends: 1, minus a margin that keeps it from hitting the light's own
    /// surface.
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32);
}

/// Estimates the light at a hit from the light's colour and the cosine at its middle.
#[inline(always)]
pub(super) fn expected(color: Vec3, cos: f32, is_seen: bool) -> f32 {
    const LEAST: f32 = 0.1;
    let luminance = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    if is_seen { luminance * (LEAST + cos.max(0.0)) } else { 0.0 }
}
