//! Derives from the arguments what the program is to do.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::job::{Existing, Job};
use super::overrides::Overrides;
use crate::cli::args::{
    Args, BakeArgs, Command, CompareArgs, DenoiseArgs, GenerateArgs, ImportArgs, MergeArgs,
    RelightArgs, SettingArgs, SheetArgs, VerifyArgs, ViewArgs, WhyArgs,
};
use crate::cli::base::{Exit, Problem, Terminal, Verbosity};
use crate::cli::values::{FrameChoice, Frames, Maps, Threads};
use slo_accel::Isa;
use slo_picture::output::check_prefix;
use slo_scene::cache::Cache;

/// What the program is to do, and how.
#[derive(Debug)]
pub(crate) struct Options {
    /// The task, or what is wrong with it.
    pub(crate) task: Result<Task, Problem>,
    pub(crate) terminal: Terminal,
    /// Most bytes of memory.
    pub(crate) memory_limit: Option<u64>,
}

/// What the program is to do.
#[derive(Debug)]
pub(crate) enum Task {
    /// Render frames.
    Render(Job),
    /// Read a scene and report.
    Check(Job),
    /// Put parts of pictures together.
    Merge(MergeArgs),
    /// Render tiles of pictures again. The job names their scene.
    Verify(VerifyArgs, Box<Job>),
    /// Measure how much a picture differs from another.
    Compare(CompareArgs),
    /// Make a contact sheet.
    Sheet(SheetArgs),
    /// Remove the noise from pictures.
    Denoise(DenoiseArgs),
    /// Show pictures in another light.
    Relight(RelightArgs),
    /// Turn a scene of another program into scene text.
    Import(ImportArgs),
    /// Write the light on objects into images. The job names their scene.
    Bake(BakeArgs, Box<Job>),
    /// Explain a pixel. The job names its scene.
    Why(WhyArgs, Box<Job>),
    /// Show a scene in the browser. The job names it.
    View(ViewArgs, Box<Job>),
    /// Print a manual page, or completions of a shell.
    Generate(GenerateArgs),
    /// Print the recipe of a picture.
    Recipe(PathBuf),
}

impl From<Args> for Options {
    fn from(args: Args) -> Self {
        let Args { quiet, verbose, memory_limit, .. } = args;
        let quiet = match &args.command {
            Some(Command::Merge(merge)) => merge.quiet,
            Some(Command::Denoise(denoise)) => denoise.quiet,
            Some(Command::Relight(relight)) => relight.quiet,
            Some(Command::Import(import)) => import.quiet,
            Some(Command::Bake(bake)) => bake.quiet,
            Some(Command::Why(why)) => why.quiet,
            Some(Command::View(view)) => view.quiet,
            _ => quiet,
        };
        let verbosity = match (quiet, verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        };
        let terminal = Terminal::new(args.color, verbosity);
        Self { terminal, task: task(args, terminal), memory_limit }
    }
}

fn task(mut args: Args, terminal: Terminal) -> Result<Task, Problem> {
    if let Some(command) = args.command.take() {
        return Ok(match command {
            Command::Merge(merge) => Task::Merge(merge),
            Command::Verify(verify) => {
                args.scene = verify.scene.clone();
                args.indir = verify.indir.clone();
                args.allow_outside = verify.allow_outside;
                args.threads = verify.threads;
                Task::Verify(verify, Box::new(job(args, terminal)?))
            }
            Command::Compare(compare) => Task::Compare(compare),
            Command::Sheet(sheet) => Task::Sheet(sheet),
            Command::Denoise(denoise) => Task::Denoise(denoise),
            Command::Relight(relight) => Task::Relight(relight),
            Command::Import(import) => Task::Import(import),
            Command::Bake(bake) => {
                let &BakeArgs { format, look, samples, noise, integrator, photons, seed, .. } =
                    &bake;
                args.settings = SettingArgs {
                    format,
                    look,
                    samples,
                    noise,
                    integrator,
                    photons,
                    seed,
                    ..SettingArgs::default()
                };
                args.scene = Some(bake.scene.clone());
                args.indir = bake.indir.clone();
                args.outdir = bake.outdir.clone();
                args.allow_outside = bake.allow_outside;
                args.overwrite = bake.overwrite;
                args.skip_existing = !bake.overwrite;
                args.threads = bake.threads;
                args.progress = bake.progress;
                args.frame = bake.frame.map(|n| FrameChoice::These(Frames::single(n)));
                Task::Bake(bake, Box::new(job(args, terminal)?))
            }
            Command::Why(why) => {
                let &WhyArgs { size, integrator, photons, seed, .. } = &why;
                args.settings =
                    SettingArgs { size, integrator, photons, seed, ..SettingArgs::default() };
                args.scene = why.file.clone().or_else(|| why.scene.clone());
                args.progress = why.progress;
                args.indir = why.indir.clone();
                args.allow_outside = why.allow_outside;
                args.threads = why.threads;
                Task::Why(why, Box::new(job(args, terminal)?))
            }
            Command::Generate(generate) => Task::Generate(generate),
            Command::View(view) => {
                args.scene = view.scene.clone();
                args.indir = view.indir.clone();
                args.allow_outside = view.allow_outside;
                args.settings = view.settings;
                args.threads = view.threads;
                Task::View(view, Box::new(job(args, terminal)?))
            }
        });
    }
    match args.recipe.clone() {
        Some(picture) => Ok(Task::Recipe(picture)),
        None if args.check => job(args, terminal).map(Task::Check),
        None => job(args, terminal).map(Task::Render),
    }
}

