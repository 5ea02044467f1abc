//! Vectors of AVX2 and AVX-512.

#![allow(clippy::undocumented_unsafe_blocks)] // the caller's promise, in each of them

use std::arch::x86_64::*;

use super::{Lanes, Quads, SetLanes, lanes_of};

/// A function for each of a type's instructions.
macro_rules! lanes {
    ($type:ty, $count:literal, $splat:ident, $load:ident, $store:ident, $add:ident, $sub:ident,
     $mul:ident, $div:ident, $fmadd:ident, $fmsub:ident, $fnmadd:ident, $min:ident, $max:ident,
     $and:ident, $compare:ident, $replace:ident, $halves:ident, $leasts:ident) => {
        impl Lanes for $type {
            const COUNT: usize = $count;

            #[inline(always)]
            unsafe fn splat(x: f32) -> Self {
                unsafe { $splat(x) }
            }
            #[inline(always)]
            unsafe fn load(from: *const f32) -> Self {
                unsafe { $load(from) }
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut f32) {
                unsafe { $store(to, self) }
            }
            #[inline(always)]
            unsafe fn add(self, other: Self) -> Self {
                unsafe { $add(self, other) }
            }
            #[inline(always)]
            unsafe fn sub(self, other: Self) -> Self {
                unsafe { $sub(self, other) }
            }
            #[inline(always)]
            unsafe fn mul(self, other: Self) -> Self {
                unsafe { $mul(self, other) }
            }
            #[inline(always)]
            unsafe fn div(self, other: Self) -> Self {
                unsafe { $div(self, other) }
            }
            #[inline(always)]
            unsafe fn mul_add(self, b: Self, c: Self) -> Self {
                unsafe { $fmadd(self, b, c) }
            }
            #[inline(always)]
            unsafe fn mul_sub(self, b: Self, c: Self) -> Self {
                unsafe { $fmsub(self, b, c) }
            }
            #[inline(always)]
            unsafe fn neg_mul_add(self, b: Self, c: Self) -> Self {
                unsafe { $fnmadd(self, b, c) }
            }
            #[inline(always)]
            unsafe fn min(self, other: Self) -> Self {
                unsafe { $min(self, other) }
            }
            #[inline(always)]
            unsafe fn max(self, other: Self) -> Self {
                unsafe { $max(self, other) }
            }
            #[inline(always)]
            unsafe fn abs(self) -> Self {
                unsafe { $and(self, $splat(f32::from_bits(0x7fff_ffff))) }
            }
            #[inline(always)]
            unsafe fn le(self, other: Self) -> u32 {
                unsafe { $compare::<_CMP_LE_OQ>(self, other) }
            }
            #[inline(always)]
            unsafe fn lt(self, other: Self) -> u32 {
                unsafe { $compare::<_CMP_LT_OQ>(self, other) }
            }
            #[inline(always)]
            unsafe fn replace(self, set: u32, other: Self) -> Self {
                unsafe { $replace(self, set, other) }
            }
            #[inline(always)]
            unsafe fn leasts(four: [Self; 4]) -> [f32; 4] {
                unsafe { $leasts(four) }
            }
            #[inline(always)]
            unsafe fn largest(self) -> f32 {
                unsafe {
                    let [a, b] = $halves(self);
                    largest4(_mm_max_ps(a[0], b[0]), _mm_max_ps(a[1], b[1]))
                }
            }
        }
    };
}

lanes!(
    __m256,
    8,
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_fmadd_ps,
    _mm256_fmsub_ps,
    _mm256_fnmadd_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_and_ps,
    compare8,
    replace8,
    quarters8,
    leasts8
);
lanes!(
    __m512,
    16,
    _mm512_set1_ps,
    _mm512_loadu_ps,
    _mm512_storeu_ps,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_div_ps,
    _mm512_fmadd_ps,
    _mm512_fmsub_ps,
    _mm512_fnmadd_ps,
    _mm512_min_ps,
    _mm512_max_ps,
    _mm512_and_ps,
    compare16,
    replace16,
    quarters16,
    leasts16
);

