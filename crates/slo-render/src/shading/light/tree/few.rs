//! The choice among a few lights, for all hits of a batch at once.

use super::super::receiver;
use super::node::Node;
use super::sums::BELOW_ONE;
use super::{Choices, NO_LIGHT};
use slo_accel::Lanewise;
use slo_accel::math::columns::{Column, Vec3s, lanes, select};

/// So many lights are estimated one after the other for many hits, and more for one hit after the
/// other.
pub(super) const FEW: usize = 4;

/// [`choose`](super::LightTree::choose) for each of `len` hits, with the same bits, of a tree whose
/// only node has at most [`FEW`] lights.
pub(super) struct ChooseFew<'a> {
    pub(super) root: &'a Node,
    pub(super) len: usize,
    pub(super) from: &'a Vec3s,
    pub(super) normal: &'a Column<u32>,
    pub(super) u: &'a Column<f32>,
    pub(super) to: &'a mut Choices,
}

impl Lanewise for ChooseFew<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        if self.root.has_classes() {
            self.choose::<true>();
        } else {
            self.choose::<false>();
        }
    }
}

impl ChooseFew<'_> {
    #[inline(always)]
    fn choose<const HAS_CLASSES: bool>(self) {
        let Self { root, len, from, normal, u, to } = self;
        let lights = [0, 1, 2, 3].map(|k| root.light(k).unwrap_or(NO_LIGHT));
        for i in lanes(len) {
            let (from, normal) = (from.get(i), receiver::unpack(normal[i]));
            // Written out, since an inner loop would keep this one from becoming vector code.
            let part = |k: usize| root.estimate(k, from, normal);
            let mut parts = [part(0), part(1), part(2), part(3)];
            let total = sum(parts);
            if HAS_CLASSES {
                root.share_among_classes(&mut parts, total);
            }
            let all = sum(parts);
            // Halves of the interval, as `Sums::find` takes them.
            let [a, b, c, d] = parts;
            let x = u[i] * all;
            let is_late = (x >= a + b) & (c + d > 0.0);
            let x = x - select(is_late, a + b, 0.0);
            let (first, second) = (select(is_late, c, a), select(is_late, d, b));
            let is_second = (x >= first) & (second > 0.0);
            let x = x - select(is_second, first, 0.0);
            let part = select(is_second, second, first);
            let early = select(is_second, lights[1], lights[0]);
            let late = select(is_second, lights[3], lights[2]);
            let is_any = total > 0.0;
            to.light[i] = select(is_any, select(is_late, late, early), NO_LIGHT);
            to.chance[i] = select(is_any, part / all, 0.0);
            to.rest[i] = select(is_any, (x / part).clamp(0.0, BELOW_ONE), u[i]);
        }
    }
}

/// The sum, with the bits of [`Sums`](super::sums::Sums).
#[inline(always)]
fn sum([a, b, c, d]: [f32; FEW]) -> f32 {
    (a + b) + (c + d)
}
