//! One form for lights of all kinds, for loops in which every lane has a light of its own.

use glam::Vec3;

use super::lamp::Lamp;
use super::point::Point;
use super::rectangle::Rectangle;

/// A light of any kind: a point is a rectangle without sides. Its answers are those of its
/// [`Lamp`], bit for bit.
#[derive(Clone, Copy, Debug)]
pub struct AnyLight {
    /// Radiance that reaches a hit, at any distance.
    pub color: Vec3,
    rectangle: Rectangle,
}

impl From<Point> for AnyLight {
    fn from(Point { color, position }: Point) -> Self {
        Self::from(Rectangle {
            color,
            corner: position,
            sides: [Vec3::ZERO; 2],
            normal: Vec3::Z,
            sensitivity: Vec3::ZERO,
            magnitude: Vec3::ZERO,
            area: 0.0,
        })
    }
}

impl From<Rectangle> for AnyLight {
    fn from(rectangle: Rectangle) -> Self {
        Self { color: rectangle.color, rectangle }
    }
}

impl AnyLight {
    /// See [`Lamp::IS_AREA`].
    #[inline(always)]
    pub fn is_area(&self) -> bool {
        self.rectangle.sides[0] != Vec3::ZERO
    }

    /// See [`Lamp::point`].
    #[inline(always)]
    pub fn point(&self, u: [f32; 2]) -> Vec3 {
        self.rectangle.point(Vec3::ZERO, u)
    }

    /// See [`Lamp::density`].
    #[inline(always)]
    pub fn density(&self, way: Vec3) -> f32 {
        self.rectangle.density(way)
    }

    /// See [`Lamp::expected`].
    #[inline(always)]
    pub fn expected(&self, hit: Vec3, normals: [Vec3; 2], through: bool) -> f32 {
        self.rectangle.expected(hit, normals, through)
    }

    /// See [`Lamp::shadow_ray`].
    #[inline(always)]
    pub fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        let (direction, end) = self.rectangle.shadow_ray(from, point);
        (direction, if self.is_area() { end } else { 1.0 })
    }
}
