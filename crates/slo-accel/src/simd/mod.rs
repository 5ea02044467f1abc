//! Vectors of 8 and 16 numbers, so that a kernel is written once for all of them.
//!
//! Nothing is reordered or approximated: a lane has the bits that the same operations give in plain
//! Rust.

#[cfg(target_arch = "aarch64")]
pub(crate) mod neon;
mod prefetch;
pub(crate) mod sets;
#[cfg(all(test, any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use self::prefetch::prefetch;
use crate::rays::{Hits, LANES};

/// A vector of `COUNT` numbers.
///
/// Functions are inlined into a kernel that is compiled for the CPU's instruction set.
///
/// # Safety
/// That set must have the type's instructions: AVX2 and FMA or NEON for 8 lanes, AVX-512 F, DQ and
/// VL for 16. Pointers must be valid for all lanes; they need no alignment.
pub(crate) trait Lanes: Copy {
    const COUNT: usize;

    unsafe fn splat(x: f32) -> Self;
    unsafe fn load(from: *const f32) -> Self;
    unsafe fn store(self, to: *mut f32);
    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    unsafe fn div(self, other: Self) -> Self;
    /// `self * b + c`, rounded once.
    unsafe fn mul_add(self, b: Self, c: Self) -> Self;
    /// `self * b - c`, rounded once.
    unsafe fn mul_sub(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, rounded once.
    unsafe fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// The smaller; `other` if one is NaN.
    unsafe fn min(self, other: Self) -> Self;
    /// The larger; `other` if one is NaN.
    unsafe fn max(self, other: Self) -> Self;
    unsafe fn abs(self) -> Self;
    /// The lanes with `self <= other`: bit `i` for lane `i`; not set if one is NaN, as in all
    /// comparisons.
    unsafe fn le(self, other: Self) -> u32;
    unsafe fn lt(self, other: Self) -> u32;
    /// `other` in the lanes of `set`, `self` in the others.
    unsafe fn replace(self, set: u32, other: Self) -> Self;
    /// The smallest of all lanes of each of four vectors, none of which is NaN.
    unsafe fn leasts(four: [Self; 4]) -> [f32; 4];
    /// The largest of all lanes, none of which is NaN.
    unsafe fn largest(self) -> f32;
}

/// Vectors that can store a set of their lanes.
///
/// # Safety
/// As [`Lanes`]; pointers must be valid for the lanes of the set.
pub(crate) trait SetLanes: Lanes {
    /// Stores lane `i` of a set at `to[i]`.
    unsafe fn store_set(self, to: *mut f32, set: u32);
    /// Stores lane `i` of a set at `to[indices[i]]`; all indices are readable.
    unsafe fn scatter_set(self, to: *mut f32, indices: *const u32, set: u32);
}

/// Vectors as rows of four lanes each.
///
/// # Safety
/// As [`Lanes`].
pub(crate) trait Quads: Lanes {
    /// Four lanes from each pointer, of the first `COUNT / 4`.
    unsafe fn quads(from: &[*const f32; LANES / 4]) -> Self;
    /// The number at each pointer, of the first `COUNT / 4`, four times.
    unsafe fn splat_quads(from: &[*const f32; LANES / 4]) -> Self;
    /// Each four lanes filled with one of them, whose number is `LANE`: two bits, four times.
    unsafe fn splat_in_quads<const LANE: i32>(self) -> Self;
    /// Stores lane `i` of each of four vectors at `to + i * stride`.
    unsafe fn store_columns(four: [Self; 4], to: *mut f32, stride: usize);
}

/// Transposes sixteen rays to their places in memory: lane `i` of each four rows goes to `to + i *
/// stride`, after that of the four rows before.
///
/// # Safety
/// The CPU has the instructions of `L`; rows have sixteen numbers, and there is room for the rays.
#[inline(always)]
pub(crate) unsafe fn deal_rows<L: Quads>(rows: &[[*const f32; 4]], to: *mut f32, stride: usize) {
    for base in (0..LANES).step_by(L::COUNT) {
        for (i, row) in rows.iter().enumerate() {
            // SAFETY: the caller's.
            unsafe {
                let four = [
                    L::load(row[0].add(base)),
                    L::load(row[1].add(base)),
                    L::load(row[2].add(base)),
                    L::load(row[3].add(base)),
                ];
                L::store_columns(four, to.add(base * stride + 4 * i), stride);
            }
        }
    }
}

/// Stores the hits of a set of rays (t, u, v, and bits of ids), each at its index in the batch; the
/// indices of neighbours are consecutive.
///
/// # Safety
/// The CPU has the instructions of `L`; there are indices for its lanes, and hits for the set's.
#[inline(always)]
pub(crate) unsafe fn store_hits<L: SetLanes>(
    hits: &mut Hits,
    indices: &[u32],
    are_neighbours: bool,
    set: u32,
    [t, u, v, ids]: [L; 4],
) {
    let Hits { t: ts, u: us, v: vs, primitive } = hits;
    let arrays = [ts.as_mut_ptr(), us.as_mut_ptr(), vs.as_mut_ptr(), primitive.as_mut_ptr().cast()];
    for (array, lanes) in arrays.into_iter().zip([t, u, v, ids]) {
        // SAFETY: the caller's.
        unsafe {
            if are_neighbours {
                lanes.store_set(array.wrapping_add(indices[0] as usize), set);
            } else {
                lanes.scatter_set(array, indices.as_ptr(), set);
            }
        }
    }
}

/// The lanes of a set, lowest first.
#[inline(always)]
pub(crate) fn lanes_of(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// Three rows, from lane `base` on.
///
/// # Safety
/// The CPU has the instructions of `L`, and `base` leaves enough lanes.
#[inline(always)]
pub(crate) unsafe fn load3<L: Lanes>(rows: &[[f32; LANES]; 3], base: usize) -> [L; 3] {
    // SAFETY: the caller's.
    unsafe {
        [
            L::load(rows[0].as_ptr().add(base)),
            L::load(rows[1].as_ptr().add(base)),
            L::load(rows[2].as_ptr().add(base)),
        ]
    }
}
