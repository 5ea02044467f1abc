//! From hits to what shading needs: points, normals, colours of images, rounding bounds.
//!
//! Tables are looked up hit by hit ([`gather`]); all arithmetic is done for whole columns.

mod gather;

use glam::{DVec3, Vec3};

use self::gather::Gathered;
use super::FrameScene;
use super::world::WorldHits;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};
use slo_accel::math::rounding::gamma;
use slo_accel::{Lanewise, Rays};

/// Index of the material of hits whose colour nobody asks for.
pub(crate) const NO_MATERIAL: u32 = u32::MAX;

/// What is at the hits of a batch. Render space.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// How many hits there are.
    pub(crate) len: usize,
    /// Number of the ray in its batch.
    pub(crate) ray: Column<u32>,
    /// Index of the material.
    pub(crate) material: Column<u32>,
    /// The hits.
    pub(crate) point: Vec3s,
    /// Bound of the rounding errors of `point`, and of those that a test of a ray from there
    /// makes, along the normal.
    offset: Column<f32>,
    /// Unit normals of the surfaces themselves, on the sides that the rays came from.
    pub(crate) n_geo: Vec3s,
    /// Unit normals for shading, within 90 degrees of `n_geo`.
    pub(crate) n_shade: Vec3s,
    /// 1 where the ray came from outside, 0 elsewhere.
    pub(crate) from_outside: Column<u32>,
    /// Colours of the materials' images; white where there is none.
    pub(crate) tint: Vec3s,
    /// Largest coordinates that points were computed from.
    magnitude: Vec3s,
}

impl Default for Surfaces {
    fn default() -> Self {
        Self {
            len: 0,
            ray: [0; BATCH],
            material: [0; BATCH],
            point: Vec3s::default(),
            offset: [0.0; BATCH],
            n_geo: Vec3s::default(),
            n_shade: Vec3s::default(),
            from_outside: [0; BATCH],
            tint: Vec3s::default(),
            magnitude: Vec3s::default(),
        }
    }
}

impl Surfaces {
    /// Adds a hit: the number of its ray and its material, or [`NO_MATERIAL`].
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: usize, material: u32) {
        self.ray[self.len] = ray as u32;
        self.material[self.len] = material;
        self.len += 1;
    }

    /// Where a ray from hit `i` toward `direction` starts, so that it can't hit the surface that
    /// it leaves.
    ///
    /// Source: Wächter and Binder (Ray Tracing Gems 6) for the problem; as in pbrt 3.9.5 the
    /// offset is the error bound of this very hit, not a constant.
    #[inline(always)]
    pub(crate) fn leave(&self, i: usize, direction: Vec3) -> Vec3 {
        let n_geo = self.n_geo.get(i);
        let side = if direction.dot(n_geo) < 0.0 { -n_geo } else { n_geo };
        let moved = self.point.get(i) + side * self.offset[i];
        // The sum is rounded too: away from the surface.
        Vec3::new(away(moved.x, side.x), away(moved.y, side.y), away(moved.z, side.z))
    }
}

#[cfg(test)]
impl Surfaces {
    /// Gives hit `i` one normal, as if it were flat.
    pub(crate) fn set_normals(&mut self, i: usize, n: Vec3) {
        self.n_geo.set(i, n);
        self.n_shade.set(i, n);
    }
}

/// The next number after `p` on the side that `n` points to; `p` where `n` is 0 or `p` is not
/// finite. Without branches.
#[inline(always)]
fn away(p: f32, n: f32) -> f32 {
    const SIGN: u32 = 1 << 31;
    let bits = p.to_bits();
    let size = bits & !SIGN;
    // Counted so that the next number is one more, through both zeros.
    let count = if bits & SIGN == 0 { size as i32 } else { -(size as i32) };
    let step = i32::from(n > 0.0) - i32::from(n < 0.0);
    let moved = count + step;
    let result = if moved < 0 { moved.unsigned_abs() | SIGN } else { moved as u32 };
    let stays = step == 0 || size >= 0x7f80_0000;
    f32::from_bits(if stays { bits } else { result })
}

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(crate) struct SurfaceScratch(Gathered);

