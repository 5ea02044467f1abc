//! Meshes that change their shape.

use slo_scene::{Files, Shape, load};

const QUAD: &[u8] = b"slo_mesh 1 vertices { 0 0 0  1 0 0  1 0 1  0 0 1 } faces { 0 1 2  0 2 3 }";
const FILES: &[(&str, &[u8])] = &[("a.slo", QUAD), ("body_01.slo", QUAD), ("body_02.slo", QUAD)];

/// Times and paths of the shapes of a mesh, or the number of errors and the report.
fn shapes(mesh: &str) -> Result<Vec<(f64, String)>, (usize, String)> {
    let text = format!(
        "Camera c {{ fps 25 Film f {{ width 8 height 8 }}
            CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 0 -9 0 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
         light_point l {{ color {{ 1 1 1 }} position {{ 0 0 4 }} }}
         phong_info m {{ }} material_phong m {{ phong_info m }}
         mesh body {{ material m {mesh} }}"
    );
    let loaded = load("scene.txt", &text, &Files::built_in("", FILES));
    let errors = (loaded.diagnostics.error_count(), loaded.diagnostics.render(false));
    let scene = loaded.scene.ok_or(errors)?;
    assert!(scene.objects[0].shape.changes());
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!("no mesh") };
    let shapes = mesh.shapes.as_ref().expect("shapes");
    Ok(shapes.keys().map(|(time, path)| (time, path.to_owned())).collect())
}

#[test]
fn shapes_have_times_and_files() {
    let of = |list: &[(f64, &str)]| {
        Ok(list.iter().map(|(time, path)| (*time, (*path).to_owned())).collect::<Vec<_>>())
    };
    let added = "addShape { time -1 filename a.slo } addShape { filename body_01.slo time 2.5 }";
    assert_eq!(shapes(added), of(&[(-1.0, "a.slo"), (2.5, "body_01.slo")]));
    let numbered = "shapes { filename body_##.slo first 1 last 2 fps 24 }";
    assert_eq!(shapes(numbered), of(&[(0.0, "body_01.slo"), (1.0 / 24.0, "body_02.slo")]));
    let later = "shapes { filename body_##.slo first 1 last 2 fps 2 time 3 }";
    assert_eq!(shapes(later), of(&[(3.0, "body_01.slo"), (3.5, "body_02.slo")]));
}

#[test]
fn a_mistake_gives_one_error() {
    for (mesh, message) in [
        ("addShape { time 0 filename a.slo }", "mesh `body` has a single `addShape`"),
        (
            "addShape { time 0 filename a.slo } addShape { time 0 filename a.slo }",
            "shapes of mesh `body` are not in order of time",
        ),
        (
            "addShape { time 0 filename a.slo } addShape { time 1 filename b.slo }",
            "file `b.slo` not found",
        ),
        (
            "addShape { time 0 filename a.slo } shapes { filename body_##.slo first 1 last 2 fps 9 }",
            "mesh `body` has `addShape` and `shapes`",
        ),
        (
            "filename a.slo shapes { filename body_##.slo first 1 last 2 fps 9 }",
            "mesh `body` has `filename` and shapes",
        ),
        ("shapes { filename body.slo first 1 last 2 fps 9 }", "has no place for a number"),
        (
            "shapes { filename body_##.slo first 2 last 2 fps 9 }",
            "`last` must be more than `first`",
        ),
        ("shapes { filename body_##.slo first 1 last 3 fps 9 }", "file `body_03.slo` not found"),
        ("shapes { filename body_##.slo first 1 last 2 fps 0 }", "fps"),
        ("addShape { filename a.slo } addShape { time 1 filename a.slo }", "time"),
        ("", "mesh `body` has no `filename`"),
    ] {
        let (count, report) = shapes(mesh).expect_err(mesh);
        assert!(count == 1 && report.contains(message), "{mesh}:\n{report}");
    }
}
