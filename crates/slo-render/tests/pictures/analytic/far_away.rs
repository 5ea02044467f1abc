//! A scene a million units from the origin looks the same as at the origin.

use slo_accel::Isa;
use slo_render::frame::FrameScene;

use crate::support::{Picture, Shot, describe, expose_frame, glow, material, pivot_at, vector};

/// A little of everything around a point, seen from 10 units in front of it.
fn scene(o: [f64; 3]) -> Picture {
    let at = |x: f64, y: f64, z: f64| vector([o[0] + x, o[1] + y, o[2] + z]);
    let keys = pivot_at(0.0, [o[0] - 1.5, o[1], o[2] + 1.5])
        + &pivot_at(1.0, [o[0] + 1.5, o[1], o[2] + 1.5]);
    let elements = material("paper", "ambient { 0.1 0.1 0.1 } diffuse { 0.6 0.5 0.4 }")
        + &material("mirror", "reflectance 0.9 diffuse { 0.1 0.1 0.1 }")
        + &material("glass", "refraction 0.9 refraction_index 1.5")
        + &glow("blue", [0.2, 0.3, 1.0])
        + &format!(
            "rectangle floor {{ material paper vertex0 {} vertex1 {} vertex2 {} }}
             sphere ball {{ material mirror center {} radius 1 }}
             sphere lens {{ material glass center {} radius 0.8 }}
             box block {{ material paper vertex0 {} vertex1 {} vertex2 {} height 1.2 }}
             cylinder post {{ material paper base {} top {} radius 0.3 }}
             cone hat {{ material blue base {} apex {} radius 0.6 }}
             sphere bird {{ material blue center {{ 0 0 0 }} radius 0.3 {keys} }}
             light_rectangle lamp {{ color {{ 0.8 0.8 0.8 }} vertex0 {} vertex1 {} vertex2 {} }}
             light_point spot {{ color {{ 0.3 0.3 0.3 }} position {} }}",
            at(-9.0, -9.0, -1.0),
            at(9.0, -9.0, -1.0),
            at(9.0, 9.0, -1.0),
            at(-1.2, 1.0, 0.0),
            at(1.0, -1.0, -0.2),
            at(2.0, 2.0, -1.0),
            at(2.0, 3.0, -1.0),
            at(1.0, 3.0, -1.0),
            at(-3.0, 0.0, -1.0),
            at(-3.0, 0.0, 1.0),
            at(0.0, 3.0, -1.0),
            at(0.0, 3.0, 1.0),
            at(-1.0, -1.0, 4.0),
            at(1.0, -1.0, 4.0),
            at(1.0, 1.0, 4.0),
            at(-5.0, -5.0, 5.0),
        );
    let shot = Shot {
        from: vec![[o[0], o[1] - 10.0, o[2] + 2.0]],
        to: vec![o],
        lens: 0.1,
        blur: 1.0,
        samples: 16,
        recursion: 4,
        settings: "background { 0.3 0.3 0.4 }".into(),
        ..Shot::default()
    };
    shot.take(&elements)
}

#[test]
fn a_million_units_away_nothing_changes_but_the_last_digits() {
    let near = scene([0.0; 3]);
    assert!(near.sum(0) > 1000.0 && near.sum(0) < 3000.0);
    for origin in [[1e6, -1e6, 1e6], [123_456.78, 987_654.32, -1e6]] {
        let far = scene(origin);
        // Both pictures take the same samples. They differ only in a few rays that pass an edge on
        // the other side.
        let mut differences: Vec<f32> = near
            .0
            .rgb
            .iter()
            .zip(&far.0.rgb)
            .map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max))
            .collect();
        differences.sort_by(f32::total_cmp);
        let [most, worst] = [differences[4096 * 95 / 100], differences[4095]];
        let mean = differences.iter().sum::<f32>() / 4096.0;
        assert!(
            most < 2e-3 && mean < 2e-3 && worst < 0.2,
            "95 %: {most}, mean {mean}, worst {worst}"
        );
    }
}

/// Curved objects around a point, and the shadows that they cast.
fn curved(from: Vec<[f64; 3]>, o: [f64; 3], frames: u32) -> Picture {
    let at = |x: f64, y: f64, z: f64| vector([o[0] + x, o[1] + y, o[2] + z]);
    let elements = material("paper", "diffuse { 0.9 0.9 0.9 }")
        + &format!(
            "sphere ball {{ material paper center {} radius 1 }}
             cylinder post {{ material paper base {} top {} radius 1 }}
             cone hat {{ material paper base {} apex {} radius 1 }}
             plane floor {{ material paper normal {{ 0 0 1 }} position {} }}
             light_point lamp {{ color {{ 0.9 0.9 0.9 }} position {} }}",
            at(0.0, 0.0, 0.0),
            at(-3.0, 0.0, -1.0),
            at(-3.0, 0.0, 1.0),
            at(3.0, 0.0, -1.0),
            at(3.0, 0.0, 1.0),
            at(0.0, 0.0, -1.0),
            at(-3.0, -5.0, 5.0),
        );
    let shot = Shot { from, to: vec![o], samples: 16, ..Shot::default() };
    // With two frames a second, frame 1 is in the middle of the segment.
    let text = shot.of(&elements).replace("fps 1", &format!("fps {frames}"));
    let scene = describe(&text);
    let frame = FrameScene::build(&scene, i64::from(frames - 1), Isa::best()).expect("it is seen");
    Picture(expose_frame(&scene, &frame).image())
}

#[test]
fn a_camera_that_has_flown_far_sees_what_one_sees_that_stood_there() {
    let target = [500_000.0, 0.0, 1.0];
    let here = [target[0], -8.0, 3.0];
    let still = curved(vec![here], target, 1);
    let start = [0.0, -8.0, 3.0];
    let end = [2.0 * target[0], -8.0, 3.0];
    let flown = curved(vec![start, end], target, 2);
    assert!(still.sum(0) > 500.0);
    let pairs = still.0.rgb.iter().zip(&flown.0.rgb);
    let mut differences: Vec<f32> = pairs.map(|(a, b)| (a[0] - b[0]).abs()).collect();
    differences.sort_by(f32::total_cmp);
    // All but the pixels of edges.
    let most = differences[4096 * 95 / 100];
    assert!(most < 2e-3, "{most}");
}
