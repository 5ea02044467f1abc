//! Copies are what the same things would be if they were written in their places.

use slo_accel::Isa;
use slo_render::frame::{FrameError, FrameScene};
use slo_scene::{Copy, Original};

use crate::support::{Picture, Shot, describe, glow, material};

const LOOKS: &str = "material_principled red { base_color { .8 .2 .1 } roughness .3 }
    material_principled grey { base_color { .5 .5 .5 } }
    material_principled lit { emission_strength 4 base_color { 0 0 0 } } ";
const FLOOR: &str = "plane floor { material grey normal { 0 0 1 } position { 0 0 -1.5 } }
    environment sky { radiance { .3 .3 .4 } } ";

fn shot() -> Shot {
    let settings = "integrator PATH".to_owned();
    Shot { samples: 16, blur: 1.0, settings, ..Shot::default() }
}

/// Asserts that two pictures are the same to the last bit.
#[track_caller]
fn assert_same(a: &Picture, b: &Picture) {
    let differ = a.0.rgb.iter().zip(&b.0.rgb).filter(|(a, b)| a != b).count();
    assert!(differ == 0 && a.sum(0) > 50.0, "{differ} pixels differ, of {}", a.sum(0));
}

#[test]
fn a_copy_of_a_group_is_the_group_in_another_place() {
    let house = |group: &str, name: &str, red: &str| {
        format!(
            "box walls{name} {{ material grey vertex0 {{ 0 0 0 }} vertex1 {{ 1 0 0 }} vertex2 {{ 1 1 0 }} height 1 parent {group} }}
             mesh ball{name} {{ material {red} filename files/ball.obj smooth_normals 1 parent door{name}
                 addKframe {{ time 0 key {{ pivot {{ 0 0 1.2 }} scale {{ .4 .4 .4 }} }} }}
                 addKframe {{ time 1 key {{ pivot {{ .5 0 1.2 }} scale {{ .4 .6 .4 }} }} }} }}
             sphere lantern{name} {{ material lit center {{ -.5 0 .5 }} radius .2 parent door{name} }}
             group door{name} {{ parent {group} addKframe {{ time 0 key {{ pivot {{ .2 0 0 }} }} }} }}
             lamp_rectangle lamp{name} {{ power {{ 30 30 20 }} vertex0 {{ 0 0 2 }} vertex1 {{ 0 1 2 }} vertex2 {{ 1 1 2 }} parent {group} }}"
        )
    };
    let place =
        "addKframe { time 0 key { pivot { -1.5 0 0 } right { 1 1 0 } scale { 1.2 1.2 1.2 } } }
        addKframe { time 1 key { pivot { -1 0 .5 } right { 1 1.4 0 } } }";
    let other = "addKframe { time 0 key { pivot { 1.2 0 -1 } } }";
    let copied = format!(
        "{LOOKS} {FLOOR} group house {{ hidden 1 addKframe {{ time 0 key {{ pivot {{ 99 0 0 }} }} }} }} {}
         copy one {{ of house {place} }} copy two {{ of house {other} material grey }}",
        house("house", "", "red")
    );
    let mut written = format!(
        "{LOOKS} {FLOOR} {} {} group one {{ {place} }} group two {{ {other} }}",
        house("one", "1", "red"),
        house("two", "2", "grey")
    );
    // The material of a copy is that of everything in it.
    written = written.replace("sphere lantern2 { material lit", "sphere lantern2 { material grey");
    assert_same(&shot().take(&copied), &shot().take(&written));
    // The original is there too, unless it is hidden.
    let near = |text: &str| text.replace("pivot { 99 0 0 }", "pivot { 0 0 1 }");
    let shown = shot().take(&near(&copied).replace("hidden 1", "hidden 0"));
    let hidden = shot().take(&near(&copied));
    assert_same(&hidden, &shot().take(&copied));
    assert!(shown.0 != hidden.0);
}

