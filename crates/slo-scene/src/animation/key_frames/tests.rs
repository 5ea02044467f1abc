use glam::DMat3;

use super::*;

fn at(pivot: [f64; 3]) -> Placement {
    Placement { pivot: Some(pivot.into()), ..Placement::default() }
}

fn facing(right: DVec3) -> Placement {
    Placement { right: Some(right), ..Placement::default() }
}

fn key(time: f64, key: Placement) -> KeyFrame {
    KeyFrame { time, key, ..KeyFrame::default() }
}

fn path(keys: &[KeyFrame]) -> KeyFrames {
    KeyFrames::new(keys).unwrap()
}

fn is_rotation(m: DMat3) -> bool {
    let error = m.transpose() * m - DMat3::IDENTITY;
    m.is_finite() && error.to_cols_array().iter().all(|x| x.abs() < 1e-14)
}

#[test]
fn no_key_frame_is_scene_space() {
    let path = path(&[]);
    assert_eq!(path.pose(3.0), DRigid::IDENTITY);
    assert!(!path.moves([0.0, 9.0]));
}

#[test]
fn one_key_frame_places_a_still_object() {
    let path = path(&[key(2.0, Placement { right: Some(DVec3::Y), ..at([1.0, 2.0, 3.0]) })]);
    for time in [-5.0, 2.0, 7.0] {
        // object x goes to scene y, object y to scene -x
        let p = path.pose(time).point(DVec3::new(1.0, 10.0, 100.0));
        assert_eq!(p, DVec3::new(-9.0, 3.0, 103.0));
    }
    assert!(!path.moves([-9.0, 9.0]));
}

#[test]
fn without_handles_motion_is_linear_in_time() {
    let path = path(&[key(1.0, at([0.0, 3.0, -1.0])), key(5.0, at([8.0, 3.0, 1e3]))]);
    for i in 0..=100 {
        let u = i as f64 / 100.0;
        let p = path.pose(1.0 + 4.0 * u).translation;
        let expected = DVec3::new(8.0 * u, 3.0, -1.0 + 1001.0 * u);
        assert!((p - expected).length() < 1e-12 * 1e3, "{p} at {u}");
    }
}

#[test]
fn a_lone_handle_meets_a_third_of_the_straight_line() {
    let mut first = key(0.0, at([0.0; 3]));
    first.nex = at([0.0, 6.0, 0.0]);
    let path = path(&[first, key(1.0, at([3.0, 0.0, 0.0]))]);
    // control points 0, (0, 6), (2, 0), (3, 0); half way: (p0 + 3 p1 + 3 p2 + p3) / 8
    let middle = path.pose(0.5).translation;
    assert!((middle - DVec3::new(9.0 / 8.0, 18.0 / 8.0, 0.0)).length() < 1e-15);
}

#[test]
fn handles_are_separate_for_every_component() {
    let mut first = key(0.0, at([0.0; 3]));
    first.nex = Placement { up: Some(DVec3::new(0.0, 1.0, 1.0)), ..Placement::default() };
    let path = path(&[first, key(1.0, at([4.0, 0.0, 0.0]))]);
    assert!((path.pose(0.25).translation - DVec3::X).length() < 1e-15); // still linear
    // up: (z + 3 (y + z) + 3 z + z) / 8 = z + 3/8 y
    let up = path.pose(0.5).rotation.z_axis;
    assert!((up - DVec3::new(0.0, 0.375, 1.0).normalize()).length() < 1e-15);
}

#[test]
fn handles_of_the_far_sides_take_no_part() {
    let mut keys = [key(0.0, at([0.0; 3])), key(1.0, at([1.0, 0.0, 0.0]))];
    keys[0].pre = at([99.0; 3]);
    keys[1].nex = at([99.0; 3]);
    assert!((path(&keys).pose(0.5).translation - DVec3::X * 0.5).length() < 1e-15);
}

