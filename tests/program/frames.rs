//! Many frames in one run.

use std::fs;
use std::time::{Duration, Instant, SystemTime};

use super::{Folder, SCENE};

fn changed(folder: &Folder, name: &str) -> SystemTime {
    fs::metadata(folder.path().join(name)).unwrap().modified().unwrap()
}

/// Fields of the lines of a dry run.
fn plan(printed: &str) -> Vec<[&str; 3]> {
    let fields = |line: &'static str| -> [&str; 3] {
        line.split('\t').collect::<Vec<_>>().try_into().unwrap()
    };
    printed.to_owned().leak().lines().map(fields).collect()
}

#[test]
fn ranges_lists_and_orders() {
    let folder = Folder::with_scene(&SCENE.replace("videoStart 0", "videoStart -1"));
    let names = |frames: &[i64]| {
        let name = |&f: &i64| {
            format!("ball_{}{:05}.png\n", if f < 0 { "-" } else { "" }, f.unsigned_abs())
        };
        frames.iter().map(name).collect::<String>()
    };
    let check = |typed: &str, frames: &[i64]| {
        assert_eq!(folder.printed(&format!("-q -s scene.txt {typed}")), names(frames), "{typed}");
    };
    check("-f 1-10x4,20,-2--1", &[1, 5, 9, 20, -2, -1]);
    check("--frame=3-1 --order reverse", &[1, 2, 3]);
    check("-f 0-9:5 --overwrite", &[0, 5, 4, 8, 3, 6, 9, 2, 1, 7]);
    check("-f 0-3 --order coarse", &[0, 2, 1, 3]);
}

#[test]
fn the_same_command_again_renders_what_is_missing_damaged_or_stale() {
    let folder = Folder::new();
    let frames = "-q -s scene.txt -f 0-5";
    let printed = folder.printed(frames);
    let whole = folder.read("ball_00002.png");
    folder.printed("-q -s scene.txt -f 3 --seed 1");
    let old = changed(&folder, "ball_00004.png");
    fs::remove_file(folder.path().join("ball_00001.png")).unwrap();
    folder.write("ball_00002.png", &whole[..whole.len() - 5]);
    folder.write("ball_00005.png", "");
    let listed = folder.run("-s scene.txt -f 0-5,26 --dry-run");
    assert_eq!(
        plan(&listed.printed),
        [
            ["0", "ball_00000.png", "finished"],
            ["1", "ball_00001.png", "missing"],
            ["2", "ball_00002.png", "damaged"],
            ["3", "ball_00003.png", "stale (seed: 1)"],
            ["4", "ball_00004.png", "finished"],
            ["5", "ball_00005.png", "damaged"],
            ["26", "ball_00026.png", "no such frame"],
        ]
    );
    assert!(listed.said.contains("4 of 7 frames to render"), "{}", listed.said);
    assert_eq!(listed.exit, 1, "a frame fails, as in the run");
    assert!(listed.said.contains("does not have 1 of 7 frames: 26"), "{}", listed.said);
    assert_eq!(folder.printed(frames), printed);
    assert_eq!(folder.read("ball_00002.png"), whole);
    assert_eq!(changed(&folder, "ball_00004.png"), old);
    assert!(
        folder.run(&format!("{frames} --dry-run")).printed.lines().all(|l| l.ends_with("finished"))
    );
}

#[test]
fn a_scene_of_several_files() {
    let folder = Folder::with_scene("include parts/all.txt");
    let missing = folder.run("-s scene.txt --check");
    assert_eq!(missing.exit, 66, "{}", missing.said);
    fs::create_dir(folder.path().join("parts")).unwrap();
    folder.write("parts/all.txt", SCENE);
    folder.printed("-q -s scene.txt -f 0-2");
    assert_eq!(folder.run("verify -s scene.txt ball_00001.png").exit, 0);
    folder.write("parts/all.txt", format!("{SCENE}# another text"));
    assert_ne!(folder.run("verify -s scene.txt ball_00001.png").exit, 0);
    let listed = folder.run("-s scene.txt -f all --dry-run");
    let states: Vec<_> = plan(&listed.printed).into_iter().map(|[_, _, state]| state).collect();
    assert_eq!(states.iter().filter(|state| state.starts_with("stale (")).count(), 3, "{states:?}");
    assert_eq!(states.iter().filter(|state| **state == "missing").count(), states.len() - 3);
}

#[test]
fn with_times_in_their_names_too() {
    let folder = Folder::new();
    folder.printed("-q -s scene.txt -f 0-2 --info");
    let names = folder.names();
    assert_eq!(names.len(), 3);
    fs::remove_file(folder.path().join(&names[1])).unwrap();
    let printed = folder.printed("-q -s scene.txt -f 0-2 --info");
    assert_eq!(printed.lines().next(), Some(&*names[0]));
    assert_eq!(folder.names().len(), 3);
}