impl Quads for __m256 {
    #[inline(always)]
    unsafe fn quads(from: &[*const f32; 4]) -> Self {
        unsafe { _mm256_set_m128(_mm_loadu_ps(from[1]), _mm_loadu_ps(from[0])) }
    }

    #[inline(always)]
    unsafe fn splat_quads(from: &[*const f32; 4]) -> Self {
        unsafe { _mm256_set_m128(_mm_broadcast_ss(&*from[1]), _mm_broadcast_ss(&*from[0])) }
    }

    #[inline(always)]
    unsafe fn splat_in_quads<const LANE: i32>(self) -> Self {
        unsafe { _mm256_permute_ps::<LANE>(self) }
    }

    #[inline(always)]
    unsafe fn store_columns([a, b, c, d]: [Self; 4], to: *mut f32, stride: usize) {
        unsafe {
            use _mm256_castps_pd as pd;
            let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            let columns = [
                _mm256_unpacklo_pd(pd(ab), pd(cd)),
                _mm256_unpackhi_pd(pd(ab), pd(cd)),
                _mm256_unpacklo_pd(pd(ab_high), pd(cd_high)),
                _mm256_unpackhi_pd(pd(ab_high), pd(cd_high)),
            ];
            for (i, column) in columns.into_iter().enumerate() {
                let column = _mm256_castpd_ps(column);
                let to = to.add(i * stride);
                _mm_storeu_ps(to, _mm256_castps256_ps128(column));
                _mm_storeu_ps(to.add(4 * stride), _mm256_extractf128_ps::<1>(column));
            }
        }
    }
}

impl Quads for __m512 {
    #[inline(always)]
    unsafe fn quads(from: &[*const f32; 4]) -> Self {
        unsafe {
            let lanes = _mm512_castps128_ps512(_mm_loadu_ps(from[0]));
            let lanes = _mm512_mask_broadcast_f32x4(lanes, 0xf0, _mm_loadu_ps(from[1]));
            let lanes = _mm512_mask_broadcast_f32x4(lanes, 0xf00, _mm_loadu_ps(from[2]));
            _mm512_mask_broadcast_f32x4(lanes, 0xf000, _mm_loadu_ps(from[3]))
        }
    }

    #[inline(always)]
    unsafe fn splat_quads(from: &[*const f32; 4]) -> Self {
        unsafe {
            let lanes = _mm512_set1_ps(*from[0]);
            let lanes = _mm512_mask_broadcastss_ps(lanes, 0xf0, _mm_load_ss(from[1]));
            let lanes = _mm512_mask_broadcastss_ps(lanes, 0xf00, _mm_load_ss(from[2]));
            _mm512_mask_broadcastss_ps(lanes, 0xf000, _mm_load_ss(from[3]))
        }
    }

    #[inline(always)]
    unsafe fn splat_in_quads<const LANE: i32>(self) -> Self {
        unsafe { _mm512_permute_ps::<LANE>(self) }
    }

    #[inline(always)]
    unsafe fn store_columns([a, b, c, d]: [Self; 4], to: *mut f32, stride: usize) {
        unsafe {
            use _mm512_castps_pd as pd;
            let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
            let columns = [
                _mm512_unpacklo_pd(pd(ab), pd(cd)),
                _mm512_unpackhi_pd(pd(ab), pd(cd)),
                _mm512_unpacklo_pd(pd(ab_high), pd(cd_high)),
                _mm512_unpackhi_pd(pd(ab_high), pd(cd_high)),
            ];
            for (i, column) in columns.into_iter().enumerate() {
                let column = _mm512_castpd_ps(column);
                let to = to.add(i * stride);
                _mm_storeu_ps(to, _mm512_castps512_ps128(column));
                _mm_storeu_ps(to.add(4 * stride), _mm512_extractf32x4_ps::<1>(column));
                _mm_storeu_ps(to.add(8 * stride), _mm512_extractf32x4_ps::<2>(column));
                _mm_storeu_ps(to.add(12 * stride), _mm512_extractf32x4_ps::<3>(column));
            }
        }
    }
}

impl SetLanes for __m256 {
    #[inline(always)]
    unsafe fn store_set(self, to: *mut f32, set: u32) {
        unsafe { _mm256_maskstore_ps(to, mask8(set), self) }
    }

