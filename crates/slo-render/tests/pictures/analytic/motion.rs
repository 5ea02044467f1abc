//! Motion blur: a pixel's value is the share of the shutter time during which it is covered.

use crate::support::{
    Picture, Shot, assert_profile, glow, material, panel, panel_corners, pivot_at, rectangle,
    vector,
};

/// Size of a pixel in the plane through the origin, in the default shot.
const PX: f64 = 10.0 * 0.5 / 32.0;

/// For each column, the share of the shutter during which a bar 6 pixels wide covers the pixel, if
/// the middle of the bar is at `place(s)` pixels at shutter time `s`.
fn streak(place: impl Fn(f64) -> f64) -> Vec<f64> {
    let times = 4000;
    let mut columns = vec![0.0; 64];
    for k in 0..times {
        let middle = place((k as f64 + 0.5) / times as f64) + 32.0;
        for (x, column) in columns.iter_mut().enumerate() {
            let [left, right] = [(middle - 3.0).max(x as f64), (middle + 3.0).min(x as f64 + 1.0)];
            *column += (right - left).max(0.0) / times as f64;
        }
    }
    columns
}

/// A glowing bar 6 pixels wide and 20 pixels high, which moves by the key frames.
fn bar(key_frames: &str) -> String {
    let corners = panel_corners([-3.0 * PX, 3.0 * PX], 0.0, [-10.0 * PX, 10.0 * PX]);
    glow("white", [1.0; 3]) + &rectangle("bar", "white", corners, key_frames)
}

#[track_caller]
fn assert_streak(picture: &Picture, place: impl Fn(f64) -> f64) {
    assert_profile(&picture.columns(22..42, 0), &streak(place), 0.012);
    let dark: f64 = (0..64).map(|x| picture.at(x, 20)[0] + picture.at(x, 43)[0]).sum();
    assert_eq!(dark, 0.0);
}

fn shutter(blur: f64) -> Shot {
    Shot { blur, ..Shot::default() }
}

#[test]
fn a_bar_leaves_a_streak_as_long_as_its_way() {
    let keys = pivot_at(0.0, [-10.0 * PX, 0.0, 0.0]) + &pivot_at(1.0, [14.0 * PX, 0.0, 0.0]);
    assert_streak(&shutter(1.0).take(&bar(&keys)), |s| -10.0 + 24.0 * s);
    assert_streak(&shutter(0.25).take(&bar(&keys)), |s| -10.0 + 6.0 * s);
    assert_streak(&shutter(0.0).take(&bar(&keys)), |_| -10.0);
}

#[test]
fn a_shutter_that_outlasts_the_segment_sees_the_bar_come_to_rest() {
    let keys = pivot_at(0.0, [-10.0 * PX, 0.0, 0.0]) + &pivot_at(1.0, [14.0 * PX, 0.0, 0.0]);
    let place = |s: f64| -10.0 + 24.0 * (2.0 * s).min(1.0);
    assert_streak(&shutter(2.0).take(&bar(&keys)), place);
}

#[test]
fn before_and_after_its_keys_the_bar_rests() {
    let keys = pivot_at(0.25, [-10.0 * PX, 0.0, 0.0]) + &pivot_at(0.5, [14.0 * PX, 0.0, 0.0]);
    let place = |s: f64| -10.0 + 24.0 * (4.0 * (s - 0.25)).clamp(0.0, 1.0);
    assert_streak(&shutter(1.0).take(&bar(&keys)), place);
}

#[test]
fn repeated_motion_goes_on() {
    let keys = |repeat: &str, start: f64| {
        let [a, b] = [[start, -10.0], [start + 0.25, 14.0]];
        pivot_at(a[0], [a[1] * PX, 0.0, 0.0])
            + &pivot_at(b[0], [b[1] * PX, 0.0, 0.0])
            + &format!("repeat {repeat}")
    };
    let part = |s: f64| (4.0 * s).rem_euclid(1.0);
    // The same whether the key frames are before, within or long after the shutter.
    for start in [-1000.0, 0.25, 1000.0] {
        let there = |s: f64| -10.0 + 24.0 * part(s);
        assert_streak(&shutter(1.0).take(&bar(&keys("CYCLE", start))), there);
        let and_back =
            |s: f64| -10.0 + 24.0 * (1.0 - (2.0 * part(s / 2.0 + start * 0.5) - 1.0).abs());
        assert_streak(&shutter(1.0).take(&bar(&keys("PINGPONG", start))), and_back);
    }
    let on = pivot_at(7.0, [102.0 * PX, 0.0, 0.0]) + &pivot_at(7.25, [106.0 * PX, 0.0, 0.0]);
    assert_streak(&shutter(1.0).take(&bar(&(on + "repeat OFFSET"))), |s| -10.0 + 16.0 * s);
}

