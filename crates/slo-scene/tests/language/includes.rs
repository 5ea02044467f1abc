//! Scenes of several files.

use std::sync::Arc;

use slo_scene::{Files, Loaded, Shape, load};

type Table = &'static [(&'static str, &'static [u8])];

const PAWN: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A set of pieces in a folder of its own, which uses a library of materials in another one.
const SET: Table = &[
    (
        "set/pieces.txt",
        b"include ../library/woods.txt
          mesh pawn { filename pawn.obj material oak fit { 2 } }
          mesh twin { filename ../set/./pawn.obj material oak fit { 2 } }",
    ),
    ("set/pawn.obj", PAWN),
    (
        "library/woods.txt",
        b"material_principled oak { base_color { .5 .3 .1 } }
          material_principled ash { base_color { .8 .7 .6 } }",
    ),
    ("red wood.txt", b"\xef\xbb\xbfmaterial_principled red { }\r\n"),
];

const CAMERA: &str = include_str!("../scenes/minimal.txt");

fn load_with(text: &str, files: Table) -> Loaded {
    load("scene.txt", format!("{CAMERA}{text}"), &Files::built_in("", files))
}

/// The names of objects and materials, if nothing is said.
#[track_caller]
fn names(text: &str, files: Table) -> Vec<String> {
    let loaded = load_with(text, files);
    assert_eq!(loaded.diagnostics.render(false), "");
    let scene = loaded.scene.expect("no errors");
    let objects = scene.objects.iter().map(|object| object.name.clone());
    objects.chain(scene.materials.iter().map(|material| material.name.clone())).collect()
}

/// The report without the lines of the camera.
#[track_caller]
fn report(text: &str, files: Table) -> String {
    let loaded = load_with(text, files);
    assert!(loaded.scene.is_none());
    loaded.diagnostics.render(false)
}

#[test]
fn elements_stand_where_they_are_included() {
    let found =
        names("include set/pieces.txt\nsphere s { center { 9 0 0 } radius 1 material ash }", SET);
    assert_eq!(found, ["koule", "pawn", "twin", "s", "červená", "oak", "ash"]);
    // What is not used of a library is not wrong, and a name may need quotes.
    let found = names("include \"library/woods.txt\"\ninclude \"red wood.txt\"", SET);
    assert_eq!(found, ["koule", "červená", "oak", "ash", "red"]);
}

#[test]
fn a_file_counts_once_however_many_include_it() {
    let text = "include library/woods.txt include set/pieces.txt include set/../library/woods.txt";
    assert_eq!(names(text, SET), ["koule", "pawn", "twin", "červená", "oak", "ash"]);
}

