//! A tree over boxes: which of them a ray enters. The upper level of the two-level structure, over
//! the boxes of moving objects.

use glam::Vec3;

use crate::math::{Bounds, rounding::gamma};

/// A binary tree over boxes, split at the median centre of the longest axis.
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

/// The median split halves the boxes, so that 2^32 boxes give at most 33 levels.
const MAX_DEPTH: usize = 40;

impl BoxTree {
    /// Builds the tree; boxes are numbered by their place in `boxes`.
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

    /// Calls `visit` with the number of every box that the ray enters before `t_max`, and perhaps
    /// of some that it misses by a rounding error. The order is the tree's.
    #[inline]
    pub fn visit(&self, origin: Vec3, direction: Vec3, t_max: f32, mut visit: impl FnMut(u32)) {
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

/// Slab test that errs on the side of entering.
///
/// Source: T. Ize, "Robust BVH Ray Traversal" (JCGT 2013): the far distances are enlarged by the
/// error of the near ones.
#[inline]
fn enters(bounds: &Bounds, origin: Vec3, inverse: Vec3, t_max: f32) -> bool {
    const ENLARGE: f32 = 1.0 + 2.0 * gamma(3);
    let (mut near, mut far) = (0.0f32, t_max);
    for axis in 0..3 {
        let a = (bounds.min[axis] - origin[axis]) * inverse[axis];
        let b = (bounds.max[axis] - origin[axis]) * inverse[axis];
        // A ray inside a slab's plane gives 0 * infinity: that slab excludes nothing.
        if !(a.is_nan() || b.is_nan()) {
            near = near.max(a.min(b));
            far = far.min(a.max(b) * ENLARGE);
        }
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
    fn a_ray_in_the_plane_of_a_face_enters() {
        let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let enters = |o, d: Vec3| enters(&bounds, o, d.recip(), 10.0);
        assert!(enters(Vec3::new(0.0, 0.5, -1.0), Vec3::Z));
        assert!(enters(Vec3::new(1.0, 1.0, -1.0), Vec3::Z));
        assert!(!enters(Vec3::new(1.5, 0.5, -1.0), Vec3::Z));
        assert!(!enters(Vec3::new(0.5, 0.5, -20.0), Vec3::Z));
    }
}
