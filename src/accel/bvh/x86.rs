//! The steps of a ray on AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::layout::{Child, Node};
use super::ray::Ray;
use super::steps::{BlockHits, Steps};
use crate::accel::triangle::MIN_DETERMINANT;

/// AVX2 with fused multiply-add.
pub(super) struct Avx2;

/// AVX-512 on 8 lanes.
pub(super) struct Avx512;

/// Distances where a ray enters and leaves the eight boxes.
///
/// # Safety
/// The CPU has AVX2 and FMA.
#[inline(always)]
unsafe fn slabs(node: &Node, ray: &Ray) -> (__m256, __m256) {
    let planes = node.planes.as_ptr().cast::<u8>();
    // SAFETY: the offsets lie within the planes, which are aligned to 32 bytes.
    unsafe {
        let (x, y, z) = (ray.entries[0] as usize, ray.entries[1] as usize, ray.entries[2] as usize);
        let near = _mm256_max_ps(
            _mm256_max_ps(
                slab(planes.add(x), &ray.inverse[0], &ray.near[0]),
                slab(planes.add(y), &ray.inverse[1], &ray.near[1]),
            ),
            _mm256_max_ps(slab(planes.add(z), &ray.inverse[2], &ray.near[2]), _mm256_setzero_ps()),
        );
        let far = _mm256_min_ps(
            _mm256_min_ps(
                slab(planes.add(x ^ 32), &ray.inverse[0], &ray.far[0]),
                slab(planes.add(y ^ 32), &ray.inverse[1], &ray.far[1]),
            ),
            _mm256_min_ps(
                slab(planes.add(z ^ 32), &ray.inverse[2], &ray.far[2]),
                _mm256_broadcast_ss(&ray.t),
            ),
        );
        (near, far)
    }
}

/// Distances to eight planes.
///
/// # Safety
/// The CPU has AVX2 and FMA; there are eight planes, aligned to 32 bytes.
#[inline(always)]
unsafe fn slab(planes: *const u8, inverse: &f32, offset: &f32) -> __m256 {
    // SAFETY: the caller's.
    unsafe {
        _mm256_fmsub_ps(
            _mm256_load_ps(planes.cast()),
            _mm256_broadcast_ss(inverse),
            _mm256_broadcast_ss(offset),
        )
    }
}

/// Which child is the n-th from the far end, in the low three bits of each lane.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
unsafe fn order(node: &Node, ray: &Ray) -> __m256i {
    // SAFETY: the words are aligned to 32 bytes.
    unsafe {
        let words = _mm256_load_si256(node.order.as_ptr().cast());
        _mm256_srlv_epi32(words, _mm256_set1_epi32(ray.order_shift as i32))
    }
}

