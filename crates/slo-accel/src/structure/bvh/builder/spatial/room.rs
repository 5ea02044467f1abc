//! Room for the references that cuts add.

use crate::structure::bvh::builder::boxes::Reference;

/// The references of a subtree, followed by room for more.
pub(super) struct Room<'a> {
    /// Index of the first slot among all.
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

    /// The rooms of the first `middle` references and of the others, each with its share of the
    /// spare slots.
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
