//! `--share`: processes in one folder share the frames, and lose nothing if some of them die.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::{Folder, Run, SCENE};

/// A scene whose frames take a fifth of a second each.
fn folder() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 60");
    Folder::with_scene(&text.replace("width 16 height 9", "width 100 height 70"))
}

/// A scene whose frames take several seconds each.
fn long() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 2000");
    Folder::with_scene(&text.replace("width 16 height 9", "width 250 height 150"))
}

fn start(folder: &Folder, typed: &str) -> Child {
    let mut command = folder.command(&format!("-s scene.txt --progress json -q {typed}"));
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Asserts that the frames equal frames rendered without sharing, and that nothing else is left.
fn check_all(folder: &Folder, frames: &str) {
    let printed = folder.printed(&format!("-q -s scene.txt -f {frames} -od alone"));
    let names: Vec<&str> = printed.lines().map(|path| path.rsplit('/').next().unwrap()).collect();
    for name in &names {
        assert!(folder.read(name) == folder.read(&format!("alone/{name}")), "{name}: other bytes");
    }
    let left: Vec<String> = folder.names().into_iter().filter(|name| name != "alone").collect();
    assert_eq!(left, names, "nothing but pictures is left");
}

/// Counts how often a run finished each frame.
fn finished(run: &Run, counts: &mut BTreeMap<i64, u32>) {
    for line in run.said.lines().filter(|line| line.starts_with('{')) {
        let event: serde_json::Value = serde_json::from_str(line).unwrap();
        if event["event"] == "finished" {
            *counts.entry(event["frame"].as_i64().unwrap()).or_default() += 1;
        }
    }
}

fn wait_for(what: impl Fn() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(120);
    while !what() {
        assert!(Instant::now() < deadline, "nothing happens");
        sleep(Duration::from_millis(10));
    }
}

fn has(folder: &Path, end: &str) -> bool {
    let names = fs::read_dir(folder).unwrap().flatten();
    names.into_iter().any(|entry| entry.file_name().to_string_lossy().ends_with(end))
}

#[test]
fn each_frame_is_rendered_by_one_of_several_processes() {
    let folder = folder();
    let orders = ["forward", "forward", "reverse", "coarse"];
    let typed = |order| format!("-f 0-11,7 --share --order {order}");
    let children = orders.map(|order| start(&folder, &typed(order)));
    let mut counts = BTreeMap::new();
    for child in children {
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 0, "{}", run.said);
        finished(&run, &mut counts);
    }
    assert_eq!(counts, (0..12).map(|frame| (frame, 1)).collect());
    check_all(&folder, "0-11");
    let again = folder.printed("-s scene.txt -f 0-11 --share -q");
    assert_eq!(again.lines().count(), 12);
}

#[test]
fn processes_build_ahead_and_write_beside_rendering() {
    let folder = folder();
    let typed = "-s scene.txt -f 0-7 -v --threads 2 --share";
    let start = || {
        let mut command = folder.command(typed);
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let children = [start(), start()];
    for child in children {
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 0, "{}", run.said);
        let rendered = run.said.contains("frames rendered");
        assert_eq!(rendered, run.said.contains("beside rendering: building "), "{}", run.said);
    }
    check_all(&folder, "0-7");
}

#[test]
fn killed_at_random_moments_and_started_again() {
    let folder = folder();
    let typed = "-f 0-15 --share=4 --checkpoint 1";
    let mut random = StdRng::seed_from_u64(5);
    let mut children: Vec<Child> = (0..3).map(|_| start(&folder, typed)).collect();
    for _ in 0..12 {
        sleep(Duration::from_millis(random.random_range(20..500)));
        let victim = random.random_range(0..children.len());
        let mut killed = std::mem::replace(&mut children[victim], start(&folder, typed));
        let _ = killed.kill();
        killed.wait().unwrap();
    }
    for child in children {
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 0, "{}", run.said);
    }
    check_all(&folder, "0-15");
}

