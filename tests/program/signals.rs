//! Signals and kills: finished work is never lost, and a stopped picture ends up the same.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Folder, Run, SCENE};

/// A state file that any run of the picture reads.
const STATE: &str = ".slo-rt-ball_00000.png.state";

/// Names of the checkpoints of frame 0.
fn states(folder: &Folder) -> Vec<String> {
    let is_state =
        |name: &String| name.starts_with(".slo-rt-ball_00000.png.") && name.ends_with(".state");
    folder.names().into_iter().filter(is_state).collect()
}

/// A scene that takes minutes to render, in tiles of a fraction of a second.
fn long() -> Folder {
    let text = SCENE.replace("imageSamples 2", "imageSamples 16384");
    Folder::with_scene(&text.replace("width 16 height 9", "width 2000 height 2000"))
}

/// A scene that takes one or a few seconds to render.
fn short(settings: &str) -> Folder {
    let text = SCENE.replace("imageSamples 2", settings);
    Folder::with_scene(&text.replace("width 16 height 9", "width 250 height 150"))
}

/// Whether this process, and therefore its children, ignore SIGINT. `nohup` and background jobs of
/// scripts ignore it, and the program respects that.
fn interrupts_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    u64::from_str_radix(mask.trim(), 16).unwrap_or(0) & 0b11 != 0
}

fn start(folder: &Folder, typed: &str) -> Child {
    let mut command = folder.command(typed);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, signal: &str) {
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
}

/// Waits until a checkpoint exists.
fn wait_for_state(folder: &Folder, child: &mut Child) {
    let deadline = Instant::now() + Duration::from_secs(120);
    while states(folder).is_empty() {
        assert!(child.try_wait().unwrap().is_none(), "it still renders");
        assert!(Instant::now() < deadline, "no checkpoint");
        sleep(Duration::from_millis(20));
    }
}

fn check(name: &str) {
    if interrupts_are_ignored() && name != "-TERM" {
        eprintln!("SIGINT or SIGHUP is ignored here: nothing to see");
        return;
    }
    let folder = long();
    let mut child = start(&folder, "-s scene.txt");
    sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "it still renders");
    let start = Instant::now();
    signal(&child, name);
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.exit, &*run.printed), (75, ""), "{name}: {}", run.said);
    assert!(run.said.contains("interrupted in frame 0"), "{}", run.said);
    assert!(start.elapsed() < Duration::from_secs(60), "it stops soon");
    assert_eq!(states(&folder).len(), 1);
    assert_eq!(folder.names(), states(&folder));
}

/// Each ray of a pixel splits into two at each of a hundred surfaces, so no step ever ends.
#[test]
fn rays_that_branch_without_end_stop() {
    let text = SCENE.replace("imageSamples 2", "imageSamples 64 recursion 100").replace(
        "sphere ball",
        "phong_info glass { reflectance .9 refraction .9 refraction_index 1.5 }
         material_phong glass { phong_info glass }
         plane floor { normal { 0 0 1 } position { 0 0 -1 } material glass }
         sphere left { center { -1 2 0 } radius 1 material glass }
         sphere right { center { 1 2 0 } radius 1 material glass }
         sphere ball",
    );
    let folder = Folder::with_scene(&text);
    let mut child = start(&folder, "-s scene.txt --threads 1");
    sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "it still renders");
    let start = Instant::now();
    signal(&child, "-TERM");
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.exit, &*run.printed), (75, ""), "{}", run.said);
    assert!(start.elapsed() < Duration::from_secs(30), "it stops soon");
}

/// A batch of hits that samples so many lights takes longer than anyone would wait for the program
/// to stop.
#[test]
fn rays_to_a_hundred_thousand_lights_stop() {
    let lights: String = (0..100_000)
        .map(|i| {
            let (x, y) = (i % 300 - 150, i / 300 - 150);
            format!("light_point l{i} {{ color {{ 1 1 1 }} position {{ {x} {y} 9 }} }}\n")
        })
        .collect();
    let settings = "imageSamples 60000 lightSamplingType SAMPLE_ONE_AT_TIME";
    let text = SCENE.replace("imageSamples 2", settings) + &lights;
    let folder = Folder::with_scene(&text.replace("width 16 height 9", "width 64 height 64"));
    let mut child = start(&folder, "-s scene.txt --threads 1 -q --progress json");
    let deadline = Instant::now() + Duration::from_secs(120);
    let mut said = String::new();
    let mut lines = std::io::BufReader::new(child.stderr.take().unwrap());
    while !said.contains("started") {
        assert!(std::io::BufRead::read_line(&mut lines, &mut said).unwrap() > 0, "{said}");
        assert!(Instant::now() < deadline, "{said}");
    }
    sleep(Duration::from_secs(2));
    let start = Instant::now();
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(start.elapsed() < Duration::from_secs(30), "it stops soon");
}

