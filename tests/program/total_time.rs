//! `--total-time`: a span of time for all frames of a sequence.

use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Folder, noisy_scene};

fn folder() -> Folder {
    Folder::with_scene(&noisy_scene([160, 120]))
}

fn name(frame: i64) -> String {
    format!("ball_{frame:05}.png")
}

/// Reads the two numbers of the steps in a picture's recipe.
fn steps(folder: &Folder, frame: i64) -> (u64, u64) {
    let recipe = folder.printed(&format!("--recipe out/{}", name(frame)));
    let recipe: serde_json::Value = serde_json::from_str(&recipe).unwrap();
    let number = |i: usize| recipe["steps"][i].as_u64().unwrap();
    (number(0), number(1))
}

/// Asserts that each frame can be rendered again without the clock.
#[track_caller]
fn check_again(folder: &Folder, frames: impl Iterator<Item = i64>) {
    for frame in frames {
        let (step, tiles) = steps(folder, frame);
        let name = name(frame);
        folder.printed(&format!("-q -s scene.txt -f {frame} -od again --steps {step},{tiles}"));
        let same = folder.read(&format!("out/{name}")) == folder.read(&format!("again/{name}"));
        assert!(same, "frame {frame}, steps {step},{tiles}: other bytes");
    }
}

/// Names in the folder of the pictures, except files that a killed run was writing.
fn names(folder: &Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path().join("out")).into_iter().flatten();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| !name.ends_with(".part")).collect();
    names.sort();
    names
}

#[test]
fn frames_come_out_equally_clean_and_can_be_made_again() {
    let folder = folder();
    let typed = "-s scene.txt -f 1-4 -od out --total-time 4s";
    let printed = folder.printed(typed);
    assert_eq!(printed.lines().count(), 4, "{printed}");
    assert_eq!(names(&folder), (1..=4).map(name).collect::<Vec<_>>());
    let reached: Vec<u64> = (1..=4).map(|frame| steps(&folder, frame).0).collect();
    let (least, most) = (reached.iter().min().unwrap(), reached.iter().max().unwrap());
    assert!(*least >= 4 && most - least <= 1, "{reached:?}");
    check_again(&folder, 1..=4);
    let again = folder.run(typed);
    assert!(again.said.contains("4 frames were finished already"), "{}", again.said);
    assert_eq!(again.printed, printed);
}

#[test]
fn a_killed_run_has_pictures_and_goes_on() {
    let folder = folder();
    let mut command = folder.command("-q -s scene.txt -f 1-3 -od out --total-time 300s");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while !(1..=3).all(|frame| names(&folder).contains(&name(frame))) {
        assert!(start.elapsed() < Duration::from_secs(200), "{:?}", names(&folder));
        sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let planned = folder.printed("-q -s scene.txt -f 1-3 -od out --total-time 4s --dry-run");
    assert_eq!(planned.matches("stale (the time was not over)").count(), 3, "{planned}");
    folder.printed("-q -s scene.txt -f 1-3 -od out --total-time 4s");
    assert_eq!(names(&folder), (1..=3).map(name).collect::<Vec<_>>());
    check_again(&folder, 1..=3);
}

#[test]
fn states_stay_where_they_are_asked_for() {
    let folder = folder();
    folder.printed("-q -s scene.txt -f 1-2 -od out --total-time 1s --keep-state");
    let expected: Vec<String> =
        (1..=2).flat_map(|frame| [name(frame), name(frame).replace(".png", ".state")]).collect();
    assert_eq!(names(&folder), expected);
}

#[test]
fn a_frame_that_is_missing_gets_its_share_and_no_more() {
    let folder = folder();
    folder.printed("-q -s scene.txt -f 1-8 -od out --steps 5,0");
    std::fs::remove_file(folder.path().join("out").join(name(3))).unwrap();
    let start = Instant::now();
    folder.printed("-q -s scene.txt -f 1-8 -od out --total-time 80s");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
    assert_eq!(steps(&folder, 1), (5, 0));
    check_again(&folder, 3..=3);
}

#[test]
fn one_frame_is_no_sequence() {
    let run = folder().run("-s scene.txt -f 3 --total-time 5s");
    assert_eq!(run.exit, 2);
    assert!(run.said.contains("--total-time needs a sequence"), "{}", run.said);
}

#[test]
fn a_time_that_is_too_short_is_told_at_the_end() {
    let folder = folder();
    let run = folder.run("-s scene.txt -f 1-2 -od out --total-time 1ms");
    assert_eq!(run.exit, 0, "{}", run.said);
    let last = run.said.lines().last().unwrap();
    assert!(last.contains("every frame takes at least one sample per pixel"), "{}", run.said);
    let run = folder.run("-s scene.txt -f 1-2 -od in-time --total-time 2s");
    assert!(!run.said.contains("one sample"), "{}", run.said);
}
