//! One ray at a time, from near to far, in plain Rust: the reference of the others.

use super::leaf::{Best, Chunk, test_triangles};
use super::ray::{Line, Prepared};
use super::tree::{KdTree, MAX_DEPTH};
use super::treelet::{Child, Stand};
use crate::primitives::triangle::turned::{larger, smaller};
use crate::rays::Rays;
use crate::structure::study::Counting;

/// A part of the tree and the part of a ray that lies in it.
#[derive(Clone, Copy)]
struct Visit {
    stand: Stand,
    near: f32,
    far: f32,
}

impl KdTree {
    /// The nearest hit, or `any`, of the ray in place `lane` of `prepared`.
    pub(super) fn trace_one<C: Counting>(
        &self,
        any: bool,
        prepared: &Prepared,
        lane: usize,
        rays: &Rays,
        counting: &mut C,
    ) -> Best {
        let mut best = Best::up_to(prepared.t[lane]);
        let (near, far) = (prepared.near[lane], prepared.far[lane]);
        let mut stack = [Visit { stand: self.root(), near, far }; MAX_DEPTH + 1];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let Visit { stand, near, far } = stack[depth];
            let visit = Visit { stand, near, far: smaller(best.t, far) };
            if near > best.t {
                continue;
            }
            if let Some(leaf) =
                self.descend(prepared, lane, visit, &mut stack, &mut depth, counting)
            {
                self.test_leaf(
                    leaf,
                    &prepared.line(lane),
                    (rays, prepared.index[lane]),
                    &mut best,
                    counting,
                );
                if any && best.is_hit() {
                    break;
                }
            }
        }
        best
    }

    /// The nearest leaf of a part of the tree that the ray visits, if there is one; the rest of the
    /// part goes to the stack.
    fn descend<C: Counting>(
        &self,
        prepared: &Prepared,
        lane: usize,
        Visit { stand: Stand { mut at, mut plane }, mut near, mut far }: Visit,
        stack: &mut [Visit; MAX_DEPTH + 1],
        depth: &mut usize,
        counting: &mut C,
    ) -> Option<Child> {
        while at.is_treelet() {
            counting.step();
            let treelet = self.treelet(at);
            let axis = treelet.axis(plane);
            let product = treelet.planes[plane] * prepared.inverse[axis][lane];
            let early = product - prepared.early[axis][lane];
            let late = product - prepared.late[axis][lane];
            let falls = (prepared.way[lane] >> axis & 1) as usize;
            // So written that NaN skips nothing.
            let (skips_near, skips_far) = (near > late, far < early);
            let visit_near = !skips_near && !treelet.is_empty(plane, falls);
            let visit_far = !skips_far && !treelet.is_empty(plane, 1 - falls);
            let beyond = treelet.beyond(at, plane, 1 - falls);
            if visit_near {
                if visit_far {
                    stack[*depth] = Visit { stand: beyond, near: larger(early, near), far };
                    *depth += 1;
                }
                far = smaller(late, far);
                Stand { at, plane } = treelet.beyond(at, plane, falls);
            } else if visit_far {
                near = larger(early, near);
                Stand { at, plane } = beyond;
            } else {
                return None;
            }
        }
        counting.step();
        Some(at)
    }

    /// Tests all that is in a leaf.
    fn test_leaf<C: Counting>(
        &self,
        leaf: Child,
        line: &Line,
        ray: (&Rays, u32),
        best: &mut Best,
        counting: &mut C,
    ) {
        let mut words = &self.words()[leaf.offset()..];
        let mut objects = 0;
        loop {
            let chunk = Chunk(words[0]);
            objects += chunk.triangles();
            (0..chunk.triangles()).for_each(|_| counting.test());
            test_triangles(&words[1..], chunk, &line.sheared(), best);
            words = &words[1 + chunk.end()..];
            if chunk.has_curved() {
                objects += words[0] as usize;
                (0..words[0]).for_each(|_| counting.test());
                counting.leaf(objects);
                return self.test_curved(words, ray, best);
            }
            if !chunk.is_followed() {
                return counting.leaf(objects);
            }
        }
    }
}
