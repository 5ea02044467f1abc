//! What photons bring to where they are stored: the power of the lamps, and the same on all machines.

use slo_accel::Isa;
use slo_render::frame::FrameScene;
use slo_render::integrator::{Flux, PhotonPass, PhotonTracer};
use slo_render::photons::Deposit;
use slo_scene::SceneDescription;

use crate::support::{Shot, describe};

const PATHS: u32 = 1 << 13;

fn deposits(scene: &SceneDescription, flux: Flux, isa: Isa) -> Vec<Deposit> {
    let frame = FrameScene::build(scene, 0, isa).unwrap();
    PhotonTracer::default().deposits(&frame, flux, 0..PATHS, &|| false).unwrap()
}

#[test]
fn first_hits_store_the_power_of_the_lamps() {
    // Without bounces, every light path ends where it meets a wall.
    let room = "material_principled matte { base_color { .5 .5 .5 } ior 1 specular_ior_level 0 }
        box room { material matte vertex0 { -3 -3 -3 } vertex1 { 3 -3 -3 } vertex2 { 3 3 -3 } height 6 } ";
    let lamps = [
        ("lamp_point a { power { 30 30 30 } position { 1 1 1 } }", 30.0),
        ("lamp_point b { power { 20 20 20 } position { -1 1 1 } radius .2 }", 20.0),
        (
            "lamp_spot c { power { 10 10 10 } position { 0 0 2 } target { 0 1 0 } angle_deg 50 }",
            10.0,
        ),
        (
            "lamp_rectangle d { power { 40 40 40 } vertex0 { 1 -1 1 } vertex1 { 1 -2 1 } vertex2 { 2 -2 1 } }",
            40.0,
        ),
        (
            "lamp_disc e { power { 5 5 5 } center { -1 -1 1 } normal { 1 0 -1 } radius .3 }",
            5.0,
        ),
        // On both sides: 2 pi A L.
        (
            "material_principled glow { base_color { 0 0 0 } ior 1 specular_ior_level 0 emission_strength 3 }
             rectangle f { material glow vertex0 { 1 2 0 } vertex1 { 2 2 0 } vertex2 { 2 2.5 0 } }",
            std::f64::consts::PI * 3.0,
        ),
    ];
    let check = |lamps: &str, power: f64| {
        let shot =
            Shot { settings: "integrator PHOTON_MAP".into(), recursion: 0, ..Shot::default() };
        let scene = describe(&shot.of(&(room.to_owned() + lamps)));
        let found = deposits(&scene, Flux::Everywhere, Isa::best());
        // A spot's photons start in a cone that is larger by roundings; some of them have no light.
        let has_all = found.len() == PATHS as usize;
        assert!(has_all || lamps.contains("lamp_spot"), "{lamps}: {}", found.len());
        let tolerance = if has_all { 1e-5 } else { 3.0 / f64::from(PATHS).sqrt() };
        let sum: f64 = found.iter().map(|deposit| f64::from(deposit.power.x)).sum();
        let flux = sum / f64::from(PATHS);
        assert!((flux / power - 1.0).abs() < tolerance, "{lamps}: {flux}, expected {power}");
    };
    for (lamp, power) in lamps {
        check(lamp, power);
    }
    let all = lamps.map(|(lamp, _)| lamp).join(" ");
    check(&all, lamps.iter().map(|(_, power)| power).sum());
}

/// Lamps of several kinds, something sharp, and something that moves.
fn scene(settings: &str) -> SceneDescription {
    let shot =
        Shot { settings: settings.into(), recursion: 6, samples: 4, blur: 0.5, ..Shot::default() };
    describe(&shot.of("
        material_principled matte { base_color { .6 .5 .4 } ior 1 specular_ior_level 0 }
        material_principled glass { base_color { 1 1 1 } transmission 1 roughness 0 }
        material_principled satin { base_color { .9 .8 .7 } metallic 1 roughness .3 }
        texture plank { filename files/plank.png }
        material_principled shade { emission_strength 3 emission_color_texture plank coat .5 }
        lamp_point bulb { power { 300 280 250 } position { 2 -1 3 } radius .2 }
        lamp_sun sun { irradiance { 1 1 2 } direction { 1 1 -2 } angle_deg 2 }
        environment sky { radiance { .3 .4 .5 } }
        plane floor { normal { 0 0 1 } position { 0 0 -1 } material matte }
        rectangle panel { material shade vertex0 { -3 2 0 } vertex1 { -2 2 0 } vertex2 { -2 2 1 } }
        sphere pearl { center { 1.5 0 -.4 } radius .6 material satin }
        sphere ball { center { 0 0 0 } radius .8 material glass
            addKframe { time 0 key { pivot { -1 0 0 } } } addKframe { time 1 key { pivot { 1 0 .5 } } } }"))
}

#[test]
fn all_instruction_sets_store_the_same_photons() {
    let path = scene("integrator PATH photons 1");
    let pass = |isa| {
        let frame = FrameScene::build(&path, 0, isa).unwrap();
        let pass = PhotonPass::new(&frame, 2);
        PhotonTracer::default().trace(&frame, pass, 0..pass.paths(), &|| false).unwrap()
    };
    let photon_map = scene("integrator PHOTON_MAP");
    let expected = pass(Isa::Portable);
    assert!(expected.len() > 400, "{}", expected.len());
    for flux in [Flux::Everywhere, Flux::Caustics] {
        let expected = deposits(&photon_map, flux, Isa::Portable);
        assert!(expected.len() > 1000, "{}", expected.len());
        for isa in Isa::available() {
            assert!(deposits(&photon_map, flux, isa) == expected, "{isa:?}");
        }
    }
    for isa in Isa::available() {
        assert!(pass(isa) == expected, "{isa:?}");
    }
}
