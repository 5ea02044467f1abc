//! Meshes that change their shape while the shutter is open: a pixel's value is the share of the
//! time during which the mesh covers it, with every vertex at its own place at each time.

use slo_accel::Isa;
use slo_render::frame::{FrameError, FrameScene};
use slo_scene::{Files, SceneDescription, ShapeError, load};

use crate::support::{Picture, Shot, assert_profile, expose, glow, pivot_at};

/// Size of a pixel in the plane through the origin, in the default shot.
const PX: f64 = 10.0 * 0.5 / 32.0;

/// A quad from column 22 on, 20 pixels high, whose right edge is 8, 24, and 16 pixels away; the
/// last file has another number of faces. A pixel is 0.15625 units.
const FILES: &[(&str, &[u8])] = &[
    (
        "quad_1.slo",
        b"slo_mesh 1 vertices { -1.5625 0 -1.5625  -0.3125 0 -1.5625  -0.3125 0 1.5625  -1.5625 0 1.5625 }
        faces { 0 1 2  0 2 3 }",
    ),
    (
        "quad_2.slo",
        b"slo_mesh 1 vertices { -1.5625 0 -1.5625  2.1875 0 -1.5625  2.1875 0 1.5625  -1.5625 0 1.5625 }
        faces { 0 1 2  0 2 3 }",
    ),
    (
        "quad_3.slo",
        b"slo_mesh 1 vertices { -1.5625 0 -1.5625  0.9375 0 -1.5625  0.9375 0 1.5625  -1.5625 0 1.5625 }
        faces { 0 1 2  0 2 3 }",
    ),
    (
        "other.slo",
        b"slo_mesh 1 vertices { -1.5625 0 -1.5625  2.1875 0 -1.5625  2.1875 0 1.5625  -1.5625 0 1.5625 }
        faces { 0 1 2 }",
    ),
];

fn scene(blur: f64, shapes: &str) -> SceneDescription {
    let shot = Shot { blur, ..Shot::default() };
    let text = glow("white", [1.0; 3]) + &format!("mesh quad {{ material white {shapes} }}");
    let loaded = load("test", shot.of(&text), &Files::built_in("", FILES));
    loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)))
}

/// For each column, the share of the shutter during which a quad from column 22 on covers it, if
/// its right edge is `reach(s)` columns away at shutter time `s`, and both `shift(s)` more.
fn covered(reach: impl Fn(f64) -> f64, shift: impl Fn(f64) -> f64) -> Vec<f64> {
    let times = 4000;
    let mut columns = vec![0.0; 64];
    for k in 0..times {
        let s = (k as f64 + 0.5) / times as f64;
        let [start, end] = [22.0 + shift(s), 22.0 + reach(s) + shift(s)];
        for (x, column) in columns.iter_mut().enumerate() {
            let [left, right] = [start.max(x as f64), end.min(x as f64 + 1.0)];
            *column += (right - left).max(0.0) / times as f64;
        }
    }
    columns
}

#[track_caller]
fn check(
    blur: f64,
    shapes: &str,
    reach: impl Fn(f64) -> f64,
    shift: impl Fn(f64) -> f64,
) -> FrameScene {
    let scene = scene(blur, shapes);
    let picture = Picture(expose(&scene, Isa::best()).image());
    // Both edges may move, and the poses of key frames are up to half a pixel apart.
    assert_profile(&picture.columns(24..40, 0), &covered(reach, shift), 0.02);
    FrameScene::build(&scene, 0, Isa::best()).expect("the frame can be built")
}

const TWO: &str = "addShape { time 0 filename quad_1.slo } addShape { time 1 filename quad_2.slo }";

#[test]
fn an_edge_that_moves_leaves_a_ramp() {
    check(1.0, TWO, |s| 8.0 + 16.0 * s, |_| 0.0);
    check(0.5, TWO, |s| 8.0 + 8.0 * s, |_| 0.0);
}

