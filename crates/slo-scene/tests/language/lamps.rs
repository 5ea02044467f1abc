//! Lamps, environments and integrators: what they mean, and which of them go together.

use std::f64::consts::PI;

use glam::DVec3;
use slo_scene::light::{DiscLamp, Environment, PointLamp, RectangleLamp, Sky, SpotLamp, SunLamp};
use slo_scene::settings::{Entries, recorded, restore};
use slo_scene::{
    Files, Integrator, Layer, Light, LightKind, LightSampling, SceneDescription, Settings, load,
    load_adapted,
};

const PLAIN: &str = include_str!("../scenes/minimal.txt");

const FILES: &[(&str, &[u8])] = &[("plank.png", include_bytes!("../scenes/files/plank.png"))];

/// What is said about a scene whose only light is in these elements.
fn report(elements: &str) -> String {
    let dark = PLAIN.lines().filter(|line| !line.starts_with("light_point"));
    let text = format!("{elements}\n{}", dark.collect::<Vec<_>>().join("\n"));
    load("scene.txt", text, &Files::built_in("", FILES)).diagnostics.render(false)
}

/// The scene with these elements, about which there is nothing to say.
#[track_caller]
fn scene(elements: &str) -> SceneDescription {
    let loaded = load("scene.txt", format!("{elements}\n{PLAIN}"), &Files::built_in("", FILES));
    assert_eq!(loaded.diagnostics.render(false), "");
    loaded.scene.unwrap()
}

#[track_caller]
fn lamp(element: &str) -> Light {
    scene(element).lights[0].clone()
}

#[test]
fn lamps_have_the_defaults_of_the_documentation() {
    let light = lamp("lamp_point a { power { 60 60 60 } position { 0 0 3 } }");
    let LightKind::PointLamp(point) = light.kind else { panic!("{light:?}") };
    let position = DVec3::Z * 3.0;
    assert_eq!(point, PointLamp { power: [60.0; 3], position, radius: 0.0 });
    assert!(light.camera_visible && light.solid && light.group.is_none());
    assert!(light.key_frames.is_empty());

    let light =
        lamp("lamp_spot a { power { 9 9 9 } position { 0 0 3 } target { 0 0 1 } angle_deg 60 }");
    let LightKind::SpotLamp(spot) = light.kind else { panic!("{light:?}") };
    let (power, axis) = ([9.0; 3], DVec3::NEG_Z);
    assert_eq!(spot, SpotLamp { power, position, radius: 0.0, axis, angle_deg: 60.0, blend: 0.0 });

    let light = lamp("lamp_sun a { irradiance { 900 900 800 } direction { 0 0 -5 } }");
    let LightKind::SunLamp(sun) = light.kind else { panic!("{light:?}") };
    let irradiance = [900.0, 900.0, 800.0];
    assert_eq!(sun, SunLamp { irradiance, direction: DVec3::NEG_Z, angle_deg: 0.53 });

    let light = lamp("environment a { radiance { .1 .2 .3 } }");
    let LightKind::Environment(environment) = light.kind else { panic!("{light:?}") };
    let sky = Sky::Even([0.1, 0.2, 0.3]);
    assert_eq!(environment, Environment { sky, strength: 1.0, turn_deg: 0.0 });
}

#[test]
fn what_a_lamp_says_is_kept() {
    let light = lamp(
        "lamp_rectangle a {
            radiance { 1 2 3 }  vertex0 { 0 0 4 }  vertex1 { 0 1 4 }  vertex2 { 1 1 4 }
            camera_visible 0  solid 0  light_group key  two_sided 1
            addKframe { time 0 }  addKframe { time 1  key { pivot { 1 0 0 } } }
        }",
    );
    assert!(!light.camera_visible && !light.solid);
    assert_eq!((light.group.as_deref(), light.key_frames.len()), (Some("key"), 2));
    let LightKind::RectangleLamp(lamp) = light.kind else { panic!("{light:?}") };
    assert_eq!((lamp.radiance, lamp.two_sided), ([1.0, 2.0, 3.0], true));
}