    #[inline(always)]
    unsafe fn scatter_set(self, to: *mut f32, indices: *const u32, set: u32) {
        let mut values = [0.0; 8];
        unsafe {
            self.store(values.as_mut_ptr());
            for lane in lanes_of(set) {
                *to.add(*indices.add(lane) as usize) = values[lane % 8];
            }
        }
    }
}

impl SetLanes for __m512 {
    #[inline(always)]
    unsafe fn store_set(self, to: *mut f32, set: u32) {
        unsafe { _mm512_mask_storeu_ps(to, set as u16, self) }
    }

    #[inline(always)]
    unsafe fn scatter_set(self, to: *mut f32, indices: *const u32, set: u32) {
        unsafe {
            let indices = _mm512_loadu_si512(indices.cast());
            _mm512_mask_i32scatter_ps::<4>(to, set as u16, indices, self);
        }
    }
}

#[inline(always)]
unsafe fn compare8<const HOW: i32>(a: __m256, b: __m256) -> u32 {
    unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<HOW>(a, b)) as u32 }
}

#[inline(always)]
unsafe fn compare16<const HOW: i32>(a: __m512, b: __m512) -> u32 {
    unsafe { u32::from(_mm512_cmp_ps_mask::<HOW>(a, b)) }
}

#[inline(always)]
unsafe fn replace8(a: __m256, set: u32, b: __m256) -> __m256 {
    unsafe { _mm256_blendv_ps(a, b, _mm256_castsi256_ps(mask8(set))) }
}

/// All bits in the lanes of a set.
#[inline(always)]
unsafe fn mask8(set: u32) -> __m256i {
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(set as i32), bits), bits)
    }
}

#[inline(always)]
unsafe fn replace16(a: __m512, set: u32, b: __m512) -> __m512 {
    unsafe { _mm512_mask_mov_ps(a, set as u16, b) }
}

/// Four vectors of four lanes that hold all lanes, some more than once.
#[inline(always)]
unsafe fn quarters8(a: __m256) -> [[__m128; 2]; 2] {
    unsafe { [[_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a)]; 2] }
}

#[inline(always)]
unsafe fn quarters16(a: __m512) -> [[__m128; 2]; 2] {
    unsafe {
        let (low, high) = (_mm512_castps512_ps256(a), _mm512_extractf32x8_ps::<1>(a));
        [
            [_mm256_castps256_ps128(low), _mm256_extractf128_ps::<1>(low)],
            [_mm256_castps256_ps128(high), _mm256_extractf128_ps::<1>(high)],
        ]
    }
}

#[inline(always)]
unsafe fn leasts4([a, b, c, d]: [__m128; 4]) -> [f32; 4] {
    let mut least = [0.0; 4];
    unsafe {
        let ab = _mm_min_ps(_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
        let cd = _mm_min_ps(_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
        _mm_storeu_ps(least.as_mut_ptr(), _mm_min_ps(_mm_movelh_ps(ab, cd), _mm_movehl_ps(cd, ab)));
    }
    least
}

#[inline(always)]
unsafe fn leasts8([a, b, c, d]: [__m256; 4]) -> [f32; 4] {
    unsafe { leasts4([halved8(a), halved8(b), halved8(c), halved8(d)]) }
}

#[inline(always)]
unsafe fn leasts16([a, b, c, d]: [__m512; 4]) -> [f32; 4] {
    unsafe { leasts8([halved16(a), halved16(b), halved16(c), halved16(d)]) }
}

/// The smaller lanes of both halves.
#[inline(always)]
unsafe fn halved8(a: __m256) -> __m128 {
    unsafe { _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a)) }
}

/// The smaller lanes of both halves.
#[inline(always)]
unsafe fn halved16(a: __m512) -> __m256 {
    unsafe { _mm256_min_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps::<1>(a)) }
}

/// The largest of eight lanes.
#[inline(always)]
unsafe fn largest4(a: __m128, b: __m128) -> f32 {
    unsafe {
        let four = _mm_max_ps(a, b);
        let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_max_ps(two, _mm_shuffle_ps::<1>(two, two)))
    }
}
