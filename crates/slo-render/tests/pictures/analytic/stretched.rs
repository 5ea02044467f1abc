//! Things that are scaled, or hang in others.

use std::f64::consts::TAU;

use glam::DVec3;
use slo_accel::Isa;
use slo_render::frame::{FrameError, FrameScene, LampFault};
use slo_scene::shape::MeshSurface;
use slo_scene::{Mesh, SceneDescription, Shape};

use crate::support::{
    Picture, Shot, assert_profile, describe, expose, glow, material, over_pixel, panel_corners,
    rectangle, vector,
};

/// Size of a pixel in the plane through the origin, in the default shot.
const PX: f64 = 10.0 * 0.5 / 32.0;

fn path_shot(samples: u32) -> Shot {
    let settings = "integrator PATH".to_owned();
    Shot { samples, settings, blur: 1.0, ..Shot::default() }
}

/// A key frame with a scale.
fn scaled(time: f64, scale: [f64; 3]) -> String {
    format!("addKframe {{ time {time} key {{ scale {} }} }}", vector(scale))
}

fn picture(scene: &SceneDescription) -> Picture {
    Picture(expose(scene, Isa::best()).image())
}

/// Greatest difference of any 4 x 4 pixels.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let block = |of: &Picture, i: usize| {
        let pixel = |k: usize| of.at(i % 16 * 4 + k % 4, i / 16 * 4 + k / 4);
        (0..16).map(|k| pixel(k).iter().sum::<f64>() / 48.0).sum::<f64>()
    };
    (0..256).map(|i| (block(a, i) - block(b, i)).abs()).fold(0.0, f64::max)
}

/// A smooth mesh of the unit sphere, scaled along its axes.
fn ellipsoid(scale: DVec3) -> Shape {
    const AROUND: u32 = 192;
    const ALONG: u32 = 96;
    let mut mesh = Mesh::default();
    for i in 0..=ALONG {
        for k in 0..AROUND {
            let (s, c) = libm::sincos(TAU * f64::from(k) / f64::from(AROUND));
            let (r, z) = libm::sincos(TAU * 0.5 * f64::from(i) / f64::from(ALONG));
            let p = DVec3::new(r * c, r * s, -z);
            mesh.positions.push(p * scale);
            mesh.normals.push((p / scale).normalize().as_vec3().to_array());
        }
    }
    for i in 0..ALONG {
        for k in 0..AROUND {
            let at = |i, k| i * AROUND + k % AROUND;
            let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Shape::Mesh(MeshSurface::new(mesh, true))
}

#[test]
fn an_ellipsoid_is_what_a_mesh_of_it_is() {
    let scale = [2.0, 0.7, 1.2];
    let ball = |material: &str, keys: &str| {
        format!("sphere ball {{ material {material} center {{ 0 0 0 }} radius 1 {keys} }}")
    };
    let key = |time: f64, x: f64, scale: &str| {
        format!(
            "addKframe {{ time {time} key {{ pivot {{ {x} 0 0.5 }} right {{ 1 1 0.3 }}
             up {{ -1 0.4 2 }} {scale} }} }}"
        )
    };
    let grown = format!("scale {}", vector(scale));
    for (surface, settings) in [
        (
            "material_principled m { roughness .3 metallic 1 base_color { .9 .6 .2 } }",
            "integrator PATH",
        ),
        ("material_principled m { base_color { .8 .5 .2 } }", "integrator PATH"),
        (
            "phong_info i { diffuse { .6 .6 .5 } reflectance .3 } material_phong m { phong_info i }",
            "",
        ),
    ] {
        let lamp = match settings {
            "" => {
                "light_rectangle l { color { 1 1 1 } vertex0 { -2 -4 6 } vertex1 { 2 -4 6 } vertex2 { 2 -2 6 } }"
            }
            _ => {
                "lamp_rectangle l { power { 900 900 900 } vertex0 { -2 -4 6 } vertex1 { -2 -2 6 } vertex2 { 2 -2 6 } }"
            }
        };
        let around = format!(
            "{surface} {lamp} material_principled grey {{ base_color {{ .5 .5 .5 }} }}
             {} plane floor {{ material {} normal {{ 0 0 1 }} position {{ 0 0 -1.5 }} }}",
            material("paper", "diffuse { .5 .5 .5 }"),
            if settings.is_empty() { "paper" } else { "grey" },
        );
        let settings = format!("{settings} background {{ .1 .2 .3 }}");
        for (end, blur) in [(0.0, 0.0), (0.8, 1.0)] {
            let shot = Shot { samples: 32, settings: settings.clone(), blur, ..Shot::default() };
            let keys = |scale: &str| {
                if blur > 0.0 {
                    key(0.0, 0.0, scale) + &key(1.0, end, scale)
                } else {
                    key(0.0, 0.0, scale)
                }
            };
            let text = shot.of(&(around.clone() + &ball("m", &keys(&grown))));
            let exact = describe(&text);
            let mut scaled_mesh = exact.clone();
            let mut ready = describe(&shot.of(&(around.clone() + &ball("m", &keys("")))));
            let index = exact.objects.iter().position(|o| o.name == "ball").expect("it is there");
            scaled_mesh.objects[index].shape = ellipsoid(DVec3::ONE);
            ready.objects[index].shape = ellipsoid(scale.into());
            let [exact, scaled_mesh, ready] =
                [exact, scaled_mesh, ready].map(|scene| picture(&scene));
            // Noise where a reflection takes another way; shading of a coarse surface.
            let far = difference(&exact, &ready);
            assert!(far < 0.05, "{surface} {blur}: {far} between a sphere and a mesh");
            let far = difference(&scaled_mesh, &ready);
            assert!(far < 0.03, "{surface} {blur}: {far} between two meshes");
            let mean = [&exact, &scaled_mesh, &ready].map(|picture| picture.sum(0));
            assert!((mean[0] / mean[2] - 1.0).abs() < 4e-3, "{surface}: {mean:?}");
            assert!((mean[1] / mean[2] - 1.0).abs() < 1e-3, "{surface}: {mean:?}");
        }
    }
}