impl Steps for Avx512 {
    #[inline(always)]
    unsafe fn children(node: &Node, ray: &Ray, ts: *mut f32, children: *mut Child) -> usize {
        // SAFETY: the caller's.
        unsafe {
            let (near, far) = slabs(node, ray);
            let order = order(node, ray);
            let near = _mm256_permutevar8x32_ps(near, order);
            let far = _mm256_permutevar8x32_ps(far, order);
            let names = _mm256_load_si256(node.children.as_ptr().cast());
            let names = _mm256_permutevar8x32_epi32(names, order);
            let entered = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(near, far);
            _mm256_storeu_ps(ts, _mm256_maskz_compress_ps(entered, near));
            _mm256_storeu_si256(children.cast(), _mm256_maskz_compress_epi32(entered, names));
            entered.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn triangles(block: *const f32, count: usize, ray: &Ray, hits: &mut BlockHits) -> u32 {
        // SAFETY: the caller's.
        unsafe { Block::test(block, count, ray).report(hits) }
    }

    #[inline(always)]
    unsafe fn any_triangle(block: *const f32, count: usize, ray: &Ray) -> bool {
        // SAFETY: the caller's.
        unsafe { Block::test(block, count, ray).any_before(ray) }
    }
}

/// For each set of lanes: their numbers, in order, then zeros.
static LANES_OF: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                table[set][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
};

impl Steps for Avx2 {
    #[inline(always)]
    unsafe fn children(node: &Node, ray: &Ray, ts: *mut f32, children: *mut Child) -> usize {
        // SAFETY: the caller's.
        unsafe {
            let (near, far) = slabs(node, ray);
            let entered = _mm256_cmp_ps::<_CMP_LE_OQ>(near, far);
            let order = order(node, ray);
            let set = _mm256_movemask_ps(_mm256_permutevar8x32_ps(entered, order)) as usize;
            let lanes = _mm_loadl_epi64(LANES_OF[set & 255].as_ptr().cast());
            let order = _mm256_permutevar8x32_epi32(order, _mm256_cvtepu8_epi32(lanes));
            let names = _mm256_load_si256(node.children.as_ptr().cast());
            _mm256_storeu_ps(ts, _mm256_permutevar8x32_ps(near, order));
            _mm256_storeu_si256(children.cast(), _mm256_permutevar8x32_epi32(names, order));
            set.count_ones() as usize
        }
    }

    #[inline(always)]
    unsafe fn triangles(block: *const f32, count: usize, ray: &Ray, hits: &mut BlockHits) -> u32 {
        // SAFETY: the caller's.
        unsafe { Block::test(block, count, ray).report(hits) }
    }

    #[inline(always)]
    unsafe fn any_triangle(block: *const f32, count: usize, ray: &Ray) -> bool {
        // SAFETY: the caller's.
        unsafe { Block::test(block, count, ray).any_before(ray) }
    }
}

/// The test of [`triangle`](crate::accel::triangle) for four triangles: the same operations in the
/// same order.
struct Block {
    area_b: __m128,
    area_c: __m128,
    determinant: __m128,
    t: __m128,
    /// Triangles that are hit no farther than the best.
    hits: u32,
}

impl Block {
    /// # Safety
    /// The CPU has AVX2 and FMA; otherwise as [`Steps::triangles`].
    #[inline(always)]
    unsafe fn test(block: *const f32, count: usize, ray: &Ray) -> Self {
        // SAFETY: rows and what is read beyond the last are readable, as the caller promises.
        unsafe {
            let origin = load3(&ray.origin);
            let shear = load3(&ray.shear);
            let x = block.add(ray.axes[0] as usize * count);
            let y = block.add(ray.axes[1] as usize * count);
            let z = block.add(ray.axes[2] as usize * count);
            let (second, third) = (3 * count, 6 * count);
            let a = corner(x, y, z, &origin, &shear);
            let b = corner(x.add(second), y.add(second), z.add(second), &origin, &shear);
            let c = corner(x.add(third), y.add(third), z.add(third), &origin, &shear);
            let area_a = difference_of_products(c[0], b[1], c[1], b[0]);
            let area_b = difference_of_products(a[0], c[1], a[1], c[0]);
            let area_c = difference_of_products(b[0], a[1], b[1], a[0]);
            let determinant = _mm_add_ps(_mm_add_ps(area_a, area_b), area_c);
            let z =
                _mm_fmadd_ps(area_c, c[2], _mm_fmadd_ps(area_b, b[2], _mm_mul_ps(area_a, a[2])));
            let t = _mm_mul_ps(_mm_div_ps(z, determinant), shear[2]);
            let zero = _mm_setzero_ps();
            let least = _mm_min_ps(_mm_min_ps(area_a, area_b), area_c);
            let most = _mm_max_ps(_mm_max_ps(area_a, area_b), area_c);
            let inside = _mm_or_ps(_mm_cmpge_ps(least, zero), _mm_cmple_ps(most, zero));
            let size = _mm_andnot_ps(_mm_set1_ps(-0.0), determinant);
            let solid = _mm_cmpge_ps(size, _mm_set1_ps(MIN_DETERMINANT));
            let ahead =
                _mm_and_ps(_mm_cmpgt_ps(t, zero), _mm_cmple_ps(t, _mm_broadcast_ss(&ray.t)));
            let hits = _mm_movemask_ps(_mm_and_ps(_mm_and_ps(inside, solid), ahead)) as u32;
            let mut hits = hits & ((1 << count) - 1);
            if hits != 0 {
                hits &= lie_ahead(block, count, ray, determinant);
            }
            Self { area_b, area_c, determinant, t, hits }
        }
    }

    /// # Safety
    /// The CPU has AVX2.
    #[inline(always)]
    unsafe fn report(&self, hits: &mut BlockHits) -> u32 {
        if self.hits != 0 {
            // SAFETY: the arrays have four elements.
            unsafe {
                _mm_storeu_ps(hits.t.as_mut_ptr(), self.t);
                _mm_storeu_ps(hits.u.as_mut_ptr(), _mm_div_ps(self.area_b, self.determinant));
                _mm_storeu_ps(hits.v.as_mut_ptr(), _mm_div_ps(self.area_c, self.determinant));
            }
        }
        self.hits
    }

    /// # Safety
    /// The CPU has AVX2.
    #[inline(always)]
    unsafe fn any_before(&self, ray: &Ray) -> bool {
        // SAFETY: no memory beyond the ray is read.
        let before = unsafe { _mm_movemask_ps(_mm_cmplt_ps(self.t, _mm_broadcast_ss(&ray.t))) };
        self.hits & before as u32 != 0
    }
}

/// Which of four triangles the ray starts before: the sign of the origin's distance from their
/// planes, in f64, as in [`triangle`](crate::accel::triangle).
///
/// # Safety
/// As [`Block::test`].
#[inline(always)]
unsafe fn lie_ahead(block: *const f32, count: usize, ray: &Ray, determinant: __m128) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let row = |corner: usize, axis: usize| {
            let row = block.add((3 * corner + ray.axes[axis] as usize) * count);
            _mm256_cvtps_pd(_mm_loadu_ps(row))
        };
        let edge = |corner: usize, axis: usize| _mm256_sub_pd(row(corner, axis), row(0, axis));
        let [e, f] = [1, 2].map(|corner| [0, 1, 2].map(|axis| edge(corner, axis)));
        let term = |axis: usize| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let minor =
                _mm256_sub_pd(_mm256_mul_pd(e[next], f[last]), _mm256_mul_pd(e[last], f[next]));
            let origin = _mm256_set1_pd(f64::from(ray.origin[axis]));
            _mm256_mul_pd(minor, _mm256_sub_pd(row(0, axis), origin))
        };
        let volume = _mm256_add_pd(_mm256_add_pd(term(0), term(1)), term(2));
        let nonzero = _mm256_cmp_pd::<_CMP_NEQ_UQ>(volume, _mm256_setzero_pd());
        let flipped = if ray.shear[2] < 0.0 { 15 } else { 0 };
        let ahead = _mm256_movemask_pd(volume) ^ _mm_movemask_ps(determinant) ^ flipped;
        (ahead & _mm256_movemask_pd(nonzero)) as u32
    }
}

