//! Light maps of objects, and texture coordinates that are not fit for them.

use slo_scene::{Files, LightMap, load};

/// A square with texture coordinates, without any, with some that overlap, and with some outside.
const FILES: &[(&str, &[u8])] = &[
    (
        "square.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    ),
    ("bare.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"),
    (
        "twice.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 2/2 4/3\n",
    ),
    (
        "large.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    ),
    ("nowhere.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 3 0\nvt 4 0\nvt 4 1\nf 1/1 2/2 3/3\n"),
];

const RECTANGLE: &str = "vertex0 { 0 0 0 } vertex1 { 1 0 0 } vertex2 { 1 1 0 }";

/// The light map of an object, and the report.
fn light_map(object: &str) -> (Option<LightMap>, String) {
    let text = format!(
        "Camera c {{ fps 25 Film f {{ width 8 height 8 }}
            CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 0 -9 0 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
         lamp_point l {{ power {{ 1 1 1 }} position {{ 0 0 4 }} }}
         material_principled m {{ }}
         {object}"
    );
    let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
    let object = loaded.scene.and_then(|scene| scene.objects[0].light_map);
    (object, loaded.diagnostics.render(false))
}

#[test]
fn objects_with_texture_coordinates_have_light_maps() {
    let of = |side, inside| (Some(LightMap { side, inside }), String::new());
    for object in [
        format!("rectangle a {{ material m {RECTANGLE} lightMap 64 }}"),
        format!("triangle a {{ material m {RECTANGLE} lightMap 64 }}"),
        "plane a { material m normal { 0 0 1 } position { 0 0 0 } lightMap 64 }".into(),
        "sphere a { material m center { 0 0 0 } radius 1 lightMap 64 }".into(),
        "mesh a { material m filename square.obj lightMap 64 }".into(),
    ] {
        assert_eq!(light_map(&object), of(64, false), "{object}");
        let inside = object.replace("lightMap 64", "lightMap 8192 lightMapInside 1");
        assert_eq!(light_map(&inside), of(8192, true), "{inside}");
    }
    assert_eq!(light_map("mesh a { material m filename bare.obj }"), (None, String::new()));
}

#[test]
fn what_is_not_fit_is_reported() {
    let mut report = String::new();
    for object in [
        format!("rectangle a {{ material m {RECTANGLE} lightMap 0 }}"),
        format!("rectangle a {{ material m {RECTANGLE} lightMap 8193 }}"),
        format!("rectangle a {{ material m {RECTANGLE} lightMapInside 1 }}"),
        format!("rectangle a {{ material m {RECTANGLE} lightMap 16 hidden 1 }}"),
        format!("box a {{ material m {RECTANGLE} height 1 lightMap 16 }}"),
        "cylinder a { material m base { 0 0 0 } top { 0 0 1 } radius 1 lightMap 16 }".into(),
        "cone a { material m base { 0 0 0 } apex { 0 0 1 } radius 1 lightMap 16 }".into(),
        "mesh a { material m filename bare.obj lightMap 16 }".into(),
        "mesh a { material m filename twice.obj lightMap 16 }".into(),
        "mesh a { material m filename large.obj lightMap 16 }".into(),
        "mesh a { material m filename nowhere.obj lightMap 16 }".into(),
    ] {
        let (_, said) = light_map(&object);
        assert_eq!(said.matches(" --> ").count(), 1, "{said}");
        report += &said;
    }
    insta::assert_snapshot!("light_maps", report);
}
