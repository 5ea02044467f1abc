//! One ray at a time, from near to far.

use glam::Vec3;

use super::leaf::{Best, test_triangles};
use super::node::{Chunk, Node};
use super::ray::WalkRay;
use super::{KdTree, MAX_DEPTH};
use crate::accel::triangle::TriangleHit;

/// Tests the triangles of a chunk, whose words come first in `words`.
pub(super) trait TestTriangles {
    /// Leaves the nearest hit in `best`.
    fn test(&self, words: &[u32], chunk: Chunk, ray: &WalkRay, best: &mut Best);
}

/// Plain Rust.
pub(super) struct Portable;

impl TestTriangles for Portable {
    #[inline(always)]
    fn test(&self, words: &[u32], chunk: Chunk, ray: &WalkRay, best: &mut Best) {
        test_triangles(words, chunk, &ray.sheared, best);
    }
}

/// The far side of a split, to be visited later.
#[derive(Clone, Copy)]
struct Later {
    node: u32,
    near: f32,
    far: f32,
}

/// The nearest hit; of `ANY` hit that is found first.
#[inline(always)]
pub(super) fn trace<const ANY: bool>(
    tree: &KdTree,
    origin: Vec3,
    direction: Vec3,
    t_max: f32,
    tester: &impl TestTriangles,
) -> Best {
    let mut best = Best::before(t_max);
    let ray = WalkRay::new(origin, direction, &tree.bounds);
    let Some([mut near, mut far]) = ray.span(&tree.bounds, best.t) else { return best };
    let mut stack = [Later { node: 0, near: 0.0, far: 0.0 }; MAX_DEPTH + 1];
    let mut depth = 0;
    let mut node = tree.nodes[0];
    loop {
        while !node.is_leaf() {
            let axis = node.axis();
            let crossing = ray.crossing(axis, node.position());
            let (early, late) = (crossing - ray.slack[axis], crossing + ray.slack[axis]);
            let lower = node.lower_child();
            let first = lower + u32::from(ray.direction[axis].is_sign_negative());
            let second = 2 * lower + 1 - first;
            let (visit_near, visit_far) = (near <= late, far >= early);
            if visit_near && visit_far {
                stack[depth] = Later { node: second, near: near.max(early), far };
                depth += 1;
            }
            far = if visit_near { far.min(late) } else { far };
            node = tree.nodes[if visit_near { first } else { second } as usize];
        }
        tree.test_leaf(node, &ray, &mut best, tester);
        if ANY && best.is_hit() {
            return best;
        }
        loop {
            if depth == 0 {
                return best;
            }
            depth -= 1;
            if stack[depth].near <= best.t {
                break;
            }
        }
        (near, far) = (stack[depth].near, stack[depth].far.min(best.t));
        node = tree.nodes[stack[depth].node as usize];
    }
}

impl KdTree {
    #[inline(always)]
    fn test_leaf(&self, leaf: Node, ray: &WalkRay, best: &mut Best, tester: &impl TestTriangles) {
        let mut chunk = leaf.chunk();
        if chunk.is_empty() {
            return;
        }
        let mut words = &self.arena.words[leaf.offset() as usize..];
        loop {
            tester.test(words, chunk, ray, best);
            if !chunk.is_followed() {
                return;
            }
            words = &words[chunk.end()..];
            if chunk.has_curved() {
                self.test_curved(words, ray, best);
                return;
            }
            chunk = Chunk(words[0]);
            words = &words[1..];
        }
    }

    #[cold]
    fn test_curved(&self, words: &[u32], ray: &WalkRay, best: &mut Best) {
        let first = self.primitives.triangles.len();
        for &id in &words[1..][..words[0] as usize] {
            let curved = &self.primitives.curved[id as usize - first];
            let (origin, t_end) = (ray.sheared.origin, best.t.next_up());
            if let Some((t, part)) = curved.intersect(origin, ray.direction, t_end) {
                best.offer(TriangleHit { t, u: part.to_u(), v: 0.0 }, id);
            }
        }
    }
}
