//! Light that glass lets through, by formulas.

use crate::support::{Shot, pivot_at};

const GLASS: &str =
    "material_principled glass { base_color { 1 1 1 } transmission 1 roughness 0 } ";

/// A view straight down, from below the glass, that shows a square of `side` units of a floor at height 0.
fn down(side: f64, settings: &str, samples: u32) -> Shot {
    Shot {
        from: vec![[0.0, 0.0, 3.0]],
        to: vec![[0.0, 0.0, 0.0]],
        sky: [0.0, 1.0, 0.0],
        fov: side / 6.0,
        recursion: 24,
        samples,
        settings: format!("integrator PATH {settings}"),
        ..Shot::default()
    }
}

fn mean(shot: &Shot, scene: &str) -> f64 {
    shot.take(scene).sum(0) / 4096.0
}

/// A floor so dark that hardly any light comes back to it.
const DARK: &str =
    "material_principled matte { base_color { .001 .001 .001 } ior 1 specular_ior_level 0 } ";

#[test]
fn a_pane_lets_through_what_its_two_surfaces_leave() {
    // R = .04 at each surface, reflected to and fro any number of times: T = (1 - R) / (1 + R).
    let expected = 0.923077 * 2.0 * 0.001 / std::f64::consts::PI;
    let floor = "rectangle floor { material matte vertex0 { -2 -2 0 } vertex1 { 2 -2 0 } vertex2 { 2 2 0 } } ";
    let pane = "box pane { material glass vertex0 { -4 -4 4 } vertex1 { 4 -4 4 } vertex2 { 4 4 4 } height .5 } ";
    for angle in ["0", "2"] {
        let sun = format!(
            "lamp_sun l {{ irradiance {{ 2 2 2 }} direction {{ 0 0 -1 }} angle_deg {angle} }}"
        );
        let scene = [DARK, GLASS, floor, pane, &sun].concat();
        let found = mean(&down(2.0, "photons 20", 16), &scene);
        assert!((found / expected - 1.0).abs() < 0.01, "{angle}: {found}, expected {expected}");
    }
}

#[test]
fn a_floor_that_rises_in_the_shutter_gets_as_much_light() {
    // Parallel light is as bright at any height.
    let expected = 0.923077 * 2.0 * 0.001 / std::f64::consts::PI;
    let keys = pivot_at(0.0, [0.0, 0.0, -2.0]) + &pivot_at(1.0, [0.0; 3]);
    let floor = format!(
        "rectangle floor {{ material matte vertex0 {{ -4 -4 0 }} vertex1 {{ 4 -4 0 }} vertex2 {{ 4 4 0 }} {keys} }} "
    );
    let pane = "box pane { material glass vertex0 { -4 -4 4 } vertex1 { 4 -4 4 } vertex2 { 4 4 4 } height .5 } ";
    let sun = "lamp_sun l { irradiance { 2 2 2 } direction { 0 0 -1 } angle_deg 0 }";
    let shot = Shot { blur: 1.0, ..down(2.0, "photons 20", 16) };
    let found = mean(&shot, &[DARK, GLASS, &floor, pane, sun].concat());
    assert!((found / expected - 1.0).abs() < 0.015, "{found}, expected {expected}");
}

#[test]
fn a_ball_of_glass_lets_through_what_its_surfaces_leave() {
    let room = |ball: &str| {
        format!(
            "{DARK} {GLASS}
             material_principled white {{ base_color {{ .001 .001 .001 }} ior 1 specular_ior_level 0 }}
             box room {{ material white vertex0 {{ -6 -6 0 }} vertex1 {{ 6 -6 0 }} vertex2 {{ 6 6 0 }} height 12 }}
             lamp_spot l {{ power {{ 100 100 100 }} position {{ 0 0 11.9 }} target {{ 0 0 0 }} angle_deg 9 }}
             {ball}"
        )
    };
    // All light that passes both surfaces at once lands on the floor, wherever it is focused.
    let floor = |ball: &str, photons: &str| mean(&down(11.9, photons, 16), &room(ball));
    // The spot's cone is within the ball: a radius of .63 at a distance of 7.9.
    let ball = "sphere ball { material glass center { 0 0 4 } radius .8 }";
    let without = floor("", "");
    let with = floor(ball, "photons 20");
    let share = through_ball(7.9, 0.8, 4.5_f64.to_radians());
    assert!(
        (with / without / share - 1.0).abs() < 0.01,
        "{with} of {without}: {}, expected {share}",
        with / without
    );
}

/// The share of the light of a cone of this half angle, from a distance to the middle of a ball of glass
/// of index 1.5, that passes through both surfaces at once.
fn through_ball(distance: f64, radius: f64, half_angle: f64) -> f64 {
    let steps = 2000;
    let (mut sum, mut all) = (0.0, 0.0);
    for step in 0..steps {
        let versine = (1.0 - libm::cos(half_angle)) * (f64::from(step) + 0.5) / f64::from(steps);
        let cos_angle = 1.0 - versine;
        let sin_angle = (1.0 - cos_angle * cos_angle).sqrt();
        let sin_in = distance * sin_angle / radius;
        let cos_in = (1.0 - sin_in * sin_in).max(0.0).sqrt();
        let cos_out = (1.0 - sin_in * sin_in / 2.25).sqrt();
        let s = (cos_in - 1.5 * cos_out) / (cos_in + 1.5 * cos_out);
        let p = (1.5 * cos_in - cos_out) / (1.5 * cos_in + cos_out);
        let reflected = 0.5 * (s * s + p * p);
        sum += (1.0 - reflected) * (1.0 - reflected);
        all += 1.0;
    }
    sum / all
}
