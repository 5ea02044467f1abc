//! AFF.

use glam::DVec3;
use slo_scene::Shape;

use super::{refused, says, scene_of};

const VIEW: &str =
    "v from 0 0 9 at 0 0 0 up 0 1 0 angle 90 hither 0.1 resolution 40 30\nl 0 9 9 .5 .5 .5\n";

/// A triangle in the plane z = 0.
const TRIANGLE: &str = "p 3 0 0 0 1 0 0 0 1 0\n";

/// A spline along x that passes `x = t * t` at 1 to 3 s, where even keys of no shape are exact.
const PARABOLA: &str =
    "transl 5 0 0 0 0 0 0 0  1 1 0 0 0 0 0  2 4 0 0 0 0 0  3 9 0 0 0 0 0  4 16 0 0 0 0 0\n";

fn aff(text: &str) -> (crate::Imported, slo_scene::SceneDescription) {
    scene_of(&[("a.aff", &format!("{VIEW}{text}"))])
}

#[test]
fn fills_run_on_and_meet_the_light_everywhere() {
    let text = "am 2 1 .5\nfm .1 .2 .3  .4 .5 .6  .3 .3 .3  7 .5 0 % glass\n\
                xs 1 1 1  0 0 0 0  0 0 0 { f 1 .5 0 .5 .25 8 0 0 s 0 0 0 1 }\r\n\
                s 3 0 0 -1\nx free { p 3 0 0 0 1 0 0 0 1 0 }";
    let (imported, scene) = aff(text);
    assert_eq!((imported.shapes, imported.materials), ((1, 2), 1), "the first fill is not used");
    assert_eq!(scene.objects.len(), 3);
    says(&imported, "phong_info fill { diffuse { 0.5 0.25 0 }  specular { 0.25 0.25 0.25 }");
    let (imported, _) = aff(&text.replace("f 1 .5 0 .5 .25 8 0 0", ""));
    says(&imported, "ambient { 0.2 0.2 0.15 }  diffuse { 0.4 0.5 0.6 }  specular { 0.3 0.3 0.3 }");
    says(&imported, "recursion 5  shadow TRANSPARENT }");
    says(&imported, "shininess 7  reflectance 0.3  refraction 0.5  refraction_index 1 }");
    says(&imported, "light_point light { color { 0.5 0.5 0.5 }  position { 0 9 9 } }");
    assert!(imported.left_out.is_empty() && imported.made_up.is_empty(), "{imported:?}");
    let (imported, _) = aff("fm 0 0 0 1 1 1 .5 .3 .1 2 0 0 s 0 0 0 1");
    assert_eq!(imported.left_out, ["the colour of a mirror"]);
}

#[test]
fn groups_move_by_splines() {
    let text = format!(
        "a 1 3 5\nx runner {{ xs 2 2 2  0 0 2 90  5 0 0 {{ {TRIANGLE} }} {TRIANGLE} }}\n\
         x unknown {{ s 0 0 0 1 s 1 0 0 1 }}\n k runner {{ {PARABOLA} }}\nk unused {{ {PARABOLA} }}"
    );
    let (imported, scene) = aff(&text);
    assert_eq!(imported.made_up, ["when it starts: at 0 s, which is 1 s in the file"]);
    // Five frames in two seconds.
    says(&imported, "fps 2\n");
    says(&imported, "videoEnd 2.5 ");
    says(&imported, "group runner {\n    addKframe { time 0  key { pivot { 1 0 0 } } }\n");
    says(&imported, "addKframe { time 0.5  key { pivot { 2.25 0 0 } } }");
    says(&imported, "addKframe { time 2  key { pivot { 9 0 0 } } }\n  }");
    says(&imported, "turn { axis { 0 0 1 } angle_deg 90 }  scale { 2 2 2 } } }  parent runner }");
    assert_eq!(scene.objects.len(), 4);
    assert_eq!(imported.files.len(), 1, "the same mesh twice is one file");
}

#[test]
fn cameras_follow_their_block() {
    let text = format!(
        "a 0 4 5\n{TRIANGLE}k camera {{ {PARABOLA}\nrot 4 0 0 3 0 0 0 0 0  1 0 1 0 -90 0 0 0  \
         3 0 1 0 -90 0 0 0  4 0 1 0 0 0 0 0 }}"
    );
    let (imported, _) = aff(&text);
    says(&imported, "fps 1\n");
    // Outside of the spline the camera rests, and looks along x.
    says(
        &imported,
        "CamSegment s0 { videoStart 0  videoEnd 1  addPosition { 1 0 0 }  addTarget { 2 0 0 }  \
         addPosition { 1 0 0 }  addTarget { 2 0 0 }  skyStart { 0 1 0 }  skyEnd { 0 1 0 }  fovStart 1 }",
    );
    says(
        &imported,
        "CamSegment s1 { videoStart 1  videoEnd 2  addPosition { 1 0 0 }  addTarget { 2 0 0 }  addPosition { 4 0 0 }",
    );
    says(&imported, "CamSegment s4 { videoStart 4  videoEnd 5 ");
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
}

