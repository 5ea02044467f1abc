//! Lights in render space: one file for each kind.

mod lamp;
mod lights;
mod point;
mod rectangle;

use glam::{DVec3, Vec3};

use slo_scene::LightKind;

pub use lamp::Lamp;
pub use lights::{Lights, WithLamps};
pub use point::Point;
pub use rectangle::Rectangle;

/// A light.
#[derive(Clone, Copy, Debug)]
pub enum Light {
    /// `light_point`
    Point(Point),
    /// `light_rectangle`
    Rectangle(Rectangle),
}

/// Work for one light that is compiled for each kind, so that it handles a whole column of hits
/// without asking for the kind.
pub trait WithLamp {
    /// Result of the work.
    type Output;

    /// Does the work.
    fn run<L: Lamp>(self, lamp: L) -> Self::Output;
}

impl Light {
    /// The light with the origin of render space at `origin` of scene space.
    pub fn new(light: &slo_scene::Light, origin: DVec3) -> Self {
        match &light.kind {
            LightKind::Point(light) => Self::Point(Point::new(light, origin)),
            LightKind::Rectangle(light) => Self::Rectangle(Rectangle::new(light, origin)),
        }
    }

    /// Does work for this light.
    #[inline(always)]
    pub fn with<W: WithLamp>(&self, work: W) -> W::Output {
        match *self {
            Self::Point(lamp) => work.run(lamp),
            Self::Rectangle(lamp) => work.run(lamp),
        }
    }

    /// See [`Lamp::IS_AREA`].
    pub fn is_area(&self) -> bool {
        struct IsArea;
        impl WithLamp for IsArea {
            type Output = bool;

            fn run<L: Lamp>(self, _: L) -> bool {
                L::IS_AREA
            }
        }
        self.with(IsArea)
    }

    /// See [`Lamp::radiance`].
    pub fn radiance(&self, way: Vec3) -> Vec3 {
        struct Radiance(Vec3);
        impl WithLamp for Radiance {
            type Output = Vec3;

            fn run<L: Lamp>(self, lamp: L) -> Vec3 {
                lamp.radiance(self.0)
            }
        }
        self.with(Radiance(way))
    }

    /// See [`Lamp::density`].
    pub fn density(&self, way: Vec3) -> f32 {
        struct Density(Vec3);
        impl WithLamp for Density {
            type Output = f32;

            fn run<L: Lamp>(self, lamp: L) -> f32 {
                lamp.density(self.0)
            }
        }
        self.with(Density(way))
    }
}