fn job(args: Args, terminal: Terminal) -> Result<Job, Problem> {
    let usage = |why: String| Problem::new(Exit::Usage, why);
    check_prefix(args.prefix.as_deref().unwrap_or_default()).map_err(usage)?;
    let maps = Maps {
        samples: args.sample_map,
        error: args.error_map,
        cost: args.cost_map,
        counts: args.count,
    };
    let several = args.frame.as_ref().is_some_and(FrameChoice::is_several);
    maps.check_names(several).map_err(usage)?;
    if several && args.guide_file.as_ref().is_some_and(|path| !path.tells_frames()) {
        let message = "--guide-file: fields of several frames need `####` in their path";
        return Err(usage(message.into()));
    }
    check_total_time(args.total_time, args.frame.as_ref())?;
    Ok(Job {
        scene: args.scene,
        indir: args.indir,
        allow_outside: args.allow_outside,
        frames: args.frame,
        order: args.order,
        share: args.share,
        region: args.region,
        part: args.part.map(|part| (part, args.part_by)),
        outdir: args.outdir.unwrap_or_default(),
        info: args.info,
        existing: match (args.skip_existing || args.share.is_some(), args.overwrite) {
            (true, _) => Existing::Skip,
            (_, true) => Existing::Overwrite,
            _ => Existing::Auto,
        },
        checkpoint: Some(args.checkpoint).filter(|time| !time.is_zero()),
        keep_state: args.keep_state,
        time: args.time,
        total_time: args.total_time,
        steps: args.steps,
        maps,
        guide_file: args.guide_file,
        display_server: args.display_server,
        dry_run: args.dry_run,
        watch: args.watch,
        progress: args.progress,
        overrides: Overrides {
            prefix: args.prefix,
            layers: args.layers.into_iter().map(|name| name.0).collect(),
            settings: args.settings,
            is_stepwise: args.time.is_some() || args.total_time.is_some() || args.steps.is_some(),
        },
        threads: args.threads.map(|threads| match threads {
            Threads::All => std::thread::available_parallelism().map_or(1, usize::from),
            Threads::Count(threads) => threads as usize,
        }),
        cache: args.cache.map(|folder| {
            let warn = move |text: &str| terminal.warn(text);
            Arc::new(Cache::new(&folder, args.cache_size, warn))
        }),
        isa: Isa::from_env().map_err(|why| usage(format!("SLO_RT_ISA: {why}")))?,
    })
}

/// Checks that a time for all frames comes with a sequence of frames that share it.
fn check_total_time(time: Option<Duration>, frames: Option<&FrameChoice>) -> Result<(), Problem> {
    let is_sequence = frames.is_some_and(FrameChoice::is_sequence);
    match time {
        Some(_) if !is_sequence => {
            let message = "--total-time needs a sequence of frames, such as `--frame 1-100`";
            Err(Problem::new(Exit::Usage, message).with_help("for one frame, use `--time`"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    fn task(typed: &str) -> Result<Task, Problem> {
        let args = Args::parse_from(format!("slo-rt {typed}").trim().split(' '));
        Options::from(args).task
    }

    #[test]
    fn tasks() {
        assert!(matches!(task("").unwrap(), Task::Render(Job { frames: None, .. })));
        assert!(matches!(task("--check -f 3").unwrap(), Task::Check(Job { frames: Some(_), .. })));
        assert!(matches!(task("--recipe x.png").unwrap(), Task::Recipe(_)));
    }

    #[test]
    fn sequences_skip_what_is_finished() {
        let check = |typed: &str, expected: bool| {
            let Task::Render(job) = task(typed).unwrap() else { panic!("{typed}") };
            assert_eq!(job.skips_finished(), expected, "{typed}");
        };
        check("", false);
        check("-f 5", false);
        check("-f 5 --skip-existing", true);
        check("-f 5 --share", true);
        check("-f 5-5", true);
        check("-f all", true);
        check("-f 5,6 --overwrite", false);
    }

    #[test]
    fn a_time_for_all_frames_needs_frames() {
        assert!(task("-f 1-3 --total-time 8h").is_ok());
        for typed in ["--total-time 8h", "-f 3 --total-time 8h"] {
            assert_eq!(task(typed).unwrap_err().exit, Exit::Usage, "{typed}");
        }
    }

    #[test]
    fn a_prefix_with_a_folder_is_a_usage_error() {
        assert_eq!(task("--prefix a/b").unwrap_err().exit, Exit::Usage);
    }
}
