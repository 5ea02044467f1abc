//! Accounts of samples: they tell the light of a picture, bit by bit, and where it comes from.

use slo_accel::Isa;
use slo_picture::film::Fixed;
use slo_render::frame::FrameScene;
use slo_render::integrator::{Account, Leg, SampleSum, Source};
use slo_render::render::explain;
use slo_scene::SceneDescription;

use crate::support::{describe, expose_frame};

/// A room with a lamp, a mirror, glass, and a moving ball. `materials` are `matte`, `mirror` and `glass`.
fn scene(settings: &str, materials: &str, lamp: &str) -> SceneDescription {
    describe(&format!(
        "settings s {{ imageSamples 4 imageContrastLimit 0 {settings} }}
         Camera c {{ fps 25
             Film f {{ width 12 height 9 prefix test output EXR_IMAGE }}
             CamSegment only {{ videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 blurDuration .04
                 addPosition {{ 0 -5 1.5 }} addTarget {{ 0 0 0.4 }} fovStart .35
                 dofStart 5 lensRadiusStart .1 }} }}
         {materials} {lamp}
         rectangle floor {{ vertex0 {{ -4 -4 -1 }} vertex1 {{ 4 -4 -1 }} vertex2 {{ 4 4 -1 }} material matte }}
         rectangle wall {{ vertex0 {{ -4 3 -1 }} vertex1 {{ 4 3 -1 }} vertex2 {{ 4 3 5 }} material mirror }}
         sphere ball {{ center {{ 0 0 0 }} radius .9 material glass
             addKframe {{ time 0 key {{ pivot {{ -1 0 0 }} }} }}
             addKframe {{ time 1 key {{ pivot {{ 3 0 0 }} }} }} }}"
    ))
}

const PHONG: &str = "
    phong_info matte { ambient { .1 .1 .1 } diffuse { .7 .6 .5 } reflectance .2 diffuse_reflection .3 }
    material_phong matte { phong_info matte }
    phong_info mirror { diffuse { .1 .1 .1 } reflectance .8 }
    material_phong mirror { phong_info mirror }
    phong_info glass { diffuse { .05 .05 .05 } reflectance .2 refraction .7 refraction_index 1.4 }
    material_phong glass { phong_info glass }";

const PHYSICAL: &str = "
    material_principled matte { base_color { .7 .6 .5 } roughness .6 emission_color { .1 .2 .1 } emission_strength .2 }
    material_principled mirror { base_color { .9 .9 .9 } metallic 1 roughness 0 }
    material_principled glass { base_color { .9 1 .9 } transmission 1 roughness 0 ior 1.4 alpha .8 }";

const THESIS_LAMP: &str = "light_rectangle lamp { color { 1 1 1 }
    vertex0 { 2 -3 4 } vertex1 { 3 -3 4 } vertex2 { 3 -2 4 } }
    light_point spark { color { .3 .3 .5 } position { -3 -3 3 } }";

const LAMP: &str =
    "lamp_disc lamp { power { 60 60 60 } center { 2 -2 4 } normal { 0 0 -1 } radius .5 }
    environment sky { radiance { .2 .3 .4 } }";

/// All accounts of a pixel.
fn accounts(frame: &FrameScene, at: [u32; 2], samples: u32) -> Vec<Account> {
    let mut accounts = Vec::new();
    let tell = &mut |sample: u32, account: &Account| {
        assert_eq!(sample as usize, accounts.len());
        accounts.push(account.clone());
    };
    explain(frame, at, 0..samples, &|| false, tell).unwrap();
    accounts
}

fn sum(accounts: &[Account]) -> SampleSum {
    let mut sum = SampleSum::default();
    for more in accounts.iter().map(Account::sum) {
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }
    sum
}

#[test]
fn accounts_add_up_to_the_picture() {
    let many = "softShadowSamples 3 diffuseReflectionSamples 2 recursion 3";
    for (name, settings, materials, lamp) in [
        ("distributed", "recursion 3", PHONG, THESIS_LAMP),
        ("many rays", many, PHONG, THESIS_LAMP),
        ("one light", "lightSamplingType SAMPLE_ONE_AT_TIME", PHONG, THESIS_LAMP),
        ("shadows", "shadow TRANSPARENT recursion 3", PHONG, THESIS_LAMP),
        ("path", "integrator PATH recursion 6", PHYSICAL, LAMP),
        ("photons", "integrator PATH recursion 6 photons .5", PHYSICAL, LAMP),
        ("guided", "integrator PATH recursion 6 guide 1", PHYSICAL, LAMP),
        (
            "photon map",
            "integrator PHOTON_MAP photonMapSize 2000 causticMapSize 2000",
            PHYSICAL,
            LAMP,
        ),
    ] {
        let scene = scene(settings, materials, lamp);
        let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
        let film = expose_frame(&scene, &frame);
        let mut rays = 0;
        for (i, pixel) in (0..).zip(film.pixels()) {
            let accounts = accounts(&frame, [i % 12, i / 12], pixel.samples);
            assert_eq!(sum(&accounts), pixel.sum, "{name}, pixel {i}");
            rays += accounts.iter().map(|account| account.rays.len()).sum::<usize>();
        }
        assert!(rays > 1000, "{name}: {rays}");
    }
}

#[test]
fn ways_lead_from_the_camera_to_the_light() {
    let scene = scene("integrator PATH recursion 4", PHYSICAL, LAMP);
    let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
    let things = frame.things(&scene).unwrap();
    let name = |thing: u32| things.objects[thing as usize].name.as_str();
    // The wall is a mirror above the ball.
    let (mut mirrored, mut asked) = (0, 0);
    for account in accounts(&frame, [9, 3], 256) {
        for gain in &account.gains {
            let way = account.way(gain.ray);
            let first = &account.rays[way[0] as usize];
            assert_eq!((first.leg, first.before), (Leg::Camera, None));
            for pair in way.windows(2) {
                let [before, ray] = [pair[0], pair[1]].map(|ray| account.rays[ray as usize]);
                assert_eq!(ray.before, Some(pair[0]));
                let passes = u32::from(ray.leg != Leg::Behind);
                assert_eq!(ray.depth, before.depth + passes);
                let hit = before.hit.expect("only hits send rays");
                let from = before.origin + before.direction * hit.distance;
                assert!(from.distance(ray.origin) < 1e-2, "{from} {}", ray.origin);
            }
            let legs: Vec<Leg> = way.iter().map(|ray| account.rays[*ray as usize].leg).collect();
            let seen = first.hit.map(|hit| name(hit.thing));
            if seen == Some("wall") && legs.get(1) == Some(&Leg::Sharp) {
                mirrored += 1;
            }
            if let (Source::Asked, Some(Leg::ToLight(light))) = (gain.source, legs.last()) {
                assert!(["lamp", "sky", "floor"].contains(&&*things.lights[*light as usize]));
                asked += 1;
            }
            assert_ne!(gain.light, [Fixed::ZERO; 3]);
        }
    }
    assert!(mirrored > 10, "{mirrored}");
    assert!(asked > 10, "{asked}");
}