#[test]
fn many_turns_cover_a_disc_evenly() {
    // A blade from the axis to radius 20 px turns five times within the shutter, about the view: of
    // 360 degrees of each circle, it covers what a blade of its width covers.
    let keys = "addKframe { time 0 key { turn_deg { 0 0 0 } } }
                addKframe { time 1 key { turn_deg { 0 1800 0 } } }";
    let corners = panel_corners([0.0, 20.0 * PX], 0.0, [-PX, PX]);
    let blade = glow("white", [1.0; 3]) + &rectangle("blade", "white", corners, keys);
    let picture = shutter(1.0).take(&blade);
    let half = |range: std::ops::Range<usize>| range.map(|x| (x, x as f64 - 31.5));
    for (columns, rows) in [(12..32, 12..32), (12..32, 32..52), (32..52, 12..32), (32..52, 32..52)]
    {
        let places = half(columns).flat_map(|x| half(rows.clone()).map(move |y| (x, y)));
        let ring = |r: f64| (6.0..18.0).contains(&r);
        let [mut found, mut expected] = [0.0, 0.0];
        for ((column, x), (row, y)) in places.filter(|((_, x), (_, y))| ring(x.hypot(*y))) {
            found += picture.at(column, row)[0];
            expected += 1.0 / (std::f64::consts::PI * x.hypot(y));
        }
        assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
    }
}

#[test]
fn handles_make_the_bar_start_and_stop_gently() {
    // Control points 0, 0, 1, 1 of the way: 3 u^2 - 2 u^3.
    let at = |x: f64| vector([x * PX, 0.0, 0.0]);
    let keys = format!(
        "addKframe {{ time 0 key {{ pivot {0} }} nex {{ pivot {0} }} }}
         addKframe {{ time 1 pre {{ pivot {1} }} key {{ pivot {1} }} }}",
        at(-12.0),
        at(12.0)
    );
    assert_streak(&shutter(1.0).take(&bar(&keys)), |s| {
        -12.0 + 24.0 * (3.0 * s * s - 2.0 * s * s * s)
    });
}

#[test]
fn a_moving_camera_leaves_the_streak_on_the_other_side() {
    let shot = Shot {
        from: vec![[-8.0 * PX, -10.0, 0.0], [12.0 * PX, -10.0, 0.0]],
        to: vec![[-8.0 * PX, 0.0, 0.0], [12.0 * PX, 0.0, 0.0]],
        ..shutter(1.0)
    };
    assert_streak(&shot.take(&bar("")), |s| 8.0 - 20.0 * s);
}

#[test]
fn a_camera_that_follows_a_bar_sees_it_sharp() {
    let keys = pivot_at(0.0, [0.0; 3]) + &pivot_at(1.0, [20.0 * PX, 0.0, 0.0]);
    let shot = Shot {
        from: vec![[0.0, -10.0, 0.0], [20.0 * PX, -10.0, 0.0]],
        to: vec![[0.0; 3], [20.0 * PX, 0.0, 0.0]],
        ..shutter(1.0)
    };
    let found = shot.take(&bar(&keys)).columns(23..41, 0);
    // The bar is placed to half a sample step, a hundredth of a pixel here.
    assert_profile(&found, &streak(|_| 0.0), 0.02);
}

