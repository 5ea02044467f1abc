//! `--layers lights` and `relight`.

use std::path::Path;

use slo_picture::film::{FileLayer, Image};
use slo_picture::output::{Picture, Raster, read_layers, read_recipe, with_denoiser};
use slo_scene::{Look, OutputFormat};

use super::{Folder, SCENE};

/// A ball under three lamps, of the groups `key`, `rim` and none.
fn folder() -> Folder {
    let lamps = "lamp_point key { power { 200 100 50 } position { 2 -3 4 } light_group key }
         lamp_point rim { power { 50 60 200 } position { -3 -4 1 } light_group rim }
         light_point lamp";
    let text = SCENE.replace("width 16 height 9", "width 40 height 36");
    let text = text.replace("imageSamples 2", "integrator PATH imageSamples 2");
    Folder::with_scene(&text.replace("light_point lamp", lamps))
}

/// Names of the channels of an EXR file.
fn channels(bytes: &[u8]) -> Vec<String> {
    let meta = exr::meta::MetaData::read_from_buffered(bytes, false).unwrap();
    meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect()
}

/// Checks that every group has light, and that the groups add up to the picture.
fn check_sums(path: &Path) {
    let image = Raster::read(path).unwrap().image;
    let layers = read_layers(path).unwrap();
    assert_eq!(layers.len(), 3);
    let mut sum = vec![[0.0; 3]; image.rgb.len()];
    for (layer, light) in &layers {
        let has_light = light.rgb.iter().any(|rgb| rgb.iter().all(|c| *c > 0.01));
        assert!(has_light, "{layer:?} is dark");
        for (sum, light) in sum.iter_mut().zip(&light.rgb) {
            (0..3).for_each(|c| sum[c] += f64::from(light[c]));
        }
    }
    for (sum, whole) in sum.iter().zip(&image.rgb) {
        for c in 0..3 {
            assert!((sum[c] - f64::from(whole[c])).abs() < 1e-6, "{sum:?} {whole:?}");
        }
    }
}

#[test]
fn files_have_a_layer_for_each_group() {
    let folder = folder();
    let lights = "-q -s scene.txt --format exr --layers lights";
    assert_eq!(folder.printed(lights), "ball_00000.exr\n");
    let whole = folder.read("ball_00000.exr");
    let names = channels(&whole);
    let groups: Vec<&str> =
        names.iter().filter_map(|name| name.strip_prefix("lights.")?.strip_suffix(".G")).collect();
    assert_eq!((groups, names.len()), (vec!["key", "rest", "rim"], 12));
    check_sums(&folder.path().join("ball_00000.exr"));
    assert!(folder.printed("--recipe ball_00000.exr").contains("\"layers\": [\"lights\"]"));
    let verified = folder.printed("verify ball_00000.exr -s scene.txt --tiles 99");
    assert_eq!(verified, "same\tball_00000.exr\t4 tiles\n");
    let parts = ["1/2", "2/2"].map(|part| folder.printed(&format!("{lights} --part {part}")));
    folder.printed(&format!("merge -q -od merged {}", parts.concat().replace('\n', " ")));
    assert!(folder.read("merged/ball_00000.exr") == whole);
    folder.printed(&format!("{lights} --samples 1 --keep-state -od more"));
    folder.printed(&format!("{lights} --samples 2 -od more"));
    folder.printed(&format!("{lights} --samples 2 -od anew"));
    assert!(folder.read("more/ball_00000.exr") == folder.read("anew/ball_00000.exr"));
    let run = folder.run("-s scene.txt --format exr --samples 2 -od more");
    assert!(run.said.contains("it has layers of lights, but this run does"), "{}", run.said);
    folder.printed("-q -s scene.txt --format exr -od plain");
    let same = "compare ball_00000.exr plain/ball_00000.exr --max-pixels 0";
    assert!(folder.printed(same).starts_with("pixels\t0\n"), "layers change no colour");
}

/// Writes `lit.exr`: a rendered picture whose layers are known. A quarter of its light is of the group
/// `key`, and the rest of none.
fn lit(folder: &Folder) -> Image {
    folder.printed("-q -s scene.txt --format exr --layers lights");
    let path = folder.path().join("ball_00000.exr");
    let image = Raster::read(&path).unwrap().image;
    let share = |factor: f32| {
        let rgb = image.rgb.iter().map(|rgb| rgb.map(|c| c * factor)).collect();
        Image { rgb, ..image.clone() }
    };
    let layer = |name: &str, factor| (FileLayer::Light(name.to_owned()), share(factor));
    let layers = [layer("key", 0.25), layer("rest", 0.75)];
    let recipe = read_recipe(&path).unwrap();
    let (format, look) = (OutputFormat::Exr, Look::default());
    let picture = Picture { image: &image, format, look, recipe: &recipe, crop: None };
    picture.save_with(&folder.path().join("lit.exr"), &layers).unwrap();
    image
}