impl FrameScene {
    /// Fills in everything about the hits that were pushed: those of `rays` at `time`, `found` in
    /// the world.
    pub(crate) fn find_surfaces(
        &self,
        rays: &Rays,
        time: &Column<f32>,
        found: &WorldHits,
        surfaces: &mut Surfaces,
        scratch: &mut SurfaceScratch,
    ) {
        let gathered = &mut scratch.0;
        self.gather(found, surfaces.len, &surfaces.ray, gathered);
        self.isa.run(OnTriangles { gathered, to: surfaces });
        self.place_curved(rays, time, found, gathered, surfaces);
        self.look_up_images(found, surfaces);
        self.place_moving(time, found, gathered, surfaces);
        if let [Some(x), Some(y), Some(z)] = rays.direction.each_ref().map(|d| d.first_chunk()) {
            self.isa.run(Facing { directions: [x, y, z], to: surfaces });
        }
    }
}

/// Points and normals of triangles in the space of their structure; the normals of vertices are
/// left as they are interpolated, in `n_shade`.
struct OnTriangles<'a> {
    gathered: &'a Gathered,
    to: &'a mut Surfaces,
}

impl Lanewise for OnTriangles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        on_triangles(self.gathered, self.to);
    }
}

#[inline(always)]
fn on_triangles(gathered: &Gathered, to: &mut Surfaces) {
    for i in lanes(to.len) {
        let (u, v) = (gathered.u[i], gathered.v[i]);
        let [a, b, c] = &gathered.corners;
        let (a, b, c) = (a.get(i), b.get(i), c.get(i));
        // In f64: the squares of tiny edges would underflow.
        let (edge_b, edge_c) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        let normal = edge_b.cross(edge_c);
        let length = normal.dot(normal).sqrt();
        let unit = normal * (1.0 / length);
        let unit = if length > 0.0 { unit } else { DVec3::Z };
        to.point.set(i, a * (1.0 - u - v) + b * u + c * v);
        to.n_geo.set(i, unit.as_vec3());
        to.magnitude.set(i, a.abs().max(b.abs()).max(c.abs()));
        // N = (1 - u - v) N_a + u N_b + v N_c. Source: thesis 5.1.
        let [a, b, c] = &gathered.normals;
        let (a, b, c) = (a.get(i), b.get(i), c.get(i));
        to.n_shade.set(i, a * (1.0 - u - v) + b * u + c * v);
    }
}

/// Turns normals to the side of the ray, and bounds the errors of points.
struct Facing<'a> {
    /// Of the batch's rays.
    directions: [&'a Column<f32>; 3],
    to: &'a mut Surfaces,
}

impl Lanewise for Facing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        face(self.directions, self.to);
    }
}

#[inline(always)]
fn face(directions: [&Column<f32>; 3], to: &mut Surfaces) {
    for i in lanes(to.len) {
        let ray = (to.ray[i] as usize).min(BATCH - 1);
        let outward = to.n_geo.get(i);
        let direction = Vec3::new(directions[0][ray], directions[1][ray], directions[2][ray]);
        let from_outside = direction.dot(outward) < 0.0;
        let n_geo = if from_outside { outward } else { -outward };
        to.n_geo.set(i, n_geo);
        to.from_outside[i] = u32::from(from_outside);
        // Opposite normals may cancel, and what is flat has none.
        let n = to.n_shade.get(i);
        let scale = 1.0 / n.length();
        let n = if scale.is_finite() && scale > 0.0 { n * scale } else { n_geo };
        to.n_shade.set(i, if n.dot(n_geo) < 0.0 { -n } else { n });
        // Roundings: 3 of a weighted sum, 5 of a transform there, 5 of one back, and those of
        // the next ray's own test of this surface.
        to.offset[i] = n_geo.abs().dot(to.magnitude.get(i)) * gamma(32);
    }
}

#[cfg(test)]
mod tests {
    use super::away;

    #[test]
    fn away_is_the_next_number_on_that_side() {
        let numbers = [0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, f32::MAX, f32::MIN, f32::MIN_POSITIVE];
        for p in numbers.into_iter().chain((1..1000).map(|i| (i as f32 - 500.5) * 0.37)) {
            assert_eq!(away(p, 0.3), p.next_up(), "{p}");
            assert_eq!(away(p, -1e-9), p.next_down(), "{p}");
            assert_eq!(away(p, 0.0).to_bits(), p.to_bits(), "{p}");
        }
    }
}
