//! All lights of a frame, one by one and by kind.

use std::ops::Deref;

use super::{Lamp, Light, Point, Rectangle};

/// The lights of a frame. For loops in which every lane has a light of its own, the lights of each kind
/// lie in a table.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    all: Vec<Light>,
    points: Vec<Point>,
    rectangles: Vec<Rectangle>,
    /// Place of each light in the table of its kind.
    place: Vec<u32>,
    /// Number of the table of each light.
    table: Vec<u32>,
}

/// Work for lights of one kind that is compiled for each kind.
pub trait WithLamps {
    /// Does the work for the lights of a table: lane by lane `mine` says whether light `i` of the frame
    /// is one of them, and `place` where it lies; `place` may be asked of any light of the frame.
    fn run<L: Lamp>(
        &mut self,
        lamps: &[L],
        mine: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> usize,
    );
}

impl Lights {
    /// Calls `work` once for each kind of which there are lights.
    pub fn for_each_kind(&self, work: &mut impl WithLamps) {
        // All tables are named, so that a new one cannot be forgotten.
        let Self { all: _, points, rectangles, place: _, table: _ } = self;
        self.for_kind(Self::POINTS, points, work);
        self.for_kind(Self::RECTANGLES, rectangles, work);
    }

    const POINTS: u32 = 0;
    const RECTANGLES: u32 = 1;

    fn for_kind<L: Lamp>(&self, table: u32, lamps: &[L], work: &mut impl WithLamps) {
        if lamps.len() == self.all.len() {
            work.run(lamps, |_| true, |light| light as usize);
        } else if !lamps.is_empty() {
            let mine = |light: u32| self.table[light as usize] == table;
            let place = |light: u32| (self.place[light as usize] as usize).min(lamps.len() - 1);
            work.run(lamps, mine, place);
        }
    }
}

impl FromIterator<Light> for Lights {
    fn from_iter<I: IntoIterator<Item = Light>>(lights: I) -> Self {
        let mut to = Self::default();
        for light in lights {
            let (table, place) = match light {
                Light::Point(point) => (Self::POINTS, push(&mut to.points, point)),
                Light::Rectangle(rectangle) => {
                    (Self::RECTANGLES, push(&mut to.rectangles, rectangle))
                }
            };
            to.table.push(table);
            to.place.push(place);
            to.all.push(light);
        }
        to
    }
}

/// Adds an entry; its place.
fn push<T>(to: &mut Vec<T>, entry: T) -> u32 {
    to.push(entry);
    to.len() as u32 - 1
}

impl Deref for Lights {
    type Target = [Light];

    fn deref(&self) -> &[Light] {
        &self.all
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use slo_scene::LightKind;
    use slo_scene::light::{PointLight, RectangleLight};
    use slo_scene::shape;

    use super::*;

    /// Radiance of each light of a frame, found through the tables.
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
        Light::new(&slo_scene::Light { name: "l".into(), kind }, DVec3::ZERO)
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
