//! Vectors of NEON: eight lanes in two registers.
//!
//! All instructions here are part of every AArch64 CPU that has floating point.

#![allow(clippy::undocumented_unsafe_blocks)] // the CPU has NEON; pointers are the caller's

use std::arch::aarch64::*;
use std::mem::transmute;

use super::sets::LANES_OF;
use super::{Lanes, Quads, SetLanes, lanes_of};

/// Lanes 0 to 3, and lanes 4 to 7.
#[derive(Clone, Copy)]
pub(crate) struct Eight(pub(crate) float32x4_t, pub(crate) float32x4_t);

impl Eight {
    #[inline(always)]
    fn with(self, other: Self, what: impl Fn(float32x4_t, float32x4_t) -> float32x4_t) -> Self {
        Self(what(self.0, other.0), what(self.1, other.1))
    }

    /// The smaller; the other if one is NaN. Unlike [`Lanes::min`], it is one instruction.
    #[inline(always)]
    pub(crate) fn min_number(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vminnmq_f32(a, b)) }
    }

    /// The larger; the other if one is NaN. Unlike [`Lanes::max`], it is one instruction.
    #[inline(always)]
    pub(crate) fn max_number(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vmaxnmq_f32(a, b)) }
    }

    /// All bits in each lane with `self <= other`, as bytes.
    #[inline(always)]
    pub(crate) fn le_bytes(self, other: Self) -> uint8x8_t {
        unsafe { vmovn_u16(narrow(vcleq_f32(self.0, other.0), vcleq_f32(self.1, other.1))) }
    }

    /// The lanes of a set, in order, then lane 0 again and again.
    #[inline(always)]
    pub(crate) fn packed(self, set: u32) -> Self {
        Places::of(lanes_in(set)).take(self)
    }

    #[inline(always)]
    fn mask(set: u32) -> [uint32x4_t; 2] {
        unsafe {
            let set = vdupq_n_u32(set);
            [vtstq_u32(set, BITS_32[0]), vtstq_u32(set, BITS_32[1])]
        }
    }
}

/// Bit `i` in lane `i`.
// SAFETY: vectors are arrays of numbers.
const BITS_8: uint8x8_t = unsafe { transmute([1u8, 2, 4, 8, 16, 32, 64, 128]) };
// SAFETY: as above.
const BITS_16: uint16x8_t = unsafe { transmute([1u16, 2, 4, 8, 16, 32, 64, 128]) };
// SAFETY: as above.
const BITS_32: [uint32x4_t; 2] = unsafe { transmute([1u32, 2, 4, 8, 16, 32, 64, 128]) };

/// The low halves of eight lanes.
#[inline(always)]
pub(crate) fn narrow(low: uint32x4_t, high: uint32x4_t) -> uint16x8_t {
    unsafe { vuzp1q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high)) }
}

/// The set of the lanes that have all bits; the others have none.
#[inline(always)]
fn set_of(low: uint32x4_t, high: uint32x4_t) -> u32 {
    unsafe { u32::from(vaddvq_u16(vandq_u16(narrow(low, high), BITS_16))) }
}

/// As [`set_of`], of bytes.
#[inline(always)]
pub(crate) fn set_of_bytes(lanes: uint8x8_t) -> u32 {
    unsafe { u32::from(vaddv_u8(vand_u8(lanes, BITS_8))) }
}

/// The numbers of the lanes of a set, in order, then zeros.
#[inline(always)]
pub(crate) fn lanes_in(set: u32) -> uint8x8_t {
    unsafe { vld1_u8(LANES_OF[set as usize % 256].as_ptr()) }
}

/// Which lanes a vector is made of, by the places of their bytes.
#[derive(Clone, Copy)]
pub(crate) struct Places(uint8x16_t, uint8x16_t);

impl Places {
    /// For lane `i` the lane whose number is the i-th, below 8.
    #[inline(always)]
    pub(crate) fn of(lanes: uint8x8_t) -> Self {
        unsafe {
            let first = vshl_n_u8::<2>(lanes);
            let first = vcombine_u8(first, first);
            let twice = vreinterpretq_u16_u8(vzip1q_u8(first, first));
            let next = vreinterpretq_u8_u32(vdupq_n_u32(0x0302_0100));
            let low = vreinterpretq_u8_u16(vzip1q_u16(twice, twice));
            let high = vreinterpretq_u8_u16(vzip2q_u16(twice, twice));
            Self(vorrq_u8(low, next), vorrq_u8(high, next))
        }
    }

    #[inline(always)]
    pub(crate) fn take(self, from: Eight) -> Eight {
        unsafe {
            let table = uint8x16x2_t(vreinterpretq_u8_f32(from.0), vreinterpretq_u8_f32(from.1));
            Eight(
                vreinterpretq_f32_u8(vqtbl2q_u8(table, self.0)),
                vreinterpretq_f32_u8(vqtbl2q_u8(table, self.1)),
            )
        }
    }
}

impl Lanes for Eight {
    const COUNT: usize = 8;

