//! How rays are chosen on NEON.

use std::arch::aarch64::*;

use super::Choosing;
use crate::rays::LANES;
use crate::simd::Lanes;
use crate::simd::neon::{Eight, lanes_in, set_of_bytes};

/// NEON.
pub(crate) struct Neon;

impl Choosing for Neon {
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        // SAFETY: there are sixteen values.
        unsafe {
            let equal = vceqq_u8(vld1q_u8(values.as_ptr()), vdupq_n_u8(value));
            set_of_bytes(vget_low_u8(equal)) | set_of_bytes(vget_high_u8(equal)) << 8
        }
    }

    #[inline(always)]
    unsafe fn compress_lanes(first: u32, set: u32, to: *mut u32) {
        let [low, high] = [set & 255, set >> 8 & 255];
        // SAFETY: the caller's; so many are written behind the first eight as are in the low half.
        unsafe {
            store_numbers(first, low, to);
            store_numbers(first + 8, high, to.add(low.count_ones() as usize));
        }
    }

    #[inline(always)]
    unsafe fn compress(from: &[f32; LANES], set: u32, to: *mut f32) {
        let [low, high] = [set & 255, set >> 8 & 255];
        // SAFETY: the caller's; a half has eight numbers, and so many are written behind the first.
        unsafe {
            Eight::load(from.as_ptr()).packed(low).store(to);
            let to = to.add(low.count_ones() as usize);
            Eight::load(from.as_ptr().add(8)).packed(high).store(to);
        }
    }
}

/// Writes `first + lane` for each lane of a set, of eight, in order, and what is behind them.
///
/// # Safety
/// `to` is writable for eight values.
#[inline(always)]
unsafe fn store_numbers(first: u32, set: u32, to: *mut u32) {
    // SAFETY: the caller's.
    unsafe {
        let (lanes, first) = (vmovl_u8(lanes_in(set)), vdupq_n_u32(first));
        vst1q_u32(to, vaddw_u16(first, vget_low_u16(lanes)));
        vst1q_u32(to.add(4), vaddw_high_u16(first, lanes));
    }
}
