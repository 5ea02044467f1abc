//! A balanced kd-tree of points: finds the nearest ones.
//!
//! The two halves of a node hold as many points, so nodes need no pointers, and a leaf has 8 to 16
//! points, whose distances are one vector.

use glam::Vec3;
use rayon::prelude::*;
use slo_accel::math::Bounds;

/// Most points of a leaf.
const WIDE: usize = 16;

/// Most inner nodes on a way down.
const MOST_LEVELS: usize = 32;

/// Number of points from which a level is built by all threads.
const MANY: usize = 1 << 14;

#[derive(Clone, Copy, Debug)]
struct Split {
    at: f32,
    axis: u32,
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Leaf {
    at: [[f32; WIDE]; 3],
    /// Number of its first point, in the order of the tree.
    first: u32,
    len: u32,
}

/// Points in a tree.
#[derive(Clone, Debug, Default)]
pub(super) struct KdTree {
    /// Inner nodes, level by level: the children of `i` are `2 i + 1` and `2 i + 2`.
    splits: Vec<Split>,
    /// From left to right.
    leaves: Vec<Leaf>,
}

/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    /// The middle.
    pub point: Vec3,
    /// Distances along this vector count more, by its length. A disc is flat along its normal.
    pub flat: Vec3,
    /// Square of the distance below which points are found.
    pub square: f32,
}

impl KdTree {
    /// Builds a tree. Returns it with the numbers of the points in the order of the tree. Points that
    /// are equal stay in their order.
    pub(super) fn new(points: &[Vec3]) -> (Self, Vec<u32>) {
        let mut all: Vec<(Vec3, u32)> = points.iter().copied().zip(0..).collect();
        let mut levels = 0;
        while all.len().div_ceil(1 << levels) > WIDE {
            levels += 1;
        }
        let mut splits = Vec::with_capacity((1 << levels) - 1);
        let mut parts: Vec<&mut [(Vec3, u32)]> = vec![&mut all];
        for _ in 0..levels {
            let split = |part: &mut [(Vec3, u32)]| halve(part);
            let found: Vec<_> = if parts.iter().map(|part| part.len()).sum::<usize>() >= MANY {
                parts.par_iter_mut().map(|part| split(part)).collect()
            } else {
                parts.iter_mut().map(|part| split(part)).collect()
            };
            splits.extend(found);
            parts = parts
                .into_iter()
                .flat_map(|part| {
                    let (low, high) = part.split_at_mut(part.len() / 2);
                    [low, high]
                })
                .collect();
        }
        let mut first = 0;
        let leaves = parts
            .iter()
            .map(|part| {
                let at = |axis: usize, i: usize| part.get(i).map_or(f32::INFINITY, |p| p.0[axis]);
                let at = std::array::from_fn(|axis| std::array::from_fn(|i| at(axis, i)));
                let leaf = Leaf { at, first, len: part.len() as u32 };
                first += part.len() as u32;
                leaf
            })
            .collect();
        drop(parts);
        (Self { splits, leaves }, all.into_iter().map(|(_, number)| number).collect())
    }

    /// Calls `found` with each point nearer than asked, by its number in the order of the tree, with
    /// the square of its distance. `found` returns the square below which points are found from
    /// then on. The order is the same for all instruction sets.
    #[inline(always)]
    pub(super) fn near(&self, around: Around, mut found: impl FnMut(u32, f32) -> f32) {
        let Around { point, flat, mut square } = around;
        let mut stack = [(0u32, [0.0f32; 3]); MOST_LEVELS + 1];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (mut node, off) = stack[waiting];
            if off[0] + off[1] + off[2] >= square {
                continue;
            }
            while let Some(split) = self.splits.get(node as usize) {
                let axis = (split.axis as usize).min(2);
                let way = point[axis] - split.at;
                let (near, far) = if way < 0.0 { (1, 2) } else { (2, 1) };
                let mut beyond = off;
                beyond[axis] = way * way;
                if beyond[0] + beyond[1] + beyond[2] < square {
                    stack[waiting] = (2 * node + far, beyond);
                    waiting += 1;
                }
                node = 2 * node + near;
            }
            let Some(leaf) = self.leaves.get(node as usize - self.splits.len()) else { continue };
            let squares = leaf.squares(point, flat);
            for (i, &distance) in squares.iter().enumerate().take(leaf.len as usize) {
                if distance < square {
                    square = found(leaf.first + i as u32, distance);
                }
            }
        }
    }

    /// Memory in bytes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.splits[..]) + size_of_val(&self.leaves[..])
    }
}

impl Leaf {
    #[inline(always)]
    fn squares(&self, point: Vec3, flat: Vec3) -> [f32; WIDE] {
        let [x, y, z] = &self.at;
        std::array::from_fn(|i| {
            let [dx, dy, dz] = [x[i] - point.x, y[i] - point.y, z[i] - point.z];
            let along = dx * flat.x + dy * flat.y + dz * flat.z;
            dx * dx + dy * dy + dz * dz + along * along
        })
    }
}

