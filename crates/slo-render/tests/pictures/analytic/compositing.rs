//! Layers for compositors, tested on scenes whose depth, places and motion are known.

use slo_picture::film::{FileLayer, Film, Mask, MaskKind, mask_id};
use slo_scene::{Layer, SceneDescription};

use crate::support::{Shot, describe, material, panel, panel_corners, pivot_at, rectangle};

/// Physical scenes are rendered by another integrator.
const PATH: &str = "integrator PATH";

fn both(shot: impl Fn(&str) -> Shot) -> [Shot; 2] {
    ["", PATH].map(shot)
}

/// Renders a scene with layers. `change` changes its description first.
#[track_caller]
fn take(
    shot: &Shot,
    elements: &str,
    layers: &[Layer],
    change: impl Fn(&mut SceneDescription),
) -> (Film, SceneDescription) {
    let mut scene = describe(&shot.of(elements));
    scene.camera.film.layers = layers.to_vec();
    change(&mut scene);
    (shot.film(&scene), scene)
}

/// Returns a layer of one pixel.
fn at(film: &Film, layer: &FileLayer, x: usize, y: usize) -> [f64; 3] {
    let image = film.layer_of(film.area(), layer);
    image.rgb[y * image.width as usize + x].map(f64::from)
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near && found.len() == expected.len(), "{found:?}, expected {expected:?}");
}

/// A wall in the left half of the view, which covers half of column 31 at the distance 10; nothing on the
/// right.
fn half_wall(y: f64) -> String {
    material("grey", "diffuse { 0.5 0.5 0.5 }")
        + &panel("wall", "grey", [-90.0, -5.0 / 64.0], y, [-90.0, 90.0])
}

#[test]
fn depth_is_the_distance_along_the_view() {
    // The wall is perpendicular to the view, so its depth is the same everywhere, for lens and
    // motion of the camera too.
    for shot in both(|settings| Shot {
        from: vec![[0.0, -10.0, 0.0], [0.0, -8.0, 0.0]],
        samples: 16,
        lens: 0.5,
        settings: settings.into(),
        ..Shot::default()
    }) {
        let (film, _) = take(&shot, &half_wall(2.0), &[Layer::Depth], |_| {});
        for (x, y) in [(0, 0), (10, 63), (25, 30)] {
            assert_near(&at(&film, &FileLayer::Depth, x, y), &[12.0, 0.0, 0.0], 1e-5);
        }
        assert_eq!(at(&film, &FileLayer::Depth, 60, 30)[0], 1e10);
        // Partly covered pixels are as deep as what covers them.
        let edge = (0..64).map(|x| at(&film, &FileLayer::Depth, x, 40)[0]);
        assert!(edge.into_iter().all(|z| (z - 12.0).abs() < 1e-5 || z == 1e10));
        // The shutter is open for a second, in which the camera comes 2 nearer.
        let shot = Shot { blur: 1.0, samples: 256, ..shot };
        let (film, _) = take(&shot, &half_wall(2.0), &[Layer::Depth], |_| {});
        assert_near(&at(&film, &FileLayer::Depth, 5, 30), &[11.0, 0.0, 0.0], 0.02);
    }
}

#[test]
fn positions_are_those_of_the_scene_however_far_from_its_origin() {
    for far in [0.0, 3e6] {
        for shot in both(|settings| Shot {
            from: vec![[far, -10.0, 5.0]],
            to: vec![[far, 0.0, 5.0]],
            fov: 1e-3,
            samples: 4,
            settings: settings.into(),
            ..Shot::default()
        }) {
            let wall = material("grey", "diffuse { 0.5 0.5 0.5 }")
                + &panel("wall", "grey", [far - 90.0, far + 90.0], 2.0, [-90.0, 90.0]);
            let (film, _) = take(&shot, &wall, &[Layer::Position], |_| {});
            let size = 12.0 * 1e-3 + far * 1e-7;
            assert_near(&at(&film, &FileLayer::Position, 32, 32), &[far, 2.0, 5.0], size);
        }
    }
}

#[test]
fn texture_coordinates_are_means_of_what_is_hit() {
    // The rectangle spans half of the film each way, so uv runs from 0 to 1 over 32 pixels.
    let square = material("grey", "diffuse { 0.5 0.5 0.5 }")
        + &rectangle("square", "grey", panel_corners([-2.5, 2.5], 0.0, [-2.5, 2.5]), "");
    for shot in both(|settings| Shot { settings: settings.into(), ..Shot::default() }) {
        let (film, _) = take(&shot, &square, &[Layer::Uv], |_| {});
        for (x, y) in [(16, 16), (30, 40), (47, 17)] {
            let expected = [(x as f64 + 0.5 - 16.0) / 32.0, (47.5 - y as f64) / 32.0, 1.0];
            assert_near(&at(&film, &FileLayer::Uv, x, y), &expected, 3e-3);
        }
        assert_eq!(at(&film, &FileLayer::Uv, 2, 2), [0.0; 3]);
    }
}

