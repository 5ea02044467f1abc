use std::collections::BTreeMap;

use slo_scene::edit::applied;
use slo_scene::{Files, SceneDescription, load};

use super::*;

const OWN: &str = "settings s {}
Camera c { fps 10 Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
    CamSegment all { videoStart 0 videoEnd 2 addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart .4 }
}
light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
phong_info red { diffuse { .8 .1 .1 } }
material_phong red { phong_info red }
phong_info grey { diffuse { .5 .5 .5 } }
material_phong grey { phong_info grey }
sphere ball { center { 0 0 0 } radius 1 material red }
sphere stone { center { 3 0 0 } radius 1 material grey }
";

const OTHER: &str = "# A tree
include library/woods.txt
Camera c { fps 10 Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
    # from afar
    CamSegment all {
        videoStart 1 videoEnd 4 addPosition { 0 -9 1 } addTarget { 0 0 0 } fovStart .4
    }
}
# the sun
lamp_sun lamp { irradiance { 1 1 1 } direction { 0 0 -1 } } # bright
phong_info red { diffuse { .9 0 0 } }
material_phong red { phong_info red }
phong_info grey { diffuse { .5  .5 .5 } }
material_phong grey { phong_info grey }

group tree { hidden 1 }
/* its wood */
mesh trunk { filename \"the trunk.slo\" material bark parent tree }
sphere ball { center { 0 0 2 } radius 1 material red parent tree }
copy oak { of tree addKframe { time 0 key { pivot { 4 0 0 } } } }
sphere pebble { center { 0 0 0 } radius .1 material grey }
sphere broken { center { 0 0 0 } radius 1 material none }
";

const WOODS: &str = "texture rings { filename rings.png }
phong_info bark { diffuse { .3 .2 .1 } }
material_texture bark { phong_info bark texture rings }
";

const MESH: &[u8] = b"slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 } uvs { 0 0 1 0 0 1 } face_uvs { 0 1 2 }";

/// Reads the files of the two scenes, which lie in different folders.
fn open(path: &str) -> Result<String, String> {
    match path {
        "sets/library/woods.txt" => Ok(WOODS.to_owned()),
        _ => Err(format!("there is no `{path}`")),
    }
}

/// The text after things of the other scene were taken over.
fn merged(own: &str, other: &str, chosen: &[&str]) -> Result<(String, Merged), String> {
    let own_catalog = Catalog::of(own.into(), "", &open)?;
    let other = Catalog::of(other.into(), "sets/", &open)?;
    let index = |name: &&str| {
        let called = |of: &Thing| format!("{} {}", of.keyword, of.name) == **name;
        other.things.iter().position(called).expect(name)
    };
    let chosen: Vec<usize> = chosen.iter().map(index).collect();
    let merged = merge(&own_catalog, &other, "sets/tree.txt", &chosen)?;
    let text = applied(own, merged.edits.clone()).expect("the edits fit");
    Ok((text, merged))
}

/// The scene that a text describes.
fn scene(text: &str) -> SceneDescription {
    let png = png();
    let files = BTreeMap::from([
        ("sets/the trunk.slo".to_owned(), MESH.to_vec()),
        ("sets/library/rings.png".to_owned(), png),
    ]);
    let loaded = load("scene.txt", text, &Files::in_memory("", files));
    loaded.scene.unwrap_or_else(|| panic!("{}\n{text}", loaded.diagnostics.render(false)))
}

fn png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[200, 100, 50]).expect("a pixel");
    writer.finish().expect("an end");
    file
}