#[test]
fn what_a_key_leaves_out_comes_from_the_key_before() {
    let [pivot, up, right] = [DVec3::ONE, DVec3::X, DVec3::Y].map(Some);
    let full = Placement { pivot, up, right, scale: None };
    let path = path(&[
        key(0.0, Placement::default()),
        key(1.0, full),
        key(2.0, Placement::default()),
        key(3.0, at([5.0; 3])),
    ]);
    assert_eq!(path.pose(0.0), DRigid::IDENTITY);
    assert_eq!(path.pose(1.0), path.pose(2.0));
    // columns (right, forward, up), forward = up x right = x x y = z
    assert_eq!(path.pose(3.0).rotation, DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    assert_eq!(path.pose(3.0).translation, DVec3::splat(5.0));
}

#[test]
fn a_quarter_turn_in_one_piece() {
    let path = path(&[key(0.0, facing(DVec3::X)), key(1.0, facing(DVec3::Y))]);
    let right = |u: f64| path.pose(u).rotation.x_axis;
    // right runs along the straight line (1 - u, u): the angle is atan(u / (1 - u))
    for (u, degrees) in [(0.0, 0.0), (0.25, 18.434_948_822_922_01), (0.5, 45.0), (1.0, 90.0)] {
        let angle = libm::atan2(right(u).y, right(u).x).to_degrees();
        assert!((angle - degrees).abs() < 1e-12, "{angle} at {u}");
    }
}

#[test]
fn outside_the_keys_the_object_rests() {
    let path = path(&[key(1.0, at([1.0; 3])), key(2.0, at([2.0; 3]))]);
    assert_eq!(path.pose(f64::NEG_INFINITY).translation, DVec3::splat(1.0));
    assert_eq!(path.pose(0.999).translation, DVec3::splat(1.0));
    assert_eq!(path.pose(2.0).translation, DVec3::splat(2.0));
    assert_eq!(path.pose(1e9).translation, DVec3::splat(2.0));
    for rest in [[0.0, 1.0], [2.0, 3.0], [-9.0, -8.0], [1.5, 1.5]] {
        assert!(!path.moves(rest), "{rest:?}");
    }
    for motion in [[0.0, 1.01], [1.99, 3.0], [0.0, 3.0], [1.5, 1.500_001]] {
        assert!(path.moves(motion), "{motion:?}");
    }
}

#[test]
fn an_object_that_returns_moves() {
    let mut there_and_back = [key(0.0, at([0.0; 3])), key(1.0, at([0.0; 3]))];
    assert!(!path(&there_and_back).moves([0.0, 1.0]));
    there_and_back[1].pre = at([0.0, 0.0, 5.0]);
    assert!(path(&there_and_back).moves([0.0, 1.0]));
    let keys = [0.0, 1.0, 0.0].map(|x| key(x * 2.0, at([x, 0.0, 0.0])));
    let path = path(&[keys[0], keys[1], key(4.0, at([0.0; 3]))]);
    assert_eq!(path.pose(0.0), path.pose(4.0));
    assert!(path.moves([0.0, 4.0]));
}

#[test]
fn path_is_continuous_at_its_keys() {
    let handle = Placement { up: Some(DVec3::new(0.3, 1.0, 1.0)), ..at([7.0, -3.0, 2.0]) };
    let mut keys = [
        key(0.0, at([0.0; 3])),
        key(0.3, facing(DVec3::new(0.2, 1.0, 0.0))),
        key(1.0, at([0.1, 0.2, 0.3])),
    ];
    keys.iter_mut().for_each(|key| (key.pre, key.nex) = (handle, handle));
    let path = path(&keys);
    for time in [0.0, 0.3, 1.0] {
        let [a, b] = [path.pose(time - 1e-12), path.pose(time + 1e-12)];
        assert!((a.translation - b.translation).length() < 1e-9);
        assert!((a.rotation - b.rotation).to_cols_array().iter().all(|x| x.abs() < 1e-9));
    }
    assert!(path.jumps([0.0, 1.0]).is_empty());
}

#[test]
fn keys_without_orientation_are_named() {
    let upright = key(0.0, Placement::default());
    let parallel = key(1.0, facing(DVec3::NEG_Z));
    assert_eq!(KeyFrames::new(&[upright, parallel]).unwrap_err(), KeyFrameError::NoOrientation(1));
    let gone = key(0.0, Placement { up: Some(DVec3::ZERO), ..Placement::default() });
    let error = KeyFrames::new(&[gone]).unwrap_err();
    assert_eq!(error, KeyFrameError::NoOrientation(0));
    assert_eq!(error.to_string(), "`up` of key frame 1 is parallel to its `right`, or zero");
    assert_eq!(
        KeyFrames::new(&[key(1.0, Placement::default()), upright]).unwrap_err(),
        KeyFrameError::OutOfOrder(1)
    );
    assert!(KeyFrames::new(&[key(f64::NAN, Placement::default())]).is_err());
}

#[test]
fn two_keys_of_one_time_are_a_cut() {
    let path = path(&[
        key(0.0, at([0.0; 3])),
        key(1.0, at([1.0; 3])),
        key(1.0, at([5.0; 3])),
        key(2.0, at([6.0; 3])),
    ]);
    assert!((path.pose(1.0 - 1e-9).translation - DVec3::ONE).length() < 1e-8);
    assert_eq!(path.pose(1.0).translation, DVec3::splat(5.0));
    let cut = Jump { key: 1, time: 1.0, collapse: false };
    assert_eq!(path.jumps([0.0, 2.0]), [cut]);
    assert!(path.jumps([1.1, 2.0]).is_empty());
}

#[test]
fn half_a_turn_in_one_piece_keeps_the_side_it_came_from() {
    let path = path(&[key(2.0, facing(DVec3::X)), key(4.0, facing(DVec3::NEG_X))]);
    assert_eq!(path.pose(2.99).rotation.x_axis, DVec3::X);
    assert_eq!(path.pose(3.0).rotation.x_axis, DVec3::X); // right is exactly 0 here
    assert_eq!(path.pose(3.01).rotation.x_axis, DVec3::NEG_X);
    let jumps = path.jumps([0.0, 9.0]);
    assert_eq!(jumps.len(), 1);
    assert!(jumps[0].collapse && jumps[0].key == 0 && (jumps[0].time - 3.0).abs() < 1e-6);
}

#[test]
fn up_that_runs_through_right_is_found_off_the_grid_of_the_search() {
    // up turns in the xz plane from z to -z by way of x = right, at an odd place
    let up = |x: f64, z: f64| Placement { up: Some(DVec3::new(x, 0.0, z)), ..Placement::default() };
    let path = path(&[key(0.0, up(0.0, 1.0)), key(1.0, up(1.0, -0.7))]);
    let expected = 1.0 / 1.7; // z of up is 1 - 1.7 u
    let jumps = path.jumps([0.0, 1.0]);
    assert_eq!(jumps.len(), 1);
    assert!((jumps[0].time - expected).abs() < 1e-6);
    assert!(is_rotation(path.pose(jumps[0].time).rotation));
}

#[test]
fn a_touch_without_a_leap_is_continuous() {
    // right shrinks to 0 half way and grows again in the same direction: r = (1 - 2u)^2
    let mut keys = [key(0.0, facing(DVec3::X)), key(1.0, facing(DVec3::X))];
    (keys[0].nex, keys[1].pre) = (facing(DVec3::X / -3.0), facing(DVec3::X / -3.0));
    let path = path(&keys);
    for i in 0..=1000 {
        let right = path.pose(i as f64 / 1000.0).rotation.x_axis;
        assert!((right - DVec3::X).length() < 1e-15);
    }
    assert!(path.jumps([0.0, 1.0]).is_empty());
}

#[test]
fn poses_are_rotations_on_random_paths() {
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / 8_388_608.0 - 1.0
    };
    for _ in 0..200 {
        let mut vector = || Some(DVec3::new(random(), random(), random()));
        let mut placement =
            || Placement { pivot: vector(), up: vector(), right: vector(), scale: None };
        let keys: Vec<_> = (0..4)
            .map(|i| KeyFrame {
                time: i as f64,
                pre: placement(),
                key: placement(),
                nex: placement(),
            })
            .collect();
        let path = path(&keys);
        for i in -10..=410 {
            let pose = path.pose(i as f64 / 100.0);
            assert!(is_rotation(pose.rotation) && pose.translation.is_finite());
            assert!(pose.translation.abs().max_element() <= 1.0 + 1e-12); // hull of the controls
        }
    }
}