#[test]
fn placements_scale_and_tint_what_they_choose() {
    // Three places, 5 apart: a ball, a box of half the size, a ball of twice the size.
    let shot = |integrator: &str| Shot {
        samples: 16,
        settings: integrator.to_owned(),
        to: vec![[5.0, 0.0, 0.0]],
        from: vec![[5.0, -30.0, 3.0]],
        ..Shot::default()
    };
    let originals = |red: &str, blue: &str| {
        format!(
            "sphere ball {{ material {red} center {{ 0 0 0 }} radius 1 hidden 1 parent away }}
             box cube {{ material {blue} vertex0 {{ -1 -1 -1 }} vertex1 {{ 1 -1 -1 }} vertex2 {{ 1 1 -1 }} height 2 hidden 1 }}
             group away {{ addKframe {{ time 0 key {{ pivot {{ 0 0 77 }} }} }} }}"
        )
    };
    let phong =
        |name: &str, [r, g, b]: [f64; 3]| material(name, &format!("diffuse {{ {r} {g} {b} }}"));
    let principled = |name: &str, [r, g, b]: [f64; 3]| {
        format!("material_principled {name} {{ base_color {{ {r} {g} {b} }} }} ")
    };
    type Named<'a> = &'a dyn Fn(&str, [f64; 3]) -> String;
    let looks: [(&str, Named<'_>, &str); 2] = [
        ("", &phong, "light_point l { color { 1 1 1 } position { 5 -30 20 } }"),
        (
            "integrator PATH",
            &principled,
            "lamp_point l { power { 300000 300000 300000 } position { 5 -30 20 } }",
        ),
    ];
    for (integrator, look, lamp) in looks {
        let base = [0.8, 0.6, 0.4];
        let copied = format!(
            "{lamp} {} {} copies row {{ of ball of cube placements files/row.ply addKframe {{ time 0 key {{ pivot {{ 0 0 1 }} }} }} }}",
            look("m", base),
            originals("m", "m")
        );
        let tinted = |tint: [f64; 3]| [0, 1, 2].map(|c| base[c] * tint[c]);
        let written = format!(
            "{lamp} {} {} {}
             sphere a {{ material m center {{ 0 0 1 }} radius 1 }}
             box b {{ material b vertex0 {{ 4.5 -.5 .5 }} vertex1 {{ 5.5 -.5 .5 }} vertex2 {{ 5.5 .5 .5 }} height 1 }}
             sphere c {{ material c center {{ 10 0 1 }} radius 2 }}",
            look("m", base),
            look("b", tinted([1.0, 0.0, 0.2])),
            look("c", tinted([0.0, 0.0, 1.0]))
        );
        let (copied, written) = (shot(integrator).take(&copied), shot(integrator).take(&written));
        // A rounding of a colour may send a ray another way.
        let far = |(a, b): &([f32; 3], [f32; 3])| (0..3).any(|c| (a[c] - b[c]).abs() > 2e-3);
        let pixels = copied.0.rgb.iter().copied().zip(written.0.rgb.iter().copied());
        let differ = pixels.filter(far).count();
        assert!(differ < 8, "{integrator}: {differ} pixels differ");
        for channel in 0..3 {
            let [a, b] = [&copied, &written].map(|picture| picture.sum(channel));
            assert!((a / b - 1.0).abs() < 1e-3, "{integrator}: {a}, expected {b}");
        }
        assert!(copied.sum(0) > 5.0 && copied.sum(2) > 5.0, "{}", copied.sum(0));
    }
}

#[test]
fn copies_of_copies_and_of_lights() {
    let dot = glow("white", [1.0; 3])
        + "sphere dot { material white center { 0 0 0 } radius .2 hidden 1 }";
    let shift = |by: [f64; 3]| {
        format!("addKframe {{ time 0 key {{ pivot {{ {} {} {} }} }} }}", by[0], by[1], by[2])
    };
    let nested = format!(
        "{dot} copy a {{ of dot {} parent two }} copy b {{ of dot {} parent two }} group two {{ hidden 1 }}
         copy c {{ of two {} parent four }} copy d {{ of two {} parent four }} group four {{ }}
         copy e {{ of four {} }} copy f {{ of e {} }}",
        shift([-0.5, 0.0, 0.0]), shift([0.5, 0.0, 0.0]), shift([0.0, 0.0, -0.5]), shift([0.0, 0.0, 0.5]),
        shift([2.5, 0.0, 0.0]), shift([-2.5, 0.0, 1.0])
    );
    let written: String = [[0.0, 0.0], [2.5, 0.0], [-2.5, 1.0]]
        .iter()
        .enumerate()
        .flat_map(|(k, [x, z])| {
            (0..4).map(move |i| {
                let (x, z) = (x + f64::from(i % 2) - 0.5, z + f64::from(i / 2) - 0.5);
                format!("sphere s{k}{i} {{ material white center {{ {x} 0 {z} }} radius .2 }}\n")
            })
        })
        .collect();
    let shot = Shot { samples: 16, ..Shot::default() };
    let [nested, written] =
        [nested, glow("white", [1.0; 3]) + &written].map(|text| shot.take(&text));
    let lit = |picture: &Picture| picture.0.rgb.iter().filter(|pixel| pixel[0] > 0.5).count();
    let differ = nested.0.rgb.iter().zip(&written.0.rgb).filter(|(a, b)| (a[0] - b[0]).abs() > 0.1);
    assert!(differ.count() == 0 && lit(&nested) > 12, "{}", lit(&nested));

    let lamps = |more: &str| {
        let text = format!(
            "{LOOKS} plane floor {{ material grey normal {{ 0 0 1 }} position {{ 0 0 -1.5 }} }}
             lamp_spot l {{ power {{ 50 50 50 }} position {{ 0 0 2 }} target {{ 0 0 0 }} angle_deg 60 radius .1 }} {more}"
        );
        self::shot().take(&text)
    };
    let written = lamps(
        "lamp_spot m { power { 50 50 50 } position { 1 0 2 } target { 1 0 0 } angle_deg 60 radius .1 }",
    );
    let copied = lamps("copy m { of l addKframe { time 0 key { pivot { 1 0 0 } } } }");
    assert!((copied.sum(0) / written.sum(0) - 1.0).abs() < 2e-3);
}

#[test]
fn rings_built_in_memory_end() {
    let text = shot().of(&format!(
        "{LOOKS} sphere s {{ material red center {{ 0 0 0 }} radius 1 }} copy c {{ of s }}"
    ));
    let mut scene = describe(&text);
    let ring = Copy { of: vec![Original::Copy(0)], ..scene.copies[0].clone() };
    scene.copies[0] = ring;
    let error = FrameScene::build(&scene, 0, Isa::Portable).map(|_| ()).unwrap_err();
    assert!(matches!(&error, FrameError::Nested { copy } if copy == "c"), "{error}");
}