    #[inline(always)]
    unsafe fn splat(x: f32) -> Self {
        unsafe { Self(vdupq_n_f32(x), vdupq_n_f32(x)) }
    }

    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        unsafe { Self(vld1q_f32(from), vld1q_f32(from.add(4))) }
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe {
            vst1q_f32(to, self.0);
            vst1q_f32(to.add(4), self.1);
        }
    }

    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vaddq_f32(a, b)) }
    }

    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vsubq_f32(a, b)) }
    }

    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vmulq_f32(a, b)) }
    }

    #[inline(always)]
    unsafe fn div(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vdivq_f32(a, b)) }
    }

    #[inline(always)]
    unsafe fn mul_add(self, b: Self, c: Self) -> Self {
        unsafe { Self(vfmaq_f32(c.0, self.0, b.0), vfmaq_f32(c.1, self.1, b.1)) }
    }

    #[inline(always)]
    unsafe fn mul_sub(self, b: Self, c: Self) -> Self {
        unsafe {
            Self(vfmaq_f32(vnegq_f32(c.0), self.0, b.0), vfmaq_f32(vnegq_f32(c.1), self.1, b.1))
        }
    }

    #[inline(always)]
    unsafe fn neg_mul_add(self, b: Self, c: Self) -> Self {
        unsafe { Self(vfmsq_f32(c.0, self.0, b.0), vfmsq_f32(c.1, self.1, b.1)) }
    }

    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vbslq_f32(vcltq_f32(a, b), a, b)) }
    }

    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        unsafe { self.with(other, |a, b| vbslq_f32(vcgtq_f32(a, b), a, b)) }
    }

    #[inline(always)]
    unsafe fn abs(self) -> Self {
        unsafe { Self(vabsq_f32(self.0), vabsq_f32(self.1)) }
    }

    #[inline(always)]
    unsafe fn le(self, other: Self) -> u32 {
        unsafe { set_of(vcleq_f32(self.0, other.0), vcleq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    unsafe fn lt(self, other: Self) -> u32 {
        unsafe { set_of(vcltq_f32(self.0, other.0), vcltq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    unsafe fn replace(self, set: u32, other: Self) -> Self {
        unsafe {
            let [low, high] = Self::mask(set);
            Self(vbslq_f32(low, other.0, self.0), vbslq_f32(high, other.1, self.1))
        }
    }

    #[inline(always)]
    unsafe fn leasts(four: [Self; 4]) -> [f32; 4] {
        unsafe {
            let [a, b, c, d] = four.map(|eight| vminq_f32(eight.0, eight.1));
            let mut least = [0.0; 4];
            vst1q_f32(least.as_mut_ptr(), vpminq_f32(vpminq_f32(a, b), vpminq_f32(c, d)));
            least
        }
    }

    #[inline(always)]
    unsafe fn largest(self) -> f32 {
        unsafe { vmaxvq_f32(vmaxq_f32(self.0, self.1)) }
    }
}

impl SetLanes for Eight {
    #[inline(always)]
    unsafe fn store_set(self, to: *mut f32, set: u32) {
        let mut values = [0.0; 8];
        unsafe {
            if set == 255 {
                self.store(to);
            } else {
                self.store(values.as_mut_ptr());
                for lane in lanes_of(set) {
                    *to.add(lane) = values[lane % 8];
                }
            }
        }
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

impl Quads for Eight {
    #[inline(always)]
    unsafe fn quads(from: &[*const f32; 4]) -> Self {
        unsafe { Self(vld1q_f32(from[0]), vld1q_f32(from[1])) }
    }

    #[inline(always)]
    unsafe fn splat_quads(from: &[*const f32; 4]) -> Self {
        unsafe { Self(vld1q_dup_f32(from[0]), vld1q_dup_f32(from[1])) }
    }

    #[inline(always)]
    unsafe fn splat_in_quads<const LANE: i32>(self) -> Self {
        unsafe {
            let splat = |quad| match LANE & 3 {
                0 => vdupq_laneq_f32::<0>(quad),
                1 => vdupq_laneq_f32::<1>(quad),
                2 => vdupq_laneq_f32::<2>(quad),
                _ => vdupq_laneq_f32::<3>(quad),
            };
            Self(splat(self.0), splat(self.1))
        }
    }

    #[inline(always)]
    unsafe fn store_columns([a, b, c, d]: [Self; 4], to: *mut f32, stride: usize) {
        unsafe {
            for (place, [a, b, c, d]) in [(0, [a.0, b.0, c.0, d.0]), (4, [a.1, b.1, c.1, d.1])] {
                let (ab, cd) = (vzip1q_f32(a, b), vzip1q_f32(c, d));
                let (ab_high, cd_high) = (vzip2q_f32(a, b), vzip2q_f32(c, d));
                let columns = [
                    vzip1q_f64(vreinterpretq_f64_f32(ab), vreinterpretq_f64_f32(cd)),
                    vzip2q_f64(vreinterpretq_f64_f32(ab), vreinterpretq_f64_f32(cd)),
                    vzip1q_f64(vreinterpretq_f64_f32(ab_high), vreinterpretq_f64_f32(cd_high)),
                    vzip2q_f64(vreinterpretq_f64_f32(ab_high), vreinterpretq_f64_f32(cd_high)),
                ];
                for (i, column) in columns.into_iter().enumerate() {
                    vst1q_f32(to.add((place + i) * stride), vreinterpretq_f32_f64(column));
                }
            }
        }
    }
}
