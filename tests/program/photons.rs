//! Photons: parts, kept states, time limits and `verify` make the same picture.

use super::Folder;

/// A ball of glass and a mirror under a small lamp.
fn folder(settings: &str) -> Folder {
    Folder::with_scene(&format!(
        "settings s {{ integrator PATH recursion 6 imageSamples 12 {settings} }}
         Camera c {{
             fps 25
             Film f {{ width 70 height 41 prefix ball_ output PNG_IMAGE }}
             CamSegment only {{
                 videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
                 addPosition {{ 0 -5 1 }} addTarget {{ 0 0 0 }} fovStart .4
             }}
         }}
         lamp_point lamp {{ power {{ 300 300 300 }} position {{ 2 -3 4 }} radius .01 }}
         material_principled matte {{ }}
         material_principled glass {{ transmission 1 roughness 0 }}
         sphere ball {{ center {{ 0 0 0 }} radius .9 material glass }}
         plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 -1 }} material matte }}"
    ))
}

const NAME: &str = "ball_00000.png";

#[test]
fn the_option_is_the_setting() {
    let (scene, option) = (folder("photons .5"), folder(""));
    scene.printed("-q -s scene.txt");
    option.printed("-q -s scene.txt --photons .5");
    let recipe = |folder: &Folder, name: &str| folder.printed(&format!("--recipe {name}"));
    for folder in [&scene, &option] {
        assert!(recipe(folder, NAME).contains("\"photons\": 0.5"));
        folder.printed("-q -s scene.txt --photons 0 -od none");
        assert!(!recipe(folder, "none/ball_00000.png").contains("photons"));
        assert!(folder.read(NAME) != folder.read("none/ball_00000.png"), "photons find nothing");
    }
}

#[test]
fn pictures_are_verified() {
    let folder = folder("photons .5");
    folder.printed("-q -s scene.txt --threads 1");
    let verified = folder.printed(&format!("verify {NAME} -s scene.txt --tiles 99"));
    assert!(verified.starts_with("same\t"), "{verified}");
}

#[test]
fn parts_and_kept_states_make_the_picture() {
    let folder = folder("photons .5");
    folder.printed("-q -s scene.txt");
    for by in ["pixels", "samples"] {
        for number in [3, 1, 2] {
            folder.printed(&format!("-q -s scene.txt --part {number}/3 --part-by {by} -od {by}"));
        }
        let parts = (1..4).map(|n| format!("{by}/ball_00000.{by}-{n}-of-3.part"));
        folder.printed(&format!("merge -od {by} {}", parts.collect::<Vec<_>>().join(" ")));
        assert!(folder.read(NAME) == folder.read(&format!("{by}/{NAME}")), "{by}");
    }
    folder.printed("-q -s scene.txt --samples 5 --keep-state -od more");
    folder.printed("-q -s scene.txt --samples 12 --keep-state -od more");
    assert!(folder.read(NAME) == folder.read(&format!("more/{NAME}")), "more samples");
}

#[test]
fn a_time_limit_can_be_repeated() {
    let folder = folder("photons .5");
    folder.printed("-q -s scene.txt --time 700ms");
    let recipe = folder.printed(&format!("--recipe {NAME}"));
    let recipe: serde_json::Value = serde_json::from_str(&recipe).unwrap();
    let steps = format!("--steps {},{}", recipe["steps"][0], recipe["steps"][1]);
    folder.printed(&format!("-q -s scene.txt -od again {steps}"));
    assert!(folder.read(NAME) == folder.read(&format!("again/{NAME}")), "{steps}");
    let verified = folder.printed(&format!("verify {NAME} -s scene.txt --tiles 9"));
    assert!(verified.starts_with("same\t"), "{verified}");
}

#[test]
fn the_log_tells_what_photons_took() {
    let told = |settings: &str, options: &str| {
        let said = folder(settings).said(&format!("-v -s scene.txt {options}"));
        said.lines().find(|line| line.contains("photons:")).unwrap_or_default().trim().to_owned()
    };
    let passes = told("photons .5", "--threads 1");
    assert!(passes.starts_with("photons: 10 passes, "), "{passes}");
    assert_eq!(told("photons .5", "--threads 2"), passes);
    let more = told("photons .5", "--samples 20");
    assert!(more.starts_with("photons: 14 passes, "), "{more}");
    let maps = "photonMapSize 2000 causticMapSize 2000 gatherRays 20";
    let maps = |more: &str| told(&format!("{maps} {more}"), "--integrator PHOTON_MAP");
    let without = maps("");
    assert!(without.contains(" light paths; ") && without.ends_with("MB at a time"), "{without}");
    assert!(!without.contains("pass"), "{without}");
    let cache = maps("cacheError .3");
    assert!(cache.contains(" in the irradiance cache; "), "{cache}");
    assert_eq!(told("", ""), "");
}
