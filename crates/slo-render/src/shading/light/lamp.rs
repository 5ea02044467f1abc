//! What the integrator asks of a light, whatever its kind.

use glam::Vec3;

/// A light of one kind, in render space. Everything is computed without branches, for whole columns
/// of hits.
pub trait Lamp: Copy {
    /// Whether its points differ, so that several of them are worth a ray each.
    const IS_AREA: bool;

    /// Radiance that reaches a hit from a point of the light that lies `way` from it.
    fn radiance(&self, way: Vec3) -> Vec3;

    /// The point `u` of the light as it is sampled for a hit at `from`.
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3;

    /// `pdf_solid_angle`, as seen from a hit, of the point of the light that lies `way` from it, as
    /// [`point`](Self::point) samples it; infinite for a light without an area.
    fn density(&self, way: Vec3) -> f32;

    /// About how bright the light makes a hit: its luminance times the cosine of its middle, and a
    /// little more, since a highlight or a lobe may see it better. 0 where all of it lies behind the
    /// surface, unless light from there counts (`through`). The normals are those for shading and
    /// of the surface itself.
    fn expected(&self, hit: Vec3, normals: [Vec3; 2], through: bool) -> f32;

    /// Direction of a shadow ray from `from` to a `point` of the light, and the t at which it ends:
    /// 1, less what keeps the light's own surface from being hit.
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32);
}

/// What is expected of a light at a hit, by its luminance and the cosine of its middle.
#[inline(always)]
pub(super) fn expected(color: Vec3, cos: f32, is_seen: bool) -> f32 {
    const LEAST: f32 = 0.1;
    let luminance = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    if is_seen { luminance * (LEAST + cos.max(0.0)) } else { 0.0 }
}
