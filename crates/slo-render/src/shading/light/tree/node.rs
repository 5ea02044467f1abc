//! Nodes of the tree: what 16 children may bring to a hit.

use glam::Vec3;

use super::super::bounds::LightBounds;
use super::super::receiver;
use super::sums::{WIDTH, sum};

/// Bit of [`Node::child`] that says that the child is a light.
const IS_LIGHT: u32 = 1 << 31;

/// Share of its light that a child counts for at least if it is above the horizon: highlights and
/// lobes may receive more than a diffuse surface.
const LEAST: f32 = 0.1;

/// Room for the rounding errors of cosines that come from sines.
const SLACK: f32 = 1e-3;

/// Largest part of a child; sums of 16 remain finite.
const MOST: f32 = 1e36;

/// Share of the choice that goes to the classes of lights alike: each distant light is one, and all
/// others together are one. The estimates know nothing of what stands in the way: indoors, a wall
/// keeps most of the sun away, and the sky in the window lights the room.
const ALIKE: f32 = 0.5;

/// 16 children in columns.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    center: [[f32; WIDTH]; 3],
    /// Half of the edges of the box.
    half: [[f32; WIDTH]; 3],
    /// Half of the diagonal of the box.
    radius: [f32; WIDTH],
    /// Falloff inside the ball about the box: 1 over the square of `radius`.
    most_falloff: [f32; WIDTH],
    axis: [[f32; WIDTH]; 3],
    /// Cosine and sine of the spread of the directions.
    spread: [[f32; WIDTH]; 2],
    /// Least cosine, beyond the spread, at which the child shines.
    least: [f32; WIDTH],
    /// 1 if the child shines along both ends of its axis, otherwise 0.
    two_sided: [f32; WIDTH],
    energy: [f32; WIDTH],
    /// 0 if the child is infinitely far away, otherwise 1.
    near: [f32; WIDTH],
    /// 1 if the child's light falls off, otherwise 0.
    falls_off: [f32; WIDTH],
    child: [u32; WIDTH],
    /// Number of distant children, plus 1 if there are others.
    classes: u32,
}

impl Node {
    /// A node whose children bring nothing.
    pub(super) fn empty() -> Self {
        let zeros = [0.0; WIDTH];
        Self {
            center: [zeros; 3],
            half: [zeros; 3],
            radius: zeros,
            most_falloff: zeros,
            axis: [zeros; 3],
            spread: [zeros; 2],
            least: zeros,
            two_sided: zeros,
            energy: zeros,
            near: zeros,
            falls_off: zeros,
            child: [IS_LIGHT; WIDTH],
            classes: 0,
        }
    }

    /// Sets the bounds of a child.
    pub(super) fn set(&mut self, k: usize, lights: &LightBounds) {
        let center = (lights.min + lights.max) * 0.5;
        // The middle is rounded.
        let half = (lights.max - center).max(center - lights.min);
        let (sin, cos) = libm::sincosf(lights.spread);
        for i in 0..3 {
            self.center[i][k] = center[i];
            self.half[i][k] = half[i];
            self.axis[i][k] = lights.axis[i];
        }
        let radius = half.length();
        self.radius[k] = radius;
        self.most_falloff[k] = (1.0 / (radius * radius)).min(MOST);
        self.spread[0][k] = cos;
        self.spread[1][k] = sin.max(0.0);
        self.least[k] = if lights.is_flat { 0.0 } else { 1.0 };
        self.two_sided[k] = if lights.two_sided { 1.0 } else { 0.0 };
        self.energy[k] = if lights.energy.is_finite() { lights.energy.max(0.0) } else { MOST };
        self.near[k] = if lights.is_distant { 0.0 } else { 1.0 };
        self.falls_off[k] = if lights.falls_off { 1.0 } else { 0.0 };
    }

    /// Counts the classes of the first `count` children.
    pub(super) fn count_classes(&mut self, count: usize) {
        let distant = self.near[..count].iter().filter(|near| **near == 0.0).count();
        self.classes = distant as u32 + u32::from(distant < count);
        if distant == 0 {
            self.classes = 1;
        }
    }

    /// Makes a child a light.
    pub(super) fn set_light(&mut self, k: usize, light: u32) {
        self.child[k] = light | IS_LIGHT;
    }

    /// Makes a child a node.
    pub(super) fn set_node(&mut self, k: usize, node: u32) {
        self.child[k] = node;
    }

    /// Returns the number of the light that a child is; `None` if it is a node.
    #[inline(always)]
    pub(super) fn light(&self, k: usize) -> Option<u32> {
        let child = self.child[k];
        (child & IS_LIGHT != 0).then_some(child & !IS_LIGHT)
    }

