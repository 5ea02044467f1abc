//! Counters of traversals, which cost nothing where nothing is counted.

use std::ops::AddAssign;

/// What a traversal reports of its work. `()` ignores all of it and costs nothing.
pub trait Counting {
    /// A node or a cell was visited: taken off the stack, or entered.
    #[inline(always)]
    fn step(&mut self) {}

    /// This many boxes were tested.
    #[inline(always)]
    fn boxes(&mut self, count: u64) {
        let _ = count;
    }

    /// A leaf or a cell with this many objects was entered.
    #[inline(always)]
    fn leaf(&mut self, objects: usize) {
        let _ = objects;
    }

    /// An object was tested.
    #[inline(always)]
    fn test(&mut self) {}

    /// An object was not tested since the same ray has met it before.
    #[inline(always)]
    fn mailbox_hit(&mut self) {}

    /// The traversal started again.
    #[inline(always)]
    fn restart(&mut self) {}
}

impl Counting for () {}

/// Numbers of operations, of one ray or of many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Nodes and cells visited, leaves included.
    pub steps: u64,
    /// Boxes tested.
    pub boxes: u64,
    /// Objects tested.
    pub tests: u64,
    /// Leaves or cells entered.
    pub leaves: u64,
    /// Empty ones among them.
    pub empty_leaves: u64,
    /// Tests that mailboxes saved.
    pub mailbox_hits: u64,
    /// Restarts.
    pub restarts: u64,
}

impl Counts {
    /// Names of the counters, in the order of [`numbers`](Self::numbers).
    pub const NAMES: [&'static str; 7] =
        ["steps", "boxes", "tests", "leaves", "empty_leaves", "mailbox_hits", "restarts"];

    /// The counters, in the order of [`NAMES`](Self::NAMES).
    pub fn numbers(&self) -> [u64; 7] {
        let Self { steps, boxes, tests, leaves, empty_leaves, mailbox_hits, restarts } = *self;
        [steps, boxes, tests, leaves, empty_leaves, mailbox_hits, restarts]
    }

    /// The larger of both, for each counter.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            steps: self.steps.max(other.steps),
            boxes: self.boxes.max(other.boxes),
            tests: self.tests.max(other.tests),
            leaves: self.leaves.max(other.leaves),
            empty_leaves: self.empty_leaves.max(other.empty_leaves),
            mailbox_hits: self.mailbox_hits.max(other.mailbox_hits),
            restarts: self.restarts.max(other.restarts),
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.steps += other.steps;
        self.boxes += other.boxes;
        self.tests += other.tests;
        self.leaves += other.leaves;
        self.empty_leaves += other.empty_leaves;
        self.mailbox_hits += other.mailbox_hits;
        self.restarts += other.restarts;
    }
}

impl Counting for Counts {
    fn step(&mut self) {
        self.steps += 1;
    }

    fn boxes(&mut self, count: u64) {
        self.boxes += count;
    }

    fn leaf(&mut self, objects: usize) {
        self.leaves += 1;
        self.empty_leaves += u64::from(objects == 0);
    }

    fn test(&mut self) {
        self.tests += 1;
    }

    fn mailbox_hit(&mut self) {
        self.mailbox_hits += 1;
    }

    fn restart(&mut self) {
        self.restarts += 1;
    }
}

/// Counts of many rays: integer sums and maxima, so their order does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Number of rays.
    pub rays: u64,
    /// Rays that hit anything.
    pub hits: u64,
    /// Sums over all rays.
    pub sum: Counts,
    /// The highest of a single ray, for each counter.
    pub highest: Counts,
    /// The sum of the squares of the numbers of leaves.
    pub squared_leaves: u128,
}

impl Totals {
    /// Adds a ray.
    pub fn add(&mut self, counts: Counts, hits: bool) {
        self.rays += 1;
        self.hits += u64::from(hits);
        self.sum += counts;
        self.highest = self.highest.max(counts);
        self.squared_leaves += u128::from(counts.leaves).pow(2);
    }

    /// Leaf count variability: the standard deviation of the number of leaves that a ray enters; 0 without
    /// rays. Source: Aila, Karras, Laine, *On Quality Metrics of Bounding Volume Hierarchies*, HPG 2013.
    pub fn leaf_count_variability(&self) -> f64 {
        let rays = self.rays.max(1) as f64;
        let mean = self.sum.leaves as f64 / rays;
        (self.squared_leaves as f64 / rays - mean * mean).max(0.0).sqrt()
    }
}

impl AddAssign for Totals {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.sum += other.sum;
        self.highest = self.highest.max(other.highest);
        self.squared_leaves += other.squared_leaves;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaf_count_variability_is_a_standard_deviation() {
        let mut totals = Totals::default();
        assert_eq!(totals.leaf_count_variability(), 0.0);
        for leaves in [2, 4, 4, 4, 5, 5] {
            totals.add(Counts { leaves, ..Counts::default() }, false);
        }
        let mut others = Totals::default();
        for leaves in [7, 9] {
            others.add(Counts { leaves, ..Counts::default() }, false);
        }
        totals += others;
        assert_eq!(totals.leaf_count_variability(), 2.0);
    }
}
