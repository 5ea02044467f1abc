//! The order in which a ray visits the cells of a treelet.

use std::arch::x86_64::*;

use crate::structure::kdtree::treelet::{MIDDLE, TOP, Treelet, WIDTH};

/// Aligned as registers are.
#[repr(align(64))]
pub(crate) struct Aligned<T>(pub(crate) T);

/// By which of the seven planes the ray falls through (bit `p` for plane `p`), for each cell from
/// the farthest to the nearest: bits 0-2: the child; bits 4-6 and 8-10: the planes of the last and
/// of the middle level about it; bits 7 and 11 are set if the cell lies before them.
pub(crate) static WAYS: Aligned<[[u16; WIDTH]; 128]> = {
    let mut table = [[0; WIDTH]; 128];
    let mut falls = 0;
    while falls < table.len() {
        let mut cell = 0;
        while cell < WIDTH {
            let (near0, near1, near2) = (cell >> 2 & 1, cell >> 1 & 1, cell & 1);
            let side0 = (falls >> TOP & 1) ^ near0 ^ 1;
            let plane1 = MIDDLE + side0;
            let side1 = (falls >> plane1 & 1) ^ near1 ^ 1;
            let plane2 = 2 * side0 + side1;
            let side2 = (falls >> plane2 & 1) ^ near2 ^ 1;
            let child = 4 * side0 + 2 * side1 + side2;
            let word = child | (plane2 | near2 << 3) << 4 | (plane1 | near1 << 3) << 8;
            table[falls][cell] = word as u16;
            cell += 1;
        }
        falls += 1;
    }
    Aligned(table)
};

/// The cells that lie before the planes of each level, from the top; the others lie behind them.
pub(crate) const NEAR: [u8; 3] = [0xf0, 0xcc, 0xaa];

/// As bits 8-11 of [`WAYS`], for the plane of the top level.
pub(crate) static TIMES: Aligned<[u32; WIDTH]> = {
    let (behind, before) = (TOP as u32, TOP as u32 | 8);
    Aligned([behind, behind, behind, behind, before, before, before, before])
};

/// In the two lowest bits of each lane the axis of a plane of a treelet.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
pub(crate) unsafe fn axes(treelet: &Treelet) -> __m256i {
    // SAFETY: the caller's.
    unsafe {
        let axes = _mm256_set1_epi32(treelet.axes as i32);
        _mm256_srlv_epi32(axes, _mm256_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14))
    }
}

/// The number of each plane's axis; a fourth number is readable.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
pub(crate) unsafe fn row(numbers: &[f32], axes: __m256i) -> __m256 {
    // SAFETY: the caller's.
    unsafe { _mm256_permutevar_ps(_mm256_broadcast_ps(&*numbers.as_ptr().cast()), axes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows each table entry down the planes that it tells.
    #[test]
    fn ways_lead_from_far_to_near() {
        for (falls, ways) in WAYS.0.iter().enumerate() {
            let mut met = 0;
            for (cell, &way) in ways.iter().enumerate() {
                let child = usize::from(way & 7);
                met |= 1 << child;
                let planes = [TOP, MIDDLE + (child >> 2), child >> 1];
                assert_eq!([planes[1], planes[2]], [way >> 8 & 7, way >> 4 & 7].map(usize::from));
                for (level, plane) in planes.into_iter().enumerate() {
                    let is_above = child >> (2 - level) & 1;
                    let is_near = is_above == falls >> plane & 1;
                    assert_eq!(is_near, cell >> (2 - level) & 1 == 1);
                    assert_eq!(is_near, NEAR[level] >> cell & 1 == 1);
                }
                let is_near = [0, way >> 11 & 1, way >> 7 & 1];
                assert!((1..3).all(|i| is_near[i] == u16::from(NEAR[i] >> cell & 1)));
            }
            assert_eq!(met, 0xff);
        }
    }
}
