//! What hangs in what.

use slo_scene::animation::Spaces;
use slo_scene::{Files, Original, SceneDescription, SpaceId, load};

fn scene(elements: &str) -> SceneDescription {
    let text = format!("{elements}\n{}", include_str!("../scenes/minimal.txt"));
    let loaded = load("scene.txt", &text, &Files::built_in("", &[]));
    assert_eq!(loaded.diagnostics.render(false), "", "{elements}");
    loaded.scene.expect("there are no errors")
}

#[test]
fn groups_and_parents_have_spaces_and_others_have_none() {
    let scene = scene(
        "Scaling s { 2 } phong_info p { } material_phong m { phong_info p }
         sphere hand { center { 1 0 0 } radius 1 material m parent arm }
         group arm { addKframe { time 0 key { pivot { 0 0 3 } scale { 2 1 1 } } } parent lamp }
         lamp_point lamp { power { 1 1 1 } position { 0 0 0 } parent stand
             addKframe { time 0 key { pivot { 5 0 0 } } } addKframe { time 1 key { pivot { 6 0 0 } } } }
         sphere stand { center { 9 9 9 } radius 1 material m }
         sphere free { center { 9 0 9 } radius 1 material m }"
            .trim_start(),
    );
    let names: Vec<_> = scene.spaces.iter().map(|space| space.name.as_str()).collect();
    assert_eq!(names, ["arm", "lamp", "stand"]);
    let parents: Vec<_> = scene.spaces.iter().map(|space| space.parent).collect();
    assert_eq!(parents, [Some(SpaceId(1)), Some(SpaceId(2)), None]);
    let of = |name: &str| scene.objects.iter().find(|o| o.name == name).expect("it is there");
    assert_eq!((of("hand").parent, of("stand").parent), (Some(SpaceId(0)), None));
    assert_eq!((of("free").parent, scene.lights[0].parent), (None, Some(SpaceId(2))));
    // Scaling applies to pivots, and not to scales.
    let spaces = Spaces::new(&scene.spaces).expect("they are paths");
    let hand = spaces.path(&of("hand").key_frames, None, of("hand").parent).expect("it is a path");
    let place = hand.pose(0.5).point(glam::DVec3::new(2.0, 0.0, 0.0));
    assert_eq!(place, glam::DVec3::new(11.0 + 4.0, 0.0, 6.0));
    assert!(hand.moves([0.0, 1.0]) && !hand.is_rigid());
    assert_eq!(scene.check(), Ok(()));
}

#[test]
fn nesting_has_a_limit() {
    let chain = |count: usize| {
        let groups = (1..count).map(|i| format!("group g{i} {{ parent g{} }}\n", i - 1));
        let last = count - 1;
        format!(
            "group g0 {{ }}\n{} sphere ball {{ center {{ 0 0 0 }} radius 1 material m parent g{last} }}
             phong_info p {{ }} material_phong m {{ phong_info p }}",
            groups.collect::<String>()
        )
    };
    assert_eq!(scene(&chain(999)).spaces.len(), 999);
    let text = format!("{}\n{}", chain(1000), include_str!("../scenes/minimal.txt"));
    let loaded = load("scene.txt", &text, &Files::built_in("", &[]));
    let said = loaded.diagnostics.render(false);
    assert!(said.contains("more than 1000 elements hang in one another"), "{said}");
}

#[test]
fn scenes_in_memory_are_checked() {
    let sound = scene(
        "phong_info p { } material_phong m { phong_info p } group a { parent b } group b { }
         sphere s { center { 1 0 0 } radius 1 material m parent a }",
    );
    assert_eq!(sound.check(), Ok(()));
    let mut ring = sound.clone();
    ring.spaces[1].parent = Some(SpaceId(0));
    assert!(ring.check().expect_err("a ring").contains("hangs in itself"));
    // Whoever does not check gets some path, and an end.
    let spaces = Spaces::new(&ring.spaces).expect("they are paths");
    assert!(spaces.path(&[], None, Some(SpaceId(0))).is_ok());
    let mut missing = sound.clone();
    missing.objects[0].parent = Some(SpaceId(2));
    assert!(missing.check().expect_err("no space").contains("parent that is missing"));
    let mut above = sound;
    above.spaces[0].parent = Some(SpaceId(7));
    assert!(above.check().expect_err("no space").contains("parent that is missing"));
}

#[test]
fn long_chains_are_refused_in_no_time() {
    let mut text = "phong_info p { } material_phong m { phong_info p } group g0 { }".to_owned();
    for i in 1..20_000 {
        text += &format!("\ngroup g{i} {{ parent g{} }}", i - 1);
    }
    text += " sphere s { center { 1 0 0 } radius 1 material m parent g19999 }";
    let loaded = load("scene.txt", &text, &Files::built_in("", &[]));
    assert!(loaded.diagnostics.render(false).contains("more than 1000 elements hang"));
}

#[test]
fn copies_know_what_they_show() {
    let scene = scene(
        "phong_info p { } material_phong m { phong_info p } material_phong other { phong_info p }
         copy last { of street material other parent up hidden 1 }
         group up { addKframe { time 0 key { pivot { 0 0 9 } } } }
         group house { hidden 1 }
         group street { }
         sphere roof { center { 0 0 1 } radius 1 material m parent house }
         lamp_point lamp { power { 1 1 1 } position { 0 0 2 } parent house }
         copy one { of house parent street } copy two { of roof parent street }
         copy three { of lamp } copy four { of two }",
    );
    let of = |name: &str| scene.copies.iter().find(|copy| copy.name == name).expect("it is there");
    let space = |name: &str| {
        let index = scene.spaces.iter().position(|space| space.name == name);
        SpaceId(index.expect("it is there") as u32)
    };
    assert_eq!(of("last").of, [Original::Group(space("street"))]);
    assert_eq!((of("last").parent, of("last").hidden), (Some(space("up")), true));
    assert_eq!(
        of("last").material.map(|id| scene.materials[id.0 as usize].name.as_str()),
        Some("other")
    );
    assert_eq!(of("one").of, [Original::Group(space("house"))]);
    let roof = scene.objects.iter().position(|object| object.name == "roof");
    assert_eq!(of("two").of, [Original::Object(roof.expect("it is there") as u32)]);
    assert_eq!(of("three").of, [Original::Light(0)]);
    let two = scene.copies.iter().position(|copy| copy.name == "two");
    assert_eq!(of("four").of, [Original::Copy(two.expect("it is there") as u32)]);
    assert!(scene.hides(Some(space("house"))) && !scene.hides(Some(space("street"))));
    assert_eq!(scene.check(), Ok(()));
    let mut wrong = scene.clone();
    wrong.copies[0].of = vec![Original::Copy(99)];
    assert!(wrong.check().expect_err("no copy").contains("copy of what is missing"));
}