#[test]
fn two_objects_share_a_pixel_by_their_cover() {
    // The border lies in the middle of column 31: at x = -1/64 of the half width 5.
    let border = -5.0 / 64.0;
    let elements = material("red", "diffuse { 0.5 0 0 }")
        + &material("blue", "diffuse { 0 0 0.5 }")
        + &panel("left", "red", [-90.0, border], 0.0, [-90.0, 90.0])
        + &panel("right", "blue", [border, 90.0], 0.0, [-90.0, 0.0])
        + &panel("top", "blue", [border, 90.0], 0.0, [0.0, 4.0]);
    let layers = [Layer::CryptoObject, Layer::CryptoMaterial];
    for shot in both(|settings| Shot { settings: settings.into(), ..Shot::default() }) {
        let (film, scene) = take(&shot, &elements, &layers, |_| {});
        let names = scene.layer_names();
        let rank = |kind, rank, x, y| {
            let names = match kind {
                MaskKind::Object => names.objects.clone(),
                MaskKind::Material => names.materials.clone(),
            };
            let [id, share, _] = at(&film, &FileLayer::Rank(Mask { kind, names }, rank), x, y);
            ((id as f32).to_bits(), share)
        };
        for (kind, [left, right]) in
            [(MaskKind::Object, ["left", "right"]), (MaskKind::Material, ["red", "blue"])]
        {
            assert_eq!(rank(kind, 0, 10, 50), (mask_id(left), 1.0));
            assert_eq!(rank(kind, 0, 50, 50), (mask_id(right), 1.0));
            let [first, second] = [0, 1].map(|k| rank(kind, k, 31, 50));
            assert_eq!((first.1, second.1), (0.5, 0.5));
            // Equal shares: the smaller id comes first.
            let mut ids = [mask_id(left), mask_id(right)];
            ids.sort_unstable();
            assert_eq!([first.0, second.0], ids);
            assert_eq!(rank(kind, 2, 31, 50), (0, 0.0));
        }
        assert_eq!(rank(MaskKind::Object, 0, 50, 20), (mask_id("top"), 1.0));
        assert_eq!(rank(MaskKind::Object, 0, 50, 2), (0, 0.0), "nothing");
        let manifest = &names.objects.names();
        assert_eq!(**manifest, ["left", "right", "top"]);
        assert_eq!(names.materials.names(), ["blue", "red"]);
    }
}

/// Pixels of the film per unit at the distance 10: 64 rows over 10 units.
const PX: f64 = 6.4;

#[track_caller]
fn assert_motion(film: &Film, (x, y): (usize, usize), expected: [f64; 4], tolerance: f64) {
    let before = at(film, &FileLayer::MotionBefore, x, y);
    let after = at(film, &FileLayer::MotionAfter, x, y);
    let found = [before[0], before[1], after[0], after[1]];
    assert_near(&found, &expected, tolerance);
}

/// A square that slides to the right by 0.5 and up by 0.25 each frame, over five frames.
fn sliding() -> String {
    let ends = pivot_at(-1.0, [-0.5, 0.0, -0.25]) + &pivot_at(4.0, [2.0, 0.0, 1.0]);
    material("grey", "diffuse { 0.5 0.5 0.5 }")
        + &rectangle("square", "grey", panel_corners([-2.5, 2.5], 0.0, [-2.5, 2.5]), &ends)
}

/// Three frames: frame 0 is the one in the middle.
fn three_frames(scene: &mut SceneDescription) {
    let segment = &mut scene.camera.segments[0];
    (segment.video, segment.scene) = ([-1.0, 2.0], [-1.0, 2.0]);
}

#[test]
fn a_sliding_square_has_the_motion_of_its_path() {
    for blur in [0.0, 0.5] {
        for shot in both(|settings| Shot {
            settings: settings.into(),
            blur,
            samples: 16,
            ..Shot::default()
        }) {
            let (film, _) = take(&shot, &sliding(), &[Layer::Motion], three_frames);
            let way = [-0.5 * PX, -0.25 * PX];
            // As in Blender: before minus now, and now minus next.
            let expected = [way[0], way[1], way[0], way[1]];
            assert_motion(&film, (33, 31), expected, 1e-4);
            assert_motion(&film, (40, 25), expected, 1e-4);
            assert_motion(&film, (2, 2), [0.0; 4], 0.0);
            // Without frames beside it there is no motion.
            let (film, _) = take(&shot, &sliding(), &[Layer::Motion], |scene| {
                scene.camera.segments[0].video = [0.0, 0.5];
            });
            assert_motion(&film, (33, 31), [0.0; 4], 0.0);
        }
    }
}

