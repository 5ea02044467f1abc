//! A picture is the same file, byte for byte, whatever hardware, threads and regions render it.

use std::io::Cursor;

use slo_accel::Isa;
use slo_picture::film::{FileLayer, Film};
use slo_picture::output::{Picture, Recipe};
use slo_render::frame::FrameScene;
use slo_scene::{
    Accelerator, Integrator, Layer, LightSampling, OutputFormat, SceneDescription, Settings,
};

use crate::support::{Shot, describe, expose, material};

const THREADS: [usize; 4] = [1, 2, 3, 8];

/// Sections across and down: automatic, uneven, and one for each row.
const TILINGS: [[Option<u32>; 2]; 3] = [[None, None], [Some(3), Some(5)], [Some(1), Some(64)]];

const ACCELERATORS: [Accelerator; 3] = [Accelerator::Bvh, Accelerator::KdTree, Accelerator::None];

const SHAPES: &str = "
    texture plank { filename files/plank.png }
    material_texture wood { phong_info matt_info texture plank scale_U 3 scale_V 3 }
    light_point lamp { color { .5 .5 .5 } position { 3 -6 5 } }
    light_rectangle panel { color { 1 .9 .8 }
        vertex0 { -3 -2 4 } vertex1 { -1 -2 4 } vertex2 { -1 0 4 } }
    plane floor { material wood normal { 0 0 1 } position { 0 0 -1 } }
    rectangle wall { material mirror vertex0 { -5 4 -1 } vertex1 { 5 4 -1 } vertex2 { 5 4 3 } }
    triangle sail { material matt vertex0 { 2 1 -1 } vertex1 { 3 1 -1 } vertex2 { 2.5 1.5 1 } }
    sphere pearl { material glass center { -1.5 -1 0 } radius 0.9 }
    cylinder post { material brushed base { 1.4 -1 -1 } top { 1.5 -1 0.6 } radius 0.4 }
    cone hat { material brushed base { 1.4 1 -1 } apex { 1.5 1 0.9 } radius 0.6 }
    box crate { material matt vertex0 { -3 0 -1 } vertex1 { -2 0 -1 } vertex2 { -2 1 -1 } height 1 }
    mesh ball { filename files/ball.obj smooth_normals 1 material mirror
        addKframe { time 0 key { pivot { 0 1 0.6 } } }
        addKframe { time 1 key { pivot { .5 1 1 } up { 0 1 3 } } } }
    sphere comet { material brushed center { 0 0 0 } radius 0.3
        addKframe { time 0 key { pivot { -1 -2 0.5 } } nex { pivot { 0 -3 3 } } }
        addKframe { time 1 key { pivot { 1 -2 1 } } } }
";

/// A scene with everything in it: lens, motion of camera and objects, all shapes, images, area and
/// point lights, glass, brushed metal.
pub(crate) fn everything() -> SceneDescription {
    let settings = "softShadowSamples 2 diffuseReflectionSamples 2 background { .1 .2 .3 }";
    everything_with("", settings)
}

fn everything_with(more: &str, settings: &str) -> SceneDescription {
    let elements = [
        material("matt", "ambient { .1 .1 .1 } diffuse { .5 .4 .3 }"),
        material("mirror", "diffuse { .2 .2 .2 } reflectance .5"),
        material("brushed", "specular { 1 1 1 } shininess 30 reflectance .6 diffuse_reflection .2"),
        material(
            "glass",
            "refraction .8 reflectance .2 refraction_index 1.5 diffuse_refraction .1",
        ),
        SHAPES.to_owned(),
        more.to_owned(),
    ];
    let shot = Shot {
        from: vec![[0.0, -8.0, 1.5], [0.5, -8.0, 2.0]],
        lens: 0.1,
        dof: 8.0,
        blur: 1.0,
        samples: 3,
        settings: settings.to_owned(),
        ..Shot::default()
    };
    let mut scene = describe(&shot.of(&elements.concat()));
    // More than one tile in each direction, and none of them whole.
    (scene.camera.film.width, scene.camera.film.height) = (53, 37);
    scene
}