#[test]
fn an_interrupted_rendering_keeps_what_is_done() {
    check("-INT");
}

#[test]
fn a_terminated_rendering_keeps_what_is_done() {
    check("-TERM");
}

#[cfg(target_os = "linux")]
#[test]
fn the_signal_that_batch_systems_send_keeps_what_is_done() {
    check("-USR1");
}

#[test]
fn a_second_signal_ends_at_once() {
    if interrupts_are_ignored() {
        return;
    }
    let folder = long();
    let child = start(&folder, "-s scene.txt --threads 1");
    sleep(Duration::from_millis(1000));
    signal(&child, "-INT");
    signal(&child, "-TERM");
    let exit = child.wait_with_output().unwrap().status.code();
    assert!(exit == Some(130) || exit == Some(75), "{exit:?}");
    assert!(!folder.names().iter().any(|name| name.ends_with(".png")));
}

/// Renders with `settings` without interruption, and stopped and continued as often as necessary.
fn check_resumed(settings: &str) {
    let whole = short(settings);
    whole.printed("-q -s scene.txt");
    let folder = short(settings);
    let mut stops = 0;
    for pause in (0..).map(|i| Duration::from_millis(30 + 30 * i)) {
        let mut child = start(&folder, "-s scene.txt -q");
        sleep(pause);
        if child.try_wait().unwrap().is_none() {
            signal(&child, "-TERM");
        }
        let run = Run::of(child.wait_with_output().unwrap());
        match run.exit {
            75 => stops += 1,
            0 => break,
            other => panic!("{other}: {}", run.said),
        }
    }
    assert!(stops > 0, "it was stopped at least once");
    assert_eq!(folder.names(), ["ball_00000.png"]);
    assert!(folder.read("ball_00000.png") == whole.read("ball_00000.png"), "other bytes");
}

#[test]
fn a_resumed_picture_is_the_uninterrupted_one() {
    check_resumed("imageSamples 400");
}

#[test]
fn a_resumed_adaptive_picture_is_the_uninterrupted_one() {
    check_resumed("imageSamples 6000 imageMinSamples 4 imageContrastLimit 0.02");
}

#[test]
fn a_resumed_picture_with_a_noise_level_is_the_uninterrupted_one() {
    check_resumed("imageSamples 60000 noise 0.0005");
}

#[test]
fn a_killed_rendering_goes_on_from_its_last_checkpoint() {
    let settings = "imageSamples 1500";
    let whole = short(settings);
    whole.printed("-q -s scene.txt");
    let folder = short(settings);
    let mut child = start(&folder, "-s scene.txt -q --checkpoint 1");
    wait_for_state(&folder, &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.path().join("ball_00000.png").exists());
    let left = states(&folder).remove(0);
    let state = folder.read(&left);
    folder.printed("-q -s scene.txt");
    assert!(folder.read("ball_00000.png") == whole.read("ball_00000.png"), "other bytes");
    assert!(states(&folder).is_empty());
    // As if it had been killed after it wrote the picture. The states of others are theirs.
    let other = left.replace(&left[left.len() - 14..left.len() - 6], "01234567");
    folder.write(&left, &state);
    folder.write(&other, &state);
    folder.printed("-q -s scene.txt -f 0-0");
    assert_eq!(states(&folder), [other]);
}

/// Number of camera rays of a run.
fn rays(folder: &Folder, typed: &str) -> u64 {
    let said = folder.run(&format!("-v -s scene.txt {typed}")).said;
    let line = said.lines().find(|line| line.contains("rays: ")).unwrap().to_owned();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
}

#[test]
fn a_draft_leaves_the_checkpoint_of_a_long_frame() {
    let settings = "imageSamples 1500";
    let whole = short(settings);
    whole.printed("-q -s scene.txt");
    let folder = short(settings);
    let mut child = start(&folder, "-s scene.txt -q --checkpoint 1");
    wait_for_state(&folder, &mut child);
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let state = states(&folder);
    for draft in ["--samples 2", "--samples 2 --seed 5", "--noise 0.5"] {
        let run = folder.run(&format!("-s scene.txt {draft}"));
        assert_eq!(run.exit, 0, "{}", run.said);
        assert!(run.said.contains("belongs to another run and is left alone"), "{}", run.said);
        assert_eq!(states(&folder), state, "{draft}");
    }
    assert!(rays(&folder, "") < 1500 * 250 * 150, "it goes on");
    assert!(folder.read("ball_00000.png") == whole.read("ball_00000.png"), "other bytes");
    assert_eq!(folder.names(), ["ball_00000.png"]);
}