#[test]
fn stretched_mirrors_never_hit_themselves() {
    // A convex mirror in a world of light 1 shows 1 after one bounce.
    for keys in [
        scaled(0.0, [100.0, 1.0, 0.02]),
        scaled(0.0, [1.5, 0.3, 1.0]) + &scaled(1.0, [0.2, 2.0, 1.4]),
        scaled(0.0, [1e-9, 1.0, 1.0]),
        scaled(0.0, [1e-9, 1e-9, 1e-9]) + &scaled(1.0, [1e3, 1e-6, 2.0]),
    ] {
        for shape in [
            "sphere s { material m parent far center { 0.1 0.2 0.3 } radius 1",
            "cylinder s { material m parent far base { 0 0 -1 } top { 0 0 1 } radius 1",
            "cone s { material m parent far base { 0 0 -1 } apex { 0 0.3 1 } radius 1",
            "box s { material m parent far vertex0 { 0 0 0 } vertex1 { 1 0 0 } vertex2 { 1 1 0 } height 1",
            "mesh s { material m parent far filename files/ball.obj smooth_normals 0",
        ] {
            let far = "group far { addKframe { time 0 key { pivot { 9000 -4000 3000 } right { 1 2 3 } up { 1 -1 2 } scale { 3 1 1 } } } }";
            let elements = material("m", "reflectance 1") + far + &format!("{shape} {keys} }}");
            let shot = Shot {
                from: vec![[9000.0, -4010.0, 3000.0]],
                to: vec![[9000.0, -4000.0, 3000.0]],
                settings: "background { 1 1 1 }".into(),
                recursion: 1,
                samples: 8,
                blur: 1.0,
                plain: true,
                ..Shot::default()
            };
            shot.take(&elements).assert_is([1.0; 3], 1e-6);
        }
    }
}

