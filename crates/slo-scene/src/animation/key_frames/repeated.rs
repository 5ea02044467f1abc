//! Paths that go on beyond their key frames.

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

fn is_rotation(m: glam::DMat3) -> bool {
    let error = m.transpose() * m - glam::DMat3::IDENTITY;
    m.is_finite() && error.to_cols_array().iter().all(|x| x.abs() < 1e-14)
}

/// A slide along x from 1 to 3, a second long, with a rest in its middle.
fn slide(repeat: Repeat) -> KeyFrames {
    let x = |time: f64, x: f64| key(time, at([x, 0.0, 0.0]));
    path(&[x(10.0, 1.0), x(10.25, 2.0), x(10.75, 2.0), x(11.0, 3.0)]).repeated(Some(repeat))
}

#[track_caller]
fn check_x(path: &KeyFrames, time: f64, expected: f64) {
    let x = path.pose(time).translation.x;
    assert!((x - expected).abs() < 1e-6 * expected.abs().max(1.0), "{x} at {time}");
}

#[test]
fn motion_goes_on_in_cycles_on_both_sides() {
    for whole in [0.0, 1.0, -1.0, 7.0, -10.0, 1000.0, 1e8, -1e8] {
        let [cycle, offset, ping] = [Repeat::Cycle, Repeat::Offset, Repeat::PingPong].map(slide);
        for (since, x) in [(0.0, 1.0), (0.125, 1.5), (0.5, 2.0), (0.875, 2.5)] {
            let time = 10.0 + whole + since;
            check_x(&cycle, time, x);
            check_x(&offset, time, x + 2.0 * whole);
            let is_odd = whole.rem_euclid(2.0) == 1.0;
            check_x(&ping, time, if is_odd { 4.0 - x } else { x });
        }
    }
    for repeat in Repeat::ALL {
        for time in [f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, f64::MAX] {
            let pose = slide(repeat).pose(time);
            assert!(pose.translation.abs().max_element() <= 1e9, "{pose:?}");
            assert!(is_rotation(pose.rotation));
        }
    }
}

#[test]
fn a_wheel_rolls_on() {
    let quarter = |time: f64, right: DVec3, x: f64| {
        key(time, Placement { right: Some(right), ..at([x, 0.0, 0.0]) })
    };
    let keys = [quarter(0.0, DVec3::X, 0.0), quarter(1.0, DVec3::Y, 5.0)];
    let wheel = path(&keys).repeated(Some(Repeat::Offset));
    let [back, two] = [wheel.pose(-0.5), wheel.pose(2.0)];
    assert!((two.rotation.x_axis - DVec3::NEG_X).length() < 1e-14);
    assert_eq!(two.translation, DVec3::X * 10.0);
    let half = (DVec3::X - DVec3::Y).normalize();
    assert!((back.rotation.x_axis - half).length() < 1e-14);
    assert_eq!(back.translation, DVec3::X * -2.5);
    let far = wheel.pose(4e6 + 1.0);
    assert!((far.rotation.x_axis - DVec3::Y).length() < 1e-8);
    assert!(is_rotation(far.rotation) && wheel.jumps([-9.0, 9.0]).is_empty());
}

#[test]
fn what_is_asked_of_a_repeated_path() {
    let [cycle, offset, ping] = [Repeat::Cycle, Repeat::Offset, Repeat::PingPong].map(slide);
    for path in [&cycle, &offset, &ping] {
        assert!(path.moves([110.1, 110.2]) && path.moves([-90.3, -90.2]) && path.moves([0.0, 1e9]));
        assert!(!path.moves([110.3, 110.7]) && !path.moves([-89.7, -89.3]));
        assert!(!path.moves([110.1, 110.1]));
        let times: Vec<_> = path.key_times_within([111.5, 113.1]).collect();
        for expected in [111.75, 112.0, 112.25, 112.75, 113.0] {
            assert!(times.iter().any(|time| (time - expected).abs() < 1e-9), "{times:?}");
        }
        assert!(times.len() <= 7, "{times:?}");
    }
    // Only what begins anew leaps, and only where a cycle begins.
    let leaps = cycle.jumps([111.5, 114.0]);
    assert_eq!(leaps.iter().map(|jump| jump.time).collect::<Vec<_>>(), [112.0, 113.0, 114.0]);
    assert!(leaps.iter().all(|jump| !jump.collapse));
    assert!(offset.jumps([111.5, 114.0]).is_empty() && ping.jumps([111.5, 114.0]).is_empty());
    assert!(cycle.moves([111.9999, 112.0001]));
    // Whoever asks about for ever gets an answer.
    for path in [&cycle, &offset, &ping] {
        let ever = [f64::NEG_INFINITY, f64::INFINITY];
        assert!(path.moves(ever) && path.jumps(ever).len() < 100_000);
        assert!(path.key_times_within([0.0, 1e12]).count() < 100_000);
    }
}

#[test]
fn a_path_that_ends_where_it_began_does_not_leap() {
    let keys = [key(0.0, at([0.0; 3])), key(1.0, at([1.0; 3])), key(2.0, at([0.0; 3]))];
    let closed = path(&keys).repeated(Some(Repeat::Cycle));
    assert!(closed.jumps([0.0, 9.0]).is_empty());
    assert_eq!(closed.pose(7.0).translation, DVec3::ONE);
    let still = path(&[keys[0], key(1.0, at([0.0; 3]))]).repeated(Some(Repeat::Offset));
    assert!(!still.moves([-1e6, 1e6]));
    // Without time between keys there is no cycle.
    let alone = path(&keys[1..2]).repeated(Some(Repeat::Cycle));
    assert!(!alone.moves([0.0, 1e6]) && alone.pose(5.0).translation == DVec3::ONE);
}

#[test]
fn collapses_come_again() {
    let half = [key(0.0, facing(DVec3::X)), key(2.0, facing(DVec3::NEG_X))];
    let path = path(&half).repeated(Some(Repeat::PingPong));
    let times: Vec<_> = path.jumps([0.5, 6.0]).iter().map(|jump| jump.time).collect();
    assert_eq!(times.len(), 3, "{times:?}");
    for (time, expected) in times.iter().zip([1.0, 3.0, 5.0]) {
        assert!((time - expected).abs() < 1e-6, "{times:?}");
    }
}