    /// Returns the number of the node that a child is.
    #[inline(always)]
    pub(super) fn child(&self, k: usize) -> u32 {
        self.child[k]
    }

    /// Estimates what each child brings to a hit. If nothing may reach the hit, a root returns
    /// `None`, and another node returns the energies, so that chances always sum to 1.
    #[inline(always)]
    pub(super) fn parts(&self, from: Vec3, normal: Vec3, is_root: bool) -> Option<[f32; WIDTH]> {
        let mut parts = [0.0; WIDTH];
        for (k, part) in parts.iter_mut().enumerate() {
            *part = self.estimate(k, from, normal);
        }
        let total = sum(&parts);
        if total > 0.0 {
            if is_root && self.has_classes() {
                self.share_among_classes(&mut parts, total);
            }
            return Some(parts);
        }
        (!is_root && sum(&self.energy) > 0.0).then_some(self.energy)
    }

    /// Whether there are distant lights, beside each other or beside others.
    #[inline(always)]
    pub(super) fn has_classes(&self) -> bool {
        self.classes > 1
    }

    /// Gives each class of lights that brings anything a share of the choice.
    #[inline(always)]
    pub(super) fn share_among_classes<const N: usize>(&self, parts: &mut [f32; N], total: f32) {
        let (mut of_near, mut classes) = (0.0, 0.0);
        for (part, near) in parts.iter().zip(&self.near) {
            of_near += part * near;
            classes += if *part > 0.0 { 1.0 - near } else { 0.0 };
        }
        classes += if of_near > 0.0 { 1.0 } else { 0.0 };
        let each = ALIKE * total / classes;
        for (part, near) in parts.iter_mut().zip(&self.near) {
            let share = if *near > 0.0 { *part / of_near } else { 1.0 };
            let share = if *part > 0.0 { share * each } else { 0.0 };
            *part = *part * (1.0 - ALIKE) + share;
        }
    }

    /// Estimates the irradiance that a child brings to a hit, by bounds of its cosines: 0 only if
    /// the child is dark there.
    #[inline(always)]
    pub(super) fn estimate(&self, k: usize, from: Vec3, normal: Vec3) -> f32 {
        let vector =
            |columns: &[[f32; WIDTH]; 3]| Vec3::new(columns[0][k], columns[1][k], columns[2][k]);
        let (center, half, axis) = (vector(&self.center), vector(&self.half), vector(&self.axis));
        let here = from * self.near[k];
        let way = center - here;
        let square = way.length_squared().max(f32::MIN_POSITIVE);
        let distance = square.sqrt();
        let inverse = 1.0 / distance;
        let toward = way * inverse;
        let radius = self.radius[k];
        let is_inside = radius >= distance;
        // The angle that a ball about the box subtends.
        let sin = (radius * inverse).min(1.0);
        let ball = [(1.0 - sin * sin).sqrt(), sin];

        let at_surface = closer(with_sine(toward.dot(normal)), ball)[0];
        let at_surface = if is_inside { 1.0 } else { at_surface };
        let height = way.dot(normal) + half.dot(normal.abs());
        let rounding = 1e-6 * (center.abs().max_element() + here.abs().max_element());
        let is_above = height + 2.0 * receiver::ERROR * (distance + radius) + rounding >= 0.0;
        let received = if is_above { LEAST + at_surface.max(0.0) } else { 0.0 };

        let cos = -toward.dot(axis);
        let cos = if self.two_sided[k] > 0.0 { cos.abs() } else { cos };
        let at_light = closer(with_sine(cos), [self.spread[0][k], self.spread[1][k]]);
        let at_light = closer(at_light, ball)[0];
        let at_light = if is_inside { 1.0 } else { at_light };
        let is_lit = at_light + SLACK >= self.least[k];
        let sent = if is_lit { at_light.max(SLACK) } else { 0.0 };

        let falloff = (inverse * inverse).min(self.most_falloff[k]);
        let falloff = if self.falls_off[k] > 0.0 { falloff } else { 1.0 };
        (self.energy[k] * received * sent * falloff).min(MOST)
    }
}

/// Returns a cosine with its sine, which is not negative.
#[inline(always)]
fn with_sine(cos: f32) -> [f32; 2] {
    [cos, (1.0 - cos * cos).max(0.0).sqrt()]
}

/// Returns the cosine and the sine of an angle minus another, both given by their cosines and sines;
/// those of 0 if the other is larger.
#[inline(always)]
fn closer([cos, sin]: [f32; 2], [other_cos, other_sin]: [f32; 2]) -> [f32; 2] {
    let is_within = cos >= other_cos;
    let less = [cos * other_cos + sin * other_sin, sin * other_cos - cos * other_sin];
    if is_within { [1.0, 0.0] } else { less }
}
