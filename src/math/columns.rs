//! Batches as structures of arrays: columns of fixed length, so that loops over them need no bounds
//! checks and become vector code.

use std::ops::Range;

use glam::Vec3;

/// Most entries of a batch: enough to hide latencies behind, few enough for the second-level cache.
/// No power of two: entry `i` of every column would lie in the same set of the first-level cache.
pub(crate) const BATCH: usize = 1008;

/// One number of every entry of a batch.
pub(crate) type Column<T> = [T; BATCH];

/// One vector of every entry of a batch.
#[derive(Clone, Debug)]
pub(crate) struct Vec3s {
    pub(crate) x: Column<f32>,
    pub(crate) y: Column<f32>,
    pub(crate) z: Column<f32>,
}

impl Default for Vec3s {
    fn default() -> Self {
        Self { x: [0.0; BATCH], y: [0.0; BATCH], z: [0.0; BATCH] }
    }
}

impl Vec3s {
    /// The vector of entry `i`.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Gives entry `i` a vector.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, v: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (v.x, v.y, v.z);
    }

    /// Its three columns.
    pub(crate) fn columns(&self) -> [&Column<f32>; 3] {
        [&self.x, &self.y, &self.z]
    }
}

/// The entries of a batch of `len`, and as many more as fill a vector register: what is computed
/// for those is of no meaning and not looked at. The compiler sees that none is outside a column.
#[inline(always)]
pub(crate) fn lanes(len: usize) -> Range<usize> {
    0..len.next_multiple_of(16).min(BATCH)
}

/// Entries of a batch, by number, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chosen {
    numbers: Vec<u16>,
}

impl Chosen {
    /// The entries below `len` that `is` says yes to.
    pub(crate) fn set(&mut self, len: usize, is: impl Fn(usize) -> bool) {
        self.numbers.resize(BATCH, 0);
        let mut count = 0;
        for i in 0..len.min(BATCH) {
            // Written in any case, kept by counting: no branch to be guessed wrong.
            self.numbers[count] = i as u16;
            count += usize::from(is(i));
        }
        self.numbers.truncate(count);
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Copies the chosen entries of a column to a slice of their number.
    #[inline(always)]
    pub(crate) fn copy<T: Copy>(&self, from: &Column<T>, to: &mut [T]) {
        for (to, &i) in to.iter_mut().zip(&self.numbers) {
            *to = from[usize::from(i).min(BATCH - 1)];
        }
    }

    /// Adds the chosen entries of a column to the end of a vector.
    #[inline(always)]
    pub(crate) fn append<T: Copy>(&self, from: &Column<T>, to: &mut Vec<T>) {
        let start = to.len();
        to.resize(start + self.numbers.len(), from[0]);
        self.copy(from, &mut to[start..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_entries_keep_their_order() {
        let mut chosen = Chosen::default();
        let column: Column<u32> = std::array::from_fn(|i| i as u32 * 10);
        chosen.set(100, |i| i % 7 == 3);
        let mut all = vec![1];
        chosen.append(&column, &mut all);
        assert_eq!(all[..4], [1, 30, 100, 170]);
        assert_eq!((chosen.len(), all.len()), (14, 15));
        let mut some = [0; 14];
        chosen.copy(&column, &mut some);
        assert_eq!(some, all[1..]);
        chosen.set(BATCH, |_| true);
        assert_eq!(chosen.len(), BATCH);
    }
}
