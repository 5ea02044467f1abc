//! `--exposure`, `--tone-map` and `--encoding`: other looks of the same samples.

use super::{Folder, SCENE};

/// The picture has 1500 pixels.
fn folder(film: &str) -> Folder {
    let text = SCENE.replace("width 16 height 9", "width 50 height 30");
    Folder::with_scene(&text.replace("output PNG_IMAGE", &format!("output PNG_IMAGE {film}")))
}

/// Number of camera rays that a run traces.
fn rays(folder: &Folder, typed: &str) -> u64 {
    let said = folder.run(&format!("-v -s scene.txt {typed}")).said;
    let line =
        said.lines().find(|line| line.contains("rays: ")).unwrap_or_else(|| panic!("{said}"));
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn a_kept_state_serves_every_look() {
    let folder = folder("");
    assert_eq!(rays(&folder, "--keep-state"), 3000);
    for look in [
        "--exposure 1",
        "--exposure -1.5 --tone-map agx",
        "--tone-map AGX --encoding srgb --format png16",
        "--encoding SRGB",
        "--exposure 3 --format exr",
        "",
    ] {
        assert_eq!(rays(&folder, look), 0, "{look}");
        folder.printed(&format!("-q -s scene.txt {look} -od anew"));
        let name = if look.contains("exr") { "ball_00000.exr" } else { "ball_00000.png" };
        let bytes = folder.read(name);
        assert!(bytes == folder.read(&format!("anew/{name}")), "{look}");
        assert_eq!(folder.printed(&format!("verify {name} -s scene.txt --tiles 9")).len(), 28);
    }
}

#[test]
fn errors_are_measured_on_the_look() {
    let folder = folder("");
    assert!(rays(&folder, "--noise 0.02 --keep-state") > 1500);
    assert!(rays(&folder, "--noise 0.02 --exposure 1") > 1500, "another look, another noise");
    assert_eq!(rays(&folder, "--noise 0.02"), 0);
}

#[test]
fn recipes_name_a_look_that_is_not_the_first_one() {
    let folder = folder("exposure -2 toneMap AGX encoding SRGB");
    folder.printed("-q -s scene.txt");
    let recipe = folder.printed("--recipe ball_00000.png");
    let look = "\"encoding\": \"SRGB\",\n  \"exposure\": -2.0,\n  \"toneMap\": \"AGX\",\n";
    assert!(recipe.contains(look), "{recipe}");
    folder.printed("-q -s scene.txt --exposure 0 --tone-map none --encoding raw -od plain");
    let recipe = folder.printed("--recipe plain/ball_00000.png");
    assert!(recipe.contains("\"encoding\": \"RAW\",\n  \"seed\""), "{recipe}");
    let plain = "-q -s scene.txt --exposure 0 --tone-map none --encoding srgb --format exr";
    folder.printed(&format!("{plain} -od plain"));
    folder.printed("-q -s scene.txt --format exr");
    let same = "compare ball_00000.exr plain/ball_00000.exr --max-pixels 0";
    assert!(folder.printed(same).starts_with("pixels\t0\n"), "EXR files hold the light as it is");
    // A sequence makes the picture again.
    let found = folder.printed("-s scene.txt -f 0-0 --exposure 1 --dry-run");
    assert!(found.contains("exposure: -2.0"), "{found}");
    let run = folder.run("-s scene.txt --check");
    assert!(run.said.contains("PNG_IMAGE, SRGB, exposure -2, AGX, 25 frames"), "{}", run.said);
}

#[test]
fn parts_show_the_look_when_they_are_merged() {
    let folder = folder("exposure 1.5 toneMap AGX");
    folder.printed("-q -s scene.txt -od whole");
    let parts = [1, 2].map(|n| folder.printed(&format!("-q -s scene.txt --part {n}/2")));
    folder.printed(&format!("merge -q -od merged {}", parts.concat().replace('\n', " ")));
    assert!(folder.read("whole/ball_00000.png") == folder.read("merged/ball_00000.png"));
}

#[test]
fn looks_that_are_none_are_refused() {
    let folder = folder("");
    for (typed, said) in [
        ("--exposure 40", "expected a number of stops from -32 to 32"),
        ("--exposure bright", "expected a number of stops"),
        ("--tone-map filmic", "none, agx"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, 2, "{typed}");
        assert!(run.said.contains(said), "{}", run.said);
    }
    for (film, said) in [("exposure 99", "must be from -32 to 32"), ("toneMap AGGX", "`AGX`")] {
        let run = self::folder(film).run("-s scene.txt");
        assert_eq!(run.exit, 65, "{film}");
        assert!(run.said.contains(said), "{}", run.said);
    }
}