/// # Safety
/// The CPU has AVX.
#[inline(always)]
unsafe fn load3(values: &[f32; 3]) -> [__m128; 3] {
    // SAFETY: the caller's.
    unsafe {
        [_mm_broadcast_ss(&values[0]), _mm_broadcast_ss(&values[1]), _mm_broadcast_ss(&values[2])]
    }
}

/// Four corners in sheared coordinates.
///
/// # Safety
/// The CPU has FMA; four elements of each row are readable.
#[inline(always)]
unsafe fn corner(
    x: *const f32,
    y: *const f32,
    z: *const f32,
    origin: &[__m128; 3],
    shear: &[__m128; 3],
) -> [__m128; 3] {
    // SAFETY: the caller's.
    unsafe {
        let x = _mm_sub_ps(_mm_loadu_ps(x), origin[0]);
        let y = _mm_sub_ps(_mm_loadu_ps(y), origin[1]);
        let z = _mm_sub_ps(_mm_loadu_ps(z), origin[2]);
        [_mm_fnmadd_ps(shear[0], z, x), _mm_fnmadd_ps(shear[1], z, y), z]
    }
}

/// # Safety
/// The CPU has FMA.
#[inline(always)]
unsafe fn difference_of_products(a: __m128, b: __m128, c: __m128, d: __m128) -> __m128 {
    // SAFETY: the caller's.
    unsafe {
        let cd = _mm_mul_ps(c, d);
        let error = _mm_fnmadd_ps(c, d, cd);
        _mm_add_ps(_mm_fmsub_ps(a, b, cd), error)
    }
}
