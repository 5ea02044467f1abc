//! Path tracing: rooms, furnaces and lamps whose light is known by a formula.

use std::f64::consts::PI;

use crate::support::{Shot, material};

/// A matte surface: no gloss at any angle.
fn matte(albedo: f64, emission: f64) -> String {
    format!(
        "material_principled m {{ base_color {{ {albedo} {albedo} {albedo} }}
         ior 1 specular_ior_level 0 emission_strength {emission} }} "
    )
}

/// A view from inside of things about the origin.
fn inside(recursion: u32, samples: u32) -> Shot {
    let (from, to) = (vec![[0.0, -0.3, 0.1]], vec![[0.0, 1.0, 0.0]]);
    let settings = "integrator PATH".to_owned();
    Shot { from, to, fov: 0.9, recursion, samples, settings, ..Shot::default() }
}

const BALL: &str = "sphere s { material m center { 0 0 0 } radius 2 } ";
const ROOM: &str = "box b { material m vertex0 { -2 -2 -1.5 } vertex1 { 2 -2 -1.5 } \
    vertex2 { 2 2 -1.5 } height 3 } ";

#[test]
fn closed_rooms_that_glow_have_a_geometric_series_of_light() {
    let (albedo, emission) = (0.5f64, 0.5);
    for room in [BALL, ROOM] {
        for bounces in [0u32, 1, 4] {
            let terms = f64::from(bounces) + 2.0;
            let expected = emission * (1.0 - libm::pow(albedo, terms)) / (1.0 - albedo);
            let picture = inside(bounces, 64).take(&(matte(albedo, emission) + room));
            picture.assert_mean([expected; 3], 0.002);
        }
    }
}

#[test]
fn furnishings_do_not_change_a_room_that_glows_evenly() {
    let metal = "material_principled metal { base_color { .5 .5 .5 } metallic 1 roughness .3
        emission_strength .5 specular_tint { .5 .5 .5 } } ";
    let more = "sphere a { material m center { .6 .8 .2 } radius .4 }
        box c { material m vertex0 { -1 .5 -1 } vertex1 { -.4 .5 -1 } vertex2 { -.4 1.2 -1 } height .7 }";
    let picture = inside(24, 64).take(&(matte(0.5, 0.5) + metal + ROOM + more));
    picture.assert_mean([1.0; 3], 0.002);
}

#[test]
fn a_point_lamp_in_a_sphere_lights_it_evenly() {
    // Irradiance P / (4 pi r²), and a geometric series of it.
    let (power, radius, albedo) = (100.0, 2.0, 0.5f64);
    let lamp =
        format!("lamp_point l {{ power {{ {power} {power} {power} }} position {{ 0 0 0 }} }}");
    let direct = albedo / PI * power / (4.0 * PI * radius * radius);
    for (bounces, terms) in [(0u32, 1.0), (3, 4.0)] {
        // The last hit asks the lamp too, but no ray can hit the lamp.
        let expected = direct * (1.0 - libm::pow(albedo, terms)) / (1.0 - albedo);
        let picture = inside(bounces, 64).take(&(matte(albedo, 0.0) + BALL + &lamp));
        picture.assert_mean([expected; 3], 0.002);
    }
}

/// A view of a floor from above.
fn floor(settings: &str) -> Shot {
    Shot {
        from: vec![[0.0, -3.0, 6.0]],
        fov: 0.02,
        recursion: 0,
        settings: settings.to_owned(),
        ..Shot::default()
    }
}

#[test]
fn floors_under_lamps_get_the_irradiance_of_the_formulas() {
    let rectangle = {
        // 2 x 2 at height 3, over its middle.
        let (x, d) = (1.0f64, 3.0);
        let a = (d * d + x * x).sqrt();
        2.0 * 5.0 * 2.0 * x / a * libm::atan(x / a)
    };
    let lamps = [
        ("lamp_point l { power { 90 90 90 } position { 0 0 3 } }", 90.0 / (4.0 * PI * 9.0)),
        (
            "lamp_point l { power { 90 90 90 } position { 0 0 3 } radius .5 }",
            90.0 / (4.0 * PI * 9.0),
        ),
        (
            "lamp_point l { power { 90 90 90 } position { 0 0 3 } radius 1 solid 0 camera_visible 0 }",
            90.0 / (4.0 * PI * 9.0),
        ),
        ("lamp_sun l { irradiance { 2 2 2 } direction { 0 0 -1 } angle_deg 5 }", 2.0),
        ("lamp_sun l { irradiance { 2 2 2 } direction { 0 0 -1 } angle_deg 0 }", 2.0),
        ("environment l { radiance { .7 .7 .7 } }", PI * 0.7),
        (
            "lamp_rectangle l { radiance { 5 5 5 }
              vertex0 { -1 -1 3 } vertex1 { -1 1 3 } vertex2 { 1 1 3 } }",
            rectangle,
        ),
        (
            "lamp_disc l { radiance { 5 5 5 } center { 0 0 3 } normal { 0 0 -1 } radius 1 }",
            PI * 5.0 / 10.0,
        ),
        ("light_point l { color { .4 .4 .4 } position { 0 0 3 } }", PI * 0.4),
    ];
    let ground =
        "rectangle g { material m vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } } ";
    for (lamp, irradiance) in lamps {
        for integrator in
            ["integrator PATH", "", "integrator PATH lightSamplingType SAMPLE_ALL_AT_TIME"]
        {
            let picture = floor(integrator).take(&(matte(0.6, 0.0) + ground + lamp));
            picture.assert_mean([0.6 / PI * irradiance; 3], 0.004);
        }
    }
}

