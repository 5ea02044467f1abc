use glam::DMat3;

use crate::KeyFrame;
use crate::animation::{KeyFrames, about};
use crate::files::Files;
use crate::load::load;
use crate::settings::Repeat;
use glam::DVec3;

/// The key frames of a sphere with some attributes.
fn ball(attributes: &str) -> Vec<KeyFrame> {
    let text = format!(
        "{}\nmaterial_principled m {{ }}\nlamp_point l {{ power {{ 1 1 1 }} position {{ 0 0 9 }} }}\n\
         sphere ball {{ center {{ 0 0 0 }} radius 1 material m {attributes} }}",
        include_str!("../../../tests/scenes/minimal.txt")
    );
    let loaded = load("scene.txt", text, &Files::built_in("", &[]));
    let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
    scene.objects.last().unwrap().key_frames.clone()
}

fn path(attributes: &str) -> KeyFrames {
    KeyFrames::new(&ball(attributes)).unwrap()
}

/// A key frame without handles.
fn key(time: f64, said: &str) -> String {
    format!("addKframe {{ time {time} key {{ {said} }} }} ")
}

fn about_z(degrees: f64) -> String {
    format!("turn {{ axis {{ 0 0 2 }} angle_deg {degrees} }}")
}

/// How far apart two rotations are, in degrees.
fn apart(a: DMat3, b: DMat3) -> f64 {
    let columns = [0, 1, 2].map(|i| (a.col(i) - b.col(i)).length());
    columns.into_iter().fold(0.0, f64::max).to_degrees()
}

#[track_caller]
fn check_even(path: &KeyFrames, time: f64, expected: DMat3) {
    let apart = apart(path.pose(time).rotation, expected);
    assert!(apart < 2e-3, "{apart} degrees at {time}");
}

#[test]
fn turns_of_any_size_are_even() {
    for degrees in [10.0, 90.0, 180.0, 360.0, -720.0, 3600.0, 3601.0] {
        let path = path(&(key(1.0, &about_z(0.0)) + &key(3.0, &about_z(degrees))));
        for i in 0..=1000 {
            let u = f64::from(i) / 1000.0;
            check_even(&path, 1.0 + 2.0 * u, about(DVec3::Z, degrees * u));
        }
        assert!(path.jumps([0.0, 9.0]).is_empty() && path.moves([1.5, 1.6]));
    }
}

#[test]
fn three_angles_are_blenders_xyz() {
    let turn = path(&key(0.0, "turn_deg { 30 40 50 }")).pose(0.0).rotation;
    // x turns first, so its axis moves with y and z only.
    let [x, y, z] =
        [(DVec3::X, 30.0), (DVec3::Y, 40.0), (DVec3::Z, 50.0)].map(|(a, d)| about(a, d));
    assert!(apart(turn, z * y * x) < 1e-12);
    assert_eq!(path(&key(0.0, "turn_deg { 90 0 0 }")).pose(0.0).rotation.y_axis, DVec3::Z);
    let path = path(&(key(0.0, "turn_deg { 10 0 0 }") + &key(1.0, "turn_deg { 10 -60 1080 }")));
    for i in 0..=500 {
        let u = f64::from(i) / 500.0;
        let [y, z] = [about(DVec3::Y, -60.0 * u), about(DVec3::Z, 1080.0 * u)];
        check_even(&path, u, z * y * about(DVec3::X, 10.0));
    }
}

#[test]
fn between_two_axes_the_way_is_the_shortest() {
    let about_x = "turn { axis { 1 0 0 } angle_deg 90 }";
    let path = path(&(key(0.0, &about_z(90.0)) + &key(1.0, about_x)));
    let [from, to] = [about(DVec3::Z, 90.0), about(DVec3::X, 90.0)];
    // (1 + i) (1 - k) / 2 = (1 + i + j - k) / 2: a third of a turn about a diagonal.
    let axis = DVec3::new(1.0, 1.0, -1.0).normalize();
    assert!(apart(about(axis, 120.0) * from, to) < 1e-12);
    for i in 0..=300 {
        let u = f64::from(i) / 300.0;
        check_even(&path, u, about(axis, 120.0 * u) * from);
    }
}

#[test]
fn handles_ease_a_turn() {
    let text = format!(
        "addKframe {{ time 0 key {{ pivot {{ 0 0 0 }} {} }} nex {{ pivot {{ 0 3 0 }} {} }} }}\
         addKframe {{ time 1 pre {{ pivot {{ 4 0 0 }} {} }} key {{ pivot {{ 4 0 0 }} {} }} }}",
        about_z(0.0),
        about_z(0.0),
        about_z(360.0),
        about_z(360.0)
    );
    let path = path(&text);
    for i in 0..=400 {
        let u = f64::from(i) / 400.0;
        let eased = 3.0 * u * u - 2.0 * u * u * u;
        check_even(&path, u, about(DVec3::Z, 360.0 * eased));
        let (x, y) = (4.0 * eased, 9.0 * u * (1.0 - u) * (1.0 - u));
        let pivot = path.pose(u).translation;
        assert!((pivot - DVec3::new(x, y, 0.0)).length() < 1e-13, "{pivot} at {u}");
    }
    // Between axes, too, the start and the end rest.
    let easing = "addKframe { time 0 key { turn { axis { 1 0 0 } angle_deg 40 } }
                    nex { turn { axis { 1 0 0 } angle_deg 40 } } }
                  addKframe { time 1 pre { turn { axis { 0 1 0 } angle_deg 70 } }
                    key { turn { axis { 0 1 0 } angle_deg 70 } } }";
    let path = super::tests::path(easing);
    let speed = |u: f64| apart(path.pose(u).rotation, path.pose(u + 1e-3).rotation) * 1e3;
    assert!(speed(0.0) < 1.0 && speed(0.999) < 1.0 && speed(0.5) > 60.0);
    for u in [0.1, 0.2, 0.3, 0.4] {
        assert!((speed(u) / speed(1.0 - u - 1e-3) - 1.0).abs() < 0.05, "{u}");
    }
}

#[test]
fn what_is_left_out_stays() {
    let text =
        key(0.0, "pivot { 1 2 3 }") + &key(1.0, &about_z(90.0)) + &key(2.0, "pivot { 5 2 3 }");
    let path = path(&text);
    check_even(&path, 0.0, DMat3::IDENTITY);
    check_even(&path, 0.5, about(DVec3::Z, 45.0));
    assert_eq!(path.pose(0.7).translation, DVec3::new(1.0, 2.0, 3.0));
    check_even(&path, 1.5, about(DVec3::Z, 90.0));
    assert_eq!(path.pose(1.5).translation, DVec3::new(3.0, 2.0, 3.0));
    // What does not turn is not divided, and what rests rests.
    assert_eq!(ball(&text).len(), 7);
    assert!(!super::tests::path(&(key(0.0, &about_z(7.0)) + &key(1.0, ""))).moves([0.0, 1.0]));
}

#[test]
fn a_whole_turn_closes_its_cycle() {
    for said in ["turn_deg { 0 0 360 }".to_owned(), about_z(-360.0)] {
        let start = said.replace("360", "0");
        let frames = ball(&(key(0.0, &start) + &key(1.0, &said)));
        let path = KeyFrames::new(&frames).unwrap().repeated(Some(Repeat::Cycle));
        assert!(path.jumps([0.0, 50.0]).is_empty());
        let sign = if said.contains('-') { -1.0 } else { 1.0 };
        check_even(&path, 1e6 + 0.25, about(DVec3::Z, 90.0 * sign));
    }
}
