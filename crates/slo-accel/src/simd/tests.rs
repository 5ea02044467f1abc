//! Vectors against the same operations on single numbers.

use super::{Lanes, Quads, SetLanes};

const NUMBERS: [f32; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    3.3,
    -7.7e-3,
    1e-40,
    -f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1.234_567_8,
];

/// Sixteen of the numbers, others for each `k`.
fn column(k: usize) -> [f32; 16] {
    std::array::from_fn(|i| NUMBERS[(i * (2 * k + 1) + k / 3) % NUMBERS.len()])
}

/// The lanes of a vector.
unsafe fn lanes<L: Lanes>(vector: L) -> Vec<f32> {
    let mut values = vec![0.0; L::COUNT];
    // SAFETY: there are as many places as lanes.
    unsafe { vector.store(values.as_mut_ptr()) };
    values
}

/// Compares bits, but for those of NaN.
fn same(found: &[f32], what: &str, expected: impl Fn(usize) -> f32) {
    for (i, &x) in found.iter().enumerate() {
        let y = expected(i);
        assert!(x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan(), "{what}, {i}: {x} {y}");
    }
}

fn set_where(count: usize, is_in: impl Fn(usize) -> bool) -> u32 {
    (0..count).filter(|&i| is_in(i)).fold(0, |set, i| set | 1 << i)
}

/// # Safety
/// The CPU has the instructions of `L`.
#[allow(clippy::disallowed_methods)] // the reference of fused operations
#[inline(always)]
unsafe fn check<L: Quads + SetLanes>() {
    for k in 0..200 {
        let (x, y, z) = (column(k), column(k * 7 + 2), column(k * 5 + 1));
        // SAFETY: the caller's; columns have sixteen numbers, and vectors no more.
        unsafe {
            let (a, b, c) = (L::load(x.as_ptr()), L::load(y.as_ptr()), L::load(z.as_ptr()));
            same(&lanes(a.add(b)), "add", |i| x[i] + y[i]);
            same(&lanes(a.sub(b)), "sub", |i| x[i] - y[i]);
            same(&lanes(a.mul(b)), "mul", |i| x[i] * y[i]);
            same(&lanes(a.div(b)), "div", |i| x[i] / y[i]);
            same(&lanes(a.mul_add(b, c)), "mul_add", |i| x[i].mul_add(y[i], z[i]));
            same(&lanes(a.mul_sub(b, c)), "mul_sub", |i| x[i].mul_add(y[i], -z[i]));
            same(&lanes(a.neg_mul_add(b, c)), "neg_mul_add", |i| (-x[i]).mul_add(y[i], z[i]));
            same(&lanes(a.min(b)), "min", |i| if x[i] < y[i] { x[i] } else { y[i] });
            same(&lanes(a.max(b)), "max", |i| if x[i] > y[i] { x[i] } else { y[i] });
            same(&lanes(a.abs()), "abs", |i| x[i].abs());
            same(&lanes(L::splat(x[3])), "splat", |_| x[3]);
            assert_eq!(a.le(b), set_where(L::COUNT, |i| x[i] <= y[i]), "le");
            assert_eq!(a.lt(b), set_where(L::COUNT, |i| x[i] < y[i]), "lt");
            let set = (k as u32).wrapping_mul(0x9e37_79b9) >> 16;
            let is_in = |i: usize| set >> i & 1 == 1;
            same(&lanes(a.replace(set, b)), "replace", |i| if is_in(i) { y[i] } else { x[i] });

            let four = [x, y, z, column(k + 1)].map(|values| values.map(|v| v.max(-1e30)));
            let vectors = [
                L::load(four[0].as_ptr()),
                L::load(four[1].as_ptr()),
                L::load(four[2].as_ptr()),
                L::load(four[3].as_ptr()),
            ];
            let all = |row: usize| four[row][..L::COUNT].iter().copied();
            let leasts = L::leasts(vectors);
            for (row, least) in leasts.into_iter().enumerate() {
                assert_eq!(least, all(row).fold(f32::INFINITY, f32::min), "leasts");
            }
            assert_eq!(vectors[0].largest(), all(0).fold(f32::NEG_INFINITY, f32::max), "largest");

            let set = set & (u32::MAX >> (32 - L::COUNT));
            let mut stored = y;
            a.store_set(stored.as_mut_ptr(), set);
            same(&stored, "store_set", |i| if set >> i & 1 == 1 { x[i] } else { y[i] });
            let places: [u32; 16] = std::array::from_fn(|i| (i * 5 % 16) as u32);
            let mut stored = y;
            a.scatter_set(stored.as_mut_ptr(), places.as_ptr(), set);
            for (lane, &place) in places.iter().enumerate() {
                let value = if set >> lane & 1 == 1 { x[lane] } else { y[place as usize] };
                same(&[stored[place as usize]], "scatter_set", |_| value);
            }

            let rows = [x.as_ptr(), y.as_ptr().add(5), z.as_ptr().add(12), x.as_ptr().add(7)];
            let of = |i: usize| *rows[i / 4].add(i % 4);
            same(&lanes(L::quads(&rows)), "quads", of);
            same(&lanes(L::splat_quads(&rows)), "splat_quads", |i| of(i / 4 * 4));
            same(&lanes(L::quads(&rows).splat_in_quads::<0x55>()), "splat_in_quads", |i| {
                of(i / 4 * 4 + 1)
            });
            same(&lanes(L::quads(&rows).splat_in_quads::<0xaa>()), "splat_in_quads", |i| {
                of(i / 4 * 4 + 2)
            });
            let mut columns = [0.0; 16 * 6];
            L::store_columns(vectors, columns.as_mut_ptr(), 6);
            for lane in 0..L::COUNT {
                same(&columns[6 * lane..][..4], "store_columns", |row| four[row][lane]);
            }
        }
    }
}

#[cfg(target_arch = "aarch64")]
#[test]
fn neon() {
    // SAFETY: every AArch64 CPU has the instructions.
    unsafe { check::<super::neon::Eight>() };
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m256, __m512};

    use super::check;
    use crate::isa::Isa;

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn check_avx2() {
        // SAFETY: the CPU has the instructions.
        unsafe { check::<__m256>() };
    }

    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn check_avx512() {
        // SAFETY: the CPU has the instructions.
        unsafe { check::<__m512>() };
    }

    #[test]
    fn avx2() {
        if Isa::Avx2.is_available() {
            // SAFETY: the CPU has the instructions.
            unsafe { check_avx2() };
        }
    }

    #[test]
    fn avx512() {
        if Isa::Avx512.is_available() {
            // SAFETY: the CPU has the instructions.
            unsafe { check_avx512() };
        }
    }
}
