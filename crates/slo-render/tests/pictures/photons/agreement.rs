//! Pictures with and without photons agree wherever paths from the camera find all light.

use slo_accel::Isa;
use slo_render::frame::FrameScene;

use crate::support::{describe, expose_frame};

const SEEDS: u32 = 16;

/// Limit, in standard deviations, that chance exceeds in one comparison of the suite once in a
/// thousand runs.
const APART: f64 = 4.8;

/// What blurring may change, besides chance.
const BLUR: f64 = 0.004;

struct Case {
    name: &'static str,
    settings: &'static str,
    elements: &'static str,
}

/// A floor that fills the view, matter that photons pass, and a large lamp that the camera does not see.
const COMMON: &str = "
    material_principled matte { base_color { .6 .5 .4 } ior 1 specular_ior_level 0 }
    material_principled mirror { base_color { .9 .9 .9 } metallic 1 roughness 0 }
    material_principled satin { base_color { .9 .9 .9 } metallic 1 roughness .316 }
    material_principled glass { base_color { .95 1 .9 } transmission 1 roughness 0 }
    material_principled frosted { base_color { .95 1 .9 } transmission 1 roughness .3 }
    material_principled pane { base_color { .8 .8 .8 } transmission 1 roughness 0 alpha .5 }
    material_mix mixed { first mirror second matte factor .4 }
    material_principled lacquer {
        base_color { .9 .4 .2 } metallic 1 roughness .3
        coat 1 coat_roughness .2 coat_tint { .3 .6 .3 } sheen .8 sheen_roughness .3
    }
    phong_info chrome_info { diffuse { .1 .1 .1 } specular { .2 .2 .2 } shininess 20 reflectance .7 }
    material_phong chrome { phong_info chrome_info }
    phong_info brushed_info { diffuse { .1 .1 .1 } reflectance .7 diffuse_reflection .08 }
    material_phong brushed { phong_info brushed_info }
    phong_info clear_info { refraction .8 refraction_index 1.5 reflectance .2 }
    material_phong clear { phong_info clear_info }
    plane floor { material matte normal { 0 0 1 } position { 0 0 -2 } }
";

fn text(case: &Case, photons: f64, seed: u32) -> String {
    let Case { settings, elements, .. } = case;
    let recursion = if settings.contains("recursion") { "" } else { "recursion 4" };
    format!(
        "settings s {{ imageSamples 4 {recursion} generatorType PSEUDO seed {seed}
             integrator PATH photons {photons} {settings} }}
         Camera c {{
             fps 4
             Film f {{ width 64 height 48 prefix t output PNG_IMAGE }}
             CamSegment seg {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 fovStart .35 blurDuration .25
                 addPosition {{ 0 -9 3 }} addTarget {{ 0 0 -1 }}
             }}
         }}
         {COMMON} {elements}"
    )
}

/// Means of the left and the right half of a picture, for each channel.
fn halves(scene: &str) -> [f64; 6] {
    let description = describe(scene);
    let frame = FrameScene::build(&description, 0, Isa::best()).expect("the frame can be built");
    let image = expose_frame(&description, &frame).image();
    let mut sums = [0.0; 6];
    for (i, pixel) in image.rgb.iter().enumerate() {
        let half = usize::from(i % 64 >= 32);
        (0..3).for_each(|c| sums[3 * half + c] += f64::from(pixel[c]) / (32.0 * 48.0));
    }
    sums
}

/// Mean over seeds, and the variance of the mean.
fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, variance / n)
}

