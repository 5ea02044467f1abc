//! Surfaces at the hits of a batch.

use glam::{Vec2, Vec3};

use slo_accel::math::columns::{BATCH, Column, Vec3s};

/// Index of the material of hits that need no colour.
pub(crate) const NO_MATERIAL: u32 = u32::MAX;

/// Surfaces at the hits of a batch. Points and normals are in render space.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// Number of hits.
    pub(crate) len: usize,
    /// Index of the ray in its batch.
    pub(crate) ray: Column<u32>,
    /// Index of the material.
    pub(crate) material: Column<u32>,
    /// Positions of the hits.
    pub(crate) point: Vec3s,
    /// Bound, along the normal, of the rounding errors of `point` and of the intersection test of a
    /// ray that starts there.
    pub(super) offset: Column<f32>,
    /// Unit geometric normals, on the side that the ray came from.
    pub(crate) n_geo: Vec3s,
    /// Unit shading normals, within 90 degrees of `n_geo`.
    pub(crate) n_shade: Vec3s,
    /// 1 if the ray came from outside, 0 otherwise.
    pub(crate) from_outside: Column<u32>,
    /// Colours of the materials' images; white if a material has none.
    pub(crate) tint: Vec3s,
    /// The direction in which u grows; 0 on materials that do not depend on it. On smooth meshes its
    /// length is in proportion to that of the interpolated normal, as if that had length 1.
    pub(crate) tangent: Vec3s,
    /// v grows along so many times the cross product of outward normal and tangent; of hits that have
    /// a tangent. It is negative where the texture is mirrored.
    pub(crate) bitangent: Column<f32>,
    /// Texture coordinates, of hits on materials that depend on them.
    pub(crate) uv: [Column<f32>; 2],
    /// Bounds of the absolute coordinates from which points were computed.
    pub(super) magnitude: Vec3s,
    /// The way from each point to the surface that the vertices' tangent planes span, if it lies on
    /// the ray's side of the triangle; otherwise 0. Of scenes with [`FrameScene::softens`].
    ///
    /// [`FrameScene::softens`]: crate::frame::FrameScene::softens
    pub(super) lift: Vec3s,
    /// Where light arrives, as far as lamps and rays that leave are concerned: the points, or points
    /// above them on coarse smooth meshes. See `soften`. Of physical scenes.
    pub(crate) start: Vec3s,
    /// Unit normals of the planes above which light arrives that surfaces scatter: the geometric
    /// normals, or others on the ray's side on coarse smooth meshes. See `soften`. Of physical
    /// scenes.
    pub(crate) floor: Vec3s,
    /// 1 if an image bends `n_shade`, otherwise 0; if `any_is_bent`.
    pub(crate) is_bent: Column<u32>,
    /// Whether images bend normals at all.
    pub(crate) any_is_bent: bool,
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
            tangent: Vec3s::default(),
            bitangent: [1.0; BATCH],
            uv: [[0.0; BATCH]; 2],
            magnitude: Vec3s::default(),
            lift: Vec3s::default(),
            start: Vec3s::default(),
            floor: Vec3s::default(),
            is_bent: [0; BATCH],
            any_is_bent: false,
        }
    }
}

impl Surfaces {
    /// Adds a hit with the index of its ray and its material, or [`NO_MATERIAL`].
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: usize, material: u32) {
        self.ray[self.len] = ray as u32;
        self.material[self.len] = material;
        self.len += 1;
    }

    /// Returns the texture coordinates of hit `i`.
    #[inline(always)]
    pub(crate) fn uv(&self, i: usize) -> Vec2 {
        Vec2::new(self.uv[0][i], self.uv[1][i])
    }

    /// Returns the origin of a ray from hit `i` toward `direction`, such that the ray cannot hit
    /// the surface that it leaves.
    ///
    /// Source: Wächter and Binder (Ray Tracing Gems 6) describe the problem. As in pbrt 3.9.5, the
    /// offset is the error bound of this hit, not a constant.
    #[inline(always)]
    pub(crate) fn leave(&self, i: usize, direction: Vec3) -> Vec3 {
        self.moved(i, self.point.get(i), direction.dot(self.n_geo.get(i)) < 0.0)
    }

    /// Like [`leave`](Self::leave), for rays from [`start`](Self::start): a ray above the floor
    /// leaves on the side of `n_geo`.
    #[inline(always)]
    pub(crate) fn depart(&self, i: usize, direction: Vec3) -> Vec3 {
        self.moved(i, self.start.get(i), direction.dot(self.floor.get(i)) < 0.0)
    }

    /// Moves a point by the error bound of hit `i` to one side of the surface.
    #[inline(always)]
    fn moved(&self, i: usize, point: Vec3, below: bool) -> Vec3 {
        let n_geo = self.n_geo.get(i);
        let side = if below { -n_geo } else { n_geo };
        let moved = point + side * self.offset[i];
        // The sum is rounded too, so it is rounded away from the surface.
        Vec3::new(away(moved.x, side.x), away(moved.y, side.y), away(moved.z, side.z))
    }
}

#[cfg(test)]
impl Surfaces {
    /// Sets all normals of hit `i`, as on a flat surface.
    pub(crate) fn set_normals(&mut self, i: usize, n: Vec3) {
        self.n_geo.set(i, n);
        self.n_shade.set(i, n);
        self.floor.set(i, n);
    }
}

/// Returns the next number after `p` in the direction of the sign of `n`; `p` itself if `n` is 0 or
/// `p` is not finite. Free of branches.
///
/// Rustc 1.95 compiles a form that counts through both zeros as `i32` wrongly for AVX-512; the tests
/// compare pictures of physical scenes between instruction sets, which finds such mistakes.
#[inline(always)]
fn away(p: f32, n: f32) -> f32 {
    const SIGN: u32 = 1 << 31;
    let bits = p.to_bits();
    let (size, sign) = (bits & !SIGN, bits & SIGN);
    let (up, down) = (n > 0.0, n < 0.0);
    // Away from 0 if both signs agree, otherwise toward it.
    let grows = if sign == 0 { up } else { down };
    let beside = if grows { bits.wrapping_add(1) } else { bits.wrapping_sub(1) };
    // On either side of 0 lies the smallest number.
    let smallest = if up { 1 } else { SIGN | 1 };
    let result = if size == 0 { smallest } else { beside };
    let stays = !(up | down) | (size >= 0x7f80_0000);
    f32::from_bits(if stays { bits } else { result })
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
