//! The documentation of the program is correct.

use std::collections::BTreeSet;

use super::Folder;

/// Words that begin with two dashes, up to the end of the option's name.
fn options(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| !(c.is_ascii_lowercase() || c == '-'));
    let is_option = |word: &&str| word.starts_with("--") && !word.ends_with('-');
    words.filter(is_option).map(str::to_owned).collect()
}

#[test]
fn every_option_is_documented_and_every_documented_option_exists() {
    let page = include_str!("../../docs/command-line.md");
    let slo_rt = page.split("## Sequences").next().unwrap();
    let mut documented = options(slo_rt);
    assert!(documented.remove("--outdit"), "the thesis's spelling is explained");
    assert_eq!(documented, options(&Folder::new().printed("--help")));
}

#[test]
fn every_exit_code_is_documented() {
    let page = include_str!("../../docs/command-line.md");
    let help = Folder::new().printed("--help");
    for code in ["0", "1", "2", "65", "66", "69", "73", "74", "75", "130"] {
        assert!(page.contains(&format!("| {code} |")), "{code}");
        assert!(
            help.lines().any(|line| line.trim_start().starts_with(&format!("{code} "))),
            "{code}"
        );
    }
}

#[test]
fn help_fits_and_names_the_version() {
    let folder = Folder::new();
    let version = folder.printed("--version");
    assert_eq!(version, format!("slo-rt {}\n", env!("CARGO_PKG_VERSION")));
    for typed in ["-h", "--help"] {
        let help = folder.printed(typed);
        let longest = help.lines().map(|line| line.chars().count()).max();
        assert!(longest <= Some(100), "{typed}: {longest:?}");
        assert!(help.contains("Examples:"), "{typed}");
    }
}

#[test]
fn the_scene_of_the_readme_renders() {
    let readme = include_str!("../../README.md");
    let scene = readme.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = Folder::with_scene(scene);
    let run = folder.run("-s scene.txt -f 50 --size 16x9 --samples 1 -q");
    assert_eq!((run.exit, &*run.printed, &*run.said), (0, "ball_00050.png\n", ""));
}

#[test]
fn every_command_tells_about_itself() {
    for command in [
        "merge", "verify", "compare", "sheet", "denoise", "relight", "import", "bake", "why",
        "view", "generate",
    ] {
        for flag in ["-h", "--help"] {
            let help = Folder::new().printed(&format!("{command} {flag}"));
            assert!(help.contains(&format!("Usage: slo-rt {command}")), "{help}");
        }
    }
}
