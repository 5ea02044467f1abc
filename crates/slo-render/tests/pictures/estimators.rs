//! Noise reduction does not change a picture's expectation: means over many seeds agree with the
//! means of the plainest estimator, and vary less.

use slo_accel::Isa;
use slo_render::frame::FrameScene;
use slo_render::shading::light::Techniques;

use crate::support::{describe, expose_counted, expose_frame, material};

/// Settings and camera.
fn seen(settings: &str, seed: u32) -> String {
    format!(
        "settings s {{ imageSamples 4 recursion 3 generatorType PSEUDO seed {seed} {settings} }}
         Camera c {{
             fps 4
             Film f {{ width 32 height 24 prefix t output PNG_IMAGE }}
             CamSegment seg {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 fovStart .4
                 addPosition {{ 0 -9 3 }} addTarget {{ 0 0 .5 }}
             }}
         }}"
    )
}

/// A lamp over a rough floor, half of it behind a pane of rough glass. `settings` are added.
fn scene(settings: &str, seed: u32) -> String {
    let materials = material(
        "brushed",
        "reflectance .8 diffuse_reflection .15 diffuse { .1 .1 .1 }",
    ) + &material(
        "frosted",
        "refraction .8 refraction_index 1.4 diffuse_refraction .2 reflectance .1 diffuse_reflection .2",
    );
    format!(
        "{}
         {materials}
         plane floor {{ material brushed normal {{ 0 0 1 }} position {{ 0 0 -.5 }} }}
         box pane {{ material frosted vertex0 {{ -3 -3 -.4 }} vertex1 {{ -.5 -3 -.4 }} vertex2 {{ -.5 -2.8 -.4 }} height 4 }}
         light_rectangle lamp {{ color {{ 3 2 1 }} vertex0 {{ -2 3 3 }} vertex1 {{ 1 3 3 }} vertex2 {{ 1 4 3.5 }} }}
         light_rectangle low {{ color {{ 1 1 2 }} vertex0 {{ 2 2 0 }} vertex1 {{ 3 2 0 }} vertex2 {{ 3 2 1 }} }}",
        seen(settings, seed)
    )
}

/// A dark ball and a dark floor, seen in a dim mirror, so that every ray to a light has little
/// weight.
fn dark_scene(settings: &str, seed: u32) -> String {
    let materials = material("mirror", "reflectance .12 diffuse { 0 0 0 }")
        + &material("dark", "diffuse { .03 .02 .012 } specular { .01 .01 .01 } shininess 9");
    format!(
        "{}
         {materials}
         plane wall {{ material mirror normal {{ 0 -1 0 }} position {{ 0 2 0 }} }}
         rectangle ground {{ material dark vertex0 {{ -9 -40 -1 }} vertex1 {{ 9 -40 -1 }} vertex2 {{ 9 -9.5 -1 }} }}
         sphere ball {{ material dark center {{ 0 -14 1 }} radius 2 }}
         light_rectangle lamp {{ color {{ 1 .9 .8 }} vertex0 {{ -2 -9 9 }} vertex1 {{ 1 -9 9 }} vertex2 {{ 1 -12 9 }} }}
         light_point dim {{ color {{ .2 .1 .3 }} position {{ 6 -10 5 }} }}",
        seen(settings, seed)
    )
}

