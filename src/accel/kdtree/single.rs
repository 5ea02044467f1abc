//! One ray at a time, from near to far.

use super::leaf::{Best, test_triangles};
use super::node::{Chunk, Node};
use super::ray::{Line, Prepared};
use super::{KdTree, MAX_DEPTH};
use crate::accel::Rays;
use crate::accel::triangle::TriangleHit;
use crate::accel::triangle::turned::{larger, smaller};

/// What differs between instruction sets.
pub(super) trait Kernel {
    /// Tests the triangles of a chunk, whose words come first in `words`, and keeps the nearest
    /// hit.
    ///
    /// # Safety
    /// The CPU has the instruction set; the words are those of a finished arena from a chunk on.
    unsafe fn test(words: &[u32], chunk: Chunk, line: &Line, best: &mut Best);
}

/// Plain Rust.
pub(super) struct Portable;

impl Kernel for Portable {
    #[inline(always)]
    unsafe fn test(words: &[u32], chunk: Chunk, line: &Line, best: &mut Best) {
        test_triangles(words, chunk, &line.sheared(), best);
    }
}

/// A part of the tree and the part of a ray that lies in it.
#[derive(Clone, Copy)]
pub(super) struct Visit {
    pub(super) node: usize,
    pub(super) near: f32,
    pub(super) far: f32,
}

/// Keeps in `best` the nearest hit in a part of the tree, of `ANY` the first that is found; for
/// place `lane` of `prepared`, which is ray `index` of the batch.
///
/// # Safety
/// The CPU has the instruction set of `K`.
#[inline(always)]
pub(super) unsafe fn trace<K: Kernel, const ANY: bool, const N: usize>(
    tree: &KdTree,
    prepared: &Prepared<N>,
    lane: usize,
    (rays, index): (&Rays, usize),
    start: Visit,
    best: &mut Best,
) {
    let line = prepared.line(lane);
    let mut times = [[0.0; 3]; 3];
    for (axis, times) in times.iter_mut().enumerate() {
        *times =
            [prepared.inverse[axis][lane], prepared.early[axis][lane], prepared.late[axis][lane]];
    }
    let way = prepared.way[lane] as usize;
    let mut stack = [start; MAX_DEPTH + 1];
    let mut depth = 1;
    while depth > 0 {
        depth -= 1;
        let Visit { node, mut near, far } = stack[depth];
        if near > best.t {
            continue;
        }
        let mut far = smaller(best.t, far);
        let mut node = tree.nodes[node];
        let mut is_left = true;
        while !node.is_leaf() {
            let axis = node.axis();
            let [inverse, early, late] = times[axis];
            let product = node.position() * inverse;
            let (early, late) = (product - early, product - late);
            let falls = way >> axis & 1;
            let (first, second) = (node.lower_child() + falls, node.lower_child() + 1 - falls);
            // So written that NaN skips nothing.
            let (skips_near, skips_far) = (near > late, far < early);
            let visit_near = !skips_near && !node.is_empty(falls);
            let visit_far = !skips_far && !node.is_empty(1 - falls);
            if visit_near {
                if visit_far {
                    stack[depth] = Visit { node: second, near: larger(early, near), far };
                    depth += 1;
                }
                far = smaller(late, far);
                node = tree.nodes[first];
            } else if visit_far {
                near = larger(early, near);
                node = tree.nodes[second];
            } else {
                is_left = false;
                break;
            }
        }
        if is_left {
            // SAFETY: the caller's.
            unsafe { tree.test_leaf::<K>(node, &line, (rays, index), best) };
            if ANY && best.is_hit() {
                return;
            }
        }
    }
}

impl KdTree {
    /// Tests all that is in a leaf.
    ///
    /// # Safety
    /// The CPU has the instruction set of `K`.
    #[inline(always)]
    pub(super) unsafe fn test_leaf<K: Kernel>(
        &self,
        leaf: Node,
        line: &Line,
        ray: (&Rays, usize),
        best: &mut Best,
    ) {
        let chunk = leaf.chunk();
        if chunk.is_empty() {
            return;
        }
        let words = &self.arena.words[leaf.offset()..];
        // SAFETY: the caller's.
        unsafe {
            K::test(words, chunk, line, best);
            if chunk.is_followed() {
                self.test_rest::<K>(&words[chunk.end()..], chunk, line, ray, best);
            }
        }
    }

    /// Tests what follows a chunk, whose words come first.
    ///
    /// # Safety
    /// The CPU has the instruction set of `K`.
    #[inline(always)]
    pub(super) unsafe fn test_rest<K: Kernel>(
        &self,
        mut words: &[u32],
        mut chunk: Chunk,
        line: &Line,
        ray: (&Rays, usize),
        best: &mut Best,
    ) {
        while chunk.is_followed() && !chunk.has_curved() {
            chunk = Chunk(words[0]);
            // SAFETY: the caller's.
            unsafe { K::test(&words[1..], chunk, line, best) };
            words = &words[1 + chunk.end()..];
        }
        if chunk.has_curved() {
            self.test_curved(words, ray, best);
        }
    }

    /// Tests curved primitives, whose number and ids come first in `words`.
    #[cold]
    pub(super) fn test_curved(&self, words: &[u32], (rays, i): (&Rays, usize), best: &mut Best) {
        let first = self.primitives.triangles.len();
        for &id in &words[1..][..words[0] as usize] {
            let curved = &self.primitives.curved[id as usize - first];
            let hit = curved.intersect(rays.origin(i), rays.direction(i), best.t.next_up());
            if let Some((t, part)) = hit {
                best.offer(TriangleHit { t, u: part.to_u(), v: 0.0 }, id);
            }
        }
    }
}
