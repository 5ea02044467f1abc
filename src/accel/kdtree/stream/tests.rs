//! Registers of both widths against plain Rust.

use std::arch::x86_64::{__m256, __m512};

use super::Vector;
use crate::accel::Isa;
use crate::accel::simd::lanes_of;

/// What the operations on words and sets of lanes give, for all sets of a register's lanes that a
/// few bits tell.
#[inline(always)]
unsafe fn check<V: Vector<N>, const N: usize>() {
    let row: [u32; N] = std::array::from_fn(|i| (i as u32 + 1).wrapping_mul(0x9e37_79b9));
    let other: [u32; N] = std::array::from_fn(|i| 100 + i as u32);
    let table: [u32; 64] = std::array::from_fn(|i| 7 * i as u32 + 3);
    let places: [u32; N] = std::array::from_fn(|i| (5 * i as u32) % 32);
    for set in (0..1u32 << N).step_by(if N > 8 { 97 } else { 1 }) {
        let is_in = |lane: usize| set >> lane & 1 == 1;
        // SAFETY: the caller's; rows are as long as registers, and places lie in the table.
        unsafe {
            let read = |words: V::Words| {
                let mut row = [0u32; N];
                V::store_words(words, row.as_mut_ptr());
                row
            };
            let (a, b) = (V::load_words(row.as_ptr()), V::load_words(other.as_ptr()));
            let lanes = V::set(set);
            assert_eq!(V::bits(lanes), set);
            assert_eq!(V::bits(!lanes & V::set(0x5555)), !set & 0x5555 & ((1 << N) - 1));
            for count in 0..=N as u32 {
                let lowest = lanes_of(set).take(count as usize).fold(0, |s, lane| s | 1 << lane);
                assert_eq!(V::lowest(set, count), lowest);
            }
            let of = |f: &dyn Fn(usize) -> u32| -> [u32; N] { std::array::from_fn(f) };
            let chosen = of(&|i| if is_in(i) { other[i] } else { row[i] });
            assert_eq!(read(V::choose_words(lanes, a, b)), chosen);
            assert_eq!(read(V::add_one(b, lanes)), of(&|i| other[i] + u32::from(is_in(i))));
            assert_eq!(read(V::take_one(b, lanes)), of(&|i| other[i] - u32::from(is_in(i))));
            let places = V::load_words(places.as_ptr());
            let at = |i: usize| (5 * i) % 32;
            let gathered = of(&|i| if is_in(i) { table[at(i)] } else { 0 });
            assert_eq!(read(V::gather(table.as_ptr(), places, lanes)), gathered);
            for (half, words) in
                V::gather_pairs(table.as_ptr(), places, lanes).into_iter().enumerate()
            {
                let gathered = of(&|i| if is_in(i) { table[2 * at(i) + half] } else { 0 });
                assert_eq!(read(words), gathered);
            }
            let packed: Vec<u32> = lanes_of(set).map(|lane| row[lane]).collect();
            assert_eq!(read(V::numbers(a).compress(set).words())[..packed.len()], packed);
            let mut next = other.iter();
            let spread = of(&|i| row[i]);
            let mut spread = spread;
            lanes_of(set).for_each(|lane| spread[lane] = *next.next().expect("as many"));
            assert_eq!(read(V::numbers(a).expand(set, V::numbers(b)).words()), spread);
        }
    }
}

/// What the operations on shares of a register give.
#[inline(always)]
unsafe fn check_shares<V: Vector<N>, const N: usize, const M: usize>() {
    let numbers: [f32; N] = std::array::from_fn(|i| ((i * 7 + 5) % N) as f32 - 3.5);
    let share = N / M;
    // SAFETY: the caller's; rows are as long as registers.
    unsafe {
        let read = |lanes: V| {
            let mut row = [0.0f32; N];
            lanes.store(row.as_mut_ptr());
            row
        };
        let from: [*const f32; M] = std::array::from_fn(|i| &raw const numbers[i]);
        assert_eq!(read(V::shares(from)), std::array::from_fn(|i| numbers[i / share]));
        let least =
            |i: usize| numbers[i / share * share..][..share].iter().copied().fold(9.0, f32::min);
        let leasts: [f32; N] = std::array::from_fn(least);
        assert_eq!(read(V::load(numbers.as_ptr()).least_of_shares::<M>()), leasts);
        let rows: [[f32; N]; 4] = std::array::from_fn(|r| numbers.map(|x| x + 100.0 * r as f32));
        let rows = V::interleave(rows.map(|row| V::load(row.as_ptr())));
        let rows = rows.map(read);
        for lane in 0..N {
            let four = &rows[lane % 4][lane / 4 * 4..][..4];
            assert!(
                (0..4).all(|r| four[r] == numbers[lane] + 100.0 * r as f32),
                "{lane}: {four:?}"
            );
        }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn check_avx2() {
    // SAFETY: those are the instructions.
    unsafe {
        check::<__m256, 8>();
        check_shares::<__m256, 8, 1>();
        check_shares::<__m256, 8, 2>();
        check_shares::<__m256, 8, 4>();
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn check_avx512() {
    // SAFETY: those are the instructions.
    unsafe {
        check::<__m512, 16>();
        check_shares::<__m512, 16, 1>();
        check_shares::<__m512, 16, 2>();
        check_shares::<__m512, 16, 4>();
    }
}

#[test]
fn registers_do_what_plain_rust_does() {
    // SAFETY: the CPU has the instructions.
    unsafe {
        if Isa::Avx2.is_available() {
            check_avx2();
        }
        if Isa::Avx512.is_available() {
            check_avx512();
        }
    }
}