#[test]
fn more_samples_go_on_from_the_checkpoint_of_fewer() {
    let folder = short("imageSamples 3000");
    let mut child = start(&folder, "-s scene.txt -q --samples 2000 --checkpoint 1");
    wait_for_state(&folder, &mut child);
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(rays(&folder, "--samples 2100") < 2100 * 250 * 150);
    assert_eq!(folder.names(), ["ball_00000.png"], "what it went on from is of no more use");
}

#[test]
fn another_look_goes_on_from_a_checkpoint() {
    let folder = short("imageSamples 2000");
    let mut child = start(&folder, "-s scene.txt -q --checkpoint 1");
    wait_for_state(&folder, &mut child);
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let look = "--exposure 1 --tone-map agx --encoding srgb";
    assert!(rays(&folder, look) < 2000 * 250 * 150);
    folder.printed(&format!("-q -s scene.txt {look} -od anew"));
    assert!(folder.read("ball_00000.png") == folder.read("anew/ball_00000.png"), "other bytes");
}

#[test]
fn what_is_kept_is_not_lost_to_fewer_samples() {
    let folder = short("imageSamples 300");
    let pixels = 250 * 150;
    folder.printed("-q -s scene.txt --samples 64 --keep-state");
    let kept = folder.read("ball_00000.state");
    let run = folder.run("-s scene.txt --samples 4 --keep-state");
    assert_eq!(run.exit, 0);
    assert!(run.said.contains("has more samples than this picture"), "{}", run.said);
    assert!(folder.read("ball_00000.state") == kept);
    assert_eq!(rays(&folder, "--samples 80 --keep-state"), (80 - 64) * pixels);
    let run = folder.run("-s scene.txt --samples 4 --keep-state --seed 1");
    assert!(run.said.contains("other settings and is replaced"), "{}", run.said);
    assert_eq!(rays(&folder, "--samples 5 --seed 1"), pixels);
}

#[test]
fn checkpoints_that_are_damaged_or_foreign_are_not_used() {
    let settings = "imageSamples 100";
    let folder = short(settings);
    folder.printed("-q -s scene.txt --keep-state");
    let expected = folder.read("ball_00000.png");
    let state = folder.read("ball_00000.state");
    let mut flipped = state.clone();
    flipped[state.len() / 2] ^= 1;
    for (bad, said) in [
        (&flipped[..], "it is damaged"),
        (&state[..state.len() / 2], "it was cut off"),
        (b"", "it is no state of slo-rt"),
    ] {
        folder.write(STATE, bad);
        fs::remove_file(folder.path().join("ball_00000.state")).ok();
        let run = folder.run("-s scene.txt");
        assert_eq!(run.exit, 0);
        assert!(run.said.contains(&format!("`{STATE}` can't be used: {said}")), "{}", run.said);
        assert!(folder.read("ball_00000.png") == expected);
    }
    // Samples of another seed do not belong to this picture.
    folder.printed("-q -s scene.txt --keep-state --seed 1");
    folder.printed("-q -s scene.txt");
    assert!(folder.read("ball_00000.png") == expected);
}

#[test]
fn a_picture_gets_more_samples() {
    let folder = short("imageSamples 300");
    let rays = |typed: &str| rays(&folder, typed);
    let pixels = 250 * 150;
    assert_eq!(rays("--samples 64 --keep-state"), 64 * pixels);
    assert_eq!(rays("--samples 100 --keep-state -od other"), 100 * pixels);
    assert_eq!(rays("--samples 100 --format exr"), (100 - 64) * pixels, "another file format");
    assert_eq!(rays("--samples 256"), (256 - 64) * pixels, "it goes on from 64");
    let extended = folder.read("ball_00000.png");
    assert_eq!(rays("--samples 256 -od other2"), 256 * pixels);
    assert!(extended == folder.read("other2/ball_00000.png"), "other bytes");
    assert_eq!(rays("--samples 32"), 32 * pixels, "fewer samples begin anew");
    assert!(folder.path().join("ball_00000.state").exists(), "what was kept stays");
}

/// If the scene comes through a pipe, or from a file server that hangs, the program can still be
/// stopped.
#[test]
fn a_signal_while_the_scene_is_read_ends_at_once() {
    let folder = Folder::new();
    for typed in ["-s /dev/stdin", "-s /dev/stdin -f 0-3 --share=5"] {
        let mut command = folder.command(typed);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let kept = child.stdin.take();
        sleep(Duration::from_millis(700));
        assert!(child.try_wait().unwrap().is_none(), "it waits");
        let start = Instant::now();
        signal(&child, "-TERM");
        let run = Run::of(child.wait_with_output().unwrap());
        drop(kept);
        assert_eq!((run.exit, &*run.printed), (75, ""), "{typed}: {}", run.said);
        assert!(run.said.contains("interrupted before the first frame"), "{}", run.said);
        assert!(start.elapsed() < Duration::from_secs(30), "it ends at once");
    }
}
