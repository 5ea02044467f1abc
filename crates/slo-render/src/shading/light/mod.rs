//! Lights in render space: one file for each kind.

mod kinds;
mod lamp;
mod lamp_rectangle;
mod point;
mod rectangle;
pub mod receiver;
mod techniques;
mod tree;

use std::ops::Deref;

use glam::Vec3;

use kinds::lamps;

pub use kinds::{WithLamp, WithLamps};
pub use lamp::Lamp;
pub use lamp_rectangle::RectangleLamp;
pub use point::Point;
pub use rectangle::Rectangle;
pub use techniques::Techniques;
pub use tree::LightTree;

lamps! {
    /// A light.
    pub enum Light, all in Lights {
        /// `light_point`
        Point(Point) in points,
        /// `light_rectangle`
        Rectangle(Rectangle) in rectangles,
        /// `lamp_rectangle`
        RectangleLamp(RectangleLamp) in rectangle_lamps,
    }
}

impl Deref for Lights {
    type Target = [Light];

    fn deref(&self) -> &[Light] {
        &self.all
    }
}

impl Light {
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

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use slo_scene::LightKind;
    use slo_scene::light::{PointLight, RectangleLight};
    use slo_scene::shape;

    use super::*;

    /// Radiance of each light of a frame, looked up through the tables.
    struct Colors(Vec<Option<Vec3>>);

    impl WithLamps for Colors {
        fn run<L: Lamp>(
            &mut self,
            lamps: &[L],
            mine: impl Fn(u32) -> bool,
            place: impl Fn(u32) -> usize,
        ) {
            for light in 0..self.0.len() as u32 {
                let lamp = lamps[place(light)];
                if mine(light) {
                    let before = self.0[light as usize].replace(lamp.radiance(Vec3::X));
                    assert_eq!(before, None, "light {light} is in two tables");
                }
            }
        }
    }

    fn light(number: usize, is_point: bool) -> Light {
        let color = [number as f32, 0.0, 0.0];
        let vertices = [DVec3::ZERO, DVec3::X, DVec3::ONE];
        let kind = if is_point {
            LightKind::Point(PointLight { color, position: DVec3::ZERO })
        } else {
            LightKind::Rectangle(RectangleLight { color, rectangle: shape::Rectangle { vertices } })
        };
        let (name, key_frames, group) = ("l".into(), Vec::new(), None);
        let (camera_visible, solid) = (true, true);
        let light = slo_scene::Light { name, kind, key_frames, camera_visible, solid, group };
        Light::new(&light, DVec3::ZERO).unwrap()
    }

    #[test]
    fn every_light_is_in_the_table_of_its_kind() {
        for kinds in ["", "p", "r", "pp", "rr", "prprr", "rpp"] {
            let one = |(number, kind)| light(number, kind == 'p');
            let lights: Lights = kinds.chars().enumerate().map(one).collect();
            let mut colors = Colors(vec![None; kinds.len()]);
            lights.for_each_kind(&mut colors);
            for (number, color) in colors.0.into_iter().enumerate() {
                assert_eq!(color, Some(Vec3::X * number as f32), "light {number} of {kinds}");
                assert_eq!(lights[number].is_area(), &kinds[number..=number] == "r");
            }
        }
    }
}
