//! `--time`: a span of time instead of a number of samples.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Folder, Run, noisy_scene};

/// A scene so large that the last step is never reached.
fn folder() -> Folder {
    Folder::with_scene(&noisy_scene([400, 300]))
}

/// Returns the option that reproduces a picture.
fn steps(folder: &Folder, name: &str) -> String {
    let recipe = folder.printed(&format!("--recipe {name}"));
    let recipe: serde_json::Value = serde_json::from_str(&recipe).unwrap();
    format!("--steps {},{}", recipe["steps"][0], recipe["steps"][1])
}

#[track_caller]
fn check_again(folder: &Folder, name: &str) {
    let steps = steps(folder, name);
    folder.printed(&format!("-q -s scene.txt -od again --overwrite {steps}"));
    assert!(folder.read(name) == folder.read(&format!("again/{name}")), "{steps}: other bytes");
}

/// The project's limit is 5 %; the test allows more for a busy machine.
#[test]
fn a_frame_takes_its_time_and_can_be_made_again_without_the_clock() {
    let folder = folder();
    let start = Instant::now();
    folder.printed("-q -s scene.txt --time 1500ms");
    let took = start.elapsed().as_secs_f64();
    assert!((0.8..6.0).contains(&took), "{took}");
    let name = "ball_00000.png";
    check_again(&folder, name);
    let verified = folder.printed(&format!("verify {name} -s scene.txt --tiles 20"));
    assert!(verified.starts_with("same\t"), "{verified}");
    let run = folder.run("-s scene.txt --time 1500ms --skip-existing");
    assert!(run.said.contains("is finished already"), "{}", run.said);
}

#[test]
fn there_is_a_picture_however_little_time_there_is() {
    let folder = folder();
    folder.printed("-q -s scene.txt --time 1ms");
    assert_eq!(steps(&folder, "ball_00000.png"), "--steps 0,0");
    check_again(&folder, "ball_00000.png");
}

#[test]
fn a_frame_that_was_stopped_goes_on_from_there() {
    let folder = folder();
    for _ in 0..2 {
        let mut command = folder.command("-q -s scene.txt --time 60s");
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        sleep(Duration::from_millis(1200));
        let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.exit, 75, "{}", run.said);
    }
    folder.printed("-q -s scene.txt --time 500ms");
    assert_eq!(folder.names(), ["ball_00000.png"]);
    check_again(&folder, "ball_00000.png");
}
