//! Validated options: what the commands work with.

use std::path::PathBuf;
use std::time::Duration;

use super::Exit;
use super::args::{
    Args, Command, CompareArgs, DenoiseArgs, FrameChoice, MergeArgs, PartBy, Region, SheetArgs,
    SizeChoice, Threads, VerifyArgs,
};
use super::maps::Maps;
use super::problem::Problem;
use super::progress::ProgressForm;
use super::room::Beside;
use super::sequence::{Frames, Order};
use super::terminal::{Terminal, Verbosity};
use crate::accel::{Accelerator, Isa};
use crate::animation::Clock;
use crate::output::check_prefix;
use crate::render::{Part, Steps};
use crate::scene::{Layer, OutputFormat, SceneDescription};

/// What the program is to do, and how.
#[derive(Debug)]
pub(super) struct Options {
    /// What to do, or what is wrong with it.
    pub(super) task: Result<Task, Problem>,
    pub(super) terminal: Terminal,
}

/// What the program is to do.
#[derive(Debug)]
pub(super) enum Task {
    /// Render frames.
    Render(Job),
    /// Read a scene and report.
    Check(Job),
    /// Put parts of pictures together.
    Merge(MergeArgs),
    /// Render some of pictures again; the job says of which scene.
    Verify(VerifyArgs, Box<Job>),
    /// Measure how far a picture is from another.
    Compare(CompareArgs),
    /// Make a contact sheet.
    Sheet(SheetArgs),
    /// Take the noise out of pictures.
    Denoise(DenoiseArgs),
    /// Print the recipe of a picture.
    Recipe(PathBuf),
}

/// Frames of a scene.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// The scene file; `None`: the one inside the program.
    pub(super) scene: Option<PathBuf>,
    /// Folder that `scene` lies in and that its paths may not leave.
    pub(super) indir: Option<PathBuf>,
    /// Whether the paths of the scene may lead anywhere.
    pub(super) allow_outside: bool,
    /// The frames asked for; `None`: 0.
    pub(super) frames: Option<FrameChoice>,
    pub(super) order: Order,
    /// Whether other processes render the same frames, and how long they let each other pass without
    /// a sign of life.
    pub(super) share: Option<Duration>,
    /// What of the picture is to be rendered; `None`: all of it.
    pub(super) region: Option<Region>,
    /// The part of it that is this run's, and what is shared out; `None`: all.
    pub(super) part: Option<(Part, PartBy)>,
    /// Folder of the pictures; empty: the current one.
    pub(super) outdir: PathBuf,
    /// Whether settings and time go into the pictures' names.
    pub(super) info: bool,
    pub(super) existing: Existing,
    /// Time between two checkpoints; `None`: only where a frame is stopped.
    pub(super) checkpoint: Option<Duration>,
    /// Whether finished frames can get more samples later.
    pub(super) keep_state: bool,
    pub(super) maps: Maps,
    /// How long a frame may take; `None`: as long as its samples take.
    pub(super) time: Option<Duration>,
    /// How long all frames together may take.
    pub(super) total_time: Option<Duration>,
    /// How far a frame is taken, step by step, instead of by the scene's rule.
    pub(super) steps: Option<Steps>,
    /// Whether to say what would be rendered instead of doing it.
    pub(super) dry_run: bool,
    pub(super) progress: ProgressForm,
    pub(super) overrides: Overrides,
    pub(super) threads: Option<usize>,
    pub(super) isa: Isa,
}

/// Samples of a block at most, where only its noise was asked for.
const MOST_FOR_NOISE: u32 = 4096;

/// What becomes of a picture that is there, whole and with the same recipe. A file that slo-rt did not
/// make is only replaced with [`Existing::Overwrite`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Existing {
    /// It stays in a sequence, and is overwritten where one frame was asked for.
    #[default]
    Auto,
    Skip,
    Overwrite,
}

/// What the command line says over the scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Overrides {
    pub(super) prefix: Option<String>,
    /// Of EXR pictures; empty: none.
    pub(super) layers: Vec<Layer>,
    pub(super) format: Option<OutputFormat>,
    pub(super) size: Option<SizeChoice>,
    pub(super) samples: Option<u32>,
    pub(super) noise: Option<f32>,
    /// The number of samples is decided by noise or time, not by the scene.
    pub(super) is_stepwise: bool,
    pub(super) seed: Option<u64>,
    pub(super) accelerator: Option<Accelerator>,
    /// Asked for, whatever the scene says.
    pub(super) spatial_splits: bool,
}

