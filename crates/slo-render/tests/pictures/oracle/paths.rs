//! Scenes of `integrator PATH` against plain path tracing.

use super::{agrees, assert_agrees, differences, differences_between, scene, scene_seen};
use crate::support::describe;

/// Principled materials without gloss over their base.
fn physical(name: &str, inputs: &str) -> String {
    format!("material_principled {name} {{ ior 1.45 specular_ior_level 0 {inputs} }}\n")
}

/// A floor, a wall, and shapes of materials a to d.
fn room(materials: [&str; 4]) -> String {
    let named = ["a", "b", "c", "d"].iter().zip(materials);
    let materials: String = named.map(|(name, inputs)| physical(name, inputs)).collect();
    materials
        + &physical("wall", "base_color { .7 .6 .5 }")
        + &physical("white", "base_color { .9 .9 .9 }")
        + "
    rectangle floor { material wall vertex0 { -6 -6 -1 } vertex1 { 6 -6 -1 } vertex2 { 6 6 -1 } }
    rectangle back { material white vertex0 { -6 4 -1 } vertex1 { 6 4 -1 } vertex2 { 6 4 5 } }
    sphere s1 { material a center { -1.6 0 0 } radius 0.9 }
    sphere s2 { material b center { 1.7 0.5 0.1 } radius 0.8 }
    box b1 { material c vertex0 { -0.5 -1.5 -0.9 } vertex1 { 0.3 -1.8 -0.9 } vertex2 { 0.5 -1.2667 -0.9 } height 0.7 }
    triangle t1 { material d vertex0 { -1 2 -0.5 } vertex1 { 1 2 -0.5 } vertex2 { 0 2.5 2 } }\n"
}

const LAMPS: &str = "
    lamp_point p { power { 300 280 250 } position { 3 -4 5 } }
    lamp_point ball { power { 200 210 250 } position { -3 -3 3 } radius .5 }
    lamp_spot spot { power { 90 40 30 } position { 0 -3 4 } target { 0 0 0 } angle_deg 50 blend .4 }
    lamp_rectangle panel { radiance { 4 5 6 } vertex0 { -4 1 4 } vertex1 { -4 3 4 } vertex2 { -2 3 4.5 } }
    lamp_disc disc { radiance { 7 6 3 } center { 3 2 3.5 } normal { -.3 -.4 -1 } radius .7 two_sided 1 }
    lamp_sun sun { irradiance { .8 .7 .6 } direction { 1 2 -3 } angle_deg 8 }
    lamp_sun beam { irradiance { .3 .1 .1 } direction { -1 2 -2 } angle_deg 0 }\n";

const SKY: &str = "environment sky { radiance { .3 .4 .6 } strength .8 }\n";

const MATT: &str = "base_color { .6 .3 .2 }";
const MIRROR: &str = "base_color { .9 .8 .6 } specular_tint { .8 .9 1 } metallic 1 roughness 0";
const BRUSHED: &str = "base_color { .8 .5 .3 } metallic 1 roughness .35";
const HALF: &str = "base_color { .5 .6 .3 } metallic .5 roughness .4";
const GLASS: &str = "base_color { .9 1 .95 } transmission 1 roughness 0";
const BOTTLE: &str = "base_color { 1 1 1 } transmission .8 roughness 0
    absorption_color { .4 .8 .5 } absorption_distance .7";
const VEIL: &str = "base_color { .3 .5 .8 } alpha .4";

fn path(settings: &str, elements: &str) -> String {
    // The background is black where there is another sky.
    let text = scene(&format!("integrator PATH {settings}"), elements);
    text.replace("background { .1 .2 .4 }", "")
}

#[test]
fn matt_surfaces_under_every_lamp() {
    for sampling in ["SAMPLE_ONE_AT_TIME", "SAMPLE_ALL_AT_TIME"] {
        let settings = format!("recursion 2 lightSamplingType {sampling}");
        assert_agrees(&path(&settings, &(room([MATT; 4]) + LAMPS + SKY)));
    }
}

