//! The choice among the children of a node.

/// Children of a node.
pub(super) const WIDTH: usize = 16;

/// The largest number below 1.
pub(super) const BELOW_ONE: f32 = 1.0 - f32::EPSILON * 0.5;

/// The parts of children and the sums of 2, 4, 8 and 16 neighbours: a chain of sums would be slow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    parts: [f32; WIDTH],
    of_2: [f32; 8],
    of_4: [f32; 4],
    of_8: [f32; 2],
    all: f32,
}

#[inline(always)]
fn pairs<const N: usize, const HALF: usize>(of: &[f32; N]) -> [f32; HALF] {
    let mut sums = [0.0; HALF];
    for (sum, pair) in sums.iter_mut().zip(of.as_chunks::<2>().0) {
        *sum = pair[0] + pair[1];
    }
    sums
}

/// Returns the sum of all parts, with the bits of [`Sums`].
#[inline(always)]
pub(super) fn sum(parts: &[f32; WIDTH]) -> f32 {
    let of_8: [f32; 2] = pairs(&pairs::<8, 4>(&pairs::<WIDTH, 8>(parts)));
    of_8[0] + of_8[1]
}

impl Sums {
    /// Adds up parts, of which none is negative and at least one is more than 0.
    #[inline(always)]
    pub(super) fn new(parts: [f32; WIDTH]) -> Self {
        let of_2 = pairs(&parts);
        let of_4 = pairs(&of_2);
        let of_8 = pairs(&of_4);
        Self { parts, of_2, of_4, of_8, all: of_8[0] + of_8[1] }
    }

    /// Returns the chance of a child.
    #[inline(always)]
    pub(super) fn chance(&self, child: usize) -> f32 {
        self.parts[child] / self.all
    }

    /// Finds the child in whose interval `u` lies, if the intervals are as long as the parts. Returns
    /// its number, and `u` rescaled to be uniform in `[0, 1)` again. Its part is more than 0.
    #[inline(always)]
    pub(super) fn find(&self, u: f32) -> (usize, f32) {
        let mut x = u * self.all;
        let child = second(0, &self.of_8, &mut x);
        let child = second(2 * child, &self.of_4, &mut x);
        let child = second(2 * child, &self.of_2, &mut x);
        let child = second(2 * child, &self.parts, &mut x);
        (child, (x / self.parts[child]).clamp(0.0, BELOW_ONE))
    }
}

/// Returns which of two neighbours, the first of which is `first`, contains `x`, and makes `x`
/// relative to it. One of 0 contains nothing.
#[inline(always)]
fn second<const N: usize>(first: usize, of: &[f32; N], x: &mut f32) -> usize {
    let [a, b] = [of[first % N], of[(first + 1) % N]];
    let is_second = (*x >= a) & (b > 0.0);
    *x -= if is_second { a } else { 0.0 };
    first + usize::from(is_second)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    #[test]
    fn children_are_found_as_often_as_their_parts_say() {
        let mut rng = StdRng::seed_from_u64(4);
        for turn in 0..200 {
            let mut part = || {
                let size: f32 = rng.random_range(0.0..1.0);
                if rng.random_range(0..3) == 0 { 0.0 } else { size * [1.0, 1e-30][turn % 2] }
            };
            let mut parts: [f32; WIDTH] = std::array::from_fn(|_| part());
            parts[turn % WIDTH] += 1e-32;
            let sums = Sums::new(parts);
            assert_eq!(sum(&parts), sums.all);
            const COUNT: u16 = 4096;
            let (mut counts, mut last) = ([0.0; WIDTH], 0);
            for i in 0..COUNT {
                let (child, rest) = sums.find((f32::from(i) + 0.5) / f32::from(COUNT));
                assert!(parts[child] > 0.0 && (0.0..1.0).contains(&rest) && child >= last);
                counts[child] += 1.0;
                last = child;
            }
            let chances = (0..WIDTH).map(|child| sums.chance(child));
            assert!((chances.clone().sum::<f32>() - 1.0).abs() < 1e-5);
            for (count, chance) in counts.into_iter().zip(chances) {
                assert!((count - chance * f32::from(COUNT)).abs() < 1.1, "{count} {chance}");
            }
            for u in [0.0, BELOW_ONE] {
                let (child, rest) = sums.find(u);
                assert!(parts[child] > 0.0 && (0.0..1.0).contains(&rest), "{parts:?}");
            }
        }
    }
}
