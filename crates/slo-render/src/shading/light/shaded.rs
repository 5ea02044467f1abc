//! Lights whose surface is shaded where rays to them arrive.

use glam::Vec3;

use super::bounds::LightBounds;
use super::lamp::Lamp;

/// Most such lights of a frame: rays keep the number of one in 20 bits.
pub const MOST_SHADED: u32 = (1 << 20) - 1;

/// A light of this shape. Its material tells its radiance: the [`radiance`](Lamp::radiance) of the
/// light is 1. The radiance of the shape is the mean, by which lights are chosen.
#[derive(Clone, Copy, Debug)]
pub struct Shaded<L>(pub L);

impl<L: Lamp> Lamp for Shaded<L> {
    const IS_AREA: bool = L::IS_AREA;
    const IS_DELTA: bool = L::IS_DELTA;
    const IS_CLOSED: bool = L::IS_CLOSED;
    const IS_SHADED: bool = true;

    #[inline(always)]
    fn radiance(&self, _way: Vec3) -> Vec3 {
        Vec3::ONE
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.0.point(from, u)
    }

    #[inline(always)]
    fn way(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.0.way(from, u)
    }

    #[inline(always)]
    fn density(&self, from: Vec3, way: Vec3) -> f32 {
        self.0.density(from, way)
    }

    #[inline(always)]
    fn shadow_ray(&self, from: Vec3, point: Vec3) -> (Vec3, f32) {
        self.0.shadow_ray(from, point)
    }

    fn encloses(&self, point: Vec3) -> bool {
        self.0.encloses(point)
    }

    fn area(&self) -> f32 {
        self.0.area()
    }

    fn place(&self, u: [f32; 2]) -> Vec3 {
        self.0.place(u)
    }

    fn normal(&self, point: Vec3) -> Vec3 {
        self.0.normal(point)
    }

    fn bounds(&self) -> LightBounds {
        self.0.bounds()
    }
}
