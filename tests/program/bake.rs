//! `bake`: the light on objects, as images.

use std::f64::consts::PI;

use slo_picture::output::Raster;

use super::{Folder, SCENE};

/// A ball under a lamp, over a floor. The ball, the floor and a hidden wall have light maps.
fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 2 integrator PATH").replace(
        "light_point lamp { color { 1 1 1 } position { 2 -3 4 } }",
        "lamp_point lamp { power { 300 200 100 } position { 0 0 4 } }
         rectangle floor { material matte lightMap 16
             vertex0 { -4 -4 -1 } vertex1 { 4 -4 -1 } vertex2 { 4 4 -1 } }
         rectangle wall { material matte lightMap 16 hidden 1
             vertex0 { -4 -4 -1 } vertex1 { 4 -4 -1 } vertex2 { 4 -4 4 } }",
    );
    Folder::with_scene(&text.replace("radius 1 material", "radius 1 lightMap 8 material"))
}

#[test]
fn light_maps_are_files_that_are_made_once() {
    let folder = folder();
    let both = "bake scene.txt -o maps -q";
    assert_eq!(folder.printed(both), "maps/floor.exr\nmaps/ball.exr\n");
    let floor = folder.read("maps/floor.exr");
    let image = Raster::read(&folder.path().join("maps/floor.exr")).unwrap().image;
    assert_eq!((image.width, image.height), (16, 16));
    // Beside the shadow of the ball: a corner of the floor, 5 below the lamp.
    let (found, square) = (f64::from(image.rgb[0][0]), 2.0 * 3.75 * 3.75 + 25.0_f64);
    let expected = 300.0 * 5.0 / (4.0 * PI * square * square.sqrt());
    assert!((found / expected - 1.0).abs() < 0.05, "{found}, expected {expected}");
    let recipe = folder.printed("--recipe maps/floor.exr");
    assert!(recipe.contains("\"lightMap\": \"floor\"") && recipe.contains("\"width\": 16"));
    // Finished ones are left alone; a damaged one and another seed are baked.
    folder.write("maps/ball.exr", &folder.read("maps/ball.exr")[..700]);
    let again = folder.run("bake scene.txt -o maps --progress none");
    assert!(again.said.contains("`maps/floor.exr` is finished already"), "{}", again.said);
    assert!(again.said.contains("baked 1 light map in "), "{}", again.said);
    assert_eq!(again.printed, "maps/floor.exr\nmaps/ball.exr\n");
    folder.printed("bake scene.txt -o maps -q --seed 1 --object floor");
    assert!(folder.read("maps/floor.exr") != floor);
    for threads in [1, 2, 7] {
        folder.printed(&format!("bake scene.txt -od {threads} -q --threads {threads} --overwrite"));
        assert!(folder.read(&format!("{threads}/floor.exr")) == floor, "{threads}");
    }
}

#[test]
fn frames_and_formats_have_names_of_their_own() {
    let folder = folder();
    let printed = folder.printed("bake scene.txt -q -f 12 --format png --object ball");
    assert_eq!(printed, "ball_00012.png\n");
    assert!(folder.printed("--recipe ball_00012.png").contains("\"frame\": 12"));
    folder.printed("bake scene.txt -q --object floor");
    assert_eq!(folder.names(), ["ball_00012.png", "floor.exr"]);
    assert_eq!(folder.printed("relight -q floor.exr -o floor.png --exposure 2"), "floor.png\n");
    let run = folder.run("verify floor.exr -s scene.txt");
    assert!(run.exit == 65 && run.said.contains("it is a light map"), "{}", run.said);
}

#[test]
fn photons_are_shared_and_change_nothing() {
    let folder = folder();
    let more = "--integrator photon_map -q";
    folder.printed(&format!("bake scene.txt -o all {more}"));
    folder.printed(&format!("bake scene.txt -o one {more} --object ball"));
    assert!(folder.read("all/ball.exr") == folder.read("one/ball.exr"));
}

#[test]
fn mistakes_are_named() {
    let folder = folder();
    folder.write("other/floor.exr", "retouched by hand");
    folder.write("plain.txt", SCENE);
    for (typed, exit, said) in [
        ("bake scene.txt --object flor", 2, "the scene has no object `flor`"),
        ("bake scene.txt --object wall", 2, "`wall` is hidden"),
        ("bake scene.txt -f 99", 2, "choose a frame with `--frame`"),
        ("bake scene.txt -o other", 73, "slo-rt did not make the existing file"),
        ("bake plain.txt", 65, "write `lightMap 256` into each object"),
        ("bake plain.txt --object ball", 2, "`ball` has no light map"),
        ("bake none.txt", 66, "none.txt"),
        ("bake", 2, "SCENE"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
    }
    folder.printed("bake scene.txt -o other -q --overwrite");
}
