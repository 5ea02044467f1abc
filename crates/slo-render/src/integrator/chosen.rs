//! Selections of the entries of a batch.

use slo_accel::math::columns::{BATCH, Column, lanes};
use slo_accel::{GROUP, Isa, Lanewise, Word};

/// A selection of the entries of a batch.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    isa: Isa,
    /// 1 for each chosen entry, 0 for the others.
    flags: Column<u32>,
    /// The flags as bits.
    bits: [u16; BATCH / GROUP],
    count: usize,
}

impl Default for Chosen {
    fn default() -> Self {
        Self { isa: Isa::Portable, flags: [0; BATCH], bits: [0; BATCH / GROUP], count: 0 }
    }
}

impl Chosen {
    /// Chooses the entries `i < len` for which `is(i)` is true.
    #[inline(always)]
    pub(super) fn set(&mut self, isa: Isa, len: usize, is: impl Fn(usize) -> bool) {
        self.isa = isa;
        isa.run(Choose { len, is, to: self });
        self.count = self.bits.iter().map(|bits| bits.count_ones() as usize).sum();
    }

    /// Returns the number of chosen entries.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Returns the chosen entries in order.
    pub(super) fn entries(&self) -> impl Iterator<Item = usize> {
        (0..BATCH).filter(|i| self.flags[*i] != 0)
    }

    /// Returns the entries below `len` that were not chosen, in order.
    pub(super) fn others(&self, len: usize) -> impl Iterator<Item = usize> {
        let groups = self.bits.iter().enumerate().take(len.div_ceil(GROUP));
        groups.flat_map(move |(group, &bits)| {
            let start = group * GROUP;
            let mut left = !u32::from(bits) & ((1 << (len - start).min(GROUP)) - 1);
            std::iter::from_fn(move || {
                let first = (left != 0).then(|| start + left.trailing_zeros() as usize);
                left &= left.wrapping_sub(1);
                first
            })
        })
    }

    /// Copies the chosen entries of a column, in order, to a slice of as many entries. Entries
    /// beyond the end of the column count as not chosen.
    pub(super) fn copy<T: Word>(&self, from: &[T], to: &mut [T]) {
        self.isa.compress(&self.bits[..from.len().div_ceil(GROUP).min(self.bits.len())], from, to);
    }

    /// Appends the chosen entries of a column, in order, to a vector.
    pub(super) fn append<T: Word>(&self, from: &Column<T>, to: &mut Vec<T>) {
        let start = to.len();
        to.resize(start + self.count, from[0]);
        self.copy(from, &mut to[start..]);
    }
}

struct Choose<'a, F> {
    len: usize,
    is: F,
    to: &'a mut Chosen,
}

impl<F: Fn(usize) -> bool> Lanewise for Choose<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { len, is, to } = self;
        for i in lanes(len) {
            to.flags[i] = u32::from(is(i) & (i < len));
        }
        to.flags[lanes(len).end..].fill(0);
        for (bits, flags) in to.bits.iter_mut().zip(to.flags.as_chunks::<GROUP>().0) {
            *bits = (0..GROUP).fold(0, |bits, i| bits | (flags[i] << i)) as u16;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_entries_keep_their_order() {
        let mut chosen = Chosen::default();
        let column: Column<u32> = std::array::from_fn(|i| i as u32 * 10);
        chosen.set(Isa::best(), 100, |i| i % 7 == 3);
        let mut all = vec![1];
        chosen.append(&column, &mut all);
        assert_eq!(all[..4], [1, 30, 100, 170]);
        assert_eq!((chosen.len(), all.len()), (14, 15));
        let mut some = [0; 14];
        chosen.copy(&column, &mut some);
        assert_eq!(some, all[1..]);
        let others: Vec<usize> = chosen.others(20).collect();
        assert_eq!(others, (0..20).filter(|i| i % 7 != 3).collect::<Vec<_>>());
        chosen.set(Isa::best(), BATCH, |_| true);
        assert_eq!(chosen.others(BATCH).count(), 0);
        assert_eq!(chosen.len(), BATCH);
        chosen.set(Isa::best(), 17, |_| true);
        assert_eq!(chosen.len(), 17, "what stands behind the end is not chosen");
    }
}
