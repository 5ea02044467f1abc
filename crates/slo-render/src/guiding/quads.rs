//! Quadtrees over the square of directions: sums while they are learned, and shares for use.

use std::f32::consts::FRAC_1_PI;

/// Most levels of a quadtree. Packed directions have 16 bits an axis.
const LEVELS: u32 = 12;

/// A quarter is divided if it holds more than one in so many parts of all light.
const DIVIDED: u64 = 100;

/// Shares of the quarters of a node sum to this.
const WHOLE: u16 = u16::MAX;

/// A node for use. Quarters are numbered by the next bit of the height, and then of the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Quad {
    /// Share of each quarter in the light of the node, of [`WHOLE`].
    pub(super) share: [u16; 4],
    /// The node that divides each quarter, counted from the root; 0: none.
    pub(super) child: [u16; 4],
}

/// Returns the number of the quarter that a packed direction is in, `level` levels below the root.
#[inline(always)]
fn quarter(packed: u32, level: u32) -> usize {
    ((packed >> (30 - level) & 2) | (packed >> (15 - level) & 1)) as usize
}

/// Returns the density of a packed direction, per solid angle.
#[inline(always)]
pub(super) fn density(tree: &[Quad], packed: u32) -> f32 {
    let mut density = 0.25 * FRAC_1_PI;
    let (mut node, mut level) = (0, 0);
    loop {
        let Some(quad) = tree.get(node) else { return density };
        let quarter = quarter(packed, level);
        density *= f32::from(quad.share[quarter]) * (4.0 / 65535.0);
        node = usize::from(quad.child[quarter]);
        level += 1;
        if node == 0 || level >= LEVELS {
            return density;
        }
    }
}

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Chooses the half that `u` falls into: the first, of size `first` in [0, 1], or the second.
/// Returns its number, and the place of `u` within it.
#[inline(always)]
fn half(u: f32, first: f32) -> (usize, f32) {
    if u < first {
        (0, (u / first).min(BELOW_ONE))
    } else {
        (1, ((u - first) / (1.0 - first)).min(BELOW_ONE))
    }
}

/// Returns a point of the square, distributed by the tree, for a point of the unit square.
///
/// Strata are kept: by the first coordinate the half of the height is chosen, then by the second that
/// of the angle.
#[inline(always)]
pub(super) fn sample(tree: &[Quad], [mut u, mut v]: [f32; 2]) -> [f32; 2] {
    let (mut at, mut size) = ([0.0f32; 2], 1.0f32);
    let (mut node, mut level) = (0, 0);
    while let Some(quad) = tree.get(node) {
        let share = quad.share.map(f32::from);
        let low = share[0] + share[1];
        let (height, within) = half(u, low / f32::from(WHOLE));
        u = within;
        let [first, second] = [share[2 * height], share[2 * height + 1]];
        let (angle, within) = half(v, first / (first + second));
        v = within;
        size *= 0.5;
        at = [at[0] + height as f32 * size, at[1] + angle as f32 * size];
        node = usize::from(quad.child[2 * height + angle]);
        level += 1;
        if node == 0 || level >= LEVELS {
            break;
        }
    }
    [at[0] + u * size, at[1] + v * size]
}

/// A node of sums.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Light from each quarter.
    sum: [u64; 4],
    /// See [`Quad::child`].
    child: [u16; 4],
}

/// A quadtree of exact sums of light.
#[derive(Clone, Debug)]
pub(super) struct Tally(Vec<Sums>);

impl Default for Tally {
    fn default() -> Self {
        Self(vec![Sums::default()])
    }
}

impl Tally {
    /// Sum of all light.
    pub(super) fn total(&self) -> u64 {
        self.0[0].sum.iter().sum()
    }

    /// Adds light from a packed direction.
    pub(super) fn add(&mut self, packed: u32, value: u64) {
        let (mut node, mut level) = (0, 0);
        loop {
            let Some(sums) = self.0.get_mut(node) else { return };
            let quarter = quarter(packed, level);
            sums.sum[quarter] = sums.sum[quarter].saturating_add(value);
            node = usize::from(sums.child[quarter]);
            level += 1;
            if node == 0 {
                return;
            }
        }
    }

    /// Divides all sums by 2 to the power of `bits`.
    pub(super) fn weaken(&mut self, bits: u32) {
        for sums in &mut self.0 {
            sums.sum = sums.sum.map(|sum| sum >> bits);
        }
    }

    /// Divides quarters with much light, and joins those with little.
    pub(super) fn refine(&mut self) {
        let least = self.total() / DIVIDED;
        let old = std::mem::take(&mut self.0);
        let mut new = vec![Sums { sum: old[0].sum, child: [0; 4] }];
        // Nodes whose quarters are still to be divided: in the new tree, in the old one, levels.
        let mut open = vec![(0, Some(0usize), 1)];
        while let Some((node, before, level)) = open.pop() {
            for quarter in 0..4 {
                let sum = new[node].sum[quarter];
                if sum <= least || level >= LEVELS || new.len() > usize::from(u16::MAX) {
                    continue;
                }
                let child = before.map(|node| usize::from(old[node].child[quarter]));
                let child = child.filter(|&child| child != 0);
                let sum = child.map_or([sum / 4; 4], |child| old[child].sum);
                new[node].child[quarter] = new.len() as u16;
                open.push((new.len(), child, level + 1));
                new.push(Sums { sum, child: [0; 4] });
            }
        }
        self.0 = new;
    }