#[test]
fn groups_are_dimmed_and_coloured() {
    let folder = folder();
    let image = lit(&folder);
    let relit = |typed: &str, factors: [f32; 3]| {
        folder.printed(&format!("relight -q lit.exr {typed} -o out.exr"));
        let found = Raster::read(&folder.path().join("out.exr")).unwrap().image;
        for (found, old) in found.rgb.iter().zip(&image.rgb) {
            for c in 0..3 {
                let expected = old[c] * factors[c];
                assert!((found[c] - expected).abs() <= 1e-6 * expected.abs(), "{typed}");
            }
        }
    };
    relit("", [1.0; 3]);
    relit("--group key=1", [1.0; 3]);
    relit("--group key=0", [0.75; 3]);
    relit("-g key=3 -g rest=50%", [1.125; 3]);
    relit("--group rest=1,0,2 --group key=4", [1.75, 1.0, 2.5]);
    // The layers of the result add up to it, so they can be relit by other programs.
    assert!(channels(&folder.read("out.exr")).contains(&"lights.key.B".to_owned()));
    let recipe = folder.printed("--recipe out.exr");
    assert!(recipe.contains("\"relit\": \"rest=1,0,2; key=4\""), "{recipe}");
    assert!(recipe.contains("\"sceneBlake3\""), "{recipe}");
    for (typed, said) in [
        ("verify out.exr -s scene.txt", "it is relit; verify the picture that"),
        ("relight out.exr -o again.exr", "it is relit already"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, 65, "{typed}");
        assert!(run.said.contains(said), "{}", run.said);
    }
}

#[test]
fn another_look_is_as_if_it_had_been_rendered() {
    let folder = folder();
    folder.printed("-q -s scene.txt --format exr --layers lights");
    let look = "--exposure 0.5 --tone-map agx --encoding srgb";
    assert_eq!(folder.printed(&format!("relight -q ball_00000.exr {look} -o a.png")), "a.png\n");
    folder.printed(&format!("-q -s scene.txt {look}"));
    let same = folder.printed("compare a.png ball_00000.png --max-pixels 0");
    assert!(same.starts_with("pixels\t0\n"), "{same}");
    assert!(folder.printed("verify a.png -s scene.txt").starts_with("same\ta.png\t"));
    // A sequence finds it finished.
    let seen = format!("relight -q ball_00000.exr {look} --format png -od seen");
    assert_eq!(folder.printed(&seen), "seen/ball_00000.png\n");
    let found = folder.printed(&format!("-s scene.txt -f 0-0 {look} -od seen --dry-run"));
    assert_eq!(found, "0\tseen/ball_00000.png\tfinished\n");
    folder.printed("relight ball_00000.exr --format png16 -o deep.png");
    assert!(folder.printed("--recipe deep.png").contains("PNG16_IMAGE"));
    assert_eq!(folder.printed("relight -q ball_00000.exr"), "ball_00000_relit.exr\n");
}

#[test]
fn a_denoised_picture_gets_another_look_only() {
    let folder = folder();
    folder.printed("-q -s scene.txt --format exr --layers lights");
    let path = folder.path().join("ball_00000.exr");
    let (image, layers) = (Raster::read(&path).unwrap().image, read_layers(&path).unwrap());
    let recipe = with_denoiser(&read_recipe(&path).unwrap(), "a denoiser");
    let (format, look) = (OutputFormat::Exr, Look::default());
    let picture = Picture { image: &image, format, look, recipe: &recipe, crop: None };
    picture.save_with(&folder.path().join("clean.exr"), &layers).unwrap();
    let look = "--exposure 0.5 --tone-map agx";
    for name in ["ball_00000", "clean"] {
        folder.printed(&format!("relight -q {name}.exr {look} -o {name}.png"));
    }
    let same = folder.printed("compare clean.png ball_00000.png --max-pixels 0");
    assert!(same.starts_with("pixels\t0\n"), "{same}");
    assert!(folder.printed("--recipe clean.png").contains("\"denoised\": \"a denoiser\""));
    let run = folder.run("relight clean.exr -g key=2 -o b.exr");
    assert_eq!(run.exit, 65);
    assert!(run.said.contains("still holds the noise"), "{}", run.said);
}

#[test]
fn mistakes_are_named() {
    let folder = folder();
    lit(&folder);
    folder.printed("-q -s scene.txt");
    folder.printed("-q -s scene.txt -f 1 --format exr");
    folder.write("other.png", "retouched by hand");
    for (typed, exit, said) in [
        ("relight lit.exr -g kye=1 -o a.png", 2, "has no group of lights `kye`"),
        ("relight lit.exr -g kye=1 -o a.png", 2, "its groups are `key`, `rest`"),
        ("relight lit.exr -g key=1 -g key=2 -o a.png", 2, "name the same group"),
        ("relight lit.exr -g key -o a.png", 2, "such as key=0.5 or key=1,0.8,0.6"),
        ("relight lit.exr -o a.jpg", 2, "`a.jpg` does not end in .png or .exr"),
        ("relight lit.exr -o a.exr --format png", 2, "`a.exr` does not end in .png"),
        ("relight lit.exr -o lit.exr", 2, "would be replaced by its relit copy"),
        ("relight lit.exr ball_00001.exr -o a.png", 2, "name a folder with `--outdir`"),
        ("relight lit.exr -o other.png", 73, "slo-rt did not make the existing file"),
        ("relight ball_00001.exr -g key=1 -o a.png", 65, "--layers lights"),
        ("relight ball_00000.png -o a.png", 65, "relighting needs linear ones"),
        ("relight none.exr -o a.png", 66, "can't read `none.exr`"),
        ("relight scene.txt -o a.png", 65, "not a PNG or EXR picture"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
        assert!(!folder.names().contains(&"a.png".to_owned()), "{typed}");
    }
    assert_eq!(folder.read("other.png"), b"retouched by hand");
}
