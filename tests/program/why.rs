//! `why`: what a pixel is made of.

use slo_picture::output::Raster;

use super::Folder;

const SCENE: &str = "
settings s { imageSamples 8 imageContrastLimit 0 integrator PATH recursion 3 }
Camera c { fps 25
    Film f { width 16 height 9 prefix room_ output EXR_IMAGE }
    CamSegment only { videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
        addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 0.4 } }
lamp_disc key { power { 90 90 90 } center { 2 -3 4 } normal { -.3 .5 -1 } radius .4 }
environment sky { radiance { .2 .3 .4 } }
material_principled matte { base_color { .7 .6 .5 } }
material_principled chrome { metallic 1 roughness 0 }
plane floor { normal { 0 0 1 } position { 0 0 -1 } material matte }
sphere ball { center { 0 0 0 } radius 1 material chrome }
";

fn answer(folder: &Folder, typed: &str) -> serde_json::Value {
    serde_json::from_str(&folder.printed(typed)).unwrap()
}

fn shares(value: &serde_json::Value) -> Vec<(String, f64)> {
    let share = |of: &serde_json::Value| {
        (of["name"].as_str().unwrap().to_owned(), of["share"].as_f64().unwrap())
    };
    value.as_array().unwrap().iter().map(share).collect()
}

#[test]
fn an_answer_adds_up_to_the_pixel() {
    let folder = Folder::with_scene(SCENE);
    folder.printed("-q -s scene.txt");
    let pixels = Raster::read(&folder.path().join("room_00000.exr")).unwrap().image.rgb;
    for (x, y) in [(8, 4), (2, 8), (0, 0)] {
        let why = answer(&folder, &format!("why {x},{y} -s scene.txt --json"));
        assert_eq!((&why["samples"], &why["pixel"]), (&8.into(), &serde_json::json!([x, y])));
        for (channel, expected) in pixels[y * 16 + x].into_iter().enumerate() {
            let mean = why["mean"][channel].as_f64().unwrap() as f32;
            assert!((mean - expected).abs() <= 1e-6 * expected, "{x},{y}: {mean} {expected}");
        }
        for by in ["byLight", "byWay", "bySeenObject", "byLitObject"] {
            let sum: f64 = shares(&why[by]).iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{by}: {sum}");
        }
    }
}

#[test]
fn light_has_names_and_a_sample_can_be_replayed() {
    let folder = Folder::with_scene(SCENE);
    // The ball mirrors the floor and the sky.
    let why = answer(&folder, "why 8,5 -s scene.txt --samples 32 --json");
    assert_eq!(shares(&why["bySeenObject"])[0].0, "ball");
    let lights: Vec<String> = shares(&why["byLight"]).into_iter().map(|(name, _)| name).collect();
    assert!(lights.contains(&"key".to_owned()) && lights.contains(&"sky".to_owned()), "{lights:?}");
    let ways = shares(&why["byWay"]);
    assert!(ways.iter().any(|(name, _)| name == "sharp > lamp asked"), "{ways:?}");
    let brightest = &why["brightest"][0];
    let number = brightest["sample"].as_u64().unwrap();
    let one = answer(&folder, &format!("why 8,5 -s scene.txt --sample {number} --json"));
    let found = one["brightest"].as_array().unwrap().iter();
    assert!(found.into_iter().any(|way| way["way"] == brightest["way"]), "{one:#}");
    let tree = one["tree"].as_array().unwrap();
    assert_eq!((&tree[0]["leg"], &tree[0]["object"]), (&"camera".into(), &"ball".into()));
    let text = folder.printed("why 8,5 -s scene.txt --samples 32");
    for part in ["pixel 8,5 of frame 0: ", "by light", "sharp to floor [matte]", "--sample "] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let tree = folder.printed(&format!("why 8,5 -s scene.txt --sample {number}"));
    assert!(tree.contains("\n  camera: ball [chrome]  x 1.0000"), "{tree}");
}

#[test]
fn equal_ways_are_one_and_the_command_names_the_scene() {
    let folder = Folder::with_scene(SCENE);
    let why = answer(&folder, "why 8,5 scene.txt --samples 32 --ways 1000 --json");
    let ways = why["brightest"].as_array().unwrap();
    let words = |way: &serde_json::Value| {
        let steps = way["way"].as_array().unwrap().iter();
        let steps: Vec<_> = steps
            .map(|step| [&step["leg"], &step["light"], &step["object"], &step["material"]])
            .collect();
        format!("{steps:?} {}", way["source"])
    };
    let different: std::collections::BTreeSet<String> = ways.iter().map(words).collect();
    assert_eq!(different.len(), ways.len());
    assert!(ways.iter().any(|way| way["times"].as_u64() > Some(1)), "{ways:?}");
    let sum: f64 = ways.iter().map(|way| way["sumOfLuminance"].as_f64().unwrap()).sum();
    let all = why["luminance"].as_f64().unwrap() * 32.0;
    assert!((sum - all).abs() < 1e-6 * all, "{sum} {all}");
    for (typed, replay) in [
        ("why 8,5 scene.txt --samples 4", "slo-rt why 8,5 scene.txt --sample "),
        ("why 8,5 -s scene.txt -f 1 --samples 4", "slo-rt why 8,5 -s scene.txt -f 1 --sample "),
    ] {
        let text = folder.printed(typed);
        assert!(text.contains(replay), "{typed}: {text}");
    }
    let run = folder.run("why 8,5 scene.txt -s scene.txt");
    assert_eq!(run.exit, 2, "{}", run.said);
}

#[test]
fn an_answer_shows_its_progress() {
    let folder = Folder::with_scene(SCENE);
    let run = folder.run("why 8,5 scene.txt --samples 64 --progress json");
    assert!(run.said.contains("\"event\":\"started\""), "{}", run.said);
    assert_eq!(folder.run("why 8,5 scene.txt -q --samples 64").said, "");
}

#[test]
fn pixels_outside_are_refused() {
    let folder = Folder::with_scene(SCENE);
    for (typed, part) in [
        ("why 16,0 -s scene.txt", "pixel 16,0 is outside of the picture, which has 16x9"),
        ("why 3 -s scene.txt", "such as 320,180"),
        ("why 3,4 -s scene.txt -f 99", "frame 99"),
    ] {
        let run = folder.run(typed);
        assert_eq!((run.exit, &*run.printed), (2, ""), "{typed}: {}", run.said);
        assert!(run.said.contains(part), "{typed}: {}", run.said);
    }
}
