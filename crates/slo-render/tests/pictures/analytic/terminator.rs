//! Coarse smooth meshes: the border of light has no corners, and nothing leaks.

use crate::support::{Picture, Shot};

const MATT: &str = "material_principled m { base_color { 1 1 1 } ior 1 specular_ior_level 0 } ";
/// 80 triangles on a sphere of radius 1.5.
const BALL: &str = "mesh b { material m filename files/ball.obj smooth_normals 1 KEYS } ";

fn shot(recursion: u32, samples: u32) -> Shot {
    let settings = "integrator PATH".to_owned();
    Shot { fov: 0.2, recursion, samples, settings, ..Shot::default() }
}

fn ball(keys: &str) -> String {
    BALL.replace("KEYS", keys)
}

/// The red of the pixels within a share of the radius of the ball.
fn within(picture: &Picture, share: f64) -> Vec<f64> {
    let place = |i: usize| (i as f64 - 31.5) / 32.0 * 2.0 / 1.5;
    let pixels = (0..64 * 64).map(|i| (i % 64, i / 64));
    let seen = pixels.filter(|&(x, y)| place(x).hypot(place(y)) < share);
    seen.map(|(x, y)| picture.at(x, y)[0]).collect()
}

#[test]
fn the_border_of_light_is_that_of_a_sphere() {
    let sun = "lamp_sun s { irradiance { 1 1 1 } direction { 1 .2 -.3 } angle_deg 0 } ";
    let take = |shape: &str| within(&shot(0, 16).take(&format!("{MATT}{sun}{shape}")), 0.8);
    let sphere = take("sphere s { material m center { 0 0 0 } radius 1.5 } ");
    for (found, expected) in take(&ball("")).into_iter().zip(sphere) {
        assert!((found - expected).abs() < 0.02, "{found} is not {expected}");
    }
}

#[test]
fn a_white_ball_keeps_no_light() {
    let sky = "environment e { radiance { 1 1 1 } } ";
    let found = within(&shot(40, 32).take(&format!("{MATT}{sky}{}", ball(""))), 0.85);
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    assert!((mean - 1.0).abs() < 0.002, "{mean}");
}

#[test]
fn nothing_shines_through_a_shell() {
    // A lamp inside, seen from outside, and the other way round. The lamp is found by rays to it
    // and by rays that hit it.
    let lamp = |at: &str| {
        format!("lamp_point l {{ power {{ 900 900 900 }} position {{ {at} }} radius .3 }} ")
    };
    let gloss = "material_principled m { base_color { .8 .8 .8 } roughness .6 } ";
    let outside = shot(4, 16);
    let inside = Shot { from: vec![[0.2, -0.9, 0.1]], fov: 1.0, ..shot(4, 16) };
    for material in [MATT, gloss] {
        for (shot, at) in [(&outside, ".7 0 .5"), (&inside, "1.6 .9 1"), (&inside, "0 2.2 0")] {
            let picture = shot.take(&format!("{material}{}{}", lamp(at), ball("")));
            assert_eq!(picture.sum(0), 0.0, "{at}");
        }
    }
}

#[test]
fn moving_balls_look_as_balls_at_rest() {
    let lamp = "lamp_point l { power { 900 900 900 } position { -4 -2 4 } radius .5 } ";
    let key = |time: u32, x: f64| {
        format!("addKframe {{ time {time} key {{ pivot {{ {x} 0 0 }} right {{ .6 .8 0 }} }} }} ")
    };
    let shot = Shot { blur: 1.0, ..shot(0, 16) };
    let take = |keys: &str| shot.take(&format!("{MATT}{lamp}{}", ball(keys)));
    let (still, moving) = (take(&key(0, 0.0)), take(&(key(0, 0.0) + &key(1, 1e-5))));
    let differs = still.0.rgb.iter().zip(&moving.0.rgb).filter(|(a, b)| (a[0] - b[0]).abs() > 0.02);
    // Pixels of the rim may see it or not.
    assert!(differs.count() < 40);
}