impl Job {
    /// The frames to render, of a job [for a scene](Self::for_scene).
    pub(super) fn frames(&self) -> Frames {
        match &self.frames {
            Some(FrameChoice::These(frames)) => frames.clone(),
            Some(FrameChoice::All) | None => Frames::single(0),
        }
    }

    /// The same where the frames of the scene are known.
    ///
    /// # Errors
    /// All are asked for, and there are none, or too many for one run.
    pub(super) fn for_scene(&self, scene: &SceneDescription) -> Result<Self, Problem> {
        let mut job = self.clone();
        if job.frames == Some(FrameChoice::All) {
            let ranges = Clock::new(&scene.camera).segments().map(|s| s.first..=s.last).collect();
            let frames = Frames::of_ranges(ranges).map_err(|why| {
                Problem::new(Exit::Usage, format!("`--frame all`: {why}"))
                    .with_help("`--frame 1-100` names some frames")
            })?;
            job.frames = Some(FrameChoice::These(frames));
        }
        Ok(job)
    }

    /// Whether the clock decides how far a frame is taken.
    pub(super) fn is_timed(&self) -> bool {
        self.time.is_some() || self.total_time.is_some()
    }

    /// What is written beside pictures.
    pub(super) fn beside(&self) -> Beside {
        Beside { maps: !self.maps.is_empty(), states: self.keep_state }
    }

    /// Whether files are replaced whatever they are.
    pub(super) fn overwrites(&self) -> bool {
        self.existing == Existing::Overwrite
    }

    /// Whether frames that are finished already are left alone.
    pub(super) fn skips_finished(&self) -> bool {
        match self.existing {
            Existing::Auto => self.frames.as_ref().is_some_and(FrameChoice::is_sequence),
            Existing::Skip => true,
            Existing::Overwrite => false,
        }
    }
}

impl From<Args> for Options {
    fn from(args: Args) -> Self {
        let Args { quiet, verbose, .. } = args;
        let quiet = match &args.command {
            Some(Command::Merge(merge)) => merge.quiet,
            Some(Command::Denoise(denoise)) => denoise.quiet,
            _ => quiet,
        };
        let verbosity = match (quiet, verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        };
        Self { terminal: Terminal::new(args.color, verbosity), task: task(args) }
    }
}

fn task(mut args: Args) -> Result<Task, Problem> {
    if let Some(command) = args.command.take() {
        return Ok(match command {
            Command::Merge(merge) => Task::Merge(merge),
            Command::Verify(verify) => {
                args.scene = verify.scene.clone();
                args.indir = verify.indir.clone();
                args.allow_outside = verify.allow_outside;
                args.threads = verify.threads;
                Task::Verify(verify, Box::new(job(args)?))
            }
            Command::Compare(compare) => Task::Compare(compare),
            Command::Sheet(sheet) => Task::Sheet(sheet),
            Command::Denoise(denoise) => Task::Denoise(denoise),
        });
    }
    match args.recipe.clone() {
        Some(picture) => Ok(Task::Recipe(picture)),
        None if args.check => job(args).map(Task::Check),
        None => job(args).map(Task::Render),
    }
}

fn job(args: Args) -> Result<Job, Problem> {
    let usage = |why: String| Problem::new(Exit::Usage, why);
    check_prefix(args.prefix.as_deref().unwrap_or_default()).map_err(usage)?;
    let maps = Maps { samples: args.sample_map, error: args.error_map };
    let several = args.frame.as_ref().is_some_and(FrameChoice::is_several);
    maps.check_names(several).map_err(usage)?;
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
        dry_run: args.dry_run,
        progress: args.progress,
        overrides: Overrides {
            prefix: args.prefix,
            layers: args.layers.into_iter().map(Layer::from).collect(),
            format: args.format.map(OutputFormat::from),
            size: args.size,
            samples: args.samples,
            noise: args.noise,
            is_stepwise: args.time.is_some() || args.total_time.is_some() || args.steps.is_some(),
            seed: args.seed,
            accelerator: args.accelerator.map(Accelerator::from),
            spatial_splits: args.spatial_splits,
        },
        threads: args.threads.map(|threads| match threads {
            Threads::All => std::thread::available_parallelism().map_or(1, usize::from),
            Threads::Count(threads) => threads as usize,
        }),
        isa: Isa::from_env().map_err(|why| usage(format!("SLO_RT_ISA: {why}")))?,
    })
}

