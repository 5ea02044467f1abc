//! The options of the program itself: what is rendered, where it goes, and how.

use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use clap::builder::Styles;

use super::commands::Command;
use super::help::{ABOUT, EXAMPLES, EXIT_CODES, LONG_ABOUT};
use crate::cli::base::When;
use crate::cli::values::{
    AcceleratorName, FormatName, FrameChoice, FramePath, LayerName, Order, PartBy, ProgressForm,
    Region, SizeChoice, Threads, frames, interval, lease, noise, part, region, samples, seed, size,
    steps, threads, time,
};
use crate::render::{Part, Steps};

const COMMANDS: &str = "Commands, beside rendering";
const WHAT: &str = "What to render";
const WHERE: &str = "Where it goes";
const DRAFT: &str = "Instead of the scene's settings";
const HOW: &str = "How it runs";
const INSTEAD: &str = "Instead of rendering";

/// See [`ABOUT`]; every member is one option.
#[derive(Debug, Parser)]
#[command(
    name = "slo-rt",
    version,
    about = ABOUT,
    long_about = LONG_ABOUT,
    after_help = EXAMPLES,
    after_long_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"),
    override_usage = "slo-rt [--scene FILE] [--frame FRAMES] [options]",
    disable_help_flag = true,
    disable_version_flag = true,
    styles = Styles::styled(),
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    subcommand_help_heading = COMMANDS,
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,

    /// Scene file [the scene inside the program]
    #[arg(short, long, value_name = "FILE", help_heading = WHAT)]
    pub(crate) scene: Option<PathBuf>,

    /// Frames, such as 15, 1-100, 1-100x5, 3,-5--1 or all (0)
    ///
    /// 1-100x5 is every fifth, 1-100y5 all but those, 1-100:5 every fifth and
    /// then the ones in between, ever denser. Of a range or a list, frames that
    /// are finished stay as they are.
    #[arg(short, long, value_name = "FRAMES", help_heading = WHAT, value_parser = frames)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) frame: Option<FrameChoice>,

    /// Order of the frames: forward, reverse, or coarse (every 16th first)
    #[arg(long, value_name = "NAME", help_heading = WHAT, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = Order::Forward, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) order: Order,

    /// Share the frames out with all that run this command on the folder
    ///
    /// On any machines. Each frame is rendered by one of them. A process that
    /// gives no sign of life for so long (60s) is dead, and another one goes on
    /// with its frame. Returns when all frames are there.
    #[arg(long, value_name = "TIME", help_heading = WHAT, verbatim_doc_comment)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "60")]
    #[arg(value_parser = lease)]
    #[arg(conflicts_with_all = ["overwrite", "check"])]
    pub(crate) share: Option<Duration>,

    /// A region of the picture, such as 320x180+0+90
    ///
    /// Columns and rows from the upper left corner. Its pixels are those of the
    /// whole picture.
    #[arg(long, value_name = "WxH+X+Y", help_heading = WHAT, value_parser = region)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) region: Option<Region>,

    /// A part of each picture, such as 3/10: the third of ten
    ///
    /// Instead of a picture there is a file of samples. `slo-rt merge` makes the
    /// picture of all parts, byte for byte the one of a single run.
    #[arg(long, value_name = "K/N", help_heading = WHAT, value_parser = part)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["info", "keep_state"], verbatim_doc_comment)]
    pub(crate) part: Option<Part>,

    /// What is shared out in parts: pixels or samples
    #[arg(long, value_name = "NAME", help_heading = WHAT, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = PartBy::Pixels, hide_default_value = true)]
    #[arg(ignore_case = true)]
    #[arg(requires = "part")]
    pub(crate) part_by: PartBy,

    /// Folder that holds the scene file (short: -id)
    ///
    /// The path of --scene starts there, and paths in the scene may not leave it.
    /// Without it they may not leave the current folder, or the folder of the
    /// scene where that lies elsewhere.
    #[arg(long, value_name = "DIR", help_heading = WHAT, requires = "scene")]
    #[arg(verbatim_doc_comment)]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long, help_heading = WHAT)]
    pub(crate) allow_outside: bool,

    /// Folder for the picture, made where missing (short: -od) [the current one]
    #[arg(long, value_name = "DIR", help_heading = WHERE, alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// Beginning of the picture's name (short: -pre) [the scene's]
    #[arg(long, value_name = "TEXT", help_heading = WHERE)]
    pub(crate) prefix: Option<String>,

    /// Add the settings and the render time to the picture's name
    #[arg(short, long, help_heading = WHERE)]
    pub(crate) info: bool,

    /// Leave a picture that is there already, as in sequences
    ///
    /// A picture is taken for the one that this run would make when it is whole
    /// and holds the same recipe: scene, frame, settings and version.
    #[arg(long, help_heading = WHERE, conflicts_with_all = ["check", "overwrite"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) skip_existing: bool,

    /// Render again what is there already, in sequences too
    #[arg(long, help_heading = WHERE, conflicts_with = "check")]
    pub(crate) overwrite: bool,

    /// Time between checkpoints of a frame, such as 5m; 0 for none (60s)
    ///
    /// A frame that was stopped, or killed, goes on from its last checkpoint. The
    /// file lies beside the picture, and is gone when the picture is there.
    #[arg(long, value_name = "TIME", help_heading = WHERE, default_value = "60")]
    #[arg(hide_default_value = true, allow_hyphen_values = true, verbatim_doc_comment)]
    #[arg(value_parser = interval)]
    pub(crate) checkpoint: Duration,

    /// Keep what is needed to add samples to a picture later
    ///
    /// In a file beside the picture, .state in the place of .png or .exr. A run
    /// that asks for more samples, or less noise, goes on from there.
    #[arg(long, help_heading = WHERE, verbatim_doc_comment)]
    pub(crate) keep_state: bool,

    /// Write how many samples each pixel took; #### is the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) sample_map: Option<FramePath>,

    /// Write the estimated error of each pixel; #### is the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) error_map: Option<FramePath>,

    /// What an EXR picture holds beside colours: albedo, normal
    ///
    /// For denoisers: the share of light that surfaces send back, and the
    /// directions that they face, as channels of the same file.
    #[arg(long, value_name = "NAMES", help_heading = WHERE, hide_possible_values = true)]
    #[arg(value_enum, value_delimiter = ',', ignore_case = true, verbatim_doc_comment)]
    pub(crate) layers: Vec<LayerName>,

    /// File format: png, png16 or exr
    #[arg(long, value_name = "NAME", help_heading = DRAFT, hide_possible_values = true)]
    #[arg(ignore_case = true)]
    pub(crate) format: Option<FormatName>,

    /// Size of the picture, such as 320x180, 1080p, or 50% of the scene's
    #[arg(long, value_name = "WxH", help_heading = DRAFT, value_parser = size)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) size: Option<SizeChoice>,

    /// Camera samples per pixel
    ///
    /// At most so many, and in all: N stands for imageSamples, dofSamples becomes
    /// 1, and imageMinSamples becomes N where it is more. Samples of shadows and
    /// of glossy surfaces stay.
    #[arg(long, value_name = "N", help_heading = DRAFT, verbatim_doc_comment)]
    #[arg(allow_hyphen_values = true, value_parser = samples)]
    pub(crate) samples: Option<u32>,

    /// Error at which a picture is clean enough, such as 0.01
    ///
    /// As the viewer sees it: 1 is the range from black to white, 0.004 a step of
    /// 8 bits. Each block of 8 x 8 pixels takes samples until its estimated error
    /// is below, --samples at most (4096 without it).
    #[arg(long, value_name = "E", help_heading = DRAFT, value_parser = noise)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) noise: Option<f32>,

    /// Time that a frame may take, such as 90s, 15m or 1h30m
    ///
    /// Samples go where the noise is, until the time is over. The recipe says what
    /// it came to, and --steps makes the same picture without the clock.
    #[arg(long, value_name = "TIME", help_heading = DRAFT, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["noise", "steps", "part", "region"], verbatim_doc_comment)]
    pub(crate) time: Option<Duration>,

    /// Time that all frames together may take, such as 8h
    ///
    /// They come out equally clean: round by round all of them get better, until
    /// the time is over. A run that was stopped or killed goes on from there, and
    /// has the rest of the time. Recipes and --steps as with --time.
    #[arg(long, value_name = "TIME", help_heading = DRAFT, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["time", "noise", "steps", "part", "region", "share", "info"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) total_time: Option<Duration>,

    /// How far --time or --total-time came: the two numbers in a recipe
    #[arg(long, value_name = "STEP,TILES", help_heading = DRAFT, value_parser = steps)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with = "noise")]
    pub(crate) steps: Option<Steps>,

    /// Seed of the noise
    #[arg(long, value_name = "N", help_heading = DRAFT, value_parser = seed)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) seed: Option<u64>,

    /// Structure for the rays: kdtree, bvh, cwbvh or none
    #[arg(long, value_name = "NAME", help_heading = DRAFT, hide_possible_values = true)]
    #[arg(ignore_case = true)]
    pub(crate) accelerator: Option<AcceleratorName>,

    /// Let the BVH cut long triangles: bounces are faster, shadows slower
    #[arg(long, help_heading = DRAFT)]
    pub(crate) spatial_splits: bool,

    /// Threads, or auto for all [parallelThreads of the scene, or all]
    #[arg(long, value_name = "N", help_heading = HOW, allow_hyphen_values = true)]
    #[arg(value_parser = threads)]
    pub(crate) threads: Option<Threads>,

    /// Say nothing but warnings and errors
    #[arg(short, long, help_heading = HOW)]
    pub(crate) quiet: bool,

    /// Say more at the end
    #[arg(short, long, help_heading = HOW, conflicts_with = "quiet")]
    pub(crate) verbose: bool,

    /// Progress: auto, plain, json, openjd, none
    #[arg(long, value_name = "FORM", help_heading = HOW, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = ProgressForm::Auto, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) progress: ProgressForm,

    /// Colour of messages: auto, always, never
    #[arg(long, value_name = "WHEN", help_heading = HOW, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = When::Auto, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) color: When,

    /// Read the scene and all its files, report, render nothing
    #[arg(long, help_heading = INSTEAD)]
    pub(crate) check: bool,

    /// Say what would be rendered, frame by frame, and why
    #[arg(long, help_heading = INSTEAD, conflicts_with = "check")]
    pub(crate) dry_run: bool,

    /// Print how a picture was made
    ///
    /// The recipe is in every PNG and EXR file of this program: version, hash of
    /// the scene, frame, seed, and all settings that count, as JSON.
    #[arg(long, value_name = "FILE", help_heading = INSTEAD, exclusive = true)]
    #[arg(verbatim_doc_comment)]
    pub(crate) recipe: Option<PathBuf>,

    /// Help; --help says more
    #[arg(short, long, help_heading = INSTEAD, action = clap::ArgAction::Help)]
    help: (),

    /// Version
    #[arg(short = 'V', long, help_heading = INSTEAD, action = clap::ArgAction::Version)]
    version: (),
}