#[test]
fn a_growing_ball_covers_a_pixel_from_when_it_reaches_it() {
    let ball = |keys: &str| {
        glow("white", [1.0; 3])
            + &format!("sphere s {{ material white center {{ 0 0 0 }} radius 1 {keys} }}")
    };
    let keys = scaled(0.0, [0.5; 3]) + &scaled(1.0, [2.0; 3]);
    let shot = Shot { blur: 1.0, samples: 256, ..Shot::default() };
    let found = shot.take(&ball(&keys)).row(31, 0);
    // From 10 away, a ball of radius R is seen within R / sqrt(100 - R²).
    let seen = |x: f64, y: f64| {
        let slope = 0.5 * x.hypot(y);
        let radius = 10.0 * slope / (1.0 + slope * slope).sqrt();
        1.0 - ((radius - 0.5) / 1.5).clamp(0.0, 1.0)
    };
    let expected: Vec<_> = (0..64).map(|x| over_pixel(x, 31, seen)).collect();
    assert_profile(&found, &expected, 0.015);
}

/// Mean place of what glows, in pixels from the middle.
fn middle(picture: &Picture) -> [f64; 2] {
    let (mut sum, mut place) = (0.0, [0.0; 2]);
    for (i, pixel) in picture.0.rgb.iter().enumerate() {
        let weight = f64::from(pixel[0]);
        sum += weight;
        place[0] += weight * (i % 64) as f64;
        place[1] += weight * (i / 64) as f64;
    }
    [place[0] / sum - 31.5, 31.5 - place[1] / sum]
}

#[test]
fn a_moon_hangs_in_a_planet_that_hangs_in_a_sun() {
    // Turns by a quarter about y: right goes from x to z.
    let turn = |by: f64| {
        let key = |time: f64, turns: f64| {
            let (s, c) = libm::sincos(TAU * turns);
            format!(
                "addKframe {{ time {time} key {{ right {{ {c} 0 {s} }} up {{ {} 0 {c} }} }} }} ",
                -s
            )
        };
        (0..=8).map(|i| key(f64::from(i) / 8.0, by * f64::from(i) / 8.0)).collect::<String>()
    };
    let scene =
        |blur: f64, start: f64| {
            let elements =
                glow("white", [1.0; 3])
                    + &format!(
                "sphere moon {{ material white center {{ {} 0 0 }} radius {} parent planet }}
                 group planet {{ {} parent orbit }}
                 group orbit {{ addKframe {{ time 0 key {{ pivot {{ {} 0 0 }} }} }} parent sun }}
                 group sun {{ {} }}",
                6.0 * PX, 2.0 * PX, turn(0.5), 18.0 * PX, turn(0.25)
            );
            let shot = Shot { blur, samples: 256, ..Shot::default() };
            let text = shot.of(&elements).replace("sceneStart 0", &format!("sceneStart {start}"));
            picture(&describe(&text))
        };
    // The sun turns by a quarter in a second, and the planet in it by half a turn.
    let place = |time: f64| {
        let [sun, planet] = [0.25, 0.75].map(|turns| libm::sincos(TAU * turns * time));
        [18.0 * sun.1 + 6.0 * planet.1, 18.0 * sun.0 + 6.0 * planet.0]
    };
    for time in [0.0, 0.125, 0.5, 0.75] {
        let (found, expected) = (middle(&scene(0.0, time)), place(time));
        for axis in 0..2 {
            assert!(
                (found[axis] - expected[axis]).abs() < 0.05,
                "{found:?} {expected:?} at {time}"
            );
        }
    }
    // Linear between key frames: an eighth of a turn is a chord, off the circle by a little.
    let found = middle(&scene(1.0, 0.0));
    for axis in 0..2 {
        let mean = (0..1000).map(|k| place((f64::from(k) + 0.5) / 1e3)[axis]).sum::<f64>() / 1e3;
        assert!((found[axis] - mean).abs() < 0.15, "{found:?} {mean}");
    }
}

