//! Photon mapping: rooms and caustics whose light is known by a formula.

use std::f64::consts::PI;

use crate::support::{Picture, Shot};

fn matte(name: &str, albedo: f64, emission: f64) -> String {
    format!(
        "material_principled {name} {{ base_color {{ {albedo} {albedo} {albedo} }}
         ior 1 specular_ior_level 0 emission_strength {emission} }} "
    )
}

/// A picture from inside of things about the origin, with the light of `photons`.
fn inside(settings: &str, things: &str) -> Picture {
    let (from, to) = (vec![[0.0, -0.3, 0.1]], vec![[0.0, 1.0, 0.0]]);
    let settings = format!("integrator PHOTON_MAP photonMapSize 60000 {settings}");
    let shot = Shot { from, to, fov: 0.9, recursion: 16, samples: 16, settings, ..Shot::default() };
    shot.take(things)
}

const GATHERS: [&str; 3] = ["gather 0", "gather 1", "gather 1 cacheError .2 gatherRays 256"];

#[test]
fn a_point_lamp_in_a_sphere_lights_it_evenly() {
    // Irradiance P / (4 pi r²), and a geometric series of it.
    let (power, radius, albedo) = (100.0, 2.0, 0.5f64);
    let scene = matte("m", albedo, 0.0)
        + "sphere s { material m center { 0 0 0 } radius 2 } "
        + &format!("lamp_point l {{ power {{ {power} {power} {power} }} position {{ 0 0 0 }} }}");
    let direct = albedo / PI * power / (4.0 * PI * radius * radius);
    for gather in GATHERS {
        // Photons from the lamp lie more evenly than by chance, so an estimate at one of them that leaves
        // it out is too dark by up to one part in as many.
        for nearest in [50, 200] {
            let picture = inside(&format!("{gather} photonNearest {nearest}"), &scene);
            picture.assert_mean([direct / (1.0 - albedo); 3], 0.02);
        }
    }
}

#[test]
fn closed_rooms_that_glow_have_a_geometric_series_of_light() {
    let room = "box b { material m vertex0 { -2 -2 -1.5 } vertex1 { 2 -2 -1.5 } \
        vertex2 { 2 2 -1.5 } height 3 } ";
    for gather in GATHERS {
        let picture = inside(gather, &(matte("m", 0.5, 0.5) + room));
        picture.assert_mean([1.0; 3], 0.02);
    }
}

#[test]
fn lamps_of_all_kinds_send_what_path_tracing_finds_of_them() {
    let room = "box b { material m vertex0 { -2 -2 -1.5 } vertex1 { 2 -2 -1.5 } \
        vertex2 { 2 2 -1.5 } height 3 } ";
    for lamp in [
        "lamp_point l { power { 30 30 30 } position { 1 1 1 } radius .2 }",
        "lamp_spot l { power { 30 30 30 } position { 1 1 1 } target { 0 .4 -1.5 } angle_deg 60 blend .4 }",
        "lamp_rectangle l { power { 30 30 30 } vertex0 { 1 1 1 } vertex1 { 1 1.5 1 } vertex2 { 1.5 1.5 1 } }",
        "lamp_disc l { power { 30 30 30 } center { 1 1 1 } normal { 1 0 -1 } radius .3 }",
        "material_principled g { base_color { 0 0 0 } ior 1 specular_ior_level 0 emission_strength 30 }
         triangle t { material g vertex0 { 1 1 1 } vertex1 { 1 1.5 1 } vertex2 { 1.5 1.5 1 } }",
        // Emission that is looked up, and what layers leave of it.
        "texture plank { filename files/plank.png }
         material_principled g { base_color { 0 0 0 } emission_strength 30 emission_color_texture plank coat .8 coat_roughness .4 }
         rectangle t { material g vertex0 { 1 1 1 } vertex1 { 1 1.5 1 } vertex2 { 1.5 1.5 1 } }",
    ] {
        let scene = matte("m", 0.6, 0.0) + room + lamp;
        let expected = {
            let (from, to) = (vec![[0.0, -0.3, 0.1]], vec![[0.0, 1.0, 0.0]]);
            let settings = "integrator PATH".to_owned();
            let shot =
                Shot { from, to, fov: 0.9, recursion: 16, samples: 64, settings, ..Shot::default() };
            [0, 1, 2].map(|c| shot.take(&scene).sum(c) / 4096.0)
        };
        for gather in GATHERS {
            inside(gather, &scene).assert_mean(expected, 0.025);
        }
    }
}

#[test]
fn a_sun_and_a_sky_light_a_floor_and_what_stands_on_it() {
    let ground =
        "rectangle g { material m vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } }
        rectangle w { material m vertex0 { -9 2 0 } vertex1 { 9 2 0 } vertex2 { 9 2 4 } } ";
    let from = vec![[0.0, -4.0, 2.0]];
    for light in [
        "lamp_sun l { irradiance { 2 2 2 } direction { 0 1 -1 } angle_deg 2 }",
        "environment l { radiance { .7 .7 .7 } }",
    ] {
        let scene = matte("m", 0.6, 0.0) + ground + light;
        let with = |settings: &str, samples| {
            let (from, settings) = (from.clone(), settings.to_owned());
            let shot = Shot { from, recursion: 8, samples, settings, ..Shot::default() };
            shot.take(&scene)
        };
        let path = with("integrator PATH", 64);
        let expected = [0, 1, 2].map(|c| path.sum(c) / 4096.0);
        for gather in GATHERS {
            let settings = format!("integrator PHOTON_MAP photonMapSize 60000 {gather}");
            with(&settings, 16).assert_mean(expected, 0.025);
        }
    }
}

#[test]
fn a_mirror_lights_a_floor_as_a_mirrored_lamp_does() {
    // A lamp in front of a mirror, and its image behind it.
    let (power, albedo) = (100.0, 0.05);
    let scene = matte("m", albedo, 0.0)
        + "rectangle g { material m vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } }
           material_principled mirror { base_color { 1 1 1 } metallic 1 roughness 0 }
           rectangle wall { material mirror vertex0 { 2 -9 0 } vertex1 { 2 9 0 } vertex2 { 2 9 9 } }"
        + &format!(" lamp_point l {{ power {{ {power} {power} {power} }} position {{ 1 0 2 }} }}");
    let irradiance = |x: f64| {
        let square = x * x + 4.0;
        power / (4.0 * PI) * 2.0 / (square * square.sqrt())
    };
    let expected = albedo / PI * (irradiance(1.0) + irradiance(3.0));
    for filter in ["CONE", "NONE"] {
        for gather in GATHERS {
            let settings = format!(
                "integrator PHOTON_MAP photonMapSize 20000 causticMapSize 200000
                 causticNearest 1000 causticFilter {filter} {gather}"
            );
            let shot = Shot {
                from: vec![[-3.0, 0.0, 6.0]],
                fov: 0.02,
                recursion: 8,
                samples: 4,
                settings,
                ..Shot::default()
            };
            shot.take(&scene).assert_mean([expected; 3], 0.05);
        }
    }
}