/// The radiance of a rectangle and of a disc that give off 60 W.
fn radiances(scaling: &str, two_sided: u32) -> [f32; 2] {
    let scene = scene(&format!(
        "{scaling}
        lamp_rectangle a {{
            power {{ 60 60 60 }}  vertex0 {{ 0 0 4 }}  vertex1 {{ 0 2 4 }}  vertex2 {{ 3 2 4 }}
            two_sided {two_sided}
        }}
        lamp_disc b {{
            power {{ 60 60 60 }}  center {{ 9 0 4 }}  normal {{ 0 0 -1 }}  radius 2
            two_sided {two_sided}
        }}",
    ));
    match [&scene.lights[0].kind, &scene.lights[1].kind] {
        [
            LightKind::RectangleLamp(RectangleLamp { radiance: [a, ..], .. }),
            LightKind::DiscLamp(DiscLamp { radiance: [b, ..], .. }),
        ] => [*a, *b],
        others => panic!("{others:?}"),
    }
}

#[test]
fn power_becomes_radiance_by_the_area_that_glows() {
    let expected = [60.0 / (PI * 6.0), 60.0 / (PI * PI * 4.0)];
    assert_eq!(radiances("", 0), expected.map(|x| x as f32));
    assert_eq!(radiances("", 1), expected.map(|x| (x / 2.0) as f32));
}

#[test]
fn scaling_moves_lamps_apart_and_leaves_their_power() {
    let expected = [60.0 / (PI * 6.0 * 100.0), 60.0 / (PI * PI * 4.0 * 100.0)];
    assert_eq!(radiances("Scaling s { 10 }", 0), expected.map(|x| x as f32));
    let scene = scene(
        "Scaling s { 10 }
        lamp_point a { power { 60 60 60 } position { 0 0 3 } radius .1 }
        lamp_sun b { irradiance { 2 2 2 } direction { 0 0 -1 } }",
    );
    let LightKind::PointLamp(point) = &scene.lights[0].kind else { panic!("{:?}", scene.lights) };
    let expected = PointLamp { power: [60.0; 3], position: DVec3::Z * 30.0, radius: 1.0 };
    assert_eq!(*point, expected);
    let LightKind::SunLamp(sun) = &scene.lights[1].kind else { panic!("{:?}", scene.lights) };
    assert_eq!(sun.irradiance, [2.0; 3]);
}

#[test]
fn an_environment_uses_its_texture() {
    let scene = scene(
        "environment a { texture t strength 2 turn_deg -90 } texture t { filename plank.png }",
    );
    let LightKind::Environment(environment) = &scene.lights[0].kind else { panic!() };
    assert!(matches!(environment.sky, Sky::Image(texture) if texture.0 == 0));
    assert_eq!((environment.strength, environment.turn_deg), (2.0, -90.0));
}

fn settings(settings: &str) -> Settings {
    scene(&format!("settings s {{ {settings} }}")).settings
}

#[test]
fn the_integrator_decides_what_is_not_written() {
    let defaults = |written: &str| {
        let settings = settings(written);
        (settings.recursion(), settings.light_sampling())
    };
    assert_eq!(defaults(""), (3, LightSampling::All));
    assert_eq!(defaults("integrator DISTRIBUTED"), (3, LightSampling::All));
    assert_eq!(defaults("integrator PATH"), (16, LightSampling::One));
    assert_eq!(defaults("recursion 3 integrator PATH"), (3, LightSampling::One));
    let all = "integrator PATH lightSamplingType SAMPLE_ALL_AT_TIME recursion 0";
    assert_eq!(defaults(all), (0, LightSampling::All));
    // Another integrator takes its own defaults, and what is written stays.
    let mut changed = settings("lightSamplingType SAMPLE_ALL_AT_TIME");
    changed.integrator = Integrator::Path;
    assert_eq!((changed.recursion(), changed.light_sampling()), (16, LightSampling::All));
    let mut changed = settings("");
    changed.integrator = Integrator::PhotonMap;
    assert_eq!((changed.recursion(), changed.light_sampling()), (16, LightSampling::One));
}