#[test]
fn several_rays_of_first_hits() {
    let all = room([MATT, HALF, MATT, BRUSHED]) + LAMPS;
    assert_agrees(&path("recursion 1 softShadowSamples 3 diffuseReflectionSamples 2", &all));
}

#[test]
fn metals_by_every_generator() {
    for generator in ["PSEUDO", "ZERO_TWO", "QUASI"] {
        let all = room([MIRROR, HALF, BRUSHED, MIRROR]) + LAMPS + SKY;
        assert_agrees(&path(&format!("recursion 3 generatorType {generator} seed 5"), &all));
    }
}

#[test]
fn glass_and_what_it_absorbs() {
    assert_agrees(&path("recursion 4", &(room([GLASS, BOTTLE, GLASS, MATT]) + LAMPS + SKY)));
}

#[test]
fn veils_and_mixes() {
    let mixes = "material_mix inner { first a second b factor .3 }
        material_mix outer { first inner second c factor .6 }
        sphere ball { material outer center { 0 -2 1 } radius .6 }
        sphere thin { material inner center { -2 -2 .2 } radius .4 }";
    let all = room([MATT, VEIL, HALF, VEIL]) + mixes + LAMPS + SKY;
    assert_agrees(&path("recursion 3", &all));
}

#[test]
fn lamps_that_hide_and_lamps_that_let_rays_pass() {
    let lamps = LAMPS
        .replace("radius .5", "radius .5 solid 0")
        .replace("two_sided 1", "camera_visible 0")
        .replace("vertex0 { -4 1 4 }", "solid 0 vertex0 { -4 1 4 }");
    let seen = "addPosition { 0 -9 4 } addTarget { 0 0 2 }";
    let settings = "integrator PATH recursion 3";
    let text = scene_seen(seen, settings, &(room([MIRROR, MATT, MATT, BRUSHED]) + &lamps));
    assert_agrees(&text);
}

const GLOW: &str = "material_principled glow { base_color { 0 0 0 } specular_ior_level 0
        emission_color { 1 .7 .4 } emission_strength 6 }
    rectangle neon { material glow vertex0 { -3 -1 3 } vertex1 { -1 -1 3.2 } vertex2 { -1 -.5 3.2 } }
    mesh star { filename files/tetrahedron.slo material glow }
    sphere spark { material glow center { 2.5 -1.5 .5 } radius .3 sampled 0 }
    rectangle dim { material glow sampled 0 vertex0 { 2 3 0 } vertex1 { 3 3 0 } vertex2 { 3 3 1 } }\n";

#[test]
fn things_that_glow() {
    for settings in [
        "recursion 2",
        "recursion 4",
        "recursion 2 lightSamplingType SAMPLE_ALL_AT_TIME softShadowSamples 2",
        "recursion 0 lightSamplingType SAMPLE_ALL_AT_TIME",
    ] {
        let all = room([MATT, MIRROR, BRUSHED, VEIL])
            + GLOW
            + "lamp_point p { power { 90 90 90 } position { 3 -4 5 } }";
        assert_agrees(&path(settings, &all));
    }
}

#[test]
fn the_comparison_finds_small_mistakes_in_paths() {
    let text = path("recursion 3", &(room([MIRROR, HALF, MATT, GLASS]) + LAMPS + GLOW));
    for (what, instead) in [
        ("recursion 3", "recursion 2"),
        ("power { 200 210 250 }", "power { 204 210 250 }"),
        ("radiance { 4 5 6 }", "radiance { 4.1 5 6 }"),
        ("roughness .4", "roughness .41"),
        ("emission_strength 6", "emission_strength 6.1"),
        ("base_color { .7 .6 .5 }", "base_color { .71 .6 .5 }"),
    ] {
        assert!(text.contains(what), "{what}");
        let [right, wrong] =
            [text.clone(), text.replace(what, instead)].map(|text| describe(&text));
        let mistaken = differences_between(&right, &wrong);
        assert!(!agrees(&mistaken), "{what}");
    }
    assert!(agrees(&differences(&describe(&text))));
}
