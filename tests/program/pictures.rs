//! Command lines that succeed.

use std::fs;

use super::{Folder, SCENE};

fn size(png: &[u8]) -> (u32, u32) {
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    (reader.info().width, reader.info().height)
}

#[test]
fn without_a_scene_the_one_inside_is_rendered_anywhere() {
    let folder = Folder::new();
    let printed = folder.printed("--size 32x18 --samples 1");
    let name = printed.strip_suffix('\n').unwrap();
    assert!(name.ends_with("00000.png"), "{name}");
    assert_eq!(folder.names(), [name]);
    assert_eq!(size(&folder.read(name)), (32, 18));
}

#[test]
fn the_command_lines_of_the_thesis() {
    let folder = Folder::new();
    folder.write("input/scenes/animace.txt", SCENE);
    folder.write("animace.txt", SCENE);
    assert_eq!(folder.printed("--scene animace.txt"), "ball_00000.png\n");
    assert_eq!(folder.printed("-s animace.txt --frame 5"), "ball_00005.png\n");
    let long = folder.printed("-f 15 -s animace.txt -id input/scenes -od output/animace");
    assert_eq!(long, "output/animace/ball_00015.png\n");
    let prefixed = folder.printed("-f 15 -s animace.txt -id=input/scenes -pre=x -od=output");
    assert_eq!(prefixed, "output/x00015.png\n");
    let spelled = folder.printed("-s animace.txt --prefix long --outdit output");
    assert_eq!(spelled, "output/long00000.png\n");
    assert_eq!(size(&folder.read("output/x00015.png")), (16, 9));
}

#[test]
fn info_is_in_the_name_only() {
    let folder = Folder::new();
    let printed = folder.printed("-f 15 -s scene.txt --info");
    let start =
        "ball_00015_size=16x9_samples=2_min=2_contrast=difference_limit=0.03_noise=none_dof=1_";
    assert!(printed.starts_with(start), "{printed}");
    let seconds = printed.trim_end().strip_suffix(".png").unwrap().rsplit_once("_time=").unwrap().1;
    assert!(seconds.parse::<f64>().unwrap() < 60.0, "{printed}");
    folder.printed("-f 15 -s scene.txt");
    assert_eq!(folder.read(printed.trim_end()), folder.read("ball_00015.png"));
}

#[test]
fn info_tells_the_noise_and_where_it_begins() {
    let folder = Folder::new();
    let check = |typed: &str, expected: &str| {
        let name = folder.printed(&format!("-q -s scene.txt --info {typed}"));
        assert!(name.contains(expected), "{typed}: {name}");
    };
    check("--noise 0.05", "_samples=4096_min=8_contrast=difference_limit=0.03_noise=0.05_dof=1_");
    check("--noise 0.1 --samples 4", "_samples=4_min=4_contrast=difference_limit=0.03_noise=0.1_");
    check("--steps 4,0", "_samples=4096_min=1_contrast=difference_limit=0.03_noise=none_");
}

#[test]
fn frames_before_the_first() {
    let folder = Folder::with_scene(&SCENE.replace("videoStart 0", "videoStart -1"));
    assert_eq!(folder.printed("-s scene.txt -f -5"), "ball_-00005.png\n");
}

#[test]
fn every_format_holds_its_recipe() {
    for (keyword, extension) in [("PNG_IMAGE", "png"), ("PNG16_IMAGE", "png"), ("EXR_IMAGE", "exr")]
    {
        let folder = Folder::with_scene(&SCENE.replace("PNG_IMAGE", keyword));
        let name = format!("ball_00003.{extension}");
        assert_eq!(folder.printed("-s scene.txt -f 3 --seed 7"), format!("{name}\n"));
        let recipe = folder.printed(&format!("--recipe {name}"));
        let recipe: serde_json::Value = serde_json::from_str(&recipe).unwrap();
        assert_eq!(recipe["output"], keyword);
        assert_eq!((&recipe["frame"], &recipe["seed"]), (&3.into(), &7.into()));
        assert_eq!(recipe["sceneBlake3"].as_str().unwrap().len(), 64);
    }
}

#[test]
fn overrides_for_drafts() {
    let text = SCENE.replace("imageSamples 2", "imageSamples 64 imageMinSamples 8 dofSamples 2");
    let folder = Folder::with_scene(&text);
    let name = folder.printed("-s scene.txt --info --size 8x4 --samples 16 --seed 3 -f 1");
    assert!(name.contains("_size=8x4_samples=16_min=8_"), "{name}");
    assert!(name.contains("_dof=1_") && name.contains("_seed=3_"), "{name}");
    assert_eq!(size(&folder.read(name.trim_end())), (8, 4));
}

#[test]
fn quiet_says_nothing() {
    let folder = Folder::new();
    assert_eq!(folder.run("-q -s scene.txt").said, "");
    assert_ne!(folder.run("-s scene.txt").said, "");
}

#[test]
fn verbose_says_more() {
    let folder = Folder::new();
    let lines = |typed: &str| folder.run(typed).said.lines().count();
    assert!(lines("-v -s scene.txt") > lines("-s scene.txt"));
}

#[test]
fn check_renders_nothing() {
    let folder = Folder::new();
    let run = folder.run("--check -s scene.txt -od out");
    assert_eq!((run.exit, &*run.printed), (0, ""), "{}", run.said);
    assert!(run.said.contains("frames 0 to 25"), "{}", run.said);
    assert!(run.said.contains("16 x 9 pixels, PNG_IMAGE, RAW"), "{}", run.said);
    assert!(folder.names().is_empty());
}

#[test]
fn an_existing_picture_is_kept_only_with_its_recipe() {
    let folder = Folder::new();
    let changed =
        || fs::metadata(folder.path().join("ball_00000.png")).unwrap().modified().unwrap();
    folder.printed("-s scene.txt");
    let first = changed();
    assert_eq!(folder.printed("-s scene.txt --skip-existing"), "ball_00000.png\n");
    assert_eq!(changed(), first);
    let other = folder.read("ball_00000.png");
    folder.printed("-s scene.txt --skip-existing --seed 1");
    assert_ne!(folder.read("ball_00000.png"), other);
    folder.write("ball_00000.png", &other[..other.len() / 4]);
    folder.printed("-s scene.txt --skip-existing");
    assert_eq!(folder.read("ball_00000.png"), other);
}

#[test]
fn colour_only_where_it_is_wanted() {
    let folder = Folder::with_scene("nonsense");
    let said = |variables: &[(&str, &str)], typed: &str| {
        let output = folder.command(typed).envs(variables.iter().copied()).output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    for typed in ["-s scene.txt", "--nonsense"] {
        assert!(!said(&[], typed).contains('\x1b'), "{typed}");
        assert!(said(&[("CLICOLOR_FORCE", "1")], typed).contains('\x1b'), "{typed}");
        assert!(!said(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")], typed).contains('\x1b'));
        let always = format!("{typed} --color always");
        assert!(said(&[("NO_COLOR", "1")], &always).contains('\x1b'), "{always}");
    }
}
