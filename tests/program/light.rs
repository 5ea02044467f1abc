//! Very bright light, and settings that have no effect on the light of a picture.

use slo_picture::output::Raster;

use super::{Folder, SCENE};

/// A camera that sees nothing but the disc of a sun of this radiance.
fn sun(radiance: f64) -> Folder {
    let sine = libm::sin(5f64.to_radians());
    let irradiance = radiance * std::f64::consts::PI * sine * sine;
    let lamp = format!(
        "lamp_sun l {{ irradiance {{ {irradiance} {irradiance} 1 }} direction {{ 0 5 -1 }} angle_deg 10 }}"
    );
    let text = SCENE
        .replace("imageSamples 2", "integrator PATH imageSamples 65535")
        .replace("width 16 height 9", "width 2 height 1")
        .replace("PNG_IMAGE", "EXR_IMAGE")
        .replace(
            "addPosition { 0 -5 1 } addTarget { 0 0 0 }",
            "addPosition { 0 0 0 } addTarget { 0 -5 1 }",
        )
        .replace("fovStart 0.4", "fovStart 0.001")
        .replace("light_point lamp { color { 1 1 1 } position { 2 -3 4 } }", &lamp)
        .replace("center { 0 0 0 }", "center { 0 90 0 }");
    Folder::with_scene(&text)
}

fn check_radiance(folder: &Folder, name: &str, radiance: f32) {
    for [red, green, _] in Raster::read(&folder.path().join(name)).unwrap().image.rgb {
        assert!((red / radiance - 1.0).abs() < 1e-5, "{red}");
        assert_eq!(red, green);
    }
}

#[test]
fn the_brightest_sun_fits_into_every_kind_of_picture() {
    let folder = sun(1e7);
    let run = folder.run("-s scene.txt --keep-state");
    assert!(run.exit == 0 && !run.said.contains("too bright"), "{}", run.said);
    check_radiance(&folder, "ball_00000.exr", 1e7);
    // The state serves another file.
    let whole = folder.read("ball_00000.exr");
    folder.printed("-q -s scene.txt --keep-state --exposure -20 --format png");
    folder.printed("-q -s scene.txt --keep-state");
    assert!(folder.read("ball_00000.exr") == whole);
    let parts = [1, 2, 3].map(|number| {
        folder.printed(&format!("-q -s scene.txt --part {number}/3 --part-by samples -od p"))
    });
    let parts = parts.map(|part| part.trim_end().to_owned()).join(" ");
    assert_eq!(folder.printed(&format!("merge -q -od m {parts}")), "m/ball_00000.exr\n");
    assert!(folder.read("m/ball_00000.exr") == whole);
}

#[test]
fn brighter_light_is_clamped_and_counted() {
    let folder = sun(1e9);
    let run = folder.run("-s scene.txt --samples 4");
    assert!(
        run.said.contains("16 samples were too bright for the film and were clamped"),
        "{}",
        run.said
    );
    check_radiance(&folder, "ball_00000.exr", 16_777_216.0);
}

#[test]
fn pixels_that_are_full_are_counted() {
    let folder = sun(1e9);
    let text = String::from_utf8(folder.read("scene.txt")).unwrap();
    folder.write("scene.txt", text.replace("PATH imageSamples", "PATH dofSamples 2 imageSamples"));
    let run = folder.run("-s scene.txt");
    assert!(run.said.contains("2 pixels are brighter than the film can add up"), "{}", run.said);
    check_radiance(&folder, "ball_00000.exr", (1u64 << 40) as f32 / 131_070.0);
}

#[test]
fn warnings_are_about_the_integrator_that_renders() {
    let ambient = "`ambient` does nothing under `integrator PATH`";
    let folder = Folder::new();
    for (options, is_told) in [("", false), ("--integrator path", true)] {
        let run = folder.run(&format!("-s scene.txt --check {options}"));
        assert_eq!((run.exit, run.said.contains(ambient)), (0, is_told), "{options}: {}", run.said);
    }
    folder.write("path.txt", SCENE.replace("settings s {", "settings s { integrator PATH"));
    for (options, is_told) in [("", true), ("--integrator distributed", false)] {
        let run = folder.run(&format!("-s path.txt --check {options}"));
        assert_eq!((run.exit, run.said.contains(ambient)), (0, is_told), "{options}: {}", run.said);
    }
    let run = folder.run("-s scene.txt --format exr --layers lights");
    assert!(run.said.contains("there is no light group to keep apart"), "{}", run.said);
}