/// A time for all frames is shared out among frames.
fn check_total_time(time: Option<Duration>, frames: Option<&FrameChoice>) -> Result<(), Problem> {
    let is_sequence = frames.is_some_and(FrameChoice::is_sequence);
    match time {
        Some(_) if !is_sequence => {
            let message = "--total-time is for a sequence, and --frame names none, such as 1-100";
            Err(Problem::new(Exit::Usage, message).with_help("`--time` is for one frame"))
        }
        _ => Ok(()),
    }
}

impl Overrides {
    /// Puts what the command line says in the place of what the scene says.
    ///
    /// `samples` counts camera samples per pixel, whatever they sample: it stands for the product
    /// of `imageSamples` and `dofSamples`.
    pub(super) fn apply(&self, scene: &mut SceneDescription) {
        let film = &mut scene.camera.film;
        film.prefix = self.prefix.clone().unwrap_or_else(|| film.prefix.clone());
        if let Some(size) = self.size {
            let size = size.of(film.width, film.height);
            (film.width, film.height) = (size.width, size.height);
        }
        film.output = self.format.unwrap_or(film.output);
        if !self.layers.is_empty() {
            film.layers.clone_from(&self.layers);
            film.layers.sort_unstable();
            film.layers.dedup();
        }
        let settings = &mut scene.settings;
        settings.noise = self.noise.or(settings.noise);
        let open = (self.noise.is_some() || self.is_stepwise).then_some(MOST_FOR_NOISE);
        if let Some(samples) = self.samples.or(open) {
            let adaptive = settings.image_min_samples < settings.image_samples;
            let least = if adaptive { settings.image_min_samples } else { samples };
            settings.image_min_samples = least.min(samples);
            settings.image_samples = samples;
            settings.dof_samples = 1;
        }
        settings.seed = self.seed.unwrap_or(settings.seed);
        settings.accelerator = self.accelerator.unwrap_or(settings.accelerator);
        settings.spatial_splits |= self.spatial_splits;
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::test_scene::empty_scene;

    fn check_samples(scene: (u32, u32, u32), samples: u32, expected: (u32, u32, u32)) {
        let mut description = empty_scene();
        let settings = &mut description.settings;
        (settings.image_min_samples, settings.image_samples, settings.dof_samples) = scene;
        Overrides { samples: Some(samples), ..Overrides::default() }.apply(&mut description);
        let settings = &description.settings;
        let result = (settings.image_min_samples, settings.image_samples, settings.dof_samples);
        assert_eq!(result, expected, "--samples {samples} over {scene:?}");
    }

    #[test]
    fn samples_are_all_camera_samples() {
        check_samples((16, 16, 6), 4, (4, 4, 1));
        check_samples((16, 16, 1), 64, (64, 64, 1));
        check_samples((32, 256, 2), 128, (32, 128, 1));
        check_samples((32, 256, 2), 8, (8, 8, 1));
    }

    #[test]
    fn without_options_the_scene_stays() {
        let mut scene = empty_scene();
        Overrides::default().apply(&mut scene);
        assert_eq!(scene.settings, empty_scene().settings);
        assert_eq!(scene.camera.film, empty_scene().camera.film);
    }

    #[test]
    fn options_replace_what_the_scene_says() {
        let mut scene = empty_scene();
        let overrides = Overrides {
            prefix: Some("p".into()),
            size: Some(SizeChoice::Share(0.5)),
            seed: Some(7),
            accelerator: Some(Accelerator::None),
            spatial_splits: true,
            format: Some(OutputFormat::Exr),
            layers: vec![Layer::Normal, Layer::Albedo, Layer::Normal],
            ..Overrides::default()
        };
        overrides.apply(&mut scene);
        let film = &scene.camera.film;
        assert_eq!((film.width, film.height, &*film.prefix), (16, 9, "p"));
        assert_eq!((film.output, &film.layers[..]), (OutputFormat::Exr, &Layer::ALL[..]));
        assert_eq!((scene.settings.seed, scene.settings.accelerator), (7, Accelerator::None));
        assert!(scene.settings.spatial_splits);
    }

    #[test]
    fn a_noise_level_has_samples_enough() {
        let mut scene = empty_scene();
        let overrides = Overrides { noise: Some(0.01), ..Overrides::default() };
        overrides.apply(&mut scene);
        assert_eq!((scene.settings.noise, scene.settings.image_samples), (Some(0.01), 4096));
        Overrides { samples: Some(64), ..overrides }.apply(&mut scene);
        assert_eq!(scene.settings.image_samples, 64);
    }

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