#[test]
fn recipes_hold_what_applies() {
    let held = |settings: &Settings| {
        let names = ["integrator", "recursion", "lightSamplingType"];
        let recorded = recorded(settings).into_iter();
        let held = recorded.filter(|(name, _)| names.contains(name));
        held.map(|(name, value)| format!("{name} {value:?}")).collect::<Vec<_>>()
    };
    let all = "lightSamplingType Word(\"SAMPLE_ALL_AT_TIME\")";
    let old = [all, "recursion Count(3)"];
    assert_eq!(held(&settings("")), old);
    assert_eq!(held(&settings("recursion 3 lightSamplingType SAMPLE_ALL_AT_TIME")), old);
    let one = "lightSamplingType Word(\"SAMPLE_ONE_AT_TIME\")";
    let path = settings("integrator PATH");
    assert_eq!(held(&path), ["integrator Word(\"PATH\")", one, "recursion Count(16)"]);
    for written in ["integrator PATH", "recursion 3", "integrator PATH recursion 3", "recursion 16"]
    {
        let settings = settings(written);
        for mut other in [Settings::default(), path.clone()] {
            let values = recorded(&settings);
            let effects =
                [slo_scene::settings::Effect::Samples, slo_scene::settings::Effect::Count];
            let back = restore(&mut other, &effects, |entry| {
                let value = values.iter().find(|(name, _)| *name == entry.name);
                Ok(value.map(|(_, value)| value.clone()))
            });
            assert_eq!((back, recorded(&other)), (Some(()), values), "{written}");
        }
    }
    assert!(Settings::ENTRIES.iter().any(|entry| entry.name == "integrator"));
}

#[test]
fn every_kind_of_light_is_light() {
    let dark = "warning: the scene has no light";
    assert!(report("").contains(dark), "{}", report(""));
    for light in [
        "light_point l { color { 1 1 1 } position { 0 0 3 } }",
        "lamp_point l { power { 1 1 1 } position { 0 0 3 } }",
        "lamp_sun l { irradiance { 1 1 1 } direction { 0 0 -1 } }",
        "environment l { radiance { 1 1 1 } }",
        "settings s { background { 1 1 1 } }",
        "settings s { integrator PATH background { 1 1 1 } }",
    ] {
        let report = report(light);
        assert_eq!(report, "", "{light}");
    }
    let dark = "warning: all lights are black";
    for light in [
        "lamp_point l { power { 0 0 0 } position { 0 0 3 } }",
        "environment l { radiance { 1 1 1 } strength 0 }",
    ] {
        let report = report(light);
        assert!(report.contains(dark), "{light}: {report}");
    }
}

#[test]
fn settings_of_photon_maps_are_for_photon_maps() {
    let lamp = "lamp_point l { power { 1 1 1 } position { 0 0 3 } }";
    for name in ["photonMapSize 9", "causticFilter NONE", "gather 0", "cacheError .2"] {
        let of = |integrator: &str| {
            report(&format!("settings s {{ integrator {integrator} {name} }} {lamp}"))
        };
        assert_eq!(of("PHOTON_MAP"), "", "{name}");
        let expected = format!(
            "`{}` does nothing under `integrator PATH`",
            name.split(' ').next().unwrap_or_default()
        );
        assert!(of("PATH").contains(&expected), "{}", of("PATH"));
    }
}

#[test]
fn lights_of_the_thesis_send_no_photons() {
    let report = |integrator: &str| {
        report(&format!(
            "settings s {{ integrator {integrator} }}
             light_point old {{ color {{ 1 1 1 }} position {{ 0 0 3 }} }}
             light_point older {{ color {{ 1 1 1 }} position {{ 1 0 3 }} }}
             lamp_point new {{ power {{ 1 1 1 }} position {{ 0 0 3 }} }}"
        ))
    };
    assert_eq!(report("PATH"), "");
    let found = report("PHOTON_MAP");
    assert!(found.contains("light `old` sends no photons"), "{found}");
    assert!(found.contains("nor does another light"), "{found}");
}