/// Returns the bytes of a PNG and an EXR file of a film.
pub(crate) fn files(scene: &SceneDescription, film: &Film) -> [Vec<u8>; 2] {
    [OutputFormat::Png8, OutputFormat::Exr].map(|format| {
        let mut scene = scene.clone();
        scene.camera.film.output = format;
        let (image, look) = (&film.image(), scene.camera.film.look(&scene.settings));
        let recipe = &Recipe { scene: &scene, frame: 0 }.to_json();
        let mut file = Cursor::new(Vec::new());
        let layers = FileLayer::all(&scene.camera.film.layers, &scene.layer_names());
        let layers = film.layers_of(film.area(), layers);
        let picture = Picture { image, format, look, recipe, crop: None };
        picture.write_with(&mut file, &layers).unwrap();
        file.into_inner()
    })
}

/// Renders a scene on every number of threads, in every tiling, with every structure and every instruction set, and
/// compares the files. Any two of these meet. All combinations would be as many times more as there are instruction sets.
#[track_caller]
fn assert_one_file(scene: &SceneDescription) {
    let reference = expose(scene, Isa::Portable);
    let expected = files(scene, &reference);
    let isas = Isa::available();
    for (i, threads) in THREADS.into_iter().enumerate() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for (j, [columns, rows]) in TILINGS.into_iter().enumerate() {
            for (k, accelerator) in ACCELERATORS.into_iter().enumerate() {
                let isa = isas[(i + j + k) % isas.len()];
                let mut scene = scene.clone();
                scene.settings.sections_horizontal = columns;
                scene.settings.sections_vertical = rows;
                scene.settings.sections_per_thread = threads as u32;
                scene.settings.accelerator = accelerator;
                let found = pool.install(|| files(&scene, &expose(&scene, isa)));
                let what = format!("{threads} {columns:?} {rows:?} {isa:?} {accelerator:?}");
                assert!(found == expected, "{what}");
            }
        }
    }
}

#[test]
fn one_file_with_a_fixed_number_of_samples() {
    assert_one_file(&everything());
}

/// The same things in all light: lamps of every kind, a sky, physical materials, mixes, alpha.
const PHYSICAL: &str = "
    material_principled clay { base_color { .7 .5 .4 } diffuse_roughness .5 sheen .5 }
    material_principled gold { base_color { 1 .8 .4 } metallic 1 roughness .3 anisotropic .5 }
    material_principled pane { base_color { .9 1 1 } transmission 1 roughness .2 coat .5 }
    material_principled veil { alpha .5 emission_color { .2 .4 1 } emission_strength 1 }
    material_mix half { first clay second gold factor .4 }
    environment sky { radiance { .3 .4 .5 } light_group sky }
    lamp_point bulb { power { 30 30 20 } position { -2 -3 3 } radius .2 light_group key }
    lamp_spot beam { power { 90 60 60 } position { 2 -4 4 } target { 0 0 0 } angle_deg 40 blend .3 }
    lamp_sun sun { irradiance { 1 1 .9 } direction { 1 2 -3 } }
    lamp_rectangle soft { radiance { 4 4 5 } vertex0 { 2 -3 3 } vertex1 { 2 -1 3 } vertex2 { 3 -1 3 } }
    lamp_disc dish { radiance { 3 2 2 } center { -3 2 3 } normal { 1 -1 -1 } radius .5 solid 0 }
    sphere nugget { material gold center { .3 -2 -.5 } radius .5 }
    sphere bead { material pane center { -.4 -2.5 -.6 } radius .4 }
    box pot { material half vertex0 { 2 -2 -1 } vertex1 { 3 -2 -1 } vertex2 { 3 -1 -1 } height .6 }
    rectangle flag { material veil vertex0 { -2 -2 0 } vertex1 { -1 -2 0 } vertex2 { -1 -2 1 } }
    triangle plate { material clay vertex0 { -4 -3 -1 } vertex1 { 4 -3 -1 } vertex2 { 0 -4 0 } }
";

#[test]
fn one_file_in_all_light() {
    let mut scene = everything_with(PHYSICAL, "integrator PATH");
    assert_one_file(&scene);
    scene.settings.photons = 0.5;
    assert_one_file(&scene);
    scene.settings.light_sampling = Some(LightSampling::All);
    scene.camera.film.layers = vec![Layer::Lights];
    assert_one_file(&scene);
    // DISTRIBUTED with physical lamps and materials.
    scene.settings.integrator = Integrator::Distributed;
    assert_one_file(&scene);
}

