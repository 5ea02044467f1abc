//! Tests of several blocks at once, each with a ray of its own, in vectors of four lanes to a block.

use super::layout::{BLOCK, FIRST_CHANGE, triangle_at};
use super::steps::{BlockHits, MOST_BLOCKS, Meeting};
use crate::primitives::triangle::lanes::Tested;
use crate::primitives::triangle::{ShearedRay, Triangle};
use crate::simd::Quads;

/// As [`Steps::blocks`](super::steps::Steps::blocks).
///
/// # Safety
/// The CPU has the instructions of `L`; otherwise as [`Steps::blocks`](super::steps::Steps::blocks).
#[inline(always)]
pub(super) unsafe fn blocks<L: Quads, const MOVES: bool>(
    meetings: &[Meeting; MOST_BLOCKS],
    any: bool,
    hits: &mut BlockHits,
) -> u32 {
    let quads = L::COUNT / BLOCK;
    // SAFETY: rows and what is read beyond the last are readable, as the caller promises; arrays
    // of hits have as many places as there are lanes, or more.
    unsafe {
        let time = if MOVES {
            let mut times = [std::ptr::null::<f32>(); MOST_BLOCKS];
            for (time, meeting) in times.iter_mut().zip(&meetings[..quads]) {
                *time = &raw const (*meeting.ray).time;
            }
            L::splat_quads(&times)
        } else {
            L::splat(0.0)
        };
        let mut corners = [[L::splat(0.0); 3]; 3];
        let mut lines = [[std::ptr::null::<f32>(); MOST_BLOCKS]; 3];
        let mut lanes = 0;
        for (i, meeting) in meetings[..quads].iter().enumerate() {
            let axes = &(*meeting.ray).axes;
            for k in 0..3 {
                lines[k][i] = meeting.block.add(axes[k] as usize * meeting.count);
            }
            lanes |= ((1 << meeting.count) - 1) << (BLOCK * i);
        }
        for (c, corner) in corners.iter_mut().enumerate() {
            for (k, row) in corner.iter_mut().enumerate() {
                let mut rows = lines[k];
                for i in 0..quads {
                    rows[i] = rows[i].add(3 * c * meetings[i].count);
                }
                *row = L::quads(&rows);
                if MOVES {
                    for i in 0..quads {
                        rows[i] = rows[i].add(FIRST_CHANGE * meetings[i].count);
                    }
                    *row = row.add(L::quads(&rows).mul(time));
                }
            }
        }
        let mut fields = [[std::ptr::null::<f32>(); MOST_BLOCKS]; 3];
        for (i, meeting) in meetings[..quads].iter().enumerate() {
            fields[0][i] = (&raw const (*meeting.ray).origin).cast();
            fields[1][i] = (&raw const (*meeting.ray).shear).cast();
            fields[2][i] = &raw const (*meeting.ray).t;
        }
        let (origin, shear) = (L::quads(&fields[0]), L::quads(&fields[1]));
        let origin = [
            origin.splat_in_quads::<0>(),
            origin.splat_in_quads::<0x55>(),
            origin.splat_in_quads::<0xaa>(),
        ];
        let shear = [
            shear.splat_in_quads::<0>(),
            shear.splat_in_quads::<0x55>(),
            shear.splat_in_quads::<0xaa>(),
        ];
        let t_max = L::splat_quads(&fields[2]);
        let tested = Tested::new(corners, origin, shear, t_max, lanes);
        let mut set = tested.hits;
        if set == 0 {
            return 0;
        }
        let tested = tested.settle(|lane| pair_at::<MOVES>(meetings, lane));
        set = tested.hits;
        if any {
            return set & tested.t.lt(t_max);
        }
        tested.t.store(hits.t.as_mut_ptr());
        let [u, v, sum] = tested.parts();
        u.store(hits.weights[0].as_mut_ptr());
        v.store(hits.weights[1].as_mut_ptr());
        sum.store(hits.sum.as_mut_ptr());
        set
    }
}

/// The ray and the triangle of a lane. Only doubtful hits need them, so this stays out of loops.
///
/// # Safety
/// As [`Steps::blocks`](super::steps::Steps::blocks); there is such a lane.
#[cold]
#[inline(never)]
unsafe fn pair_at<const MOVES: bool>(
    meetings: &[Meeting; MOST_BLOCKS],
    lane: usize,
) -> (ShearedRay, Triangle) {
    let Meeting { block, count, ray } = meetings[lane / BLOCK];
    // SAFETY: the caller's.
    unsafe {
        let time = MOVES.then_some((*ray).time);
        ((*ray).sheared(), triangle_at(block, count, lane % BLOCK, time))
    }
}