    /// Appends the tree to others, for use.
    pub(super) fn freeze(&self, to: &mut Vec<Quad>) {
        to.extend(self.0.iter().map(|sums| Quad { share: shares(sums.sum), child: sums.child }));
    }
}

/// Returns the shares of four sums, of [`WHOLE`].
fn shares(sum: [u64; 4]) -> [u16; 4] {
    let total: u128 = sum.iter().map(|&sum| u128::from(sum)).sum();
    if total == 0 {
        return [WHOLE / 4 + 1, WHOLE / 4 + 1, WHOLE / 4 + 1, WHOLE / 4];
    }
    let mut share = sum.map(|sum| (u128::from(sum) * u128::from(WHOLE) / total) as u16);
    let left = WHOLE - share.iter().sum::<u16>();
    let largest = (0..4).max_by_key(|&i| (sum[i], std::cmp::Reverse(i))).unwrap_or(0);
    share[largest] += left;
    share
}

#[cfg(test)]
pub(super) mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;
    use crate::guiding::direction::{direction, pack};

    /// A tree of random sums; one in four quarters is empty.
    pub(in crate::guiding) fn random(seed: u64) -> Vec<Quad> {
        let mut rng = StdRng::seed_from_u64(seed);
        let mut tally = Tally::default();
        for _ in 0..5 {
            let spots: Vec<[f32; 2]> = (0..4).map(|_| [rng.random(), rng.random()]).collect();
            for _ in 0..2000 {
                let [a, b] = spots[rng.random_range(0..4)];
                let size = rng.random_range(0.01..0.3f32);
                let at = [a + size * (rng.random::<f32>() - 0.5), b + size * rng.random::<f32>()];
                let at = at.map(|x| x.rem_euclid(1.0).min(BELOW_ONE));
                tally.add(pack(direction(at)), rng.random_range(1..1000));
            }
            tally.refine();
        }
        let mut tree = Vec::new();
        tally.freeze(&mut tree);
        tree
    }

    #[test]
    fn densities_integrate_to_one_and_samples_fit_them() {
        const SIDE: usize = 32;
        for seed in 0..4 {
            let tree = random(seed);
            assert!(tree.len() > 20, "{}", tree.len());
            // Exact integral over cells, by a fine grid.
            let mut cells = [0.0f64; SIDE * SIDE];
            let fine = 1024;
            for i in 0..fine {
                for j in 0..fine {
                    let packed = (i * (65536 / fine) + 3) << 16 | (j * (65536 / fine) + 5);
                    let part = f64::from(density(&tree, packed)) * 4.0 * std::f64::consts::PI;
                    let cell = (i as usize * SIDE / fine as usize) * SIDE
                        + j as usize * SIDE / fine as usize;
                    cells[cell] += part / f64::from(fine * fine);
                }
            }
            let integral: f64 = cells.iter().sum();
            assert!((integral - 1.0).abs() < 1e-3, "{integral}");
            let mut rng = StdRng::seed_from_u64(seed + 100);
            let count = 400_000;
            let mut found = [0u32; SIDE * SIDE];
            for _ in 0..count {
                let at = sample(&tree, [rng.random(), rng.random()]);
                assert!(at.iter().all(|x| (0.0..1.0).contains(x)), "{at:?}");
                let packed = pack(direction(at));
                assert!(density(&tree, packed) > 0.0);
                found[(packed >> 27) as usize * SIDE + (packed >> 11 & 31) as usize] += 1;
            }
            let (mut chi2, mut freedom) = (0.0, -1.0);
            for (cell, found) in cells.iter().zip(found) {
                let expected = cell * f64::from(count);
                if expected >= 5.0 {
                    let apart = f64::from(found) - expected;
                    chi2 += apart * apart / expected;
                    freedom += 1.0;
                } else {
                    assert!(f64::from(found) < expected + 25.0);
                }
            }
            let deviation = (chi2 - freedom) / f64::sqrt(2.0 * freedom);
            assert!(deviation < 5.0, "{deviation}, {freedom}");
        }
    }

    #[test]
    fn even_numbers_give_even_samples() {
        let tree = random(9);
        // Of a grid of numbers, each cell of the tree's first level gets its share.
        let mut found = [0u32; 4];
        for i in 0..256 {
            for j in 0..256 {
                let u = [(i as f32 + 0.5) / 256.0, (j as f32 + 0.5) / 256.0];
                let [height, angle] = sample(&tree, u);
                found[2 * usize::from(height >= 0.5) + usize::from(angle >= 0.5)] += 1;
            }
        }
        for (found, share) in found.iter().zip(tree[0].share) {
            assert!(found.abs_diff(u32::from(share)) < 600, "{found} {share}");
        }
    }

    #[test]
    fn what_is_not_divided_stays_whole() {
        let mut tally = Tally::default();
        tally.add(0, 1000);
        tally.add(u32::MAX, 5);
        tally.refine();
        let mut tree = Vec::new();
        tally.freeze(&mut tree);
        // The lit quarter is divided until its parts are below one per cent.
        assert_eq!(tree.len(), 1 + 1 + 4 + 16 + 64);
        assert_eq!(tree[0].child[3], 0, "half a per cent of the light");
        assert_eq!(
            tree.iter().map(|quad| quad.share.iter().map(|s| u32::from(*s)).sum::<u32>()).max(),
            Some(65535)
        );
    }
}