#[test]
fn a_turning_blade_covers_a_sector() {
    // A blade from the axis to radius 20 px makes a quarter turn within the shutter, right -> up,
    // with the y axis (object "forward") kept along the view: up runs from z to -x, right from x to
    // z.
    let blade = glow("white", [1.0; 3])
        + &rectangle(
            "blade",
            "white",
            panel_corners([0.0, 100.0], 0.0, [-100.0, 0.0]),
            &format!(
                "addKframe {{ time 0 key {{ right {} up {} }} }}
                 addKframe {{ time 1 key {{ right {} up {} }} }}",
                vector([1.0, 0.0, 0.0]),
                vector([0.0, 0.0, 1.0]),
                vector([0.0, 0.0, 1.0]),
                vector([-1.0, 0.0, 0.0])
            ),
        );
    let picture = shutter(1.0).take(&blade);
    // The blade is the quadrant below right (angles -90..0 degrees) at first, and above right
    // (0..90) at last. A point at angle a in between is covered after the leading edge has passed
    // it, from the time u with atan(u / (1 - u)) = a on. A point at a - 90 is covered until then.
    for (x, y) in [(60, 20), (40, 5), (50, 28), (33, 2), (62, 30)] {
        let tan = (31.5 - y as f64) / (x as f64 - 31.5);
        let time = tan / (1.0 + tan);
        let above = picture.at(x, y)[0];
        assert!((above - (1.0 - time)).abs() < 0.03, "{above} at {x} {y}, expected {}", 1.0 - time);
        // A quarter turn back: (x, y) -> (y, -x).
        let below = picture.at(63 - y, x)[0];
        assert!((below - time).abs() < 0.03, "{below} below {x} {y}, expected {time}");
    }
    assert_eq!(picture.at(10, 10)[0], 0.0);
    assert_eq!(picture.at(10, 50)[0], 0.0);
}

/// Two panels that move together, the near one just covering the far one. The far one is visible
/// only to a ray that mixes two times.
fn covered_pair(far: &str, near: &str) -> String {
    let keys = pivot_at(0.0, [-20.0 * PX, 0.0, 0.0]) + &pivot_at(1.0, [20.0 * PX, 0.0, 0.0]);
    let piece = |name: &str, material: &str, half: f64, y: f64| {
        let corners = panel_corners([-half * PX, half * PX], y, [-half * PX, half * PX]);
        rectangle(name, material, corners, &keys)
    };
    piece("far", far, 5.0, 0.5) + &piece("near", near, 6.0, 0.0)
}

#[test]
fn all_that_one_ray_meets_is_seen_at_one_time() {
    let scene = glow("red", [1.0, 0.0, 0.0]) + &glow("green", [0.0, 1.0, 0.0]);
    let direct = shutter(1.0).take(&(scene.clone() + &covered_pair("red", "green")));
    assert_eq!(direct.sum(0), 0.0);
    assert!((direct.sum(1) / 144.0 - 1.0).abs() < 0.02);
    // And in a mirror behind the camera, which looks away from the panels.
    let mirror = material("mirror", "reflectance 1")
        + &panel("glass", "mirror", [-90.0, 90.0], -20.0, [-90.0, 90.0]);
    let away = Shot { to: vec![[0.0, -20.0, 0.0]], ..shutter(1.0) };
    let mirrored = away.take(&(scene + &mirror + &covered_pair("red", "green")));
    assert_eq!(mirrored.sum(0), 0.0);
    // Three times as far away as directly: the camera is 10 from the mirror, the panels 20.
    assert!((mirrored.sum(1) / 144.0 * 9.0 - 1.0).abs() < 0.05);
}

#[test]
fn a_shadow_is_cast_at_the_time_of_its_ray() {
    // A lid moves along with a diffuse piece of floor, between it and the lamp, so the piece is
    // always in its shadow. The underside of the lid is dark too, so nothing is lit at any time.
    let keys = |to: f64| pivot_at(0.0, [-3.0, 0.0, 0.0]) + &pivot_at(1.0, [to, 0.0, 0.0]);
    let square = |name: &str, half: f64, z: f64, to: f64| {
        let corners = [[-half, -half, z], [half, -half, z], [half, half, z]];
        rectangle(name, "paper", corners, &keys(to))
    };
    let scene = |lid_to: f64| {
        material("paper", "diffuse { 1 1 1 }")
            + "light_point lamp { color { 1 1 1 } position { 0 0 1000 } }"
            + &square("floor", 0.5, 0.0, 3.0)
            + &square("lid", 0.7, 1.0, lid_to)
    };
    let shot = Shot { from: vec![[0.0, -8.0, 0.8]], ..shutter(1.0) };
    assert_eq!(shot.take(&scene(3.0)).sum(0), 0.0);
    assert!(shot.take(&scene(2.0)).sum(0) > 1.0); // a lid that lags lets light in
}

