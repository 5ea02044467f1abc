//! Room for the references that cuts add.

use crate::structure::bvh::builder::boxes::Reference;

/// The references of a subtree, and room for more behind them.
pub(super) struct Room<'a> {
    /// Where the slots begin among all.
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) slots: &'a mut [Reference],
}

impl<'a> Room<'a> {
    pub(super) fn spare(&self) -> usize {
        self.slots.len() - self.count
    }

    pub(super) fn references(&self) -> &[Reference] {
        &self.slots[..self.count]
    }

    /// The rooms of the first `middle` references and of the others, with their shares of what is
    /// spare.
    pub(super) fn split(self, middle: usize) -> [Self; 2] {
        let Self { first, count, slots } = self;
        let spare = slots.len() - count;
        let begin = middle + (spare as u64 * middle as u64 / count as u64) as usize;
        slots.copy_within(middle..count, begin);
        let (left, right) = slots.split_at_mut(begin);
        [
            Room { first, count: middle, slots: left },
            Room { first: first + begin, count: count - middle, slots: right },
        ]
    }
}
