//! `why`: what a pixel is made of.

mod json;
mod text;

use std::path::Path;

use crate::cli::args::WhyArgs;
use crate::cli::base::{Exit, Problem, Terminal, print};
use crate::cli::files::load;
use crate::cli::options::{Job, Replay};
use crate::cli::progress::Progress;
use crate::cli::system::interrupt::{self, Guard};
use crate::cli::system::threads;
use slo_render::frame::Aids;
use slo_render::integrator::Account;
use slo_render::render::{Names, Plan, Tally, explain};
use slo_scene::SceneDescription;

/// Explains a pixel on standard output.
pub(crate) fn run(args: &WhyArgs, job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let _guard = Guard::new();
    let pool = threads::pool(job.threads)?;
    let answer = pool.install(|| {
        let scene = load::scene(job, terminal)?;
        answer(args, job, &scene, terminal)
    })?;
    print(answer.as_bytes())
        .map_err(|error| Problem::new(Exit::Failed, format!("can't print the answer: {error}")))
}

fn answer(
    args: &WhyArgs,
    job: &Job,
    scene: &SceneDescription,
    terminal: Terminal,
) -> Result<String, Problem> {
    let film = &scene.camera.film;
    let pixel = args.pixel;
    if pixel.x >= film.width || pixel.y >= film.height {
        let (width, height) = (film.width, film.height);
        let message =
            format!("pixel {pixel} is outside of the picture, which has {width}x{height}");
        let help = "columns and rows count from 0 at the upper left corner";
        return Err(Problem::new(Exit::Usage, message).with_help(help));
    }
    let number = args.frame.unwrap_or(0);
    let mut progress = Progress::new(job.progress, false, 1, 1, terminal);
    progress.call(format!("pixel {pixel}"));
    let build = || load::frame(job.isa, scene, number, Aids::default());
    let frame = interrupt::while_building(build)?;
    let things = frame.things(scene).map_err(|error| Problem::new(Exit::BadInput, error))?;
    let names = Names { frame: &frame, things: &things };
    let samples = match args.sample {
        Some(sample) => sample..sample.saturating_add(1),
        None => 0..args.samples.unwrap_or_else(|| Plan::new(scene).least().max(1)),
    };
    let mut tally = Tally::new(args.ways as usize);
    let mut only: Option<Account> = None;
    Guard::begin_work();
    let shown = progress.frame(number, Path::new(""));
    let part = 1.0 / f64::from((samples.end - samples.start).max(1));
    let mut tell = |sample, account: &Account| {
        tally.add(sample, account, &names);
        shown.advanced(part);
        only = args.sample.map(|_| account.clone());
    };
    let (at, gives_up) = ([pixel.x, pixel.y], || interrupt::requested());
    explain(&frame, at, samples, &gives_up, &mut tell)
        .ok_or_else(|| Problem::new(Exit::Stopped, "interrupted"))?;
    drop(progress);
    if args.json {
        let only = only.as_ref().map(|account| (account, &names));
        let answer = json::answer(&tally, (at, number), only);
        return Ok(format!("{answer:#}\n"));
    }
    let title = match args.sample {
        Some(sample) => format!("sample {sample} of pixel {pixel} of frame {number}"),
        None => format!("pixel {pixel} of frame {number}"),
    };
    let mut text =
        text::summary(&tally, &title, &Replay::of(args).command([pixel.x, pixel.y], args.frame));
    if let Some(account) = &only {
        text += &text::tree(account, &names);
    }
    Ok(text)
}