#[test]
fn frames_of_one_process_are_those_of_many() {
    let moving = "sphere mover { center { 0 0 0 } radius 0.4 material matte
        addKframe { time 0 key { pivot { -2 0 0 } } } addKframe { time 0.1 key { pivot { 0 0 2 } } }
        addKframe { time 1 key { pivot { 0 0 2 } } } }";
    let text = SCENE.replace("fovStart 0.4", "fovStart 0.4 blurDuration 0.04") + moving;
    let folder = Folder::with_scene(&text);
    folder.printed("-q -s scene.txt -f 0-5 -od one --order coarse");
    assert_eq!(folder.names().len(), 1);
    for frame in 0..6 {
        let name = folder.printed(&format!("-q -s scene.txt -f {frame}"));
        let name = name.trim_end();
        assert!(folder.read(name) == folder.read(&format!("one/{name}")), "frame {frame}");
    }
}

#[test]
fn bad_frames_do_not_stop_the_others() {
    let folder = Folder::new();
    folder.write("ball_00001.png/inside", "");
    let run = folder.run("-s scene.txt -f 0-2,26-28");
    assert_eq!((run.exit, &*run.printed), (1, "ball_00000.png\nball_00002.png\n"));
    assert!(run.said.contains("frame 1: can't create `ball_00001.png`"), "{}", run.said);
    assert!(run.said.contains("4 of 6 frames failed: 1, 26-28"), "{}", run.said);
    let run = folder.run("-s scene.txt -f 26-28");
    assert_eq!(run.exit, 2, "{}", run.said);
    assert!(run.said.contains("3 of 3 frames failed: 26-28"), "{}", run.said);
}

#[test]
fn a_dry_run_ends_as_the_run_does() {
    let folder = Folder::new();
    for (frames, exit) in [("0-2", 0), ("26", 2), ("26-28", 2), ("-5", 2), ("25-26", 1)] {
        let dry = folder.run(&format!("-s scene.txt -f {frames} --dry-run"));
        let run = folder.run(&format!("-s scene.txt -f {frames} -q -od out"));
        assert_eq!((dry.exit, run.exit), (exit, exit), "{frames}: {} {}", dry.said, run.said);
    }
    let one = folder.run("-s scene.txt -f 26 --dry-run");
    assert!(one.said.contains("0 of 1 frame to render"), "{}", one.said);
    assert!(one.said.contains("frame 26 (1.04 s of the video) lies in no"), "{}", one.said);
}

#[test]
fn all_frames_of_the_scene() {
    let folder = Folder::with_scene(&SCENE.replace("videoEnd 1", "videoEnd 0.1"));
    let all = "ball_00000.png\nball_00001.png\nball_00002.png\n";
    assert_eq!(folder.printed("-q -s scene.txt -f all"), all);
    let again = folder.run("-s scene.txt --frame ALL --order reverse");
    assert!(again.said.contains("3 frames were finished already"), "{}", again.said);
    assert_eq!(folder.run("-s scene.txt -f all --check").exit, 0);
    let planned = folder.printed("-s scene.txt -f all --dry-run --overwrite");
    assert_eq!(planned.lines().count(), 3);
    let run = folder.run("-s scene.txt -f all --sample-map map.png");
    assert_eq!(run.exit, 2, "each frame needs a map of its own: {}", run.said);
    folder.write("long.txt", SCENE.replace("videoEnd 1", "videoEnd 1e9"));
    let run = folder.run("-s long.txt -f all");
    assert_eq!(run.exit, 2, "{}", run.said);
    assert!(run.said.contains("one run renders at most 1000000"), "{}", run.said);
}

#[test]
fn events_for_programs() {
    let folder = Folder::new();
    folder.printed("-q -s scene.txt -f 0");
    let run = folder.run("-s scene.txt -f 0-2,26 --progress json -q");
    let events: Vec<serde_json::Value> = run
        .said
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let kinds: Vec<_> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    let expected = ["sequence", "found", "started", "finished", "started", "finished", "failed"];
    let kept = kinds.iter().copied().filter(|kind| *kind != "progress");
    assert_eq!(kept.collect::<Vec<_>>(), [&expected[..], &["ended"]].concat());
    assert_eq!(events[0]["toRender"], 2);
    let last = events.last().unwrap();
    let counts = ["rendered", "found", "failed"].map(|key| last[key].as_u64().unwrap());
    assert_eq!(counts, [2, 1, 1]);
    let openjd = folder.run("-s scene.txt -f 0-2 --overwrite --progress openjd");
    assert!(openjd.said.contains("openjd_progress: 33.3\n"), "{}", openjd.said);
    assert!(openjd.said.contains("openjd_status: frame 2\n"), "{}", openjd.said);
}

/// The project's limit is 2 s; the test allows more for a busy machine.
#[test]
fn a_finished_sequence_of_800_frames_is_known_at_once() {
    let text =
        SCENE.replace("videoEnd 1", "videoEnd 40").replace("imageSamples 2", "imageSamples 1");
    let folder = Folder::with_scene(&text.replace("width 16 height 9", "width 4 height 4"));
    folder.printed("-q -s scene.txt -f 0-799");
    let start = Instant::now();
    let run = folder.run("-s scene.txt -f 0-799");
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert!(run.said.contains("800 frames were finished already"), "{}", run.said);
}