#[test]
fn what_spins_in_a_stretched_space_is_sheared() {
    // A ball that spins in a space twice as wide stays an ellipse twice as wide as high; a square
    // becomes a rhombus half way between its sides, of the same area.
    let spin = "addKframe { time 0 key { right { 1 0 0 } up { 0 0 1 } } }
        addKframe { time 1 key { right { 0 0 1 } up { -1 0 0 } } }";
    let shot = Shot { blur: 1.0, samples: 64, ..Shot::default() };
    let group = format!("group wide {{ {} }}", scaled(0.0, [2.0, 1.0, 1.0]));
    let hung = |keys: &str| {
        let ball = format!(
            "sphere s {{ material white center {{ 0 0 0 }} radius {} parent wide {keys} }}",
            10.0 * PX
        );
        shot.take(&(glow("white", [1.0; 3]) + &group + &ball))
    };
    let (spinning, still) = (hung(spin), hung(""));
    assert!(difference(&spinning, &still) < 0.02);
    assert!((still.sum(0) / (200.0 * 0.5 * TAU) - 1.0).abs() < 0.03, "{}", still.sum(0));
    let half = "addKframe { time 0 key { right { 1 0 1 } up { -1 0 1 } } }";
    let corners = panel_corners([-7.0 * PX, 7.0 * PX], 0.0, [-7.0 * PX, 7.0 * PX]);
    let square = rectangle("s", "white", corners, &format!("parent wide {half}"));
    let rhombus = shot.take(&(glow("white", [1.0; 3]) + &group + &square));
    assert!((rhombus.sum(0) / (2.0 * 14.0 * 14.0) - 1.0).abs() < 0.01, "{}", rhombus.sum(0));
    // Its corners lie at 7 sqrt(2) up and down, and twice as far to the sides.
    for (x, y, value) in
        [(15.0, 0.0, 1.0), (21.5, 0.0, 0.0), (0.0, 8.0, 1.0), (0.0, 11.0, 0.0), (12.0, 6.5, 0.0)]
    {
        let pixel = rhombus.at((31.5 + x) as usize, (31.5 - y) as usize)[0];
        assert_eq!(pixel, value, "{x} {y}");
    }
}

const FLOOR: &str = "material_principled grey { base_color { .5 .5 .5 } }
    plane floor { material grey normal { 0 0 1 } position { 0 0 -1.5 } } ";

#[test]
fn lamps_grow_with_their_space_and_keep_their_power() {
    let near = |a: &str, b: &str| {
        let [a, b] = [a, b].map(|lamp| path_shot(64).take(&(FLOOR.to_owned() + lamp)));
        let far = difference(&a, &b);
        assert!(
            far < 0.02 && (a.sum(0) / b.sum(0) - 1.0).abs() < 2e-3,
            "{far} {}",
            a.sum(0) / b.sum(0)
        );
    };
    let moving = "addKframe { time 0 key { pivot { 0 0 0 } } } addKframe { time 1 key { pivot { 1 0 0 } right { 1 1 0 } } }";
    for keys in ["", moving] {
        let group = |scale: [f64; 3]| {
            format!("group g {{ {} parent h }} group h {{ {keys} }} ", scaled(0.0, scale))
        };
        let hung = "parent g";
        let plain = |lamp: &str| match keys {
            "" => format!("{lamp} }}"),
            _ => format!("{lamp} parent h }} group h {{ {keys} }}"),
        };
        near(
            &format!(
                "{} lamp_rectangle l {{ power {{ 99 99 99 }} vertex0 {{ -1 0 2 }} vertex1 {{ -1 1 2 }} vertex2 {{ 1 1 2 }} {hung} }}",
                group([2.0, 3.0, 1.0])
            ),
            &plain(
                "lamp_rectangle l { power { 99 99 99 } vertex0 { -2 0 2 } vertex1 { -2 3 2 } vertex2 { 2 3 2 }",
            ),
        );
        near(
            &format!(
                "{} lamp_disc l {{ power {{ 99 99 99 }} center {{ 0 .5 1 }} normal {{ 0 0 -1 }} radius .5 {hung} }}",
                group([2.0, 2.0, 3.0])
            ),
            &plain("lamp_disc l { power { 99 99 99 } center { 0 1 3 } normal { 0 0 -1 } radius 1"),
        );
        near(
            &format!(
                "{} lamp_spot l {{ power {{ 99 99 99 }} position {{ 0 .5 1 }} target {{ 0 0 0 }} radius .5 angle_deg 60 {hung} }}",
                group([2.0, 2.0, 3.0])
            ),
            &plain(
                "lamp_spot l { power { 99 99 99 } position { 0 1 3 } target { 0 0 0 } radius .5 angle_deg 60",
            ),
        );
        near(
            &format!(
                "{} lamp_sun l {{ irradiance {{ 2 2 2 }} direction {{ 1 0 -1 }} {hung} }}",
                group([2.0, 2.0, 3.0])
            ),
            &plain("lamp_sun l { irradiance { 2 2 2 } direction { 2 0 -3 }"),
        );
    }
}

