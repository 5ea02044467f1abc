//! Lamps that move: a lamp of any kind, in a space of its own that moves.

use glam::{Mat3, Vec3};

use super::bounds::LightBounds;
use super::lamp::{Lamp, Sampled};
use slo_accel::math::rounding::gamma;

/// Where a lamp is at a time: turned by an orthonormal rotation, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Orthonormal and right-handed.
    pub rotation: Mat3,
    /// Image of the origin of the lamp's space.
    pub translation: Vec3,
}

impl Pose {
    /// The lamp's space is render space.
    pub const IDENTITY: Self = Self { rotation: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// Turns a vector to the lamp's space.
    #[inline(always)]
    fn inverse_vector(&self, v: Vec3) -> Vec3 {
        let axes = &self.rotation;
        Vec3::new(axes.x_axis.dot(v), axes.y_axis.dot(v), axes.z_axis.dot(v))
    }

    /// Turns a vector to render space.
    #[inline(always)]
    fn vector(&self, v: Vec3) -> Vec3 {
        let axes = &self.rotation;
        axes.x_axis * v.x + axes.y_axis * v.y + axes.z_axis * v.z
    }

    /// Transforms a point to the lamp's space.
    #[inline(always)]
    fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }
}

/// The poses of the lights of a frame, evenly spaced over the shutter. A ray uses the pose nearest
/// to its time.
#[derive(Clone, Debug, Default)]
pub struct Poses {
    /// Poses of lights that move together; none: they stay in render space.
    paths: Vec<Vec<Pose>>,
    /// For each light, its path.
    of: Vec<u32>,
    /// Whether any light has poses.
    any: bool,
}

impl Poses {
    /// Adds the poses of the next `count` lights.
    pub fn add(&mut self, count: usize, path: Vec<Pose>) {
        self.any |= !path.is_empty();
        let number = match self.paths.last() {
            Some(last) if last.is_empty() && path.is_empty() => self.paths.len() - 1,
            _ => {
                self.paths.push(path);
                self.paths.len() - 1
            }
        };
        self.of.extend(std::iter::repeat_n(number as u32, count));
    }

    /// Returns the poses of a light; none if it stays in render space.
    #[inline(always)]
    pub fn of(&self, light: u32) -> &[Pose] {
        let path = self.of.get(light as usize).and_then(|path| self.paths.get(*path as usize));
        path.map_or(&[], |path| path)
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.any
    }

    /// Returns the pose of a light at a time of the shutter, in `[0, 1]`.
    #[inline(always)]
    pub(super) fn at(&self, light: u32, time: f32) -> Pose {
        let poses = self.of(light);
        let last = poses.len().saturating_sub(1);
        let nearest = ((time * last as f32 + 0.5) as usize).min(last);
        poses.get(nearest).copied().unwrap_or(Pose::IDENTITY)
    }
}

/// A lamp at one time.
#[derive(Clone, Copy, Debug)]
pub struct Moving<L> {
    /// The lamp in its own space.
    pub lamp: L,
    /// Where it is.
    pub pose: Pose,
}

impl<L: Lamp> Lamp for Moving<L> {
    const IS_AREA: bool = L::IS_AREA;
    const IS_DELTA: bool = L::IS_DELTA;
    const IS_OF_THESIS: bool = L::IS_OF_THESIS;
    const IS_DISTANT: bool = L::IS_DISTANT;
    const IS_CLOSED: bool = L::IS_CLOSED;
    const LOOKS_UP: bool = L::LOOKS_UP;
    const IS_SHADED: bool = L::IS_SHADED;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        self.lamp.radiance(self.pose.inverse_vector(way))
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        let way = self.way(from, u);
        if L::IS_DISTANT { way } else { from + way }
    }

    #[inline(always)]
    fn way(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.pose.vector(self.lamp.way(self.pose.inverse_point(from), u))
    }

    #[inline(always)]
    fn density(&self, from: Vec3, way: Vec3) -> f32 {
        self.lamp.density(self.pose.inverse_point(from), self.pose.inverse_vector(way))
    }

    #[inline(always)]
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Sampled {
        let sampled = self.lamp.sample(self.pose.inverse_point(from), u);
        Sampled { way: self.pose.vector(sampled.way), ..sampled }
    }

    #[inline(always)]
    fn found(&self, from: Vec3, way: Vec3) -> (Vec3, f32) {
        self.lamp.found(self.pose.inverse_point(from), self.pose.inverse_vector(way))
    }

    /// The ray ends a little earlier than the lamp's margin asks for, since the transform to the
    /// lamp's space rounds coordinates of render space.
    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let direction = point - from;
        let local = self.pose.inverse_point(from);
        let target = self.pose.inverse_point(point);
        let (_, t_max) = self.lamp.shadow_ray(local, target);
        let far = (from.abs() + point.abs() + self.pose.translation.abs()).max_element();
        let margin = gamma(32) * far / direction.abs().max_element();
        let ends = (direction, (t_max - margin).max(0.5));
        if L::IS_DISTANT { (point, f32::INFINITY) } else { ends }
    }

    fn encloses(&self, point: Vec3) -> bool {
        self.lamp.encloses(self.pose.inverse_point(point))
    }

    fn area(&self) -> f32 {
        self.lamp.area()
    }

    fn place(&self, u: [f32; 2]) -> Vec3 {
        self.pose.vector(self.lamp.place(u)) + self.pose.translation
    }

    fn normal(&self, point: Vec3) -> Vec3 {
        self.pose.vector(self.lamp.normal(self.pose.inverse_point(point)))
    }

    fn bounds(&self) -> LightBounds {
        let Pose { rotation, translation } = self.pose;
        self.lamp.bounds().in_poses(std::iter::once((rotation, translation)))
    }
}