#[test]
fn a_shutter_that_outlasts_the_segment_sees_the_edge_come_to_rest() {
    check(2.0, TWO, |s| 8.0 + 16.0 * (2.0 * s).min(1.0), |_| 0.0);
}

#[test]
fn shapes_that_a_shutter_passes_are_pieces_of_the_way() {
    let three = "addShape { time 0 filename quad_1.slo } addShape { time 0.25 filename quad_2.slo }
        addShape { time 0.75 filename quad_3.slo }";
    let reach = |s: f64| match s {
        _ if s < 0.25 => 8.0 + 64.0 * s,
        _ if s < 0.75 => 24.0 - 16.0 * (s - 0.25),
        _ => 16.0,
    };
    check(1.0, three, reach, |_| 0.0);
    let numbered = "shapes { filename quad_#.slo first 1 last 3 fps 2 time -0.5 }";
    check(1.0, numbered, |s| if s < 0.5 { 24.0 - 16.0 * s } else { 16.0 }, |_| 0.0);
}

#[test]
fn without_motion_in_the_shutter_the_shape_is_still() {
    let frame = check(
        0.0,
        "addShape { time -1 filename quad_1.slo } addShape { time 1 filename quad_2.slo }",
        |_| 16.0,
        |_| 0.0,
    );
    assert_eq!((frame.moving_objects(), frame.primitives()), (0, 2));
    let later = "addShape { time 3 filename quad_1.slo } addShape { time 4 filename quad_2.slo }";
    assert_eq!(check(1.0, later, |_| 8.0, |_| 0.0).moving_objects(), 0);
}

#[test]
fn key_frames_move_the_space_in_which_it_bends() {
    let keys = pivot_at(0.0, [0.0; 3]) + &pivot_at(1.0, [10.0 * PX, 0.0, 0.0]);
    let frame = check(1.0, &format!("{TWO} {keys}"), |s| 8.0 + 16.0 * s, |s| 10.0 * s);
    assert_eq!((frame.moving_objects(), frame.primitives()), (1, 2));
}

#[test]
fn all_instruction_sets_give_the_same_picture() {
    let scene = scene(1.0, &format!("smooth_normals 1 {TWO}"));
    let pictures: Vec<_> =
        Isa::available().into_iter().map(|isa| expose(&scene, isa).image()).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] == pair[1]));
}

/// The next frame has another shape, and takes none of the last one.
#[test]
fn frames_in_turn_are_those_built_alone() {
    let scene = scene(
        0.0,
        "addShape { time 0 filename quad_1.slo } addShape { time 1 filename quad_2.slo }",
    );
    let first = FrameScene::build(&scene, 0, Isa::best()).expect("frame 0");
    let next = FrameScene::build_with(&scene, 1, Isa::best(), first.remains()).expect("frame 1");
    let alone = FrameScene::build(&scene, 1, Isa::best()).expect("frame 1");
    let picture = |frame| crate::support::expose_frame(&scene, frame).image();
    assert_eq!(picture(&next), picture(&alone));
}

#[test]
fn other_faces_are_an_error_that_names_both_files() {
    let shapes = "addShape { time 0 filename quad_1.slo } addShape { time 1 filename other.slo }";
    let error = FrameScene::build(&scene(1.0, shapes), 0, Isa::best()).expect_err("other faces");
    assert!(matches!(&error, FrameError::Shape { reason: ShapeError::Differs { .. }, .. }));
    let message = error.to_string();
    for part in ["`quad`", "`quad_1.slo`", "`other.slo`", "2 and 1 faces"] {
        assert!(message.contains(part), "{message}");
    }
    // No shutter needs the other file.
    let late = "addShape { time 0 filename quad_1.slo } addShape { time 3 filename quad_2.slo }
        addShape { time 4 filename other.slo }";
    FrameScene::build(&scene(1.0, late), 0, Isa::best()).expect("the file is not read");
}