#[test]
fn tiny_and_huge_vectors_turn_as_others_do() {
    let far =
        Placement { up: Some(DVec3::Z * 1e200), right: Some(DVec3::Y * 1e-200), ..at([0.0; 3]) };
    let path = path(&[key(0.0, far), key(1.0, facing(DVec3::Y * 3e-200))]);
    for u in [0.0, 0.4, 1.0] {
        assert_eq!(path.pose(u).rotation.x_axis, DVec3::Y);
    }
}

#[test]
fn a_ball_grows_along_its_own_axes() {
    let scale = |x: f64, y: f64, z: f64| Some(DVec3::new(x, y, z));
    let first = Placement { scale: scale(1.0, 2.0, 3.0), right: Some(DVec3::Y), ..at([5.0; 3]) };
    let mut keys =
        [key(0.0, first), key(2.0, Placement { scale: scale(3.0, 2.0, 1.0), ..at([5.0; 3]) })];
    let straight = path(&keys);
    assert!(
        !straight.is_rigid() && straight.moves([0.5, 0.6]) && straight.jumps([0.0, 2.0]).is_empty()
    );
    let pose = straight.placed(1.0);
    // x goes to y, y to -x; half way, all axes are twice as long
    assert!((pose.linear.x_axis - DVec3::Y * 2.0).length() < 1e-14);
    assert!((pose.linear.y_axis - DVec3::NEG_X * 2.0).length() < 1e-14);
    assert_eq!(
        (pose.translation, straight.placed(9.0).linear.z_axis),
        (DVec3::splat(5.0), DVec3::Z)
    );
    // (1 + 3 * 1 + 3 * 7 + 3) / 8 = 3.5
    keys[0].nex = Placement { scale: scale(1.0, 2.0, 3.0), ..Placement::default() };
    keys[1].pre = Placement { scale: scale(7.0, 2.0, 1.0), ..Placement::default() };
    assert!((path(&keys).placed(1.0).linear.x_axis - DVec3::Y * 3.5).length() < 1e-14);
    // What a key leaves out comes from the key before; a leap in size is a leap.
    keys[1].key.scale = None;
    keys[1].pre = Placement::default();
    assert!(!path(&keys).moves([0.0, 2.0]) && path(&keys).placed(2.0).growth.is_none());
    (keys[1].time, keys[1].key.scale) = (0.0, scale(9.0, 9.0, 9.0));
    assert_eq!(
        (path(&keys).jumps([0.0, 1.0]).len(), path(&keys).placed(0.0).growth),
        (1, Some(9.0))
    );
}