#[test]
fn a_turning_square_and_a_moving_camera_move_points() {
    // A quarter turn a frame about the view: each point goes round the middle of the picture.
    let turns = [
        (-1.0, "right { 0 0 1 } up { -1 0 0 }"),
        (0.0, "right { 1 0 0 } up { 0 0 1 }"),
        (1.0, "right { 0 0 -1 } up { 1 0 0 }"),
    ]
    .map(|(time, axes)| format!("addKframe {{ time {time} key {{ pivot {{ 0 0 0 }} {axes} }} }} "));
    let square = material("grey", "diffuse { 0.5 0.5 0.5 }")
        + &rectangle(
            "square",
            "grey",
            panel_corners([-2.5, 2.5], 0.0, [-2.5, 2.5]),
            &turns.concat(),
        );
    let shot = Shot { samples: 1, ..Shot::default() };
    let layers = [Layer::Position, Layer::Motion];
    let (film, _) = take(&shot, &square, &layers, three_frames);
    let [x, _, z] = at(&film, &FileLayer::Position, 40, 28).map(|side| side * PX);
    let before = at(&film, &FileLayer::MotionBefore, 40, 28);
    let after = at(&film, &FileLayer::MotionAfter, 40, 28);
    // Both neighbours lie at right angles to it, opposite to each other.
    let radius = x.hypot(z);
    let there = [before[0] + x, before[1] + z];
    let next = [x - after[0], z - after[1]];
    assert_near(&[there[0].hypot(there[1]), next[0].hypot(next[1])], &[radius; 2], 1e-3);
    assert_near(&[there[0] + next[0], there[1] + next[1]], &[0.0; 2], 1e-3);
    assert_near(&[there[0] * x + there[1] * z], &[0.0], 1e-2);
    // A still wall before a camera that slides by 1 to the right, from frame to frame.
    for shot in both(|settings| Shot {
        from: vec![[-1.0, -10.0, 0.0], [2.0, -10.0, 0.0]],
        to: vec![[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        samples: 4,
        settings: settings.into(),
        ..Shot::default()
    }) {
        let (film, _) = take(&shot, &half_wall(0.0), &[Layer::Motion], three_frames);
        assert_motion(&film, (10, 31), [PX, 0.0, PX, 0.0], 1e-4);
    }
}

#[test]
fn lamps_that_are_seen_count_and_hidden_ones_do_not() {
    let lamp = |flags: &str| {
        format!(
            "lamp_rectangle lamp {{ radiance {{ 1 1 1 }} {flags}
                 vertex0 {{ -90 0 -90 }} vertex1 {{ 90 0 -90 }} vertex2 {{ 90 0 90 }} }}"
        )
    };
    let wall = material("grey", "diffuse { 0.5 0.5 0.5 }")
        + &panel("wall", "grey", [-90.0, 90.0], 5.0, [-90.0, 90.0]);
    let shot = Shot { settings: PATH.into(), samples: 4, ..Shot::default() };
    let layers = [Layer::Depth, Layer::Uv, Layer::CryptoObject];
    for (flags, depth, name, covered) in
        [("", 10.0, "lamp", 0.0), ("camera_visible 0", 15.0, "wall", 1.0)]
    {
        let (film, scene) = take(&shot, &(wall.clone() + &lamp(flags)), &layers, |_| {});
        assert_near(&at(&film, &FileLayer::Depth, 20, 20), &[depth, 0.0, 0.0], 1e-3);
        assert_eq!(at(&film, &FileLayer::Uv, 20, 20)[2], covered);
        let mask = Mask { kind: MaskKind::Object, names: scene.layer_names().objects };
        let [id, share, _] = at(&film, &FileLayer::Rank(mask, 0), 20, 20);
        assert_eq!(((id as f32).to_bits(), share), (mask_id(name), 1.0));
    }
}

#[test]
fn samples_and_errors_are_those_of_the_colours() {
    let shot = Shot {
        settings: "imageMinSamples 4 imageContrastLimit 0.05".into(),
        samples: 16,
        ..Shot::default()
    };
    let lamp = "light_point lamp { color { 9 9 9 } position { 0 -5 0 } }";
    let elements = half_wall(0.0) + lamp;
    let (film, _) = take(&shot, &elements, &[Layer::Samples, Layer::Error], |_| {});
    let counts = film.layer_of(film.area(), &FileLayer::Samples).rgb;
    let expected = film.sample_counts();
    assert!(counts.iter().zip(&expected).all(|(layer, count)| layer[0] == *count as f32));
    assert!(expected.contains(&4) && expected.contains(&16));
    let errors = film.layer_of(film.area(), &FileLayer::Error).rgb;
    let pairs = errors.iter().zip(film.pixels());
    assert!(pairs.into_iter().all(|(error, pixel)| Some(*error) == pixel.error()));
    assert!(errors.iter().any(|error| error[0] > 0.0));
}
