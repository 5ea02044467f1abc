//! `--watch`: pictures that follow their scene.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Stdio};
use std::time::Duration;

use super::{Folder, SCENE};

struct Watching {
    child: Child,
    printed: BufReader<std::process::ChildStdout>,
}

impl Watching {
    fn new(folder: &Folder, typed: &str) -> Self {
        let mut command = folder.command(typed);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let printed = BufReader::new(child.stdout.take().unwrap());
        Self { child, printed }
    }

    /// Waits for the path of the next picture.
    fn next(&mut self) -> String {
        let mut line = String::new();
        self.printed.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    /// Ends the program; returns what it said.
    fn end(mut self) -> String {
        self.child.kill().unwrap();
        let mut said = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        self.child.wait().unwrap();
        said
    }
}

/// Waits until another time of change is sure to differ.
fn let_time_pass() {
    std::thread::sleep(Duration::from_millis(60));
}

#[test]
fn a_picture_follows_the_scene_and_its_files() {
    let text = SCENE.replace("sphere ball", "include more.txt\n sphere ball");
    let folder = Folder::with_scene(&text);
    folder.write("more.txt", "");
    let mut watching = Watching::new(&folder, "-s scene.txt --watch --color never");
    assert_eq!(watching.next(), "ball_00000.png");
    let first = folder.read("ball_00000.png");
    let_time_pass();
    folder.write("more.txt", "sphere other { center { 0 0 0 } radius 1.5 material matte }");
    assert_eq!(watching.next(), "ball_00000.png");
    let second = folder.read("ball_00000.png");
    assert!(first != second);
    // A mistake is reported, and the next change is rendered.
    folder.write("scene.txt", text.replace("radius 1", "radios 1"));
    std::thread::sleep(Duration::from_millis(600));
    folder.write("scene.txt", &text);
    folder.write("more.txt", "");
    assert_eq!(watching.next(), "ball_00000.png");
    assert!(folder.read("ball_00000.png") == first);
    let said = watching.end();
    assert!(said.contains("unknown attribute `radios`"), "{said}");
    assert!(said.contains("waiting for changes"), "{said}");
}

#[test]
fn a_frame_whose_scene_changes_is_dropped() {
    let text = SCENE.replace("imageSamples 2", "imageSamples 65535 imageContrastLimit 0");
    let text = text.replace("width 16 height 9", "width 640 height 360");
    let folder = Folder::with_scene(&text);
    let mut watching = Watching::new(&folder, "-s scene.txt --watch --color never --progress json");
    let mut said = BufReader::new(watching.child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("\"started\"") {
        line.clear();
        assert!(said.read_line(&mut line).unwrap() > 0);
    }
    let_time_pass();
    folder.write("scene.txt", SCENE);
    assert_eq!(watching.next(), "ball_00000.png");
    watching.child.kill().unwrap();
    watching.child.wait().unwrap();
}
