//! The command line: arguments as typed -> validated options -> commands and exit codes.

mod args;
mod check;
mod checkpoint;
mod compare;
mod crash;
mod default_scene;
mod denoise;
mod interrupt;
mod load;
mod maps;
mod memory;
mod merge;
mod new_folders;
mod options;
mod parse;
mod part_names;
mod patience;
mod problem;
mod progress;
mod recipe;
mod render;
mod room;
mod scene_file;
mod sequence;
mod sheet;
mod short_forms;
mod summary;
mod target;
mod terminal;
#[cfg(test)]
mod test_scene;
mod tips;
mod verify;

use std::ffi::OsString;
use std::process::ExitCode;

use options::{Options, Task};
use problem::Problem;
use terminal::Terminal;

/// What the program tells its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything asked for was done.
    Done = 0,
    /// Rendering failed, or a file could not be read or written; frames of a sequence failed.
    Failed = 1,
    /// The command line is wrong, or names a frame that the scene does not have.
    Usage = 2,
    /// The scene, or a mesh or texture of it, has errors.
    BadInput = 65,
    /// An input file is missing or can't be read.
    NoInput = 66,
    /// The output can't be created, or a file that slo-rt did not make has its name.
    CantCreate = 73,
    /// Writing failed.
    CantWrite = 74,
    /// Stopped on purpose; the same command goes on from there.
    Stopped = 75,
    /// Ended at once by a second signal.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Runs the program with its arguments, the program's name first.
///
/// Writes the pictures' paths to standard output and all else to standard error. Listens to
/// Ctrl-C and catches panics: it is meant to be called once, by `main`.
pub fn run(args: impl IntoIterator<Item = OsString>) -> Exit {
    let args: Vec<OsString> = args.into_iter().collect();
    crash::reported(&args, || {
        interrupt::listen();
        match parse::parse(&args) {
            Ok(args) => execute(Options::from(args)),
            Err(exit) => exit,
        }
    })
}

fn execute(Options { task, terminal }: Options) -> Exit {
    let done = task.and_then(|task| match task {
        Task::Render(job) => sequence::run(&job, terminal),
        Task::Merge(args) => merge::run(&args, terminal),
        Task::Verify(args, job) => verify::run(&args, &job, terminal),
        Task::Compare(args) => compare::run(&args),
        Task::Sheet(args) => sheet::run(&args),
        Task::Denoise(args) => denoise::run(&args, terminal),
        Task::Check(job) => check::run(&job, terminal),
        Task::Recipe(picture) => recipe::run(&picture),
    });
    match done {
        Ok(()) => Exit::Done,
        Err(problem) => tell(&problem, terminal),
    }
}

fn tell(problem: &Problem, terminal: Terminal) -> Exit {
    if !problem.message.is_empty() {
        terminal.error(&problem.message, &problem.help);
    }
    problem.exit
}
