//! Batches as structures of arrays: columns of fixed length, so that loops over them need no bounds
//! checks and become vector code.

use std::ops::Range;

use glam::Vec3;

/// Entries of a column: enough to hide latencies, few enough for the second-level cache. The number
/// is no power of two, since entries `i` of all columns would then share a set of the first-level
/// cache.
pub const BATCH: usize = 1008;

/// One value for each entry of a batch.
pub type Column<T> = [T; BATCH];

/// One vector for each entry of a batch, by components.
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

    /// Sets the vector of entry `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (v.x, v.y, v.z);
    }

    /// Sets the vector of entry `i` if `condition` holds, by [`select`].
    #[inline(always)]
    pub fn set_if(&mut self, i: usize, condition: bool, v: Vec3) {
        self.x[i] = select(condition, v.x, self.x[i]);
        self.y[i] = select(condition, v.y, self.y[i]);
        self.z[i] = select(condition, v.z, self.z[i]);
    }

    /// Sets `N` entries from `start` on to one vector; none of them if fewer are left.
    ///
    /// # Panics
    /// If `start` is beyond the last entry.
    #[inline(always)]
    pub fn fill<const N: usize>(&mut self, start: usize, v: Vec3) {
        for (column, x) in [&mut self.x, &mut self.y, &mut self.z].into_iter().zip(v.to_array()) {
            if let Some(entries) = column[start..].first_chunk_mut::<N>() {
                *entries = [x; N];
            }
        }
    }

    /// The columns of the three components.
    #[inline]
    pub fn columns(&self) -> [&Column<f32>; 3] {
        [&self.x, &self.y, &self.z]
    }
}

/// The entries of a batch of `len`, rounded up to whole vector registers: results beyond `len` mean
/// nothing. The compiler sees that all lie inside a column.
#[inline(always)]
pub fn lanes(len: usize) -> Range<usize> {
    0..len.next_multiple_of(16).min(BATCH)
}

/// `a` if `condition` holds, otherwise `b`. Unlike an `if`, which the compiler may turn into a jump
/// over all that only `a` needs, it never keeps a loop from becoming SIMD code.
#[inline(always)]
pub fn select<T>(condition: bool, a: T, b: T) -> T {
    std::hint::select_unpredictable(condition, a, b)
}

/// Writes `of` the table's entry for each index to `to`; for an index beyond the table, of its last
/// entry. Leaves `to` as it is if the table is empty.
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

/// Writes the entry of each of several tables of one length for each index to the table's column in
/// `to`; for an index beyond the tables, their last entry. Leaves `to` as it is if a table is
/// empty. Neighbouring indices are mostly the same, and then looked up once.
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
