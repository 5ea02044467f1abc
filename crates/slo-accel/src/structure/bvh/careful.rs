//! Traces one ray at a time with boxes in f64: the reference of the other kernels, and the kernel
//! for rays and scenes whose numbers are too large or too small for those.

use glam::{DVec3, Vec3};

use super::hierarchy::Bvh;
use super::layout::{Child, Node};
use super::ray::Ray;
use crate::primitives::triangle::{self, POSITION_ERROR, ShearedRay};
use crate::rays::Rays;
use crate::structure::study::Counting;

/// Traces one ray of a batch from the root; stops at the first hit found if `any` is enough.
#[cold]
#[inline(never)]
pub(super) fn trace<C: Counting>(
    bvh: &Bvh,
    rays: &Rays,
    mut ray: Ray,
    any: bool,
    counting: &mut C,
) -> Ray {
    let (origin, direction) = (rays.origin(ray.index as usize), rays.direction(ray.index as usize));
    let mut stack = vec![(0.0, Child::node(0))];
    while let Some((t, child)) = stack.pop() {
        if t > f64::from(ray.t) {
            continue;
        }
        counting.step();
        if child.is_leaf() {
            test_leaf(bvh, rays, child, &mut ray, any, counting);
            if any && ray.is_hit != 0 {
                break;
            }
        } else {
            let node = &bvh.nodes[child.index()];
            let changes = bvh.moves.then(|| (&bvh.nodes[child.index() + 1], ray.time));
            for word in node.order {
                let place = (word >> ray.order_shift & 7) as usize;
                counting.boxes(u64::from(!node.is_closed(place)));
                let errors = (f64::from(POSITION_ERROR), 0.0);
                let (ray_line, end) = ((origin, direction), f64::from(ray.t));
                if let Some(t) = enter((node, changes), place, ray_line, end, errors) {
                    stack.push((t, node.children[place]));
                }
            }
        }
    }
    ray
}

fn test_leaf<C: Counting>(
    bvh: &Bvh,
    rays: &Rays,
    child: Child,
    ray: &mut Ray,
    any: bool,
    counting: &mut C,
) {
    if !child.is_block() {
        counting.leaf(1);
        counting.test();
        return bvh.test_curved(rays, child, ray);
    }
    let index = ray.index as usize;
    let sheared = ShearedRay::new(rays.origin(index), rays.direction(index));
    let (first, count) = (child.index(), child.block_len());
    counting.leaf(count);
    for lane in 0..count {
        counting.test();
        let triangle = bvh.corners.triangle_at(first, count, lane, ray.time);
        let t_max = if any { ray.t } else { ray.t.next_up() };
        if let Some(hit) = triangle::intersect(&sheared, &triangle, t_max) {
            ray.offer(hit.t, hit.u, hit.v, bvh.corners.id(first, count, lane));
        }
    }
}

/// The t at which a ray enters a child's box, unless it is beyond `t_max`. Hits may lie outside the
/// box by the sum of two errors: one in units of the largest distance of its planes from the ray's
/// origin ([`POSITION_ERROR`]), one as it is. If boxes move, `changes` tell how, and the time.
pub(super) fn enter(
    (node, changes): (&Node, Option<(&Node, f32)>),
    place: usize,
    (origin, direction): (Vec3, Vec3),
    t_max: f64,
    (relative, absolute): (f64, f64),
) -> Option<f64> {
    let planes = |side: usize| {
        DVec3::from_array(std::array::from_fn(|axis| {
            let change = |(changes, time): (&Node, f32)| {
                f64::from(changes.planes[2 * axis + side][place]) * f64::from(time)
            };
            f64::from(node.planes[2 * axis + side][place]) + changes.map_or(0.0, change)
        }))
    };
    let origin = origin.as_dvec3();
    let (lower, upper) = (planes(0) - origin, planes(1) - origin);
    let size = lower.abs().max(upper.abs()).max_element();
    if size.is_infinite() && lower.x > upper.x {
        return None;
    }
    let error = relative * size + absolute;
    let (mut near, mut far) = (0.0f64, t_max);
    for axis in 0..3 {
        let d = f64::from(direction[axis]);
        let (lower, upper) = (lower[axis] - error, upper[axis] + error);
        if d == 0.0 {
            if lower > 0.0 || upper < 0.0 {
                return None;
            }
        } else {
            let (a, b) = (lower / d, upper / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    // The quotients are right to a few units of f64, hits only to f32.
    (near * (1.0 - 1e-7) <= far).then_some(near * (1.0 - 1e-7))
}
