//! Lights in render space: one file for each kind.

mod bounds;
pub(crate) mod cone;
mod environment;
mod flat;
mod kinds;
mod lamp;
mod lamp_disc;
mod lamp_point;
mod lamp_rectangle;
mod lamp_sphere;
mod lamp_sun;
mod moving;
mod point;
pub mod receiver;
mod rectangle;
mod shaded;
mod spherical_rectangle;
mod techniques;
mod tree;
mod triangle;

use std::ops::Deref;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use kinds::lamps;
use slo_accel::Isa;
use slo_accel::math::columns::{Column, Vec3s};
use slo_scene::light::Sky;
use slo_scene::{LightKind, Texture};

pub use bounds::LightBounds;
pub use environment::{EvenSky, ImageSky, ImageView, SkyShare, SkyTable};
pub use kinds::{WithLamp, WithLamps};
pub use lamp::{Lamp, Sampled, Samples};
pub use lamp_disc::DiscLamp;
pub use lamp_point::PointLamp;
pub use lamp_rectangle::RectangleLamp;
pub use lamp_sphere::SphereLamp;
pub use lamp_sun::{ParallelLamp, SunLamp};
pub use moving::{Moving, Pose, Poses};
pub use point::Point;
pub use rectangle::Rectangle;
pub use shaded::{MOST_SHADED, Shaded};
pub use techniques::Techniques;
pub use tree::{Choices, Chosen, LightTree, NO_LIGHT};
pub use triangle::Triangle;

lamps! {
    /// A light.
    pub enum Light, all in Lights {
        /// `light_point`
        Point(Point) in points,
        /// `light_rectangle`
        Rectangle(Rectangle) in rectangles,
        /// `lamp_point` and `lamp_spot` without a radius
        PointLamp(PointLamp) in point_lamps,
        /// `lamp_point` and `lamp_spot` with a radius
        SphereLamp(SphereLamp) in sphere_lamps,
        /// `lamp_sun` of angle 0
        ParallelLamp(ParallelLamp) in parallel_lamps,
        /// `lamp_sun`
        SunLamp(SunLamp) in sun_lamps,
        /// `lamp_rectangle`
        RectangleLamp(RectangleLamp) in rectangle_lamps,
        /// `lamp_disc`
        DiscLamp(DiscLamp) in disc_lamps,
        /// `environment` without an image
        EvenSky(EvenSky) in even_skies,
        /// `environment` with an image
        ImageSky(ImageSky) in image_skies,
        /// A triangle of a surface that emits light
        Triangle(Triangle) in triangles,
        /// A triangle of a surface that emits light unevenly
        ShadedTriangle(Shaded<Triangle>) in shaded_triangles,
        /// A sphere that emits light unevenly
        ShadedSphere(Shaded<SphereLamp>) in shaded_spheres,
    }
}

/// How images are sampled that show a sky.
#[derive(Clone, Copy, Debug)]
pub struct Skies<'a> {
    /// Which light rays to the sky are to find.
    pub share: SkyShare,
    /// Skies of another frame, whose tables are used again.
    pub before: &'a [ImageSky],
}

impl Light {
    /// Converts a light of the scene; `origin` is the origin of render space in scene space.
    /// `skies` says how images of `textures` are sampled that show a sky.
    pub fn new(
        light: &slo_scene::Light,
        origin: DVec3,
        textures: &[Arc<Texture>],
        skies: Skies<'_>,
    ) -> Self {
        match &light.kind {
            LightKind::Point(lamp) => Self::Point(Point::new(lamp, origin)),
            LightKind::Rectangle(lamp) => Self::Rectangle(Rectangle::new(lamp, origin)),
            LightKind::PointLamp(lamp) if lamp.radius > 0.0 => {
                Self::SphereLamp(SphereLamp::point(lamp, origin))
            }
            LightKind::PointLamp(lamp) => Self::PointLamp(PointLamp::point(lamp, origin)),
            LightKind::SpotLamp(lamp) if lamp.radius > 0.0 => {
                Self::SphereLamp(SphereLamp::spot(lamp, origin))
            }
            LightKind::SpotLamp(lamp) => Self::PointLamp(PointLamp::spot(lamp, origin)),
            LightKind::SunLamp(lamp) => ParallelLamp::new(lamp)
                .map_or_else(|| Self::SunLamp(SunLamp::new(lamp)), Self::ParallelLamp),
            LightKind::RectangleLamp(lamp) => Self::RectangleLamp(RectangleLamp::new(lamp, origin)),
            LightKind::DiscLamp(lamp) => Self::DiscLamp(DiscLamp::new(lamp, origin)),
            LightKind::Environment(lamp) => match lamp.sky {
                Sky::Even(radiance) => {
                    Self::EvenSky(EvenSky::new(Vec3::from(radiance) * lamp.strength))
                }
                Sky::Image(image) => {
                    let texture = &textures[image.0 as usize];
                    let (strength, turn) = (lamp.strength, lamp.turn_deg);
                    Self::ImageSky(ImageSky::new(
                        texture,
                        strength,
                        turn,
                        skies.share,
                        skies.before,
                    ))
                }
            },
        }
    }
}

impl Deref for Lights {
    type Target = [Light];

    fn deref(&self) -> &[Light] {
        &self.all
    }
}

impl Lights {
    /// The same lights, with the poses of each over the shutter.
    #[must_use]
    pub fn with_poses(self, poses: Poses) -> Self {
        Self { poses, ..self }
    }

    /// Skies that are images.
    pub fn image_skies(&self) -> &[ImageSky] {
        &self.image_skies
    }