#[track_caller]
fn assert_agreement(cases: &[Case]) {
    let mut wrong = String::new();
    for case in cases {
        let take = |photons: f64, first: u32| -> Vec<[f64; 6]> {
            (first..first + SEEDS).map(|seed| halves(&text(case, photons, seed))).collect()
        };
        let (without, with) = (take(0.0, 0), take(4.0, SEEDS));
        for k in 0..6 {
            let of = |all: &[[f64; 6]]| moments(&all.iter().map(|s| s[k]).collect::<Vec<_>>());
            let ((a, va), (b, vb)) = (of(&without), of(&with));
            let sigma = (va + vb).sqrt();
            let found = format!(
                "{}, {k}: {a:.5} without and {b:.5} with photons, {:+.2} %, {:.1} deviations of {:.2} %\n",
                case.name,
                100.0 * (b / a - 1.0),
                (b - a) / sigma,
                100.0 * sigma / a
            );
            if (b - a).abs() > APART * sigma + BLUR * a {
                wrong.push_str(&found);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Puts a thing of a material over the floor, under the large disc.
macro_rules! case {
    ($name:literal, $settings:literal, $elements:literal) => {
        Case {
            name: $name,
            settings: $settings,
            elements: concat!(
                $elements,
                "\nlamp_disc l { radiance { 6 5 4 } center { 3 1 4 } normal { -1 -.3 -1 } radius 2 }"
            ),
        }
    };
}

#[test]
fn mirrors_and_glass() {
    assert_agreement(&[
        case!(
            "mirror",
            "",
            "box b { material mirror vertex0 { -2 2 -1.5 } vertex1 { 0 3 -1.5 } vertex2 { -.5 4 -1.5 } height 4 }"
        ),
        case!("ball of glass", "", "sphere b { material glass center { 0 0 -.4 } radius 1 }"),
        case!("ball of Phong", "", "sphere b { material clear center { 0 0 -.4 } radius 1 }"),
        case!("ball of chrome", "", "sphere b { material chrome center { 0 0 -.4 } radius 1 }"),
        case!("brushed", "", "sphere b { material brushed center { 0 0 -.4 } radius 1 }"),
        case!("satin", "", "sphere b { material satin center { 0 0 -.4 } radius 1 }"),
        case!("frosted", "", "sphere b { material frosted center { 0 0 -.4 } radius 1 }"),
        case!("lacquer", "", "sphere b { material lacquer center { 0 0 -.4 } radius 1 }"),
    ]);
}

#[test]
fn bounds_and_numbers_of_rays() {
    assert_agreement(&[
        case!(
            "recursion 0",
            "recursion 0",
            "sphere b { material mirror center { 0 0 -.4 } radius 1 }"
        ),
        case!(
            "recursion 1",
            "recursion 1",
            "sphere b { material mirror center { 0 0 -.4 } radius 1 } sphere c { material glass center { 2 0 -.4 } radius .8 }"
        ),
        case!(
            "recursion 2",
            "recursion 2",
            "sphere b { material mirror center { 0 0 -.4 } radius 1 } sphere c { material glass center { 2 0 -.4 } radius .8 }"
        ),
        case!(
            "several rays",
            "softShadowSamples 3 diffuseReflectionSamples 2",
            "sphere b { material satin center { 0 0 -.4 } radius 1 }"
        ),
        case!(
            "all lamps",
            "lightSamplingType SAMPLE_ALL_AT_TIME",
            "sphere b { material satin center { 0 0 -.4 } radius 1 }
            lamp_point q { power { 90 90 90 } position { -2 -1 3 } radius .6 }"
        ),
    ]);
}

#[test]
fn alpha_and_mixes() {
    assert_agreement(&[
        case!("mixed", "", "sphere b { material mixed center { 0 0 -.4 } radius 1 }"),
        case!("alpha", "", "sphere b { material pane center { 0 0 -.4 } radius 1 }
            rectangle p { material pane vertex0 { -3 -1 -1 } vertex1 { 3 -1 -1 } vertex2 { 3 0 2 } }"),
        case!("emitting mesh", "", "material_principled glow { base_color { .2 .2 .2 } emission_strength 4 }
            box lit { material glow vertex0 { -3 1 -1 } vertex1 { -2 1 -1 } vertex2 { -2 2 -1 } height 1 }
            sphere b { material glass center { 0 0 -.4 } radius 1 }"),
    ]);
}

#[test]
fn emitters_with_images_and_layers() {
    assert_agreement(&[
        Case {
            name: "image",
            settings: "",
            elements: "texture plank { filename files/plank.png }
                material_principled lit { base_color { 0 0 0 } emission_strength 9 emission_color_texture plank }
                rectangle e { material lit vertex0 { 1 2 -1 } vertex1 { 3 1 -1 } vertex2 { 3 1 1.5 } }
                sphere b { material glass center { 0 0 -.4 } radius 1 }",
        },
        Case {
            name: "coat",
            settings: "",
            elements: "material_principled lit { base_color { .3 .2 .1 } emission_strength 5 coat 1 coat_roughness .3 }
                rectangle e { material lit vertex0 { 1 2 -1 } vertex1 { 3 1 -1 } vertex2 { 3 1 1.5 } }
                sphere b { material mirror center { 0 0 -.4 } radius 1 }",
        },
        Case {
            name: "mixed",
            settings: "",
            elements: "texture plank { filename files/plank.png }
                material_principled glow { base_color { 0 0 0 } emission_strength 9 }
                material_mix lit { first glow second matte factor_texture plank }
                rectangle e { material lit vertex0 { 1 2 -1 } vertex1 { 3 1 -1 } vertex2 { 3 1 1.5 } }
                sphere b { material glass center { 0 0 -.4 } radius 1 }",
        },
    ]);
}

#[test]
fn smooth_meshes() {
    assert_agreement(&[
        case!(
            "smooth mirror",
            "",
            "mesh ball { filename files/ball.obj smooth_normals 1 material mirror addKframe { time 0 key { pivot { 0 0 -.4 } } } }"
        ),
        case!(
            "smooth glass",
            "",
            "mesh ball { filename files/ball.obj smooth_normals 1 material glass addKframe { time 0 key { pivot { 0 0 -.4 } } } }"
        ),
    ]);
}

#[test]
fn moving_things() {
    assert_agreement(&[
        case!("moving mirror", "", "sphere b { material mirror center { 0 0 0 } radius 1
            addKframe { time 0 key { pivot { -1 0 -.6 } } } addKframe { time 1 key { pivot { 1 0 .4 } } } }"),
        case!("moving receiver", "", "sphere b { material glass center { 0 0 .6 } radius 1 }
            rectangle r { material matte vertex0 { -3 -3 0 } vertex1 { 3 -3 0 } vertex2 { 3 3 0 }
                addKframe { time 0 key { pivot { 0 0 -1.9 } } } addKframe { time 1 key { pivot { 0 0 -.9 } } } }"),
        Case { name: "moving lamp", settings: "", elements: "sphere b { material glass center { 0 0 -.4 } radius 1 }
            lamp_point l { power { 300 300 300 } position { 0 0 0 } radius .7
                addKframe { time 0 key { pivot { 3 1 3 } } } addKframe { time 1 key { pivot { -1 1 4 } } } }" },
    ]);
}

#[test]
fn skies_and_suns() {
    assert_agreement(&[
        Case { name: "sky", settings: "", elements: "environment e { radiance { .5 .6 .7 } }
            sphere b { material glass center { 0 0 -.4 } radius 1 } sphere c { material satin center { 2 0 -.4 } radius .8 }" },
        Case { name: "wide sun", settings: "", elements: "lamp_sun l { irradiance { 3 3 3 } direction { 1 1 -2 } angle_deg 30 }
            sphere b { material glass center { 0 0 -.4 } radius 1 } sphere c { material satin center { 2 0 -.4 } radius .8 }" },
        Case { name: "lamps of all kinds", settings: "", elements: "
            lamp_rectangle r { radiance { 3 3 3 } vertex0 { -3 -2 4 } vertex1 { -3 2 4 } vertex2 { -1 2 4 } two_sided 1 }
            lamp_point p { power { 60 50 40 } position { 3 2 3 } radius 1 solid 0 }
            lamp_spot q { power { 60 50 40 } position { 3 -2 3 } radius .5 target { 0 0 0 } angle_deg 70 camera_visible 0 }
            light_rectangle o { color { .2 .2 .2 } vertex0 { -3 -4 4 } vertex1 { -3 -2 4 } vertex2 { -1 -2 4 } }
            sphere b { material glass center { 0 0 -.4 } radius 1 } sphere c { material mirror center { 2 0 -.4 } radius .8 }" },
    ]);
}