#[test]
fn lights_move_by_splines_and_with_groups() {
    let text = format!(
        "a 1 3 5\nla torch 1 2 3 la still 4 5 6 x runner {{ l 7 8 9 {TRIANGLE} xs 1 1 1  0 0 0 0  5 0 0 {{ l 0 0 1 }} }}\n\
         xs 2 2 2  0 0 0 0  5 0 0 {{ l 0 0 1 }} k torch {{ {PARABOLA} }} k runner {{ {PARABOLA} }} k still {{ rot 0 }}"
    );
    let (imported, scene) = aff(&text);
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    says(
        &imported,
        "light_point torch { color { 1 1 1 }  position { 1 2 3 }\n    addKframe { time 0  key { pivot { 1 0 0 } } }\n",
    );
    says(&imported, "light_point still { color { 1 1 1 }  position { 4 5 6 } }");
    says(&imported, "position { 7 8 9 }  parent runner }");
    says(
        &imported,
        "position { 0 0 1 }  addKframe { time 0  key { pivot { 5 0 0 } } }  parent runner }",
    );
    says(&imported, "position { 5 0 2 } }");
    let moving = scene.lights.iter().filter(|light| !light.key_frames.is_empty()).count();
    assert_eq!((scene.lights.len(), moving), (6, 2));
}

#[test]
fn what_is_odd_in_key_frames_is_told() {
    let text = format!(
        "x a {{ {TRIANGLE} }} la b 1 2 3 la c 0 0 0 .1 .2 .3 k b {{ {PARABOLA} }}\n\
         k a {{ rot 4 0 0 1.5 0 9 0 0 0  2 0 1 0 0 0 0 0  1 0 1 0 0 0 0 0  5 0 1 0 9 0 0 0 }}"
    );
    let (imported, scene) = aff(&text);
    assert_eq!(
        imported.left_out,
        ["that the times of a spline's keys fall", "the length of an axis, which counts as 1"]
    );
    assert_eq!(imported.made_up, ["its frames: 25 a second while something moves"]);
    assert_eq!(scene.lights.len(), 3);
    says(&imported, "light_point c { color { 0.1 0.2 0.3 }  position { 0 0 0 } }");
}

#[test]
fn what_is_invisible_is_not_there() {
    let text = format!(
        "a 0 4 5 x never {{ x deep {{ {TRIANGLE} }} l 0 0 0 }} x late {{ s 0 0 0 1 }}\n\
         k never {{ visibility 1 -1 0 }} k late {{ visibility 2 -1 0 2 1 }}"
    );
    let (imported, scene) = aff(&text);
    assert_eq!((scene.objects.len(), scene.lights.len()), (1, 1));
    assert_eq!(
        imported.made_up,
        ["how what comes and goes is hidden: it is a millionth of its size"]
    );
    says(
        &imported,
        "addKframe { time 1.9999  key { pivot { 0 0 0 }  scale { 0.000001 0.000001 0.000001 } } }\n    addKframe { time 2  key { pivot { 0 0 0 } } }",
    );
}

#[test]
fn triangles_that_move_become_shapes() {
    let row = |time: &str, z: f64| format!("{time} 0 0 {z} 0 0 2  1 0 {z} 0 0 0  0 1 {z} 0 0 1\n");
    let (one, two) = (row("0", 0.0), row("1", 1.0));
    let text = format!(
        "a -1 1 3\ntpa 2 {one} {two} tpa 2 {one} {two} tpa 1 {one} tpa 2 {one} {}",
        row("7", 5.0)
    );
    let (imported, scene) = aff(&text);
    assert_eq!((imported.shapes, scene.objects.len()), ((4, 0), 3));
    assert_eq!(imported.files.len(), 2 + 1 + 2);
    says(
        &imported,
        "mesh a {  smooth_normals 1\n    addShape { time 1  filename meshes/a_0000.ply }\n    addShape { time 2  filename meshes/a_0001.ply }\n",
    );
    says(&imported, "addShape { time 8  filename meshes/a_3_0001.ply }");
}