    /// Whether any light has poses.
    #[inline]
    pub fn move_about(&self) -> bool {
        !self.poses.is_empty()
    }

    /// Returns the pose of a light at a time of the shutter, in `[0, 1]`.
    #[inline(always)]
    pub fn pose(&self, light: u32, time: f32) -> Pose {
        self.poses.at(light, time)
    }

    /// Returns the radiance of a light at a time; see [`Lamp::radiance`].
    pub fn radiance(&self, light: u32, time: f32, way: Vec3) -> Vec3 {
        struct Radiance(Pose, Vec3);
        impl WithLamp for Radiance {
            type Output = Vec3;

            fn run<L: Lamp>(self, lamp: L) -> Vec3 {
                Moving { lamp, pose: self.0 }.radiance(self.1)
            }
        }
        self[light as usize].with(Radiance(self.pose(light, time), way))
    }

    /// Returns the radiance and the density of a light at a time; see [`Lamp::found`].
    pub fn found(&self, light: u32, time: f32, from: Vec3, way: Vec3) -> (Vec3, f32) {
        struct Found(Pose, Vec3, Vec3);
        impl WithLamp for Found {
            type Output = (Vec3, f32);

            fn run<L: Lamp>(self, lamp: L) -> (Vec3, f32) {
                Moving { lamp, pose: self.0 }.found(self.1, self.2)
            }
        }
        self[light as usize].with(Found(self.pose(light, time), from, way))
    }

    /// [`found`](Self::found) for `len` rays in the directions `way` of the samples.
    pub fn found_each(
        &self,
        isa: Isa,
        light: u32,
        (time, from, len): (&Column<f32>, &Vec3s, usize),
        to: &mut Samples,
    ) {
        struct FoundEach<'a>(Isa, &'a Vec3s, usize, &'a mut Samples);
        impl WithLamp for FoundEach<'_> {
            type Output = ();

            fn run<L: Lamp>(self, lamp: L) {
                let Self(isa, from, len, to) = self;
                lamp.found_each(isa, from, len, to);
            }
        }
        if !self.move_about() {
            return self[light as usize].with(FoundEach(isa, from, len, to));
        }
        for (i, &time) in time.iter().enumerate().take(len) {
            let (radiance, density) = self.found(light, time, from.get(i), to.way.get(i));
            to.radiance.set(i, radiance);
            to.density[i] = density;
        }
    }

    /// Whether a point lies inside a light at a time; see [`Lamp::encloses`].
    pub fn enclose(&self, light: u32, time: f32, point: Vec3) -> bool {
        struct Encloses(Pose, Vec3);
        impl WithLamp for Encloses {
            type Output = bool;

            fn run<L: Lamp>(self, lamp: L) -> bool {
                Moving { lamp, pose: self.0 }.encloses(self.1)
            }
        }
        self[light as usize].with(Encloses(self.pose(light, time), point))
    }

    /// Returns the density of a light at a time; see [`Lamp::density`].
    pub fn density(&self, light: u32, time: f32, from: Vec3, way: Vec3) -> f32 {
        struct Density(Pose, Vec3, Vec3);
        impl WithLamp for Density {
            type Output = f32;

            fn run<L: Lamp>(self, lamp: L) -> f32 {
                Moving { lamp, pose: self.0 }.density(self.1, self.2)
            }
        }
        self[light as usize].with(Density(self.pose(light, time), from, way))
    }
}

impl Light {
    /// See [`Lamp::IS_DELTA`].
    pub fn is_delta(&self) -> bool {
        struct IsDelta;
        impl WithLamp for IsDelta {
            type Output = bool;

            fn run<L: Lamp>(self, _: L) -> bool {
                L::IS_DELTA
            }
        }
        self.with(IsDelta)
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
    pub fn density(&self, from: Vec3, way: Vec3) -> f32 {
        struct Density(Vec3, Vec3);
        impl WithLamp for Density {
            type Output = f32;

            fn run<L: Lamp>(self, lamp: L) -> f32 {
                lamp.density(self.0, self.1)
            }
        }
        self.with(Density(from, way))
    }

    /// See [`Lamp::bounds`].
    pub fn bounds(&self) -> LightBounds {
        struct Bounds;
        impl WithLamp for Bounds {
            type Output = LightBounds;

            fn run<L: Lamp>(self, lamp: L) -> LightBounds {
                lamp.bounds()
            }
        }
        self.with(Bounds)
    }

    /// See [`Lamp::IS_OF_THESIS`].
    pub fn is_of_thesis(&self) -> bool {
        struct IsOfThesis;
        impl WithLamp for IsOfThesis {
            type Output = bool;

            fn run<L: Lamp>(self, _: L) -> bool {
                L::IS_OF_THESIS
            }
        }
        self.with(IsOfThesis)
    }

    /// See [`Lamp::IS_SHADED`].
    pub fn is_shaded(&self) -> bool {
        struct IsShaded;
        impl WithLamp for IsShaded {
            type Output = bool;

            fn run<L: Lamp>(self, _: L) -> bool {
                L::IS_SHADED
            }
        }
        self.with(IsShaded)
    }

    /// See [`Lamp::IS_DISTANT`].
    pub fn is_distant(&self) -> bool {
        struct IsDistant;
        impl WithLamp for IsDistant {
            type Output = bool;

            fn run<L: Lamp>(self, _: L) -> bool {
                L::IS_DISTANT
            }
        }
        self.with(IsDistant)
    }
}

#[cfg(test)]
mod tests;