#[test]
fn what_is_chosen_brings_what_it_needs() {
    let (text, merged) = merged(OWN, OTHER, &["copy oak"]).unwrap();
    let expected = format!(
        "{OWN}# From sets/tree.txt
phong_info red_2 {{ diffuse {{ .9 0 0 }} }}
material_phong red_2 {{ phong_info red_2 }}
group tree {{ hidden 1 }}
/* its wood */
mesh trunk {{ filename \"sets/the trunk.slo\" material bark parent tree }}
sphere ball_2 {{ center {{ 0 0 2 }} radius 1 material red_2 parent tree }}
copy oak {{ of tree addKframe {{ time 0 key {{ pivot {{ 4 0 0 }} }} }} }}
texture rings {{ filename sets/library/rings.png }}
phong_info bark {{ diffuse {{ .3 .2 .1 }} }}
material_texture bark {{ phong_info bark texture rings }}
"
    );
    assert_eq!(text, expected);
    assert_eq!(merged.counts, [1, 8]);
    let renamed: Vec<_> = merged.renamed.iter().map(|[old, new]| (&**old, &**new)).collect();
    assert_eq!(renamed, [("red", "red_2"), ("red", "red_2"), ("ball", "ball_2")]);
    let scene = scene(&text);
    assert_eq!((scene.objects.len(), scene.copies.len()), (4, 1));
}

#[test]
fn what_is_the_same_is_not_taken_twice() {
    let (text, _) = merged(OWN, OTHER, &["sphere pebble"]).unwrap();
    let pebble = "sphere pebble { center { 0 0 0 } radius .1 material grey }\n";
    assert_eq!(text, format!("{OWN}# From sets/tree.txt\n{pebble}"));
    scene(&text);
    // Chosen by its name, it is taken all the same.
    let (text, _) = merged(OWN, OTHER, &["material_phong grey"]).unwrap();
    assert!(text.ends_with("tree.txt\nmaterial_phong grey_2 { phong_info grey }\n"), "{text}");
}

#[test]
fn lamps_bring_their_comments_and_line_ends_stay() {
    let own = OWN.replace('\n', "\r\n");
    let (text, _) = merged(own.trim_end(), OTHER, &["lamp_sun lamp"]).unwrap();
    let lamp =
        "# the sun\r\nlamp_sun lamp_2 { irradiance { 1 1 1 } direction { 0 0 -1 } } # bright\r\n";
    assert_eq!(text, format!("{own}# From sets/tree.txt\r\n{lamp}"));
    assert_eq!(scene(&text).lights.len(), 2);
}

#[test]
fn segments_follow_the_last_one() {
    let (text, _) = merged(OWN, OTHER, &["CamSegment all"]).unwrap();
    let added = "fovStart .4 }
    # from afar
    CamSegment all_2 {
        videoStart 2 videoEnd 5 addPosition { 0 -9 1 } addTarget { 0 0 0 } fovStart .4
        sceneStart 1
    }
}
";
    assert_eq!(text, OWN.replace("fovStart .4 }\n}\n", added));
    let segment = &scene(&text).camera.segments[1];
    assert_eq!((segment.video, segment.scene), ([2.0, 5.0], [1.0, 4.0]));
}

#[test]
fn what_can_not_be_taken_is_said() {
    let fault = |own: &str, other: &str, chosen: &[&str]| merged(own, other, chosen).unwrap_err();
    let said = fault(OWN, OTHER, &["sphere broken"]);
    assert_eq!(said, "`broken` refers to `none`, which is missing");
    let twice = format!("Scaling x {{ 2 }}\n{OWN}");
    let said = fault(&twice, OTHER, &["sphere pebble"]);
    assert!(said.contains("`Scaling { 1 }`") && said.contains("`Scaling { 2 }`"), "{said}");
    assert!(merged(&twice, OTHER, &["material_phong red"]).is_ok());
    let sky = "environment sky { radiance { 1 1 1 } }\n";
    let said = fault(&format!("{OWN}{sky}"), sky, &["environment sky"]);
    assert_eq!(said, "the scene has an environment already, `sky`");
    assert_eq!(fault(OWN, OTHER, &[]), "choose what to take over");
    let said = fault("include c.txt", OTHER, &["sphere pebble"]);
    assert_eq!(said, "there is no `c.txt`");
}