#[test]
fn who_waits_goes_on_from_the_checkpoint_of_the_dead() {
    let folder = long();
    let typed = "-f 3 --share=2 --checkpoint 1";
    let mut first = start(&folder, typed);
    wait_for(|| has(folder.path(), ".state"));
    let second = start(&folder, typed);
    sleep(Duration::from_millis(500));
    first.kill().unwrap();
    first.wait().unwrap();
    let run = Run::of(second.wait_with_output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains(r#"{"event":"waiting","frames":[3]}"#), "{}", run.said);
    // Its first progress report on the frame is about the other process's work, which reveals no
    // speed.
    let progress = |line: &&str| line.contains(r#""event":"progress""#);
    if let Some(line) = run.said.lines().find(progress) {
        let event: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(event["fraction"].as_f64().unwrap() > 0.0, "{}", run.said);
        assert!(event["left"].is_null(), "{}", run.said);
    }
    check_all(&folder, "3");
}

#[test]
fn a_signal_lets_the_frame_go() {
    let folder = long();
    let first = start(&folder, "-f 0-1 --share");
    wait_for(|| has(folder.path(), ".claim"));
    sleep(Duration::from_millis(300));
    let kill = Command::new("kill").args(["-TERM", &first.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let run = Run::of(first.wait_with_output().unwrap());
    assert_eq!(run.exit, 75, "{}", run.said);
    assert!(!has(folder.path(), ".claim"));
    // No other process has to wait.
    folder.printed("-s scene.txt -f 0-1 --share=3600 -q");
    check_all(&folder, "0-1");
}

#[test]
fn who_waits_says_for_whom_and_can_be_stopped() {
    let folder = folder();
    folder.write(".slo-rt-ball_00001.png.claim", "0123456789abcdef 60000 1 4711 anna\n");
    let mut command = folder.command("-s scene.txt -f 0-1 --share");
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for(|| folder.path().join("ball_00000.png").exists());
    sleep(Duration::from_millis(1000));
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.exit, &*run.printed), (75, "ball_00000.png\n"), "{}", run.said);
    for said in [
        "waiting for other processes to finish frame 1; process 4711 on anna renders frame 1",
        "interrupted",
    ] {
        assert!(run.said.contains(said), "no `{said}` in {}", run.said);
    }
}

#[test]
fn frames_that_fail_are_not_waited_for() {
    let folder = folder();
    folder.write("ball_00001.png/inside", "");
    let run = folder.run("-s scene.txt -f 0-2,26 --share -q");
    assert_eq!((run.exit, &*run.printed), (1, "ball_00000.png\nball_00002.png\n"), "{}", run.said);
    assert!(!has(folder.path(), ".claim"));
}

#[test]
fn pictures_with_their_time_in_the_name_are_shared_too() {
    let folder = folder();
    let children = [(); 2].map(|()| start(&folder, "-f 0-5 --share --info"));
    for child in children {
        assert_eq!(Run::of(child.wait_with_output().unwrap()).exit, 0);
    }
    assert_eq!(folder.names().len(), 6, "{:?}", folder.names());
}

/// Two versions of a scene in one folder: neither run reports success if its frames are incomplete.
#[test]
fn two_versions_of_a_scene_do_not_share_a_folder() {
    for (orders, lease) in [(["forward", "forward"], 60), (["forward", "reverse"], 2)] {
        let folder = folder();
        let other = String::from_utf8(folder.read("scene.txt")).unwrap();
        folder.write("other.txt", other.replace(".7 .6 .5", ".5 .6 .7"));
        let start = |scene: &str, order| {
            // Long enough that neither run ends before the other one has begun.
            let typed = format!(
                "-s {scene} -f 0-11 --share={lease} --order {order} --size 128x72 --samples 32"
            );
            let mut command = folder.command(&typed);
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let children = [start("scene.txt", orders[0]), start("other.txt", orders[1])];
        let runs = children.map(|child| Run::of(child.wait_with_output().unwrap()));
        let finished = ["scene.txt", "other.txt"].map(|scene| {
            let same = "-f 0-11 --size 128x72 --samples 32 --dry-run";
            let plan = folder.printed(&format!("-q -s {scene} {same}"));
            plan.lines().filter(|line| line.ends_with("finished")).count()
        });
        assert!(runs.iter().any(|run| run.exit != 0), "{finished:?}");
        for (run, finished) in runs.iter().zip(finished) {
            assert_eq!(run.exit == 0, finished == 12, "{finished}: {}", run.said);
            assert!([0, 1].contains(&run.exit), "{}", run.said);
        }
        let said = &runs.iter().find(|run| run.exit != 0).unwrap().said;
        // Seen before the frame was rendered, or afterwards.
        let reasons = ["another scene or with other settings", "another run has replaced it"];
        assert!(reasons.iter().any(|reason| said.contains(reason)), "{said}");
        assert!(!has(folder.path(), ".claim"));
    }
}

/// A process that died while rendering another version of the scene blocks nobody.
#[test]
fn a_dead_claim_of_another_version_is_waited_for_and_taken_over() {
    let folder = folder();
    let claim = "0123456789abcdef 2000 1 4711 anna 00000000000000ff\n";
    folder.write(".slo-rt-ball_00000.png.claim", claim);
    let run = folder.run("-s scene.txt -f 0-1 --share=1");
    assert_eq!(run.exit, 0, "{}", run.said);
    for said in ["has claimed frame 0 for another scene", "taking over frame 0"] {
        assert!(run.said.contains(said), "no `{said}` in {}", run.said);
    }
    check_all(&folder, "0-1");
}

/// The waiting process decides how long to wait. The day that the dead one claimed does not count.
#[test]
fn the_seconds_of_the_dead_do_not_count() {
    let folder = folder();
    folder.write(".slo-rt-ball_00001.png.claim", "0123456789abcdef 86400000 1 4711 anna\n");
    let start = Instant::now();
    folder.printed("-q -s scene.txt -f 0-1 --share=2");
    assert!(start.elapsed() < Duration::from_secs(600));
    check_all(&folder, "0-1");
}

#[test]
fn what_is_no_file_in_the_place_of_a_claim_fails_that_frame_only() {
    let folder = folder();
    let at = |frame: u32| folder.path().join(format!(".slo-rt-ball_0000{frame}.png.claim"));
    assert!(Command::new("mkfifo").arg(at(0)).status().unwrap().success());
    fs::create_dir(at(1)).unwrap();
    std::os::unix::fs::symlink("nowhere", at(2)).unwrap();
    let run = folder.run("-s scene.txt -f 0-3 --share -q");
    assert_eq!((run.exit, &*run.printed), (1, "ball_00003.png\n"), "{}", run.said);
    assert!(run.said.contains("3 of 4 frames failed: 0-2"), "{}", run.said);
}

#[test]
fn pictures_that_vanish_during_the_run_are_told() {
    for share in ["", "--share"] {
        let folder = folder();
        let mut command = folder.command(&format!("-s scene.txt -f 0-7 -q {share}"));
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(|| folder.path().join("ball_00001.png").exists());
        folder.write("ball_00000.png", "notes");
        fs::remove_file(folder.path().join("ball_00001.png")).unwrap();
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 1, "{}", run.said);
        for said in ["no longer there", "another program has replaced", "frames failed: 0-1"] {
            assert!(run.said.contains(said), "no `{said}` in {}", run.said);
        }
        assert_eq!(folder.read("ball_00000.png"), b"notes");
    }
}

#[test]
fn claims_that_killed_runs_left_are_removed_when_all_is_there() {
    let folder = folder();
    for name in ["claim", "claim.0123456789abcdef"] {
        let name = format!(".slo-rt-ball_00001.png.{name}");
        folder.write(&name, "0123456789abcdef 1000 1 4711 anna\n");
    }
    folder.printed("-q -s scene.txt -f 0-7");
    check_all(&folder, "0-7");
}