/// Sorts points into two halves along the axis in which they spread most.
fn halve(points: &mut [(Vec3, u32)]) -> Split {
    let bounds = Bounds::of_points(points.iter().map(|point| point.0));
    let size = bounds.max - bounds.min;
    let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
    let middle = points.len() / 2;
    if middle >= points.len() {
        return Split { at: 0.0, axis: 0 };
    }
    let order =
        |a: &(Vec3, u32), b: &(Vec3, u32)| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1));
    let (_, at, _) = points.select_nth_unstable_by(middle, order);
    Split { at: at.0[axis], axis: axis as u32 }
}

/// The nearest of some points, at most so many.
#[derive(Debug, Default)]
pub struct Nearest {
    /// Squares of distances in the upper half, numbers in the lower one: they sort as the distances.
    found: Vec<u64>,
    most: usize,
    square: f32,
}

impl Nearest {
    /// Begins to look for at most so many points, at least one.
    pub fn restart(&mut self, most: usize, square: f32) {
        self.found.clear();
        (self.most, self.square) = (most.max(1), square);
    }

    /// Adds a point. Returns the square of the distance below which points count from now on.
    #[inline(always)]
    pub fn add(&mut self, number: u32, square: f32) -> f32 {
        self.found.push(u64::from(square.to_bits()) << 32 | u64::from(number));
        if self.found.len() >= self.most + self.most / 2 + WIDE {
            self.cut();
        }
        self.square
    }

    /// Keeps no more than asked for.
    pub fn cut(&mut self) {
        if self.found.len() >= self.most {
            let (_, last, _) = self.found.select_nth_unstable(self.most - 1);
            self.square = distance(*last);
            self.found.truncate(self.most);
        }
    }

    /// The points that were found, with the squares of their distances: at most so many, the farthest
    /// one last if there are as many as that.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (u32, f32)> {
        self.found.iter().map(|&word| (word as u32, distance(word)))
    }

    /// Square of the distance below which points count: that of the farthest one if there are as many
    /// as asked for.
    #[inline(always)]
    pub fn square(&self) -> f32 {
        self.square
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.found.len()
    }

    /// Whether there are as many as asked for.
    pub fn is_full(&self) -> bool {
        self.found.len() == self.most
    }
}

#[inline(always)]
fn distance(word: u64) -> f32 {
    f32::from_bits((word >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use slo_accel::{Isa, Lanewise};

    use super::*;

    struct Find<'a>(&'a KdTree, Around, usize);

    impl Lanewise for Find<'_> {
        type Output = Vec<(u32, f32)>;

        #[inline(always)]
        fn run(self) -> Vec<(u32, f32)> {
            let mut nearest = Nearest::default();
            nearest.restart(self.2, self.1.square);
            self.0.near(self.1, |number, square| nearest.add(number, square));
            nearest.cut();
            nearest.iter().collect()
        }
    }

    #[test]
    fn the_nearest_are_found() {
        let mut rng = StdRng::seed_from_u64(3);
        for count in [0usize, 1, 15, 16, 17, 31, 33, 100, 5000, 40_000] {
            let place = |rng: &mut StdRng| {
                let size = if rng.random_bool(0.5) { 0.02 } else { 1.0 };
                Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
            };
            let points: Vec<Vec3> = (0..count).map(|_| place(&mut rng)).collect();
            let (tree, order) = KdTree::new(&points);
            assert_eq!(order.len(), count);
            assert!(tree.leaves.iter().all(|leaf| leaf.len as usize <= WIDE));
            for most in [1, 2, 50, 300] {
                let point = place(&mut rng);
                let flat = if most == 50 { Vec3::Z * 3.0 } else { Vec3::ZERO };
                let around = Around { point, flat, square: 0.5 };
                let found = Isa::Portable.run(Find(&tree, around, most));
                for isa in Isa::available() {
                    assert_eq!(isa.run(Find(&tree, around, most)), found, "{isa}");
                }
                let mut found: Vec<u32> =
                    found.iter().map(|(number, _)| order[*number as usize]).collect();
                let square = |p: &Vec3| {
                    let way = *p - point;
                    way.length_squared() + way.dot(flat) * way.dot(flat)
                };
                let mut expected: Vec<u32> =
                    (0..count as u32).filter(|i| square(&points[*i as usize]) < 0.5).collect();
                expected.sort_by(|a, b| {
                    square(&points[*a as usize]).total_cmp(&square(&points[*b as usize]))
                });
                expected.truncate(most);
                found.sort_unstable();
                expected.sort_unstable();
                assert_eq!(found, expected, "{most} of {count}");
            }
        }
    }
}
