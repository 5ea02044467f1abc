//! A tree over boxes, which lists the rays that enter each: the upper level of a two-level
//! structure.

use glam::Vec3;

use crate::isa::compress::GROUP;
use crate::isa::{Isa, Lanewise};
use crate::math::{Bounds, rounding::gamma};
use crate::rays::{LANES, Rays};

/// A binary tree over boxes, split at the median of the centres along the longest axis.
///
/// ```
/// use slo_accel::{BoxScratch, BoxTree, Isa, Rays, glam::Vec3, math::Bounds};
///
/// let unit = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
/// let next = Bounds { min: Vec3::X * 2.0, max: Vec3::X * 2.0 + Vec3::ONE };
/// let tree = BoxTree::new(&[unit, next]);
/// let mut rays = Rays::with_capacity(1);
/// rays.push(Vec3::new(0.5, 0.5, -1.0), Vec3::Z, f32::INFINITY);
/// let mut reach = [-1.0; 16];
/// reach[0] = f32::INFINITY;
/// let mut entering = [vec![], vec![]];
/// tree.gather(Isa::best(), &rays, &reach, &mut entering, &mut BoxScratch::default());
/// assert_eq!(entering, [vec![0], vec![]]);
/// ```
#[derive(Debug, Default)]
pub struct BoxTree {
    /// Children of node `i` are `i + 1` and `second`; a leaf holds one box.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Inner node: index of the second child. Leaf: number of the box.
    index: u32,
    is_leaf: bool,
}

/// The median split halves the boxes, so 2^32 boxes give at most 33 levels.
const MAX_DEPTH: usize = 40;

impl BoxTree {
    /// Builds the tree. The number of a box is its index in `boxes`.
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self::default();
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        if !order.is_empty() {
            tree.add(boxes, &mut order);
        }
        tree
    }

    fn add(&mut self, boxes: &[Bounds], order: &mut [u32]) {
        let bounds = order.iter().fold(Bounds::EMPTY, |all, &i| all.union(boxes[i as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, index: order[0], is_leaf: order.len() == 1 });
        if order.len() == 1 {
            return;
        }
        let axis = bounds.size().max_position();
        let center = |i: u32| boxes[i as usize].min[axis] + boxes[i as usize].max[axis];
        let middle = order.len() / 2;
        order.select_nth_unstable_by(middle, |&a, &b| {
            center(a).total_cmp(&center(b)).then(a.cmp(&b))
        });
        let (first, second) = order.split_at_mut(middle);
        self.add(boxes, first);
        self.nodes[node].index = self.nodes.len() as u32;
        self.add(boxes, second);
    }

    /// Writes to `entering[b]` the indices of the rays that enter box `b` at a `t` of at most their
    /// `reach`, in ascending order; what the lists held before is dropped. Rays that miss a box by
    /// a rounding error may be listed too. A ray whose reach is negative enters no box.
    ///
    /// `reach` has as many elements as the rays, rounded up to a multiple of [`LANES`]; those
    /// behind the last ray are negative.
    ///
    /// # Panics
    /// If `reach` is shorter, or `entering` has fewer lists than there are boxes.
    ///
    /// Source: T. Ize, *Robust BVH Ray Traversal*, JCGT 2013, for the test of a box.
    pub fn gather(
        &self,
        isa: Isa,
        rays: &Rays,
        reach: &[f32],
        entering: &mut [Vec<u32>],
        scratch: &mut BoxScratch,
    ) {
        entering.iter_mut().for_each(Vec::clear);
        let Some(root) = self.nodes.first() else { return };
        scratch.reset(rays.len());
        let BoxScratch { inverse, numbers, any, enters } = scratch;
        isa.run(Invert { rays, to: inverse });
        let around = Around { rays, inverse, reach };
        isa.run(Enter { around, bounds: &root.bounds, among: None, to: any });
        if self.nodes.len() < 2 * FEW {
            for leaf in self.nodes.iter().filter(|node| node.is_leaf) {
                isa.run(Enter { around, bounds: &leaf.bounds, among: Some(any), to: enters });
                let list = &mut entering[leaf.index as usize];
                let count = enters.iter().map(|group| group.count_ones() as usize).sum();
                list.resize(count, 0);
                isa.compress(enters, numbers, list);
            }
            return;
        }
        for i in (0..rays.len()).filter(|&i| any[i / GROUP] >> (i % GROUP) & 1 == 1) {
            self.visit(rays.origin(i), rays.direction(i), reach[i], |number| {
                entering[number as usize].push(i as u32);
            });
        }
    }

    /// Calls `visit` with the number of each box that the ray enters before `t_max`, and perhaps of
    /// some that it misses by a rounding error, in the order of the tree.
    #[inline]
    fn visit(&self, origin: Vec3, direction: Vec3, t_max: f32, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = direction.recip();
        let mut stack = [0u32; MAX_DEPTH];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let at = stack[len];
            let node = &self.nodes[at as usize];
            if !enters(&node.bounds, origin, inverse, t_max) {
                continue;
            }
            if node.is_leaf {
                visit(node.index);
            } else {
                stack[len] = node.index;
                stack[len + 1] = at + 1;
                len += 2;
            }
        }
    }
}