#[test]
fn what_glows_in_a_mix_is_seen() {
    const DARK: &str = "the scene has no light";
    let report = |settings: &str, parts: &str| {
        report(&format!(
            "settings s {{ {settings} }}
            phong_info dim {{ ambient {{ .1 .1 .1 }} }} material_phong dim {{ phong_info dim }}
            material_principled lamp {{ emission_strength 5 }}
            material_principled plain {{ }}
            material_mix inner {{ {parts} }}
            material_mix outer {{ first plain second inner }}
            sphere s {{ center {{ 0 0 3 }} radius 1 material outer light_group g }}",
        ))
    };
    for (settings, parts, is_dark, is_lamp) in [
        ("", "first plain second lamp", false, true),
        ("", "first plain second plain", true, false),
        ("", "first dim second plain", false, false),
        ("integrator PATH", "first dim second plain", true, false),
        ("integrator PATH", "first lamp second plain", false, true),
    ] {
        let report = report(settings, parts);
        assert_eq!(report.contains(DARK), is_dark, "{settings} {parts}: {report}");
        let has_no_effect = report.contains("`light_group` has no effect");
        assert_eq!(has_no_effect, !is_lamp, "{settings} {parts}: {report}");
    }
}

#[test]
fn groups_that_differ_in_case_are_told() {
    let lamp = |group: &str| {
        format!(
            "lamp_point {group} {{ power {{ 1 1 1 }} position {{ 0 0 3 }} light_group {group} }}"
        )
    };
    let report =
        |groups: &[&str]| report(&groups.iter().map(|group| lamp(group)).collect::<String>());
    assert_eq!(report(&["key", "rim", "rest"]), "");
    let two = report(&["key", "rim", "Key", "KEY"]);
    assert!(two.contains("the light groups `key` and `Key` differ only in case"), "{two}");
    assert_eq!(two.matches("differ only in case").count(), 2, "{two}");
    let rest = report(&["Rest"]);
    assert!(rest.contains("the light group `Rest` is not `rest`"), "{rest}");
}

#[test]
fn settings_without_effect_are_those_of_the_picture() {
    let warnings = |text: &str, adapt: &dyn Fn(&mut SceneDescription)| {
        let text = format!(
            "{text} phong_info p {{ ambient {{ 1 1 1 }} }} material_phong p {{ phong_info p }}
            sphere s {{ center {{ 0 0 3 }} radius 1 material p }} {}",
            include_str!("../scenes/minimal.txt")
        );
        let loaded = load_adapted("scene.txt", &text, &Files::built_in("", &[]), adapt);
        assert!(loaded.scene.is_some(), "{}", loaded.diagnostics.render(false));
        loaded.diagnostics.render(false)
    };
    let with =
        |integrator| move |scene: &mut SceneDescription| scene.settings.integrator = integrator;
    let ambient = "`ambient` does nothing under `integrator PATH`";
    let shadow = "`shadow TRANSPARENT` does nothing under `integrator PATH`";
    for (settings, integrator, expected) in [
        ("shadow TRANSPARENT", Integrator::Distributed, [false, false]),
        ("shadow TRANSPARENT", Integrator::Path, [true, true]),
        ("shadow OPAQUE", Integrator::Path, [true, false]),
        ("integrator PATH shadow TRANSPARENT", Integrator::Distributed, [false, false]),
    ] {
        let report = warnings(&format!("settings s {{ {settings} }}"), &with(integrator));
        assert_eq!([ambient, shadow].map(|what| report.contains(what)), expected, "{report}");
    }
    let lights = |scene: &mut SceneDescription| scene.camera.film.layers = vec![Layer::Lights];
    let none = "there is no light group to keep apart";
    assert!(warnings("", &lights).contains(none));
    assert!(!warnings("", &|_| {}).contains(none));
    let lamp = "lamp_point k { power { 1 1 1 } position { 0 0 3 } light_group key }";
    assert!(!warnings(lamp, &lights).contains(none));
}

#[test]
fn built_scenes_are_checked() {
    let mut scene = scene("environment a { texture t } texture t { filename plank.png }");
    assert_eq!(scene.check(), Ok(()));
    scene.textures.clear();
    let fault = "environment `a` refers to a texture that is missing";
    assert_eq!(scene.check(), Err(fault.to_owned()));
}
