//! `scripts/render_sequence.sh`

use std::process::Command;

use super::{Folder, Run, SCENE};

fn sequence(folder: &Folder, typed: &str) -> Run {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/render_sequence.sh");
    let mut command = Command::new("sh");
    command.arg(script).args(typed.split_whitespace()).current_dir(folder.path());
    Run::of(command.env("SLO_RT", env!("CARGO_BIN_EXE_slo-rt")).output().unwrap())
}

#[test]
fn every_frame_is_rendered() {
    let folder = Folder::with_scene(&SCENE.replace("videoStart 0", "videoStart -1"));
    let run = sequence(&folder, "scene.txt -1 1 -pre x -q");
    assert_eq!((run.exit, &*run.said), (0, ""));
    assert_eq!(run.printed, "x-00001.png\nx00000.png\nx00001.png\n");
    assert_eq!(folder.names(), ["x-00001.png", "x00000.png", "x00001.png"]);
}

#[test]
fn frames_that_are_there_are_kept() {
    let folder = Folder::new();
    assert_eq!(sequence(&folder, "scene.txt 1 1 -q --samples 1").exit, 0);
    let stale = folder.read("ball_00001.png");
    assert_eq!(sequence(&folder, "scene.txt 0 0 -q").exit, 0);
    let modified = |name: &str| folder.path().join(name).metadata().unwrap().modified().unwrap();
    let before = modified("ball_00000.png");
    assert_eq!(sequence(&folder, "scene.txt 0 1 -q --skip-existing").exit, 0);
    assert_eq!(modified("ball_00000.png"), before);
    assert_ne!(folder.read("ball_00001.png"), stale);
}

#[test]
fn it_stops_at_a_failure_or_goes_on() {
    let folder = Folder::new();
    let stopped = sequence(&folder, "scene.txt 24 27 -q");
    assert_eq!((stopped.exit, &*stopped.printed), (2, "ball_00024.png\nball_00025.png\n"));
    assert!(stopped.said.contains("frame 26 failed"), "{}", stopped.said);
    assert!(!stopped.said.contains("frame 27 failed"), "{}", stopped.said);
    let went_on = sequence(&folder, "-k scene.txt 24 27 -q");
    assert_eq!(went_on.exit, 1);
    assert!(went_on.said.ends_with("failed frames: 26 27\n"), "{}", went_on.said);
}

#[test]
fn wrong_usage() {
    let folder = Folder::new();
    for typed in [
        "",
        "scene.txt",
        "scene.txt 0",
        "scene.txt 1 0",
        "scene.txt a 1",
        "scene.txt 0 1.5",
        "-x scene.txt 0 1",
    ] {
        let run = sequence(&folder, typed);
        assert_eq!(run.exit, 2, "{typed}");
        assert!(run.said.contains("usage: render_sequence.sh"), "{typed}");
    }
    assert_eq!(sequence(&folder, "--help").exit, 0);
}
