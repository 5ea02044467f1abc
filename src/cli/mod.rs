//! The command line: arguments as typed -> validated options -> commands and exit codes.
//!
//! The folders are floors, and each imports only from the floors below it. From the ground up:
//! `base` (exit codes, problems, messages), `values` (of options), `args` (the command line as
//! typed), `options` (what it asks for), what several commands need (`system`, `files`,
//! `progress`, `claims`), and `commands`. No command imports another.

mod args;
mod base;
mod claims;
mod commands;
mod files;
#[doc(hidden)]
pub mod fuzzing;
mod options;
mod progress;
mod system;
mod values;

use std::ffi::OsString;

use crate::gpu;
pub use base::Exit;
use base::{Problem, Terminal};
use commands::{
    bake, check, compare, denoise, generate, import, merge, recipe, relight, render, sheet, verify,
    view, why,
};
use options::{Options, Task};
use system::{crash, interrupt, memory};

/// Runs the program with its arguments, which begin with the program's name.
///
/// Writes the pictures' paths to standard output and all else to standard error. Listens for
/// Ctrl-C and catches panics, so it is meant to be called once, by `main`.
pub fn run(args: impl IntoIterator<Item = OsString>) -> Exit {
    let args: Vec<OsString> = args.into_iter().collect();
    crash::reported(&args, || {
        interrupt::listen();
        gpu::offer();
        match args::parse(&args) {
            Ok(args) => execute(Options::from(args)),
            Err(exit) => exit,
        }
    })
}

fn execute(Options { task, terminal, memory_limit }: Options) -> Exit {
    memory::limit(memory_limit);
    let done = task.and_then(|task| match task {
        Task::Render(job) => render::run(&job, terminal),
        Task::Merge(args) => merge::run(&args, terminal),
        Task::Verify(args, job) => verify::run(&args, &job, terminal),
        Task::Compare(args) => compare::run(&args),
        Task::Sheet(args) => sheet::run(&args),
        Task::Denoise(args) => denoise::run(&args, terminal),
        Task::Relight(args) => relight::run(&args, terminal),
        Task::Import(args) => import::run(&args, terminal),
        Task::Bake(args, job) => bake::run(&args, &job, terminal),
        Task::View(args, job) => view::run(&args, *job, terminal),
        Task::Why(args, job) => why::run(&args, &job, terminal),
        Task::Generate(args) => generate::run(&args),
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