#[test]
fn one_file_by_photons() {
    let mut scene = everything_with(PHYSICAL, "integrator PHOTON_MAP");
    scene.settings.photon_map_size = 6000;
    scene.settings.caustic_map_size = 2000;
    assert_one_file(&scene);
    (scene.settings.cache_error, scene.settings.gather_rays) = (0.5, 30);
    assert_one_file(&scene);
    scene.settings.gather = false;
    scene.camera.film.layers = vec![Layer::Lights];
    assert_one_file(&scene);
}

#[test]
fn one_file_with_layers() {
    let mut scene = everything();
    // There is a frame before.
    let segment = &mut scene.camera.segments[0];
    (segment.video[0], segment.scene[0]) = (-1.0, -1.0);
    let colors = expose(&scene, Isa::best()).image();
    scene.camera.film.layers = Layer::ALL.to_vec();
    let film = expose(&scene, Isa::best());
    assert!(film.image() == colors, "layers change the colours");
    for layer in FileLayer::all(&Layer::ALL, &scene.layer_names()) {
        let image = film.layer_of(film.area(), &layer);
        // All pixels have as many samples, and few see many ids.
        if matches!(layer, FileLayer::Samples | FileLayer::Rank(_, 2..)) {
            continue;
        }
        assert!(image.rgb.iter().any(|value| *value != image.rgb[0]), "{layer:?} is flat");
    }
    assert_one_file(&scene);
}

/// Crossing rods of two long triangles each, and a lens.
fn rods() -> SceneDescription {
    let rod = |i: u32| {
        let (turn, rise) = (0.37 * i as f32, 0.61 * i as f32);
        let (sin, cos) = libm::sincosf(turn);
        let (x, y, z) = (4.0 * cos, 4.0 * sin, 2.0 * libm::sinf(rise));
        format!(
            "rectangle rod{i} {{ material mirror vertex0 {{ {} {} {} }} vertex1 {{ {x} {y} {z} }} \
             vertex2 {{ {x} {y} {} }} }}\n",
            -x,
            -y,
            -z,
            z + 0.02
        )
    };
    let elements = [
        material("mirror", "diffuse { .4 .3 .2 } reflectance .5"),
        "light_point lamp { color { .9 .9 .9 } position { 3 -6 5 } }".to_owned(),
        (0..120).map(rod).collect(),
    ];
    let settings = "spatialSplits 1".into();
    let from = vec![[0.0, -8.0, 1.5]];
    let shot = Shot { from, lens: 0.1, dof: 8.0, settings, ..Shot::default() };
    let mut scene = describe(&shot.of(&elements.concat()));
    (scene.camera.film.width, scene.camera.film.height) = (53, 37);
    scene
}

#[test]
fn spatial_splits_do_not_show() {
    let mut scene = rods();
    assert!(scene.settings.spatial_splits && !Settings::default().spatial_splits);
    for isa in Isa::available() {
        scene.settings.spatial_splits = false;
        let plain = FrameScene::build(&scene, 0, isa).unwrap().memory();
        let expected = files(&scene, &expose(&scene, isa));
        scene.settings.spatial_splits = true;
        assert!(FrameScene::build(&scene, 0, isa).unwrap().memory() > plain, "nothing was cut");
        assert!(files(&scene, &expose(&scene, isa)) == expected, "{isa:?}");
    }
}

/// Two to seven samples per pixel. The test would prove little if all pixels took the same number.
#[track_caller]
fn assert_one_adaptive_file(change: impl Fn(&mut Settings)) {
    let mut scene = everything();
    scene.settings.image_min_samples = 2;
    scene.settings.image_samples = 7;
    change(&mut scene.settings);
    let found = expose(&scene, Isa::Portable).sample_counts();
    for count in [2, 7] {
        assert!(found.contains(&count), "no pixel of {count} samples");
    }
    assert_one_file(&scene);
}

#[test]
fn one_file_with_a_contrast_limit() {
    assert_one_adaptive_file(|settings| settings.image_contrast_limit = 0.1);
}

#[test]
fn one_file_with_a_noise_level() {
    assert_one_adaptive_file(|settings| settings.noise = Some(0.03));
}

#[test]
fn another_seed_is_another_file() {
    let mut scene = everything();
    let pictures = [0, 1].map(|seed| {
        scene.settings.seed = seed;
        expose(&scene, Isa::best()).image()
    });
    assert!(pictures[0] != pictures[1]);
}