/// Fewer boxes are each tested for all rays at once, without the tree.
const FEW: usize = 16;

/// Working memory of [`BoxTree::gather`], one for each thread. It holds nothing between calls.
#[derive(Debug, Default)]
pub struct BoxScratch {
    /// 1 / direction of each ray.
    inverse: [Vec<f32>; 3],
    /// 0, 1, 2, and so on.
    numbers: Vec<u32>,
    /// A bit for each ray: whether it enters the box about all boxes.
    any: Vec<u16>,
    /// A bit for each ray: whether it enters one box.
    enters: Vec<u16>,
}

impl BoxScratch {
    fn reset(&mut self, len: usize) {
        const { assert!(GROUP == LANES) };
        let groups = len.div_ceil(GROUP);
        let known = self.numbers.len() as u32;
        self.numbers.extend(known..(groups * GROUP) as u32);
        self.any.resize(groups, 0);
        self.enters.resize(groups, 0);
        self.inverse.iter_mut().for_each(|column| column.resize(groups * GROUP, 0.0));
    }
}

struct Invert<'a> {
    rays: &'a Rays,
    to: &'a mut [Vec<f32>; 3],
}

impl Lanewise for Invert<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (from, to) in self.rays.direction.iter().zip(self.to) {
            for (to, x) in to.iter_mut().zip(from) {
                *to = 1.0 / x;
            }
        }
    }
}

/// Rays that may enter boxes, in columns.
#[derive(Clone, Copy)]
struct Around<'a> {
    rays: &'a Rays,
    inverse: &'a [Vec<f32>; 3],
    reach: &'a [f32],
}

/// [`enters`] for all rays of the groups that have any bit of `among`.
struct Enter<'a> {
    around: Around<'a>,
    bounds: &'a Bounds,
    among: Option<&'a [u16]>,
    to: &'a mut [u16],
}

impl Lanewise for Enter<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Around { rays, inverse, reach } = self.around;
        for (group, to) in self.to.iter_mut().enumerate() {
            *to = 0;
            if self.among.is_some_and(|among| among[group] == 0) {
                continue;
            }
            let of = |column: &'_ [f32]| -> [f32; GROUP] { column.as_chunks().0[group] };
            let [ox, oy, oz] = [of(&rays.origin[0]), of(&rays.origin[1]), of(&rays.origin[2])];
            let [ix, iy, iz] = [of(&inverse[0]), of(&inverse[1]), of(&inverse[2])];
            let reach = of(reach);
            let mut flags = [0u32; GROUP];
            for i in 0..GROUP {
                let origin = Vec3::new(ox[i], oy[i], oz[i]);
                let inverse = Vec3::new(ix[i], iy[i], iz[i]);
                let enters = enters(self.bounds, origin, inverse, reach[i]);
                flags[i] = u32::from((reach[i] >= 0.0) & enters);
            }
            *to = (0..GROUP).fold(0, |bits, i| bits | (flags[i] << i)) as u16;
        }
    }
}