/// Means of the left and the right half of a picture, for each channel. `with` changes the frame.
fn halves(scene: &str, with: impl Fn(FrameScene) -> FrameScene) -> [f64; 6] {
    let description = describe(scene);
    let frame = FrameScene::build(&description, 0, Isa::best()).expect("the frame can be built");
    let frame = with(frame);
    let image = expose_frame(&description, &frame).image();
    let mut sums = [0.0; 6];
    for (i, pixel) in image.rgb.iter().enumerate() {
        let half = usize::from(i % 32 >= 16);
        (0..3).for_each(|c| sums[3 * half + c] += f64::from(pixel[c]) / 384.0);
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

/// For each half and channel: how many standard deviations apart the two estimators are, and the
/// ratio of their variances. `scene` takes a seed.
fn compare(scene: impl Fn(u32) -> String, bias: f64) -> [(f64, f64); 6] {
    let take = |plain| -> Vec<[f64; 6]> {
        let first = if plain { 0 } else { SEEDS };
        let with = |frame: FrameScene| if plain { frame.plain() } else { frame };
        (first..first + SEEDS).map(|seed| halves(&scene(seed), with)).collect()
    };
    let (plain, clever) = (take(true), take(false));
    std::array::from_fn(|k| {
        let of = |all: &[[f64; 6]]| moments(&all.iter().map(|sums| sums[k]).collect::<Vec<_>>());
        let ((a, va), (b, vb)) = (of(&plain), of(&clever));
        ((a - b * bias).abs() / (va + vb).sqrt(), va / vb)
    })
}

const SEEDS: u32 = 48;

/// Limit, in standard deviations, that chance exceeds in one comparison of the suite once in a
/// thousand runs.
const APART: f64 = 4.8;

#[test]
fn lamps_in_rough_surfaces_are_as_bright_and_less_noisy() {
    for settings in [
        "",
        "lightSamplingType SAMPLE_ONE_AT_TIME softShadowSamples 2",
        "softShadowSamples 3 diffuseReflectionSamples 2 diffuseRefractionSamples 3",
        "shadow TRANSPARENT",
    ] {
        let compared = compare(|seed| scene(settings, seed), 1.0);
        assert!(compared.iter().all(|(apart, _)| *apart < APART), "{settings}: {compared:?}");
        // With transparent shadows, estimators are not combined.
        if settings.is_empty() {
            let less = compared.iter().map(|(_, less)| less).sum::<f64>() / 6.0;
            assert!(less > 1.2, "{compared:?}");
        }
    }
}

#[test]
fn one_light_of_many_is_one_that_matters() {
    // Most lights are dim, below the floor, or behind the visible surfaces.
    let many: String = (0..12)
        .map(|i| {
            let (bright, z) = (0.05 * f64::from(i % 4), f64::from(i % 3) * 4.0 - 3.0);
            format!(
                "light_point l{i} {{ color {{ {bright} .1 {bright} }} position {{ {i} 3 {z} }} }}\n"
            )
        })
        .collect();
    let settings = format!("lightSamplingType SAMPLE_ONE_AT_TIME }} {many} #");
    let compared = compare(|seed| scene(&settings, seed), 1.0);
    assert!(compared.iter().all(|(apart, _)| *apart < APART), "{compared:?}");
    let less = compared.iter().map(|(_, less)| less).sum::<f64>() / 6.0;
    assert!(less > 1.5, "{compared:?}");
}

#[test]
fn weak_rays_to_lights_bring_as_much_at_a_chance() {
    for settings in ["", "lightSamplingType SAMPLE_ONE_AT_TIME", "shadow TRANSPARENT"] {
        let compared = compare(|seed| dark_scene(settings, seed), 1.0);
        assert!(compared.iter().all(|(apart, _)| *apart < APART), "{settings}: {compared:?}");
        // Roulette is active: fewer rays have more variance.
        let more = compared.iter().map(|(_, less)| 1.0 / less).sum::<f64>() / 6.0;
        assert!(!settings.is_empty() || more > 1.2, "{compared:?}");
    }
}

#[test]
fn a_bias_of_two_per_cent_is_found_out() {
    let compared = compare(|seed| scene("", seed), 1.02);
    assert!(compared.iter().any(|(apart, _)| *apart > APART), "{compared:?}");
}

/// A room with metal, gloss and glass, lit by a lamp of every kind that rays can hit, and a glowing
/// box. The lamps are large, so that every technique finds them.
fn physical_scene(seed: u32) -> String {
    format!(
        "{}
         material_principled wall {{ base_color {{ .7 .6 .5 }} }}
         material_principled metal {{ base_color {{ .9 .7 .4 }} metallic 1 roughness .35 }}
         material_principled glass {{ base_color {{ .9 1 1 }} transmission 1 roughness .4 }}
         material_principled coated {{ base_color {{ .2 .3 .6 }} coat 1 coat_roughness .3 roughness .6 }}
         material_principled glow {{ base_color {{ .2 .2 .2 }} emission_color {{ 1 .6 .3 }} emission_strength 2 }}
         plane floor {{ material wall normal {{ 0 0 1 }} position {{ 0 0 -.5 }} }}
         sphere m {{ material metal center {{ -2 0 .5 }} radius 1 }}
         sphere g {{ material glass center {{ 0 0 .5 }} radius 1 }}
         sphere c {{ material coated center {{ 2 0 .5 }} radius 1 }}
         mesh s {{ material coated filename files/ball.obj smooth_normals 1
                  addKframe {{ time 0 key {{ pivot {{ 1 -2.5 .2 }} }} }} }}
         box lit {{ material glow vertex0 {{ -1 3 0 }} vertex1 {{ 1 3 0 }} vertex2 {{ 1 4 0 }} height 1 }}
         lamp_rectangle r {{ radiance {{ 3 3 3 }} vertex0 {{ -3 -2 4 }} vertex1 {{ -3 2 4 }} vertex2 {{ -1 2 4 }} }}
         lamp_point b {{ power {{ 60 50 40 }} position {{ 3 2 3 }} radius 1 }}
         lamp_disc d {{ radiance {{ 2 2 4 }} center {{ 3 -3 3 }} normal {{ -1 1 -1 }} radius 1 }}
         lamp_sun s {{ irradiance {{ .5 .5 .4 }} direction {{ 1 1 -2 }} angle_deg 40 }}
         environment e {{ radiance {{ .1 .15 .2 }} }}",
        seen("integrator PATH", seed)
    )
}

/// Renders a scene by all techniques together and by some alone, and compares the means. Together,
/// they vary at most `most` times as much as one alone.
fn compare_techniques(scene: impl Fn(u32) -> String, alone: &[Techniques], most: f64) {
    let take = |techniques| -> Vec<[f64; 6]> {
        let first = SEEDS * techniques as u32;
        let with = |frame: FrameScene| frame.with_techniques(techniques);
        (first..first + SEEDS).map(|seed| halves(&scene(seed), with)).collect()
    };
    let of = |all: &[[f64; 6]], k: usize| moments(&all.iter().map(|s| s[k]).collect::<Vec<_>>());
    let combined = take(Techniques::Combined);
    for &techniques in alone {
        let alone = take(techniques);
        for k in 0..6 {
            let ((a, va), (b, vb)) = (of(&combined, k), of(&alone, k));
            let apart = (a - b).abs() / (va + vb).sqrt();
            assert!(apart < APART, "{techniques:?}, {k}: {a} and {b}, {apart} deviations");
            assert!(va < most * vb, "{techniques:?}, {k}: variance {va} and {vb}");
        }
    }
}

#[test]
fn every_technique_finds_the_same_light_of_lamps() {
    let alone = [Techniques::Asked, Techniques::Hit, Techniques::Separate];
    compare_techniques(physical_scene, &alone, 1.1);
}

/// Things that glow: by an image, under a coat, under sheen, in part, mixed with something dark,
/// partly transparent, round, and moving; all seen by a floor and a metal wall.
fn glowing_scene(settings: &str, seed: u32) -> String {
    let glow = "base_color { .2 .2 .2 } emission_color { 1 .6 .3 } emission_strength";
    let moves = |x: f64| {
        format!(
            "addKframe {{ time 0 key {{ pivot {{ {x} 0 0 }} }} }}
             addKframe {{ time 1 key {{ pivot {{ 0 0 {x} }} right {{ .8 .6 0 }} up {{ 0 0 1 }} }} }}"
        )
    };
    format!(
        "{}
         texture plank {{ filename files/plank.png }}
         material_principled wall {{ base_color {{ .7 .6 .5 }} }}
         material_principled metal {{ base_color {{ .9 .7 .4 }} metallic 1 roughness .35 }}
         material_principled image {{ {glow} 6 emission_color_texture {{ texture plank }} }}
         material_principled coated {{ {glow} 2 coat 1 coat_roughness .3 coat_tint {{ 1 .5 .5 }} }}
         material_principled soft {{ {glow} 2 sheen 1 sheen_roughness .4 }}
         material_principled thin {{ {glow} 2 alpha .5 }}
         material_principled even {{ {glow} 2 }}
         material_mix mixed {{ first wall second even factor_texture {{ texture plank }} factor .8 }}
         plane floor {{ material wall normal {{ 0 0 1 }} position {{ 0 0 -.5 }} }}
         rectangle back {{ material metal vertex0 {{ -5 6 -1 }} vertex1 {{ 5 6 -1 }} vertex2 {{ 5 6 6 }} }}
         box i {{ material image vertex0 {{ -4 3 0 }} vertex1 {{ -2 3 0 }} vertex2 {{ -2 4 0 }} height 1 }}
         sphere c {{ material coated center {{ -1 2 1 }} radius .7 {} }}
         sphere s {{ material image center {{ 3 -1 3 }} radius .8 }}
         rectangle m {{ material mixed vertex0 {{ 0 -1 3 }} vertex1 {{ 1 -1 3 }} vertex2 {{ 1 0 3 }} }}
         box v {{ material even vertex0 {{ 2 2 0 }} vertex1 {{ 3 2 0 }} vertex2 {{ 3 3 0 }} height 1 {} }}
         box w {{ material soft vertex0 {{ 1 4 1 }} vertex1 {{ 2 4 1 }} vertex2 {{ 2 4.5 1 }} height 1 {} }}
         rectangle t {{ material thin vertex0 {{ -4 0 1 }} vertex1 {{ -4 1 1 }} vertex2 {{ -3 1 2 }} }}",
        seen(&format!("integrator PATH {settings}"), seed).replace("fovStart", "blurDuration .25 fovStart"),
        moves(1.0),
        moves(0.5),
        moves(-0.5),
    )
}

#[test]
fn every_technique_finds_the_same_light_of_what_glows() {
    let alone = [Techniques::Asked, Techniques::Hit];
    compare_techniques(|seed| glowing_scene("", seed), &alone, 1.25);
    let one_by_one = "lightSamplingType SAMPLE_ALL_AT_TIME";
    compare_techniques(|seed| glowing_scene(one_by_one, seed), &[Techniques::Hit], 1.25);
}

/// A floor under two lamps and a grid of glowing boxes: 16 boxes have 192 triangles.
fn glowing_boxes(sampling: &str, boxes: u32, seed: u32) -> String {
    let glowing: String = (0..boxes)
        .map(|i| {
            let (x, y) = (f64::from(i % 4) - 2.0, f64::from(i / 4));
            format!(
                "box b{i} {{ material glow height .3 vertex0 {{ {x} {y} 1 }}
                    vertex1 {{ {} {y} 1 }} vertex2 {{ {} {} 1 }} }}\n",
                x + 0.3,
                x + 0.3,
                y + 0.3
            )
        })
        .collect();
    format!(
        "{}
         material_principled floor {{ base_color {{ .7 .6 .5 }} roughness .3 }}
         material_principled glow {{ base_color {{ .2 .2 .2 }} emission_color {{ 1 .6 .3 }} emission_strength 3 }}
         plane floor {{ material floor normal {{ 0 0 1 }} position {{ 0 0 -.5 }} }}
         {glowing}
         lamp_rectangle r {{ radiance {{ 3 3 3 }} vertex0 {{ -3 -2 4 }} vertex1 {{ -3 2 4 }} vertex2 {{ -1 2 4 }} }}
         lamp_point p {{ power {{ 60 50 40 }} position {{ 3 2 3 }} }}",
        seen(&format!("lightSamplingType {sampling}"), seed)
    )
}