#[test]
fn lamps_that_lose_their_shape_are_errors() {
    let lamp = |more: &str, keys: &str| {
        let text = format!(
            "{FLOOR} lamp_rectangle l {{ power {{ 9 9 9 }} vertex0 {{ -1 0 2 }} vertex1 {{ -1 1 2 }} vertex2 {{ 1 1 2 }} {more} parent g }} group g {{ {keys} }}"
        );
        let scene = describe(&path_shot(1).of(&text));
        FrameScene::build(&scene, 0, Isa::Portable).map(|_| ())
    };
    let turned = "addKframe { time 0 key { right { 1 1 0 } } }";
    let fault = |found: Result<(), FrameError>| match found {
        Err(FrameError::Lamp { lamp, reason }) if lamp == "l" => reason,
        other => panic!("{other:?}"),
    };
    assert_eq!(fault(lamp(turned, &scaled(0.0, [2.0, 1.0, 1.0]))), LampFault::Sheared);
    let grows = scaled(0.0, [1.0; 3]) + &scaled(1.0, [2.0; 3]);
    assert_eq!(fault(lamp("", &grows)), LampFault::Grows);
    assert!(lamp("", &scaled(0.0, [2.0, 1.0, 1.0])).is_ok());
    let tiny = (0..3).map(|i| {
        format!("group g{i} {{ {} parent {} }} ", scaled(0.0, [1e-6; 3]), ["g1", "g2", "h"][i])
    });
    let text = format!(
        "{FLOOR} group h {{ }} {} sphere s {{ material grey center {{ 0 0 0 }} radius 1 parent g0 }}",
        tiny.collect::<String>()
    );
    let scene = describe(&path_shot(1).of(&text));
    let error = FrameScene::build(&scene, 0, Isa::Portable).map(|_| ()).unwrap_err();
    assert!(matches!(&error, FrameError::Extent { object } if object == "s"), "{error}");
}

#[test]
fn things_that_glow_are_as_bright_as_they_are_large() {
    let tile = |x: f64, y: f64, more: &str| {
        let corners = [[-x, -y, 0.0], [-x, y, 0.0], [x, y, 0.0]];
        "material_principled lit { emission_strength 5 base_color { 0 0 0 } } ".to_owned()
            + FLOOR
            + &rectangle("tile", "lit", corners, more)
            + "sphere ball { material lit center { 3 1 0 } radius .5 parent up }"
    };
    let up = "group up { addKframe { time 0 key { pivot { 0 0 1 } } } addKframe { time 1 key { pivot { 1 0 2 } right { 1 1 0 } } } }";
    // Stretched and moving, without a change of size: as a tile of that size.
    let hung = format!("{} parent up", scaled(0.0, [2.0, 0.5, 1.0]));
    let shot = path_shot(64);
    let stretched = shot.take(&(tile(1.0, 1.0, &hung) + up));
    let plain = shot.take(&(tile(2.0, 0.5, "parent up") + up));
    assert!(difference(&stretched, &plain) < 0.02);
    assert!((stretched.sum(0) / plain.sum(0) - 1.0).abs() < 1e-3);
    // Growing: the mean of all sizes.
    let place =
        |z: &str| format!("group up {{ addKframe {{ time 0 key {{ pivot {{ 0 0 1 }} {z} }} }} }}");
    let grows = scaled(0.0, [0.5; 3]) + &scaled(1.0, [2.0; 3]);
    let shot = path_shot(128);
    let growing = shot.take(&(tile(1.0, 1.0, &format!("{grows} parent up")) + &place("")));
    let sizes = 8;
    let one = |k: u32| {
        let size = 0.5 + 1.5 * (f64::from(k) + 0.5) / f64::from(sizes);
        path_shot(32).take(&(tile(size, size, "parent up") + &place(""))).sum(0)
    };
    let mean = (0..sizes).map(one).sum::<f64>() / f64::from(sizes);
    assert!((growing.sum(0) / mean - 1.0).abs() < 0.01, "{} {mean}", growing.sum(0));
}