#[test]
fn white_things_vanish_under_an_even_sky() {
    let materials = [
        "base_color { 1 1 1 } ior 1 specular_ior_level 0",
        "base_color { 1 1 1 } metallic 1 roughness 0",
        "base_color { 1 1 1 } metallic 1 roughness .4",
        "base_color { 1 1 1 } metallic 1 roughness 1",
        "base_color { 1 1 1 } roughness .3",
        "base_color { 1 1 1 } transmission 1 roughness 0",
        "base_color { 1 1 1 } transmission 1 roughness .4",
        "base_color { 1 1 1 } coat 1",
        "base_color { 1 1 1 } sheen 1",
        "base_color { 1 1 1 } transmission 1 thin 1 roughness 0",
    ];
    for principled in materials {
        for sky in ["environment e { radiance { 1 1 1 } }", ""] {
            let background = if sky.is_empty() { "background { 1 1 1 }" } else { "" };
            let settings = format!("integrator PATH {background}");
            let shot = Shot { fov: 0.2, recursion: 40, settings, ..Shot::default() };
            let scene = format!(
                "material_principled m {{ {principled} }} {sky}
                 sphere s {{ material m center {{ 0 0 0 }} radius 1.5 }}"
            );
            shot.take(&scene).assert_mean([1.0; 3], 0.005);
        }
    }
}

#[test]
fn phong_surfaces_meet_skies_and_each_other() {
    // A floor of albedo .5 under a sky of 1 that lights it evenly.
    let phong = material("m", "diffuse { .5 .5 .5 }");
    let ground =
        "rectangle g { material m vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } } ";
    let picture = floor("integrator PATH background { 1 1 1 }").take(&(phong + ground));
    picture.assert_mean([0.5; 3], 0.002);
}

#[test]
fn alpha_and_mixes_keep_their_proportions() {
    let ground =
        "rectangle g { material m vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } } ";
    let pane =
        "rectangle p { material pane vertex0 { -9 -9 2 } vertex1 { 9 -9 2 } vertex2 { 9 9 2 } } ";
    let lamp = "lamp_sun l { irradiance { 3 3 3 } direction { 0 0 -1 } angle_deg 0 } ";
    let black =
        "material_principled pane { base_color { 0 0 0 } ior 1 specular_ior_level 0 alpha .3 } ";
    // .7 of the light reaches the floor, and .7 of that the camera.
    let picture = floor("integrator PATH").take(&(matte(0.6, 0.0) + black + ground + pane + lamp));
    picture.assert_mean([0.6 / PI * 3.0 * 0.7 * 0.7; 3], 0.006);
    let mixed = "material_principled black { base_color { 0 0 0 } ior 1 specular_ior_level 0 }
        material_principled white { base_color { .8 .8 .8 } ior 1 specular_ior_level 0 }
        material_mix m { first black second white factor .25 } ";
    let picture = floor("integrator PATH").take(&(mixed.to_owned() + ground + lamp));
    picture.assert_mean([0.8 * 0.25 / PI * 3.0; 3], 0.004);
}

#[test]
fn light_fades_in_glass_by_the_law_of_beer() {
    // Straight through 2 units of clear matter: half is left after 1 unit.
    let glass = "material_principled m { base_color { 1 1 1 } transmission 1 roughness 0 ior 1
        absorption_color { .5 .25 1 } absorption_distance 1 } ";
    let slab = "box b { material m vertex0 { -9 -1 -9 } vertex1 { 9 -1 -9 } vertex2 { 9 1 -9 } height 18 } ";
    let settings = "integrator PATH background { 1 1 1 }".to_owned();
    let shot = Shot { fov: 0.02, settings, recursion: 4, ..Shot::default() };
    shot.take(&(glass.to_owned() + slab)).assert_mean([0.25, 0.0625, 1.0], 0.002);
}

#[test]
fn camera_rays_pass_clear_panes_however_many_came_before() {
    let clear =
        "material_principled pane { base_color { 0 0 0 } ior 1 specular_ior_level 0 alpha 0 }
        rectangle p { material pane vertex0 { -9 -9 2 } vertex1 { 9 -9 2 } vertex2 { 9 9 2 } } ";
    let shot = floor("integrator PATH background { 1 1 1 }");
    // Many more batches than a ray may pass surfaces in a row.
    Shot { samples: 300, ..shot }.take(clear).assert_mean([1.0; 3], 0.0);
}
