//! The tables of kinds.

use super::*;
use slo_scene::light::{PointLight, RectangleLight};

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
            let lamp = lamps[place(light).min(lamps.len() - 1)];
            if mine(light) {
                let before = self.0[light as usize].replace(lamp.radiance(Vec3::X));
                assert_eq!(before, None, "light {light} is in two tables");
            }
        }
    }
}

fn one(number: usize, kind: char) -> Light {
    let color = [number as f32, 0.0, 0.0];
    let vertices = [DVec3::ZERO, DVec3::X, DVec3::ONE];
    let kind = match kind {
        'p' => LightKind::Point(PointLight { color, position: DVec3::ZERO }),
        'r' => {
            LightKind::Rectangle(RectangleLight { color, rectangle: shape::Rectangle { vertices } })
        }
        _ => LightKind::Environment(scene::Environment {
            sky: Sky::Image(slo_scene::TextureId(0)),
            strength: number as f32,
            turn_deg: 0.0,
        }),
    };
    let texture = Texture::from_rgb8(1, 1, vec![255, 0, 0]).unwrap();
    light(kind, &[Arc::new(texture)])
}

#[test]
fn every_light_is_in_the_table_of_its_kind() {
    for kinds in ["", "p", "r", "pp", "rr", "prprr", "rpp", "i", "pipri"] {
        let lights: Lights = kinds.chars().enumerate().map(|(i, kind)| one(i, kind)).collect();
        let mut colors = Colors(vec![None; kinds.len()]);
        lights.for_each_kind(&mut colors);
        for (number, color) in colors.0.into_iter().enumerate() {
            assert_eq!(color, Some(Vec3::X * number as f32), "light {number} of {kinds}");
            assert_eq!(lights[number].is_area(), &kinds[number..=number] != "p");
        }
    }
}

#[test]
fn tables_of_skies_serve_another_frame() {
    let textures = [Arc::new(Texture::from_rgb8(1, 1, vec![255; 3]).unwrap())];
    let lamp = scene::Environment {
        sky: Sky::Image(slo_scene::TextureId(0)),
        strength: 1.0,
        turn_deg: 0.0,
    };
    let one = |before: &[ImageSky]| {
        let (name, key_frames, group) = ("l".into(), Vec::new(), None);
        let kind = LightKind::Environment(lamp);
        let light = slo_scene::Light {
            name,
            kind,
            key_frames,
            parent: None,
            repeat: None,
            camera_visible: true,
            solid: true,
            group,
        };
        Light::new(&light, DVec3::ZERO, &textures, Skies { share: SkyShare::All, before })
    };
    let first: Lights = std::iter::once(one(&[])).collect();
    let (Light::ImageSky(first_sky), Light::ImageSky(second)) =
        (&first[0], one(first.image_skies()))
    else {
        panic!("an image");
    };
    assert!(second.shares_table(first_sky));
}
