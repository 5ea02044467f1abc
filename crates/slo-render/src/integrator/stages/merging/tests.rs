//! How photons and paths from the camera share light.

use std::f32::consts::FRAC_1_PI;

use slo_accel::Isa;
use slo_scene::{Files, load};

use super::super::continuation::Remember;
use super::*;
use crate::integrator::batch::{Past, Sent};
use crate::shading::bsdf::Diffuse;

/// A disc of area pi / 4 between mirrors.
fn frame() -> FrameScene {
    let text = "settings s { integrator PATH photons 1 imageSamples 1 }
        Camera c { fps 25 Film f { width 8 height 8 }
            CamSegment a { videoStart 0 videoEnd 1 addPosition { 0 -3.9 0 } addTarget { 0 0 0 } fovStart .3 } }
        material_principled mirror { base_color { 1 1 1 } roughness 0 metallic 1 }
        lamp_disc l { radiance { 1 1 1 } center { 0 0 0 } normal { 0 0 1 } radius .5 }
        box room { vertex0 { -4 -4 -4 } vertex1 { 4 -4 -4 } vertex2 { 4 4 -4 } height 8 material mirror }";
    let loaded = load("scene.txt", text.as_bytes(), &Files::built_in("", &[]));
    let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
    FrameScene::build(&scene, 0, Isa::best()).unwrap()
}

/// Unit directions above a surface with normal z.
fn directions() -> [Vec3; 16] {
    std::array::from_fn(|i| {
        let (x, y) = (0.2 * (i % 4) as f32 - 0.3, 0.2 * (i / 4) as f32 - 0.3);
        Vec3::new(x, y, (1.0 - x * x - y * y).sqrt())
    })
}

#[test]
fn shares_depend_on_the_area_of_the_lamp_and_of_the_disc_alone() {
    let frame = frame();
    let area = 0.25 * PI;
    let directions = directions();
    for (paths, radius) in [(1.0f32, 0.1f32), (1000.0, 0.01), (1000.0, 0.3)] {
        let mut points = Box::<Points>::default();
        points.surfaces.len = directions.len();
        let mut lobe = Diffuse(Default::default());
        let (mut sent, mut past) = (Box::<Sent>::default(), Box::<Past>::default());
        let (mut toward, mut density) = (Box::<Vec3s>::default(), Box::new([0.0; BATCH]));
        let mut point = Box::new([0; BATCH]);
        let emission = frame.emission.as_ref().unwrap();
        for (i, direction) in directions.into_iter().enumerate() {
            points.surfaces.set_normals(i, Vec3::Z);
            points.direction.set(i, Vec3::NEG_Z);
            points.caught[i] = paths * PI * radius * radius;
            lobe.0.weight.set(i, Vec3::ONE);
            lobe.0.chance[i] = 1.0;
            // Through perfect mirrors, a photon arrives in any direction whatever its start.
            let start = directions[(i * 7 + 3) % 16];
            density[i] = emission.density(&frame.lights, 0, 0.5, Vec3::ZERO, start);
            toward.set(i, direction);
            point[i] = i as u32;
            sent.direction.set(i, direction);
            sent.density[i] = lobe.evaluate(i, &points.at(i), direction).density;
        }
        let mut scattered = Box::<Vec3s>::default();
        let none = Box::new([0.0; BATCH]);
        let pairs = Pairs {
            points: &points,
            point: &point,
            toward: &toward,
            density: &density,
            field: &none,
            len: directions.len(),
            rays: 1.0,
        };
        frame.isa.run(ScatterOne { lobe: &lobe, share: &none, pairs, to: &mut scattered });
        frame.isa.run(Remember { points: &points, sent: &sent, past: &mut past });
        // The target is all around, so half of the photons start at the dark side of the disc.
        let caught = 0.5 * paths * PI * radius * radius;
        let expected = caught / (caught + area);
        for i in 0..directions.len() {
            let by_photon = scattered.x[i] / FRAC_1_PI;
            let rival = past.rough.rival[i];
            let by_path = rival / (rival + density[i]);
            assert!((by_photon / expected - 1.0).abs() < 1e-4, "{i}: {by_photon}, {expected}");
            assert!((by_photon + by_path - 1.0).abs() < 1e-5, "{i}: {by_photon} + {by_path}");
        }
    }
}

#[test]
fn photons_have_all_light_of_lamps_that_no_ray_can_hit() {
    let mut points = Box::<Points>::default();
    points.surfaces.len = 1;
    points.surfaces.set_normals(0, Vec3::Z);
    points.direction.set(0, Vec3::NEG_Z);
    points.caught[0] = 1e-6;
    let mut lobe = Diffuse(Default::default());
    lobe.0.weight.set(0, Vec3::ONE);
    lobe.0.chance[0] = 1.0;
    let (mut toward, point) = (Box::<Vec3s>::default(), Box::new([0; BATCH]));
    toward.set(0, Vec3::new(0.6, 0.0, 0.8));
    let density = Box::new([f32::INFINITY; BATCH]);
    let none = Box::new([0.0; BATCH]);
    let pairs = Pairs {
        points: &points,
        point: &point,
        toward: &toward,
        density: &density,
        field: &none,
        len: 1,
        rays: 1.0,
    };
    let mut scattered = Box::<Vec3s>::default();
    Isa::best().run(ScatterOne { lobe: &lobe, share: &none, pairs, to: &mut scattered });
    assert!((scattered.x[0] / FRAC_1_PI - 1.0).abs() < 1e-6, "{}", scattered.x[0]);
}