#[test]
fn lights_of_the_thesis_shine_from_where_they_are_at_the_time_of_a_ray() {
    // A light, a lid under it and a floor under the lid move together, so the floor is always dark.
    // The light itself is above the picture.
    let keys = |to: f64| pivot_at(0.0, [-3.0, 0.0, 0.0]) + &pivot_at(1.0, [to, 0.0, 0.0]);
    let square = |name: &str, half: f64, z: f64| {
        let corners = [[-half, -half, z], [half, -half, z], [half, half, z]];
        rectangle(name, "paper", corners, &keys(3.0))
    };
    let shot = Shot { from: vec![[0.0, -8.0, 0.8]], ..shutter(1.0) };
    for light in [
        "light_point lamp { color { 1 1 1 } position { 0 0 6 }",
        "light_rectangle lamp { color { 1 1 1 } vertex0 { -.1 -.1 6 } vertex1 { .1 -.1 6 } vertex2 { .1 .1 6 }",
    ] {
        let sum = |motion: &str| {
            let light = format!("{light} {motion} }}\n");
            let floor = square("floor", 0.5, 0.0) + &square("lid", 0.7, 1.0);
            let picture = shot.take(&(material("paper", "diffuse { 1 1 1 }") + &light + &floor));
            picture.sum(0)
        };
        assert_eq!(sum(&keys(3.0)), 0.0, "{light}");
        assert!(sum(&keys(-2.0)) > 1.0, "{light} lags");
        assert!(sum("") > 0.1, "{light} stands still");
    }
}

#[test]
fn the_shadow_of_a_moving_bar_is_blurred_as_long_as_the_light_makes_its_way() {
    // The lamp is at height 4, the bar at height 1 above the floor, so its shadow is larger than
    // the bar and moves faster, by 4 / (4 - 1). The camera looks down from below the bar.
    let px = 0.9 / 32.0;
    let scale = 4.0 / 3.0;
    let bar = |more: &str| {
        let [x, y] = [3.0 * px / scale, 200.0 * px];
        rectangle("bar", "paper", [[-x, -y, 1.0], [x, -y, 1.0], [x, y, 1.0]], more)
    };
    let floor = [[-50.0, -50.0, 0.0], [50.0, -50.0, 0.0], [50.0, 50.0, 0.0]];
    let scene = material("paper", "diffuse { 1 1 1 }")
        + "light_point lamp { color { 1 1 1 } position { 0 0 4 } }"
        + &rectangle("floor", "paper", floor, "");
    let shot = Shot {
        from: vec![[0.0, 0.0, 0.9]],
        to: vec![[0.0; 3]],
        sky: [0.0, 1.0, 0.0],
        fov: 1.0,
        ..shutter(1.0)
    };
    let way = |x: f64| [x * px / scale, 0.0, 0.0];
    let keys = pivot_at(0.0, way(-10.0)) + &pivot_at(1.0, way(14.0));
    let lit = shot.take(&scene).columns(22..42, 0);
    let shadowed = shot.take(&(scene + &bar(&keys))).columns(22..42, 0);
    let shadow: Vec<f64> = lit.iter().zip(&shadowed).map(|(lit, dark)| 1.0 - dark / lit).collect();
    assert_profile(&shadow, &streak(|s| -10.0 + 24.0 * s), 0.012);
}

#[test]
fn a_mirror_shows_motion_as_far_as_it_goes() {
    // The bar moves 10 behind the camera. A mirror 10 in front of it shows the bar 30 away.
    let keys = pivot_at(0.0, [-30.0 * PX, -20.0, 0.0]) + &pivot_at(1.0, [42.0 * PX, -20.0, 0.0]);
    let corners = panel_corners([-9.0 * PX, 9.0 * PX], 0.0, [-30.0 * PX, 30.0 * PX]);
    let scene = glow("white", [1.0; 3])
        + &material("mirror", "reflectance 1")
        + &panel("glass", "mirror", [-90.0, 90.0], 0.0, [-90.0, 90.0])
        + &rectangle("bar", "white", corners, &keys);
    assert_streak(&shutter(1.0).take(&scene), |s| -10.0 + 24.0 * s);
}