#[test]
fn glowing_objects_of_many_faces_are_asked_by_choice() {
    let rays = |boxes| {
        let scene = describe(&glowing_boxes("SAMPLE_ALL_AT_TIME", boxes, 0));
        let frame = FrameScene::build(&scene, 0, Isa::best()).expect("the frame can be built");
        let counts = expose_counted(&scene, &frame).1;
        counts.shadow_rays as f64 / (counts.camera_rays + counts.bounce_rays) as f64
    };
    // Two lamps, and one triangle of all.
    assert!(rays(1) > 1.0 && rays(16) <= 3.0, "{} {}", rays(1), rays(16));
    let take = |sampling: &str, first: u32| -> Vec<[f64; 6]> {
        let scene = |seed| glowing_boxes(sampling, 16, seed);
        (first..first + SEEDS).map(|seed| halves(&scene(seed), |frame| frame)).collect()
    };
    let of = |all: &[[f64; 6]], k: usize| moments(&all.iter().map(|s| s[k]).collect::<Vec<_>>());
    let (all, one) = (take("SAMPLE_ALL_AT_TIME", 0), take("SAMPLE_ONE_AT_TIME", SEEDS));
    for k in 0..6 {
        let ((a, va), (b, vb)) = (of(&all, k), of(&one, k));
        let apart = (a - b).abs() / (va + vb).sqrt();
        assert!(apart < APART, "{k}: {a} and {b}, {apart} deviations");
    }
}
