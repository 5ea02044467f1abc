//! Packing: chosen entries of a column, one behind the other.

use super::Isa;

/// Entries of a column for which one word of bits says whether they are chosen.
pub const GROUP: usize = 16;

/// A number of 32 bits, as [`Isa::compress`] packs them.
///
/// # Safety
/// The type must have a size of four bytes, and every pattern of bits must be a value of it.
pub unsafe trait Word: Copy {}

// SAFETY: four bytes, and every pattern of them is a number.
unsafe impl Word for f32 {}

// SAFETY: four bytes, and every pattern of them is a number.
unsafe impl Word for u32 {}

impl Isa {
    /// Copies entry `16 g + i` of `from` for each bit `i` that is set in `bits[g]`, in order, to
    /// the front of `to`. Returns the number of entries copied.
    ///
    /// # Panics
    /// If `from` has fewer than [`GROUP`] entries for each of `bits`, or `to` has no room.
    pub fn compress<T: Word>(self, bits: &[u16], from: &[T], to: &mut [T]) -> usize {
        let count = bits.iter().map(|group| group.count_ones() as usize).sum();
        assert!(bits.len() * GROUP <= from.len() && count <= to.len());
        match self {
            // SAFETY: the CPU has AVX-512, and the assertion above checks the room.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { compress_avx512(bits, from, to, count) },
            // SAFETY: the assertion above checks the room.
            #[cfg(target_arch = "aarch64")]
            Self::Neon => unsafe { compress_neon(bits, from, to, count) },
            _ => compress_portable(bits, from, to),
        }
        count
    }
}

fn compress_portable<T: Word>(bits: &[u16], from: &[T], to: &mut [T]) {
    let mut rest = to;
    for (&group, from) in bits.iter().zip(from.chunks_exact(GROUP)) {
        let (now, later) = rest.split_at_mut(group.count_ones() as usize);
        if group == u16::MAX {
            now.copy_from_slice(from);
        } else {
            let mut left = group;
            for to in now {
                *to = from[left.trailing_zeros() as usize];
                left &= left - 1;
            }
        }
        rest = later;
    }
}

/// While sixteen entries or more are left to be written, a whole register is stored: what lies
/// behind the packed entries is overwritten later, and masked stores are slow.
///
/// # Safety
/// `from` has 16 entries for each of `bits`, and `to` one for each bit that is set: `count`.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,bmi2,popcnt")]
unsafe fn compress_avx512<T: Word>(bits: &[u16], from: &[T], to: &mut [T], count: usize) {
    use std::arch::x86_64::{
        _bzhi_u32, _mm512_loadu_si512, _mm512_mask_storeu_epi32, _mm512_maskz_compress_epi32,
        _mm512_storeu_si512,
    };
    let (mut from, mut to) = (from.as_ptr(), to.as_mut_ptr());
    let mut left = count;
    for &group in bits {
        let count = group.count_ones();
        // SAFETY: 16 entries are there to be read, and as many as are left to be written.
        unsafe {
            let packed = _mm512_maskz_compress_epi32(group, _mm512_loadu_si512(from.cast()));
            if left >= GROUP {
                _mm512_storeu_si512(to.cast(), packed);
            } else {
                let kept = _bzhi_u32(u32::from(u16::MAX), count) as u16;
                _mm512_mask_storeu_epi32(to.cast(), kept, packed);
            }
            (from, to) = (from.add(GROUP), to.add(count as usize));
        }
        left -= count as usize;
    }
}

/// As on AVX-512, eight entries at a time.
///
/// # Safety
/// `from` has 16 entries for each of `bits`, and `to` one for each bit that is set: `count`.
#[cfg(target_arch = "aarch64")]
unsafe fn compress_neon<T: Word>(bits: &[u16], from: &[T], to: &mut [T], count: usize) {
    use crate::simd::{Lanes, SetLanes, neon::Eight};
    let (mut from, mut to) = (from.as_ptr().cast::<f32>(), to.as_mut_ptr().cast::<f32>());
    let mut left = count;
    for half in bits.iter().flat_map(|group| group.to_le_bytes()) {
        let count = half.count_ones() as usize;
        // SAFETY: 8 entries are there to be read, and as many as are left to be written.
        unsafe {
            let packed = Eight::load(from).packed(u32::from(half));
            if left >= 8 {
                packed.store(to);
            } else {
                packed.store_set(to, (1 << count) - 1);
            }
            (from, to) = (from.add(8), to.add(count));
        }
        left -= count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_packs_the_same_entries() {
        let from: Vec<u32> = (0..8 * GROUP as u32).map(|i| i * 7 + 1).collect();
        for bits in [
            [0; 8],
            [u16::MAX; 8],
            [1, 0x8000, 0, u16::MAX, 0x5555, 0xfffe, 0x7fff, 0x0180],
            [0, 0, 0, 0, 0, 0, 0, 0x8000],
        ] {
            let is_chosen = |i: usize| bits[i / GROUP] >> (i % GROUP) & 1 == 1;
            let expected: Vec<u32> =
                (0..from.len()).filter(|&i| is_chosen(i)).map(|i| from[i]).collect();
            for isa in Isa::available() {
                // One more, which must stay as it is.
                let mut to = vec![0; expected.len() + 1];
                assert_eq!(isa.compress(&bits, &from, &mut to), expected.len(), "{isa}");
                assert_eq!(to.pop(), Some(0), "{isa}");
                assert_eq!(to, expected, "{isa}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "count <= to.len()")]
    fn without_room_nothing_is_written() {
        Isa::best().compress(&[3], &[0u32; GROUP], &mut [0; 1]);
    }
}
