//! Computes surfaces from hits, whole columns at a time.

use glam::{DVec3, Vec3};

use super::columns::Surfaces;
use super::gather::Gathered;
use crate::frame::scene::FrameScene;
use crate::frame::world::WorldHits;
use slo_accel::math::columns::{BATCH, Column, lanes};
use slo_accel::math::rounding::gamma;
use slo_accel::{Lanewise, Rays};

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(crate) struct SurfaceScratch(Gathered);

impl FrameScene {
    /// Computes everything about the hits that were pushed to `surfaces`: hits of `rays` at `time`,
    /// which are `found` in the world.
    pub(crate) fn find_surfaces(
        &self,
        rays: &Rays,
        time: &Column<f32>,
        found: &WorldHits,
        surfaces: &mut Surfaces,
        scratch: &mut SurfaceScratch,
    ) {
        let gathered = &mut scratch.0;
        self.gather(found, time, (&surfaces.ray, surfaces.len), gathered);
        self.isa.run(OnTriangles { gathered, to: surfaces });
        self.place_curved(rays, time, found, gathered, surfaces);
        self.look_up_images(found, surfaces);
        self.place_moving(time, found, gathered, surfaces);
        if let [Some(x), Some(y), Some(z)] = rays.direction.each_ref().map(|d| d.first_chunk()) {
            self.isa.run(Facing { directions: [x, y, z], to: surfaces });
        }
        if self.is_physical {
            // Copies, since a choice between columns would keep loops from becoming vector code.
            surfaces.start.clone_from(&surfaces.point);
            surfaces.floor.clone_from(&surfaces.n_geo);
        }
        if self.softens {
            self.lift(time, found, gathered, surfaces);
        }
    }
}

/// Computes points and normals of triangles in the space of their structure. Interpolated vertex
/// normals are stored in `n_shade` without normalization.
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
        // In f64, since the squares of tiny edges would underflow.
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
    /// Directions of the batch's rays.
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
        // Opposite normals may cancel, and flat objects have no vertex normals.
        let n = to.n_shade.get(i);
        let scale = 1.0 / n.length();
        let n = if scale.is_finite() && scale > 0.0 { n * scale } else { n_geo };
        to.n_shade.set(i, if n.dot(n_geo) < 0.0 { -n } else { n });
        // Roundings: 3 in a weighted sum, 5 in a transform to the structure, 5 in one back, and
        // those of the next ray's own test of this surface.
        to.offset[i] = n_geo.abs().dot(to.magnitude.get(i)) * gamma(32);
    }
}
