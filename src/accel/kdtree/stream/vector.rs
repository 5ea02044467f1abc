//! What the stream is made of beyond arithmetic, for one width of registers.

use std::ops::{BitAnd, BitOr, Not};

use crate::accel::kdtree::node::Chunk;
use crate::accel::kdtree::single::Kernel;
use crate::accel::order::Choosing;
use crate::accel::simd::Lanes;

/// A register of `N` lanes, which hold numbers; or, as `Words`, 32 bits each.
///
/// # Safety
/// As [`Lanes`]; what has to do with sets of bits and tables of sets also needs BMI2.
pub(in crate::accel::kdtree) trait Vector<const N: usize>: Lanes {
    /// The same register, of words.
    type Words: Copy;
    /// A set of lanes, in the form that comparisons give.
    type Set: Copy
        + BitAnd<Output = Self::Set>
        + BitOr<Output = Self::Set>
        + Not<Output = Self::Set>;
    /// The test of leaves one by one.
    type Kernel: Kernel;
    /// How rays are chosen.
    type Choosing: Choosing;

    /// The set of bits: bit `i` for lane `i`.
    unsafe fn set(bits: u32) -> Self::Set;
    unsafe fn bits(set: Self::Set) -> u32;
    /// The lowest `count` bits of a set.
    unsafe fn lowest(set: u32, count: u32) -> u32;

    unsafe fn load_words(from: *const u32) -> Self::Words;
    unsafe fn store_words(words: Self::Words, to: *mut u32);
    unsafe fn splat_words(word: u32) -> Self::Words;
    unsafe fn words(self) -> Self::Words;
    unsafe fn numbers(words: Self::Words) -> Self;
    /// 0, 1, 2, and so on.
    unsafe fn lane_numbers() -> Self::Words;
    unsafe fn add_words(a: Self::Words, b: Self::Words) -> Self::Words;
    unsafe fn and_words(a: Self::Words, b: Self::Words) -> Self::Words;
    unsafe fn xor_words(a: Self::Words, b: Self::Words) -> Self::Words;
    unsafe fn shift_left(words: Self::Words, by: u32) -> Self::Words;
    unsafe fn shift_right(words: Self::Words, by: u32) -> Self::Words;
    /// One more in the lanes of a set.
    unsafe fn add_one(words: Self::Words, set: Self::Set) -> Self::Words;
    /// One less in the lanes of a set.
    unsafe fn take_one(words: Self::Words, set: Self::Set) -> Self::Words;

    /// Where one bit is set.
    unsafe fn with_bit(words: Self::Words, bit: u32) -> Self::Set;
    unsafe fn equal_words(a: Self::Words, b: Self::Words) -> Self::Set;
    /// Where a word is not above another; both are below 2^31.
    unsafe fn at_most(a: Self::Words, b: Self::Words) -> Self::Set;
    unsafe fn is_negative(self) -> Self::Set;
    /// Where not `self > other`, among a set: also where one is NaN.
    unsafe fn not_above(self, other: Self, among: Self::Set) -> Self::Set;
    /// Where not `self < other`, among a set: also where one is NaN.
    unsafe fn not_below(self, other: Self, among: Self::Set) -> Self::Set;

    /// `b` in the lanes of a set, `a` in the others.
    unsafe fn choose(set: Self::Set, a: Self, b: Self) -> Self;
    unsafe fn choose_words(set: Self::Set, a: Self::Words, b: Self::Words) -> Self::Words;
    /// The words at `from + places`, 0 in lanes that are not in the set.
    unsafe fn gather(from: *const u32, places: Self::Words, set: Self::Set) -> Self::Words;
    /// Both words at `from + 2 * places`, 0 in lanes that are not in the set.
    unsafe fn gather_pairs(
        from: *const u32,
        places: Self::Words,
        set: Self::Set,
    ) -> [Self::Words; 2];

    /// The lanes of a set, one behind the other, before any others.
    unsafe fn compress(self, set: u32) -> Self;
    /// The first lanes of `packed` in the lanes of a set, in order, `self` in the others.
    unsafe fn expand(self, set: u32, packed: Self) -> Self;
    /// Lanes `i`, `i + 4`, and so on of all four in the `i`-th, a lane's four one after the other.
    unsafe fn interleave(four: [Self; 4]) -> [Self; 4];

    /// The numbers at `M` places, each in as many neighbouring lanes.
    unsafe fn shares<const M: usize>(from: [*const f32; M]) -> Self;
    /// The least of each of `M` shares of the lanes, in all lanes of the share.
    unsafe fn least_of_shares<const M: usize>(self) -> Self;
    /// Corners (by corner, then along the axes that are told) of up to `N / M` triangles of each of
    /// `M` chunks with no more than `2 N / M` vertices, from the `first` triangle on, which is even.
    /// In lanes that hold no triangle, which are not `present`, there is a number that is not
    /// subnormal.
    ///
    /// The words are those of chunks of a finished arena.
    unsafe fn corners<const M: usize>(
        words: [*const u32; M],
        chunks: [Chunk; M],
        axes: [[usize; 3]; M],
        first: usize,
        present: u32,
    ) -> [[Self; 3]; 3];
}