/// Slab test that errs on the side of entering.
///
/// Source: T. Ize, "Robust BVH Ray Traversal" (JCGT 2013): the far distances are enlarged by the
/// error of the near ones.
#[inline(always)]
fn enters(bounds: &Bounds, origin: Vec3, inverse: Vec3, t_max: f32) -> bool {
    const ENLARGE: f32 = 1.0 + 2.0 * gamma(3);
    let (mut near, mut far) = (0.0f32, t_max);
    for axis in 0..3 {
        let a = (bounds.min[axis] - origin[axis]) * inverse[axis];
        let b = (bounds.max[axis] - origin[axis]) * inverse[axis];
        // A ray inside a slab's plane gives 0 * infinity: that slab excludes nothing.
        let counts = !(a.is_nan() || b.is_nan());
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        near = if counts && low > near { low } else { near };
        let high = high * ENLARGE;
        far = if counts && high < far { high } else { far };
    }
    near <= far
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn random_box(rng: &mut StdRng) -> Bounds {
        let mut corner = || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-5.0..5.0)));
        Bounds::of_points([corner(), corner() * 0.2])
    }

    #[test]
    fn finds_the_same_boxes_as_a_list() {
        let mut rng = StdRng::seed_from_u64(1);
        for n in [0, 1, 2, 3, 17, 100] {
            let boxes: Vec<_> = (0..n).map(|_| random_box(&mut rng)).collect();
            let tree = BoxTree::new(&boxes);
            for _ in 0..200 {
                let mut v =
                    || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-6.0f32..6.0)));
                let (origin, mut direction) = (v(), v());
                if direction.x > 0.0 {
                    direction.y = 0.0;
                }
                let mut found = Vec::new();
                tree.visit(origin, direction, 1.5, |i| found.push(i));
                found.sort_unstable();
                let expected: Vec<_> = (0..n)
                    .filter(|&i| enters(&boxes[i as usize], origin, direction.recip(), 1.5))
                    .collect();
                assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn batches_enter_the_same_boxes() {
        let mut rng = StdRng::seed_from_u64(2);
        for (n, isa) in [0usize, 1, 5, 15, 16, 17, 60]
            .into_iter()
            .flat_map(|n| Isa::available().into_iter().map(move |isa| (n, isa)))
        {
            let boxes: Vec<_> = (0..n).map(|_| random_box(&mut rng)).collect();
            let (tree, mut rays, mut reach) = (BoxTree::new(&boxes), Rays::default(), Vec::new());
            for i in 0..101 {
                let mut v =
                    || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-6.0f32..6.0)));
                rays.push(v(), v(), f32::INFINITY);
                reach.push([1.5, f32::INFINITY, -1.0][i % 3]);
            }
            reach.resize(112, -1.0);
            let mut entering = vec![Vec::new(); n];
            tree.gather(isa, &rays, &reach, &mut entering, &mut BoxScratch::default());
            let mut expected = vec![Vec::new(); n];
            for i in (0..101).filter(|&i| reach[i] > 0.0) {
                tree.visit(rays.origin(i), rays.direction(i), reach[i], |number| {
                    expected[number as usize].push(i as u32);
                });
            }
            assert_eq!(entering, expected, "{n} boxes, {isa}");
        }
    }

    #[test]
    fn a_ray_in_the_plane_of_a_face_enters() {
        let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let enters = |o, d: Vec3| enters(&bounds, o, d.recip(), 10.0);
        assert!(enters(Vec3::new(0.0, 0.5, -1.0), Vec3::Z));
        assert!(enters(Vec3::new(1.0, 1.0, -1.0), Vec3::Z));
        assert!(!enters(Vec3::new(1.5, 0.5, -1.0), Vec3::Z));
        assert!(!enters(Vec3::new(0.5, 0.5, -20.0), Vec3::Z));
    }
}
