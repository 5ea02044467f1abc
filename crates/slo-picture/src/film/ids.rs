//! Which ids the samples of a pixel saw, and how often.

/// For each id, the number of samples that saw it. It is a sum over samples, so it does not depend on
/// their order. A pixel has at most as many ids as samples, and takes 8 bytes for each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IdCounts(Vec<(u32, u32)>);

impl IdCounts {
    /// Adds samples that saw an id; `None` if there are too many.
    pub fn add(&mut self, id: u32, count: u32) -> Option<()> {
        match self.0.binary_search_by_key(&id, |entry| entry.0) {
            Ok(place) => self.0[place].1 = self.0[place].1.checked_add(count)?,
            Err(place) => {
                if self.0.is_empty() {
                    self.0.reserve_exact(1);
                }
                self.0.insert(place, (id, count));
            }
        }
        Some(())
    }

    /// Adds the samples of another; `None` if there are too many.
    pub fn add_all(&mut self, other: &Self) -> Option<()> {
        other.0.iter().try_for_each(|&(id, count)| self.add(id, count))
    }

    /// The ids in their order, each with the number of samples that saw it.
    pub fn entries(&self) -> &[(u32, u32)] {
        &self.0
    }

    /// The id that the most samples saw has rank 0. Of ids that are equal in this, the smallest comes
    /// first. `None` if there are fewer ids.
    pub fn ranked(&self, rank: usize) -> Option<(u32, u32)> {
        if self.0.len() <= 1 {
            return self.0.get(rank).copied();
        }
        let mut entries = self.0.clone();
        entries.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        entries.get(rank).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_samples_does_not_count() {
        let samples = [7, 3, 7, 9, 3, 7, 1];
        let of = |ids: &[u32]| {
            let mut counts = IdCounts::default();
            ids.iter().for_each(|&id| counts.add(id, 1).unwrap());
            counts
        };
        let whole = of(&samples);
        assert_eq!(whole.entries(), [(1, 1), (3, 2), (7, 3), (9, 1)]);
        for middle in 0..samples.len() {
            let (first, last) = samples.split_at(middle);
            let mut sum = of(last);
            sum.add_all(&of(first)).unwrap();
            assert_eq!(sum, whole);
        }
        let ranks = [0, 1, 2, 3, 4].map(|rank| whole.ranked(rank));
        assert_eq!(ranks, [Some((7, 3)), Some((3, 2)), Some((1, 1)), Some((9, 1)), None]);
    }

    #[test]
    fn more_samples_than_can_be_counted_are_refused() {
        let mut counts = IdCounts::default();
        counts.add(5, u32::MAX).unwrap();
        assert_eq!(counts.ranked(0), Some((5, u32::MAX)));
        assert_eq!(counts.add(5, 1), None);
    }
}