#[test]
fn meshes_have_lists_of_their_own() {
    let text = "m vertices 4 0 0 0 1 0 0 1 1 0 0 1 0 normals 1 0 0 9 texturecoords 2 gone.ppm 0 0 2 -1\n\
                triangles 2 0 1 2 0 0 0 0 1 0  0 2 3 0 0 0 1 1 1\n\
                m vertices 3 0 0 0 1 0 0 1 1 0 triangles 1 0 1 2\n\
                tt gone.ppm 0 0 0 0 0 1 0 0 1 0 1 1 0 1 1 ttp gone.ppm 0 0 0 0 0 1 0 0 1 0 0 0 0 1 1 0 1 1 0 0 0 1 1 1";
    let (imported, scene) = aff(text);
    assert_eq!(imported.left_out, ["the image `gone.ppm`, which can't be read"]);
    assert_eq!((imported.shapes, scene.objects.len()), ((5, 0), 2));
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    assert_eq!((mesh.mesh.positions.len(), mesh.smooth), (4 + 2 + 3, true), "uvs split vertices");
}

#[test]
fn images_lie_on_what_has_them() {
    let ppm = "P3 2 1 255 255 0 0 0 0 255\n";
    let text = format!("{VIEW}f .5 .5 .5 1 0 0 0 0 tt wall.ppm 0 0 0 0 0 1 0 0 1 0 1 1 0 1 1");
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("textures")).unwrap();
    std::fs::write(folder.path().join("textures/wall.ppm"), ppm).unwrap();
    std::fs::write(folder.path().join("a.aff"), text).unwrap();
    let imported = crate::import(&folder.path().join("a.aff"), false).unwrap();
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    says(&imported, "texture wall { filename textures/wall.png }");
    says(&imported, "material_texture wall { phong_info wall  texture wall }");
    let (_, png) = imported.files.iter().find(|(name, _)| name == "textures/wall.png").unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    super::read(&imported);
}

#[test]
fn files_are_read_in_place() {
    let main = format!("{VIEW}f 1 0 0 1 0 0 0 0 i 0 b.aff i 1 gone.aff d 2 i 1 b.aff s 0 0 0 1");
    let b = "p 3 0 0 0 1 0 0 0 1 0\nf 0 1 0 1 0 0 0 0\n";
    let (imported, scene) = scene_of(&[("a.aff", &main), ("b.aff", b)]);
    assert_eq!((imported.shapes, imported.materials), ((2, 1), 2));
    assert_eq!((scene.objects.len(), imported.files.len()), (3, 1));
    says(&imported, "mesh b { filename meshes/b.ply  material fill }");
    let message = |text: &str| refused("a.aff", text);
    assert_eq!(
        message("s 0 0 0 1\ni 0 ../b.aff"),
        "`a.aff`, line 2: this includes a file: can't read `..b.aff`: No such file or directory (os error 2)"
    );
    assert!(
        message("i 0 a.aff")
            .contains("`a.aff`, line 1: files or groups are nested more than 100 deep")
    );
}

#[test]
fn mirrored_groups_move_too() {
    let text = format!(
        "a 1 3 3 x runner {{ xs -1 1 1  0 1 0 0  0 0 0 {{ x runner {{ {TRIANGLE} s 2 0 0 1 }} }} }} k runner {{ {PARABOLA} }}"
    );
    let (imported, scene) = aff(&text);
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    // The inner one runs the other way.
    says(&imported, "addKframe { time 1  key { pivot { -4 0 0 } } }");
    says(&imported, "center { -2 0 0 }");
    let Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!("{}", imported.text) };
    let [a, b, c] = mesh.mesh.faces[0].map(|corner| mesh.mesh.positions[corner as usize]);
    assert!(mesh.mesh.positions.contains(&DVec3::new(-1.0, 0.0, 0.0)));
    assert_eq!((b - a).cross(c - a), DVec3::Z, "its front stays its front");
}

#[test]
fn mistakes_in_aff_have_their_line() {
    for (text, expected) in [
        ("x a {\ns 0 0 0 1", "`a.aff`, line 2: a group is not closed at the end"),
        ("k a { transl 3 0", "`a.aff`, line 1: a spline needs four keys or more instead of 3"),
        (
            "k a { bend 3",
            "`a.aff`, line 1: `bend` is no channel: transl, rot, scale and visibility are",
        ),
        (
            "m vertices 1 0 0 0\ntriangles 1 0 0 1",
            "`a.aff`, line 2: index 1 does not exist (there are 1)",
        ),
        ("m triangles", "`a.aff`, line 1: expected `vertices` instead of `triangles`"),
        ("\n\nq", "`a.aff`, line 3: `q` is not an item of AFF"),
        ("}", "`a.aff`, line 1: `}` is not an item of AFF"),
        (
            "tpa 2 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1",
            "`a.aff`, line 1: the times of a moving triangle do not rise",
        ),
        ("a 0 1 0", "`a.aff`, line 1: expected a whole number from 1 to 65536 instead of 0"),
        ("m vertices 999999999 0", "`a.aff`, line 1: a number is missing at the end"),
    ] {
        assert_eq!(refused("a.aff", text), expected);
    }
    let deep = "x a { ".repeat(200);
    assert!(refused("a.aff", deep).contains("nested more than 100 deep"));
}
