//! Lights in render space: one file for each kind.

mod any;
mod lamp;
mod point;
mod rectangle;

use glam::DVec3;

use slo_scene::LightKind;

pub use any::AnyLight;
pub use lamp::Lamp;
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

/// Work that is compiled for each kind of light: what it does for a whole column of hits, it does
/// without asking for the kind.
pub trait WithLamp {
    /// What comes of it.
    type Output;

    /// Does the work for one light.
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

    /// The light in the one form for all kinds.
    pub fn any(&self) -> AnyLight {
        match *self {
            Self::Point(lamp) => lamp.into(),
            Self::Rectangle(lamp) => lamp.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use slo_scene::light::{PointLight, RectangleLight};
    use slo_scene::shape;

    use super::*;

    /// Everything that a light says of a hit, as bits.
    struct Answers {
        hit: Vec3,
        normals: [Vec3; 2],
        through: bool,
        u: [f32; 2],
    }

    fn bits(v: Vec3) -> [u32; 3] {
        v.to_array().map(f32::to_bits)
    }

    impl Answers {
        fn of_any(&self, light: &AnyLight) -> (bool, [[u32; 3]; 3], [u32; 3]) {
            let point = light.point(self.u);
            let density = light.density(point - self.hit);
            let expected = light.expected(self.hit, self.normals, self.through);
            let (direction, end) = light.shadow_ray(self.hit, point);
            let numbers = [density, expected, end].map(f32::to_bits);
            (light.is_area(), [light.color, point, direction].map(bits), numbers)
        }
    }

    impl WithLamp for &Answers {
        type Output = (bool, [[u32; 3]; 3], [u32; 3]);

        fn run<L: Lamp>(self, lamp: L) -> Self::Output {
            let point = lamp.point(self.hit, self.u);
            let way = point - self.hit;
            let expected = lamp.expected(self.hit, self.normals, self.through);
            let (direction, end) = lamp.shadow_ray(self.hit, point);
            let numbers = [lamp.density(way), expected, end].map(f32::to_bits);
            (L::IS_AREA, [lamp.radiance(way), point, direction].map(bits), numbers)
        }
    }

    #[test]
    fn the_one_form_answers_as_each_kind_does() {
        let mut rng = StdRng::seed_from_u64(4);
        let mut number = || rng.random_range(-4..=4_i32);
        let (mut points, mut areas) = (0, 0);
        for i in 0..20_000 {
            // Whole numbers: coordinates of hit and light are often equal, 0, or -0.
            let mut vector = || DVec3::new(number().into(), number().into(), number().into());
            let scale = [1.0, -0.0, 0.37, 1e6][i % 4];
            let (position, a, b) = (vector() * scale, vector(), vector());
            let across = b - b.dot(a) / a.length_squared().max(1.0) * a;
            let color = [1.0, 0.5, i as f32];
            let kind = if i % 2 == 0 || a.cross(across).length() < 1e-3 {
                points += 1;
                LightKind::Point(PointLight { color, position })
            } else {
                areas += 1;
                let vertices = [position, position + a, position + a + across];
                let rectangle = shape::Rectangle { vertices };
                LightKind::Rectangle(RectangleLight { color, rectangle })
            };
            let light = slo_scene::Light { name: "l".into(), kind };
            let light = Light::new(&light, DVec3::ZERO);
            let hit = vector().as_vec3();
            let normals = [vector(), vector()].map(|n| n.normalize_or(DVec3::Z).as_vec3());
            let u = [number(), number()].map(|k| (k + 4) as f32 / 9.0);
            let answers = Answers { hit, normals, through: i % 3 == 0, u };
            let (found, expected) = (light.with(&answers), answers.of_any(&light.any()));
            // At the light itself nothing has a direction.
            if light.any().point(u) != hit {
                assert_eq!(found, expected, "{light:?} from {hit}");
            }
        }
        assert!(points > 5000 && areas > 5000, "{points} {areas}");
    }
}
