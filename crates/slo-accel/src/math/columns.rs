//! Batches as structures of arrays: columns of fixed length, so that loops over them need no bounds
//! checks and become vector code.

use std::ops::Range;

use glam::Vec3;

/// Most entries of a batch: enough to hide latencies behind, few enough for the second-level cache.
/// No power of two: entry `i` of every column would lie in the same set of the first-level cache.
pub const BATCH: usize = 1008;

/// One number of every entry of a batch.
pub type Column<T> = [T; BATCH];

/// One vector of every entry of a batch.
#[derive(Clone, Debug)]
pub struct Vec3s {
    /// First components.
    pub x: Column<f32>,
    /// Second components.
    pub y: Column<f32>,
    /// Third components.
    pub z: Column<f32>,
}

impl Default for Vec3s {
    fn default() -> Self {
        Self { x: [0.0; BATCH], y: [0.0; BATCH], z: [0.0; BATCH] }
    }
}

impl Vec3s {
    /// The vector of entry `i`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Gives entry `i` a vector.
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (v.x, v.y, v.z);
    }

    /// Gives `N` entries from `start` on one vector; none where there are less.
    #[inline(always)]
    pub fn fill<const N: usize>(&mut self, start: usize, v: Vec3) {
        for (column, x) in [&mut self.x, &mut self.y, &mut self.z].into_iter().zip(v.to_array()) {
            if let Some(entries) = column[start..].first_chunk_mut::<N>() {
                *entries = [x; N];
            }
        }
    }

    /// Its three columns.
    pub fn columns(&self) -> [&Column<f32>; 3] {
        [&self.x, &self.y, &self.z]
    }
}

/// The entries of a batch of `len`, and as many more as fill a vector register: what is computed
/// for those is of no meaning and not looked at. The compiler sees that none is outside a column.
#[inline(always)]
pub fn lanes(len: usize) -> Range<usize> {
    0..len.next_multiple_of(16).min(BATCH)
}

/// Fetches something of an entry of a table for each index; beyond the table's end, of the last one.
/// An empty table has nothing to fetch.
#[inline(always)]
pub fn look_up<T: Copy, U>(
    table: &[T],
    index: &Column<u32>,
    len: usize,
    of: impl Fn(T) -> U,
    to: &mut Column<U>,
) {
    let Some(last) = table.len().checked_sub(1) else { return };
    for i in lanes(len) {
        to[i] = of(table[(index[i] as usize).min(last)]);
    }
}

/// Entries that [`look_up_each`] looks up together.
const TOGETHER: usize = 16;

/// Fetches an entry of each of several tables of one length for each index; beyond their end, the
/// last one. Neighbours mostly ask for the same entry, which is then looked up once.
#[inline(always)]
pub fn look_up_each<const N: usize>(
    tables: [&[f32]; N],
    index: &Column<u32>,
    len: usize,
    to: [&mut Column<f32>; N],
) {
    let Some(last) = tables.iter().map(|table| table.len()).min().and_then(|n| n.checked_sub(1))
    else {
        return;
    };
    let mut to = to.map(|column| column.as_chunks_mut::<TOGETHER>().0);
    let groups = index.as_chunks::<TOGETHER>().0.iter().take(len.div_ceil(TOGETHER));
    for (group, index) in groups.enumerate() {
        let differs = index.iter().fold(0, |all, i| all | (i ^ index[0]));
        if differs == 0 {
            let at = (index[0] as usize).min(last);
            for (table, to) in tables.iter().zip(&mut to) {
                to[group] = [table[at]; TOGETHER];
            }
        } else {
            for (table, to) in tables.iter().zip(&mut to) {
                for (to, &i) in to[group].iter_mut().zip(index) {
                    *to = table[(i as usize).min(last)];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_looked_up_within_their_ends() {
        let mut index = [0; BATCH];
        (index[0], index[1], index[2]) = (2, 0, 7);
        let mut to = [0.0; BATCH];
        look_up(&[1, 2, 4], &index, 3, f64::from, &mut to);
        assert_eq!(to[..3], [4.0, 1.0, 4.0]);
    }

    #[test]
    fn tables_are_looked_up_together_as_one_by_one() {
        let index = std::array::from_fn(|i| if i < 40 { 1 } else { i as u32 % 5 });
        let tables = [&[3.0, 5.0, 7.0][..], &[2.0, 4.0, 8.0]];
        let (mut a, mut b, mut one) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH]);
        look_up_each(tables, &index, 100, [&mut a, &mut b]);
        for (table, both) in tables.into_iter().zip([a, b]) {
            look_up(table, &index, 100, |x| x, &mut one);
            assert_eq!(both[..112], one[..112]);
            assert_eq!(both[112..], [0.0; BATCH - 112]);
        }
    }
}