#[test]
fn paths_start_from_the_file_that_names_them() {
    let scene = load_with(
        "include set/pieces.txt mesh mine { filename set/pawn.obj material oak fit { 2 } }",
        SET,
    );
    let scene = scene.scene.expect("no errors");
    let meshes: Vec<_> = scene.objects[1..]
        .iter()
        .map(|object| match &object.shape {
            Shape::Mesh(surface) => surface.mesh.clone(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(meshes.iter().all(|mesh| Arc::ptr_eq(mesh, &meshes[0])), "one file, one mesh");
}

#[test]
fn scaling_holds_for_all_files() {
    const FILES: Table = &[
        ("s.txt", b"Scaling s { 2 }"),
        ("b.txt", b"sphere b { center { 1 0 0 } radius 1 material m }"),
    ];
    let rest = "material_principled m { } include b.txt";
    let text = format!("include s.txt\n{CAMERA}{rest}");
    let loaded = load("scene.txt", text, &Files::built_in("", FILES));
    let scene = loaded.scene.expect("no errors");
    let Shape::Sphere(ball) = &scene.objects[1].shape else { panic!("a sphere") };
    assert_eq!((ball.center.x, ball.radius), (2.0, 2.0));
    let late =
        load("scene.txt", format!("{CAMERA}{rest}\ninclude s.txt"), &Files::built_in("", FILES));
    assert!(late.diagnostics.render(false).contains("`Scaling` stands after an element"));
}

#[test]
fn the_hash_covers_what_is_included() {
    const A: Table = &[("a.txt", b"# one")];
    const B: Table = &[("a.txt", b"# two"), ("unread.txt", b"")];
    const C: Table = &[("a.txt", b"# one"), ("unread.txt", b"")];
    let hash = |files| load_with("include a.txt", files).scene.expect("no errors").content_hash;
    assert_ne!(hash(A), hash(B));
    assert_eq!(hash(A), hash(C));
    let plain = load_with("", A).scene.expect("no errors").content_hash;
    assert_ne!(plain, hash(A));
}

#[test]
fn errors_show_both_places() {
    const FILES: Table = &[
        ("parts/a.txt", b"# a\ninclude b.txt\ninclude gone.txt"),
        (
            "parts/b.txt",
            b"sphere b {\n    center { 0 0 0 } radius 0 material nowhere\n}\n\
              mesh m { filename bad.obj material oak }\nmesh n { filename abd.obj material oak }\n\
              material_principled oak { }\nmaterial_principled oak { }\nsphere c { center { 0 0",
        ),
        ("parts/bad.obj", b"v 0 0 0\nf 1 2 x\n"),
        ("parts/abdo.obj", b""),
    ];
    let text = "sphere a { center { 0 0 0 } radius -1 material oak }\ninclude parts/a.txt\n\
                sphere z { center { 0 0 0 } radius -2 material oak }";
    insta::assert_snapshot!("include_both_places", report(text, FILES));
}

#[test]
fn what_can_not_be_included() {
    const FILES: Table = &[
        ("mesh.txt", b"slo_mesh 1 vertices { }"),
        ("picture.txt", include_bytes!("../scenes/files/plank.png")),
        ("latin.txt", b"# \xe8\n"),
        ("ring.txt", b"include other.txt"),
        ("other.txt", b"\n  include ./ring.txt"),
        ("self.txt", b"include \"self.txt\""),
        ("library/woods.txt", b""),
    ];
    let text = "include mesh.txt include picture.txt include latin.txt
        include ring.txt
        include self.txt
        include gone.txt
        include library/wodos.txt
        include ../woods.txt
        include /woods.txt
        include library\\woods.txt
        include { woods.txt }
        include woods { }
        include red wood.txt
        inclde woods.txt
        import woods.txt
        include
        sphere s { center { 0 0 0 } radius 1 material gone include woods.txt }
        include";
    insta::assert_snapshot!("include_impossible", report(text, FILES));
}

#[test]
fn a_missing_file_is_the_only_error() {
    let loaded =
        load_with("include gone.txt\nsphere s { center { 9 0 0 } radius 1 material oak }", &[]);
    assert_eq!(loaded.diagnostics.error_count(), 1, "{}", loaded.diagnostics.render(false));
    assert!(loaded.diagnostics.missing_input());
}

#[test]
fn a_scene_that_includes_itself_is_a_ring() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.txt");
    let text = format!("{CAMERA}include scene.txt");
    std::fs::write(&path, &text).expect("it is written");
    let files = Files::on_disk(folder.path(), folder.path(), false);
    let loaded = load(&path.to_string_lossy(), &text, &files);
    let report = loaded.diagnostics.render(false);
    assert_eq!(loaded.diagnostics.error_count(), 1, "{report}");
    assert!(report.contains("`scene.txt` includes itself"), "{report}");
    // What is not of a file has no name.
    std::fs::write(folder.path().join("scene.txt"), "# another").expect("it is written");
    assert!(load("scene.txt", text, &files).scene.is_some());
}

#[test]
fn depth_is_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = Files::on_disk(folder.path(), folder.path(), false);
    for (depth, errors) in [(16, 0), (17, 1), (5000, 1)] {
        for i in 0..depth {
            let text = if i + 1 < depth { format!("include f{}", i + 1) } else { String::new() };
            std::fs::write(folder.path().join(format!("f{i}")), text).expect("it is written");
        }
        let loaded = load("scene.txt", format!("{CAMERA}include f0"), &files);
        let report = loaded.diagnostics.render(false);
        assert_eq!(loaded.diagnostics.error_count(), errors, "{depth}: {report}");
    }
}
