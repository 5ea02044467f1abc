//! Where light arrives at coarse smooth meshes.
//!
//! The interpolated normals of a mesh belong to a surface that bulges over its triangles. Light that
//! grazes this surface is blocked by the triangles, which shows as a border of shadow with corners.
//! So rays leave from above the triangles, where the vertices' tangent planes meet on average, and
//! light counts from above the interpolated normal instead of the geometric one.
//!
//! Source: J. Hanika, "Hacking the Shadow Terminator" (Ray Tracing Gems II, 2021).

use glam::Vec3;

use super::columns::Surfaces;
use super::gather::Gathered;
use crate::frame::scene::FrameScene;
use crate::frame::world::WorldHits;
use slo_accel::Lanewise;
use slo_accel::math::columns::{Column, Vec3s, lanes};

impl FrameScene {
    /// Finds how far smooth meshes bulge over the triangles of hits.
    pub(super) fn lift(
        &self,
        time: &Column<f32>,
        found: &WorldHits,
        gathered: &Gathered,
        to: &mut Surfaces,
    ) {
        if self.stretches {
            self.isa.run(Lift::<false> { gathered, to });
        } else {
            self.isa.run(Lift::<true> { gathered, to });
        }
        for &i in &gathered.moving {
            let i = usize::from(i);
            let ray = to.ray[i] as usize;
            let pose = self.world.pose(found.instance[ray], time[ray]);
            to.lift.set(i, pose.vector(to.lift.get(i)));
        }
        for &i in &gathered.curved {
            to.lift.set(usize::from(i), Vec3::ZERO);
        }
    }

    /// Lets light arrive above the triangles of coarse smooth meshes at hits for which `is_soft`,
    /// where the mesh bulges toward the ray. Nothing may have bent the interpolated normals before.
    /// `direction` are the directions of the rays.
    pub(crate) fn soften(
        &self,
        direction: &Vec3s,
        is_soft: impl Fn(usize) -> bool,
        to: &mut Surfaces,
    ) {
        if self.softens {
            self.isa.run(Soften { direction, is_soft, to });
        }
    }
}

/// Computes lifts, in the spaces of the structures. `UNIT` tells that all normals are unit.
struct Lift<'a, const UNIT: bool> {
    gathered: &'a Gathered,
    to: &'a mut Surfaces,
}

impl<const UNIT: bool> Lanewise for Lift<'_, UNIT> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { gathered, to } = self;
        for i in lanes(to.len) {
            let (u, v) = (gathered.u[i], gathered.v[i]);
            let corners = gathered.corners.each_ref().map(|corner| corner.get(i));
            let normals = gathered.normals.each_ref().map(|normal| normal.get(i));
            let from_outside = to.from_outside[i] == 1;
            to.lift.set(i, lift::<UNIT>(corners, normals, [1.0 - u - v, u, v], from_outside));
        }
    }
}

/// Returns the way from a point of a triangle, the mean of its corners with these weights, to the
/// mean of its projections to the tangent planes of those corners whose planes lie above it.
/// `from_outside` tells which side is above.
#[inline(always)]
fn lift<const UNIT: bool>(
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    weights: [f32; 3],
    from_outside: bool,
) -> Vec3 {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let mean = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
    // The normals of the vertices may be turned against those of the triangles.
    let is_outward = ab.cross(ac).dot(mean) > 0.0;
    let side = if is_outward == from_outside { 1.0 } else { -1.0 };
    let point = a + ab * weights[1] + ac * weights[2];
    let mut sum = Vec3::ZERO;
    for k in 0..3 {
        let height = ((corners[k] - point).dot(normals[k]) * side).max(0.0);
        // A normal of no length has no height.
        let square = || normals[k].length_squared().max(f32::MIN_POSITIVE);
        let share = if UNIT { weights[k] } else { weights[k] / square() };
        sum += normals[k] * (share * height);
    }
    sum * side
}

/// Turns lifts into starts and floors.
struct Soften<'a, S> {
    direction: &'a Vec3s,
    is_soft: S,
    to: &'a mut Surfaces,
}

