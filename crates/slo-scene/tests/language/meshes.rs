//! What scenes make of the files of meshes.

use std::sync::Arc;

use slo_scene::{Files, Mesh, Shape, load};

/// A tower along y, 4 high, 2 wide and 1 deep, with a vertex far away that no face uses.
const TOWER: &[u8] = b"v 1 1 1\nv 3 1 1\nv 1 5 2\nv 900 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
const FLAG: &[u8] = b"v 0 9 0\nv 1 9 0\nv 0 9 1\nf 1 2 3\n";
const HUGE: &[u8] = b"v 0 0 0\nv 4e12 0 0\nv 0 1e12 0\nf 1 2 3\n";
const FILES: &[(&str, &[u8])] = &[("tower.obj", TOWER), ("flag.obj", FLAG), ("huge.obj", HUGE)];

/// The meshes with some attributes.
fn meshes(scaling: &str, attributes: &[&str]) -> Vec<Arc<Mesh>> {
    let meshes = attributes.iter().enumerate();
    let meshes: Vec<_> =
        meshes.map(|(i, said)| format!("mesh m{i} {{ material červená {said} }}\n")).collect();
    let text = format!("{scaling}{}{}", include_str!("../scenes/minimal.txt"), meshes.concat());
    let loaded = load("scene.txt", text, &Files::built_in("", FILES));
    let report = loaded.diagnostics.render(false);
    assert_eq!(report, "");
    let objects = &loaded.scene.expect("no errors").objects[1..];
    let mesh = |shape: &Shape| match shape {
        Shape::Mesh(surface) => surface.mesh.clone(),
        other => panic!("{other:?}"),
    };
    objects.iter().map(|object| mesh(&object.shape)).collect()
}

#[test]
fn the_longest_side_is_fitted() {
    let said = "filename tower.obj fit { 8 }";
    let [plain, scaled] = ["", "Scaling s { .5 }\n"].map(|scaling| meshes(scaling, &[said]));
    assert_eq!(plain[0].positions[2].to_array(), [2.0, 10.0, 4.0]);
    assert_eq!(scaled[0].positions[2].to_array(), [1.0, 5.0, 2.0]);
    // Of several files, the whole counts: it is 9 - 1 = 8 high.
    let both = meshes("", &["filename tower.obj filename flag.obj fit { 2 }"]);
    assert_eq!(both[0].positions[2].to_array(), [0.25, 1.25, 0.5]);
    let huge = meshes("", &["filename huge.obj fit { 2 }"]);
    assert_eq!(huge[0].positions[1].to_array(), [2.0, 0.0, 0.0]);
}

#[test]
fn a_mesh_with_y_up_stands() {
    let [up, lying] = &meshes(
        "",
        &[
            "filename tower.obj axes Y_UP smooth_normals 1",
            "filename tower.obj axes Z_UP smooth_normals 1",
        ],
    )[..] else {
        panic!("two meshes")
    };
    assert_eq!(up.positions[2].to_array(), [1.0, -2.0, 5.0]);
    assert_eq!(up.normals[0], [0.0, -1.0, 0.0]);
    assert_eq!(lying.positions[2].to_array(), [1.0, 5.0, 2.0]);
    assert_eq!(up.faces, lying.faces);
}

#[test]
fn what_is_equal_is_shared() {
    let said = [
        "filename tower.obj fit { 2 } axes Y_UP",
        "axes Y_UP fit { 2.0 } filename tower.obj",
        "filename tower.obj fit { 2 }",
        "filename tower.obj fit { 3 } axes Y_UP",
        "filename tower.obj",
        "filename tower.obj axes Z_UP",
    ];
    let meshes = meshes("", &said);
    let first = |i: usize| meshes.iter().position(|mesh| Arc::ptr_eq(mesh, &meshes[i]));
    let firsts: Vec<_> = (0..meshes.len()).filter_map(first).collect();
    assert_eq!(firsts, [0, 0, 2, 3, 4, 4]);
}
