//! The scene language: fixtures of `tests/scenes`, their scenes and their messages.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use slo_scene::{Curve, Files, Filter, Loaded, Mesh, SceneDescription, Shape, Wrap, load};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes")
}

/// Loads a file of `tests/scenes`, from where no path may lead out.
pub(crate) fn load_fixture(name: &str) -> Loaded {
    let path = fixtures().join(name);
    let text = std::fs::read(&path).expect("the fixture exists");
    let folder = path.parent().expect("it lies in a folder");
    load(name, text, &Files::on_disk(folder, &fixtures(), false))
}

#[test]
fn the_least_that_a_scene_needs() {
    let loaded = load_fixture("minimal.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("there are no errors");
    assert_eq!(scene.camera.film.prefix, "frame_");
    assert_eq!(scene.camera.segments[0].scene, [0.0, 1.0]);
    assert_eq!(scene.objects.len(), 1);
}

#[test]
fn everything() {
    let loaded = load_fixture("everything.txt");
    let report = loaded.diagnostics.render(false);
    assert!(!loaded.diagnostics.has_errors(), "{report}");
    // Not all of it can mean something at once.
    assert_eq!(report.matches("does nothing beside").count(), 2, "{report}");
    for name in ["contrastType", "imageContrastLimit"] {
        assert!(report.contains(&format!("`{name}` does nothing beside `noise`")), "{report}");
    }
    let mut scene = loaded.scene.expect("there are no errors");
    scene.content_hash = [0; 32];
    insta::assert_snapshot!("everything", format!("{scene:#?}"));
}

pub(crate) fn mesh<'s>(scene: &'s SceneDescription, object: &str) -> &'s Arc<Mesh> {
    match &scene.objects.iter().find(|o| o.name == object).expect("it is there").shape {
        Shape::Mesh(surface) => &surface.mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

#[test]
fn meshes_are_scaled_added_and_shared() {
    let loaded = load_fixture("meshes.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("there are no errors");
    let [one, again, smooth, twice] = ["one", "again", "smooth", "twice"].map(|o| mesh(&scene, o));
    assert_eq!(one.positions[1].to_array(), [0.1, 0.0, 0.0]);
    assert!(Arc::ptr_eq(one, again));
    assert!(one.normals.is_empty() && smooth.normals.len() == 4);
    assert_eq!(twice.faces.len(), 2 * one.faces.len());
}

#[test]
fn a_mesh_without_uvs_under_a_texture_gets_a_warning() {
    const FILES: &[(&str, &[u8])] = &[
        ("without.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("with.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"),
        ("plank.png", include_bytes!("../scenes/files/plank.png")),
    ];
    let report = |material: &str, files: &[&str]| {
        let mut text = format!(
            "{}\nphong_info p {{ }} texture t {{ filename plank.png }}\n\
             material_texture textured {{ phong_info p texture t }}\n\
             material_phong plain {{ phong_info p }}\n\
             sphere a {{ center {{ 0 0 0 }} radius 1 material textured }}\n\
             sphere b {{ center {{ 0 0 0 }} radius 1 material plain }}\n",
            include_str!("../scenes/minimal.txt")
        );
        for name in ["first", "second"] {
            let files: String = files.iter().map(|f| format!(" filename {f}")).collect();
            text.push_str(&format!("mesh {name} {{{files} material {material} }}\n"));
        }
        let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
        assert!(!loaded.diagnostics.has_errors(), "{}", loaded.diagnostics.render(false));
        loaded.diagnostics.render(false)
    };
    let warning = "warning: mesh `without.obj` has no uvs (texture coordinates)";
    assert_eq!(report("textured", &["without.obj"]).matches(warning).count(), 1);
    assert_eq!(report("textured", &["with.obj", "without.obj"]).matches(warning).count(), 1);
    assert_eq!(report("plain", &["without.obj"]), "");
    assert_eq!(report("textured", &["with.obj"]), "");
}

/// A scene with a texture of a grey pixel and a clear one, seen on a sphere.
fn with_texture(attributes: &str) -> Loaded {
    // 2 x 1 pixels: 128 with alpha 255, 128 with alpha 0.
    const CLEAR: &[u8] = include_bytes!("../scenes/files/clear.png");
    let text = format!(
        "{}\nphong_info p {{ }} texture t {{ filename clear.png {attributes} }}\n\
         texture twin {{ filename clear.png }}\n\
         material_texture m {{ phong_info p texture t }}\n\
         material_texture again {{ phong_info p texture twin }}\n\
         sphere a {{ center {{ 0 0 0 }} radius 1 material m }}\n\
         sphere b {{ center {{ 5 0 0 }} radius 1 material again }}\n",
        include_str!("../scenes/minimal.txt")
    );
    load("scene.txt", &text, &Files::built_in("", &[("clear.png", CLEAR)]))
}

#[test]
fn how_a_texture_is_looked_up() {
    let loaded = with_texture("wrap MIRROR filter NEAREST encoding SRGB");
    let report = loaded.diagnostics.render(false);
    let textures = loaded.scene.expect(&report).textures;
    let [texture, plain] = &textures[..] else { panic!("two are written") };
    assert_eq!((texture.wrap(), texture.filter()), (Wrap::Mirror, Filter::Nearest));
    assert_eq!((texture.color_curve(), texture.data_curve()), (Curve::Srgb, Curve::Srgb));
    assert_eq!((plain.wrap(), plain.filter()), (Wrap::Repeat, Filter::Linear));
    assert_eq!((plain.color_curve(), plain.data_curve()), (Curve::Srgb, Curve::Raw));
    assert_eq!(plain.texel_rgba(1, 0)[3], 0.0);
    for (wrong, said) in [
        ("wrap mirror", "unknown wrap `mirror`, did you mean `MIRROR`?"),
        ("filter CUBIC", "unknown filter `CUBIC`"),
        ("encoding LINEAR", "unknown encoding `LINEAR`"),
        ("encoding SRGB encoding RAW", "`encoding` is given twice in texture `t`"),
        ("tile REPEAT", "unknown attribute `tile` in `texture`"),
    ] {
        let loaded = with_texture(wrong);
        let report = loaded.diagnostics.render(false);
        assert!(report.contains(said), "{report}");
    }
}

#[test]
fn alpha_that_no_material_shows_is_warned_of_once() {
    let loaded = with_texture("");
    assert!(!loaded.diagnostics.has_errors());
    insta::assert_snapshot!(loaded.diagnostics.render(false), @r"
    warning: texture `clear.png`: it has transparent pixels, but alpha is not used: they show their colour
      --> scene.txt:15:39
       |
    15 | phong_info p { } texture t { filename clear.png  }
       |                                       ^^^^^^^^^

    warning: 1 warning
    ");
}

#[test]
fn content_hash_covers_the_bytes_of_meshes() {
    const SCENE: &[u8] = include_bytes!("../scenes/meshes.txt");
    const MESH: &[u8] = include_bytes!("../scenes/files/tetrahedron.slo");
    const COMMENTED: &[u8] = b"slo_mesh 1 # the same\nvertices { 0 0 0  1 0 0  0 1 0  0 0 1 }\nfaces { 0 2 1  0 1 3  0 3 2  1 2 3 }";
    let hash = |files| {
        let scene = load("meshes.txt", SCENE, &Files::built_in("", files)).scene;
        scene.expect("there are no errors").content_hash
    };
    let original = hash(&[("files/tetrahedron.slo", MESH)]);
    assert_eq!(original, hash(&[("files/tetrahedron.slo", MESH), ("other", b"unread")]));
    assert_ne!(original, hash(&[("files/tetrahedron.slo", COMMENTED)]));
    assert_eq!(original, load_fixture("meshes.txt").scene.expect("no errors").content_hash);
}

#[test]
fn missing_files_are_told_from_bad_ones() {
    let missing = |name| load_fixture(&format!("errors/{name}.txt")).diagnostics.missing_input();
    assert!(missing("file_missing"));
    assert!(!missing("file_bad"));
    assert!(!missing("name_dangling"));
    assert!(!load_fixture("minimal.txt").diagnostics.missing_input());
}

#[test]
fn a_shutter_as_long_as_its_segment_is_no_mistake_of_rounding() {
    let text = "Camera c { fps 24 Film f { width 2 height 2 } CamSegment s {
            videoStart 0.25 videoEnd 0.2708333333333333 blurDuration 0.020833333333333332
            addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 1 } }
        light_point l { color { 1 1 1 } position { 0 0 5 } }";
    let check =
        |text: &str| load("a.txt", text, &Files::built_in("", &[])).diagnostics.render(false);
    assert!(!check(text).contains("the shutter is open"));
    assert!(check(&text.replace("0.020833333333333332", "0.0209")).contains("the shutter is open"));
}

#[test]
fn colours_only_where_asked() {
    let diagnostics = load_fixture("errors/a_hundred_errors.txt").diagnostics;
    assert!(!diagnostics.render(false).contains('\u{1b}'));
    assert!(diagnostics.render(true).contains("\u{1b}["));
}

#[test]
fn byte_order_mark_and_carriage_returns() {
    let loaded = load_fixture("bom_and_crlf.txt");
    assert_eq!(loaded.diagnostics.render(false), "");
    assert!(loaded.scene.is_some());
}

#[test]
fn carriage_returns_are_not_shown() {
    let loaded = load("crlf.txt", "sphere s {\r\n    radius x\r\n}\r\n", &Files::built_in("", &[]));
    let report = loaded.diagnostics.render(false);
    assert!(report.contains("crlf.txt:2:12"), "{report}");
    assert!(!report.contains(['\r', '\u{240d}']), "{report}");
}

/// Every file of `tests/scenes/errors`: what `--check` says about it.
#[test]
fn messages() {
    let folder = fixtures().join("errors");
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<String> = entries
        .map(|e| e.expect("it can be listed").file_name().into_string().expect("UTF-8"))
        .collect();
    names.sort();
    for name in names {
        let loaded = load_fixture(&format!("errors/{name}"));
        assert_eq!(loaded.scene.is_none(), loaded.diagnostics.has_errors(), "{name}");
        let stem = name.trim_end_matches(".txt");
        insta::assert_snapshot!(stem, loaded.diagnostics.render(false));
    }
}