impl<S: Fn(usize) -> bool> Lanewise for Soften<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { direction, is_soft, to } = self;
        for i in lanes(to.len) {
            let (point, lift) = (to.point.get(i), to.lift.get(i));
            let (n_shade, n_geo) = (to.n_shade.get(i), to.n_geo.get(i));
            let height = lift.dot(n_geo);
            let is_lifted = is_soft(i) & (height > 0.0) & (height < f32::INFINITY);
            let floor = facing(n_shade, n_geo, -direction.get(i));
            to.floor.set(i, if is_lifted { floor } else { n_geo });
            // The bound of the errors of the point, and of those of the lift.
            let offset = to.offset[i];
            to.start.set(i, if is_lifted { point + lift + n_geo * (0.25 * offset) } else { point });
        }
    }
}

/// The least cosine of the eye to the normal of a floor.
const LEAST: f32 = 0.01;

/// Turns unit normal `n` toward `n_geo`, if needed, until it faces the eye.
#[inline(always)]
fn facing(n: Vec3, n_geo: Vec3, eye: Vec3) -> Vec3 {
    let (along, most) = (n.dot(eye), n_geo.dot(eye));
    let least = LEAST.min(0.9 * most);
    // The sum is at most 1 + share long.
    let share = ((least - along) / (most - least).max(1e-6)).max(0.0);
    let turned = n + n_geo * share;
    let turned = turned * (1.0 / turned.length().max(1e-6));
    if along < least { turned } else { n }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners and normals of a small triangle inscribed in the unit sphere.
    fn inscribed() -> [Vec3; 3] {
        [Vec3::new(0.15, 0.0, 1.0), Vec3::new(-0.1, 0.15, 1.0), Vec3::new(-0.05, -0.2, 1.0)]
            .map(Vec3::normalize)
    }

    #[test]
    fn lifts_end_near_the_sphere() {
        let on = inscribed();
        for weights in [[0.2, 0.3, 0.5], [0.5, 0.5, 0.0], [0.05, 0.05, 0.9]] {
            let point: Vec3 = (0..3).map(|k| on[k] * weights[k]).sum();
            let end = point + lift::<true>(on, on, weights, true);
            let (below, above) = (1.0 - point.length(), end.length() - 1.0);
            // Tangent planes lie above a sphere by as much as chords lie below it.
            assert!((above - below).abs() < 0.1 * below, "{point}: {above} is not {below}");
            // Vertex normals that point inward are turned, and a hollow has no lift.
            let inward = on.map(|n| -n);
            assert!(
                (lift::<true>(on, inward, weights, true) - lift::<true>(on, on, weights, true))
                    .length()
                    < 1e-7
            );
            assert_eq!(lift::<true>(on, on, weights, false), Vec3::ZERO);
            // Normals may have any length.
            let long = lift::<false>(on, on.map(|n| n * 3.0), weights, true);
            let mixed = lift::<false>(on, on, weights, true);
            assert!((long - mixed).length() < 1e-7 && (point + mixed - end).length() < 1e-7);
            // So is a face whose corners go round the other way.
            let [a, b, c] = on;
            let ([u, v, w], turned) = (weights, [a, c, b]);
            assert!((point + lift::<true>(turned, turned, [u, w, v], false) - end).length() < 1e-6);
        }
        assert_eq!(lift::<true>(on, on, [1.0, 0.0, 0.0], true), Vec3::ZERO);
        assert_eq!(lift::<true>(on, [Vec3::ZERO; 3], [0.2, 0.3, 0.5], true), Vec3::ZERO);
    }

    #[test]
    fn floors_face_the_eye() {
        let n_geo = Vec3::Z;
        for (n, eye) in [
            (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.8, 0.0, 0.6)),
            (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.96, 0.0, 0.28)),
            (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-1.0, 0.0, 1e-5).normalize()),
            (Vec3::new(0.999, 0.0, 0.04).normalize(), Vec3::new(-0.96, 0.1, 0.28).normalize()),
        ] {
            let floor = facing(n, n_geo, eye);
            let least = LEAST.min(0.9 * eye.z);
            assert!(
                (floor.length() - 1.0).abs() < 1e-6 && floor.dot(eye) > least - 1e-6,
                "{floor}"
            );
            // Between both normals, and no farther than needed.
            assert!(floor.dot(n_geo) >= n.dot(n_geo) - 1e-6 && floor.y == 0.0);
            assert!(n.dot(eye) < least || floor == n);
        }
    }
}
