//! Tests the program: what it prints, what it writes, and its exit codes.

mod ahead;
#[cfg(unix)]
mod bake;
mod budget;
mod bytes;
mod cache;
mod counts;
mod display;
mod documentation;
mod exit_codes;
#[cfg(unix)]
mod failures;
#[cfg(unix)]
mod foreign;
mod frames;
mod huge;
mod import;
mod layers;
mod light;
mod looks;
mod memory_limit;
mod parts;
mod photons;
mod pictures;
mod relight;
#[cfg(unix)]
mod sequence;
#[cfg(unix)]
mod shared;
#[cfg(unix)]
mod signals;
mod tools;
#[cfg(unix)]
mod total_time;
#[cfg(unix)]
mod view;
mod watch;
mod why;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A test's own folder, with the scene `scene.txt` in it.
pub(crate) struct Folder(TempDir);

/// A ball under a lamp, 16 x 9 pixels; frames 0 to 25.
const SCENE: &str = "
settings s { imageSamples 2 }
Camera c {
    fps 25
    Film f { width 16 height 9 prefix ball_ output PNG_IMAGE }
    CamSegment only {
        videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
        addPosition { 0 -5 1 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart 0.4
    }
}
light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
phong_info matte { ambient { .1 .1 .1 } diffuse { .7 .6 .5 } }
material_phong matte { phong_info matte }
sphere ball { center { 0 0 0 } radius 1 material matte }
";

/// The same with a floor and an area light, with noisy penumbras, in a size in pixels.
fn noisy_scene([width, height]: [u32; 2]) -> String {
    let film = format!("width {width} height {height}");
    SCENE.replace("width 16 height 9", &film).replace(
        "sphere ball",
        "light_rectangle lamp2 { color { .5 .5 .5 }
            vertex0 { -3 -3 4 } vertex1 { -1 -3 4 } vertex2 { -1 -1 4 } }
         plane floor { normal { 0 0 1 } position { 0 0 -1 } material matte }
         sphere ball",
    )
}

impl Folder {
    fn new() -> Self {
        Self::with_scene(SCENE)
    }

    fn with_scene(text: &str) -> Self {
        let folder =
            Self(tempfile::tempdir().expect("the system has a folder for temporary files"));
        folder.write("scene.txt", text);
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Returns the sorted names in the folder, except `scene.txt`.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| name != "scene.txt").collect();
        names.sort();
        names
    }

    /// Returns a command that runs the program in this folder, with `typed` split at spaces.
    fn command(&self, typed: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_slo-rt"));
        command.current_dir(self.path()).args(typed.split_whitespace());
        for variable in ["NO_COLOR", "CLICOLOR_FORCE", "TERM", "SLO_RT_ISA"] {
            command.env_remove(variable);
        }
        command
    }

    fn run(&self, typed: &str) -> Run {
        Run::of(self.command(typed).output().expect("the program starts"))
    }

    /// Runs the program, which must succeed, and returns its output.
    fn printed(&self, typed: &str) -> String {
        let run = self.run(typed);
        assert_eq!(run.exit, 0, "{typed}: {}", run.said);
        run.printed
    }

    /// Runs the program, which must succeed, and returns what it said on standard error.
    fn said(&self, typed: &str) -> String {
        let run = self.run(typed);
        assert_eq!(run.exit, 0, "{typed}: {}", run.said);
        run.said
    }
}

/// Result of a run.
struct Run {
    exit: i32,
    /// Standard output.
    printed: String,
    /// Standard error.
    said: String,
}

impl Run {
    fn of(output: Output) -> Self {
        Self {
            exit: output.status.code().expect("no signal ended it"),
            printed: String::from_utf8(output.stdout).unwrap(),
            said: String::from_utf8(output.stderr).unwrap(),
        }
    }
}
