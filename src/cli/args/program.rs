//! The options of the program itself: what is rendered, where it goes, and how.

use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use clap::builder::Styles;

use super::commands::Command;
use super::help::{ABOUT, EXAMPLES, EXIT_CODES, LONG_ABOUT, SETTINGS};
use super::settings::SettingArgs;
use crate::cli::base::When;
use crate::cli::values::{
    FrameChoice, FramePath, LayerName, Order, PartBy, ProgressForm, Region, Threads, frames,
    interval, lease, part, region, steps, threads, time,
};
use slo_picture::film::Steps;
use slo_render::render::Part;

const COMMANDS: &str = "Commands besides rendering";
const WHAT: &str = "What to render";
const WHERE: &str = "Where it goes";
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

    /// Scene file [the built-in scene]
    #[arg(short, long, value_name = "FILE", help_heading = WHAT)]
    pub(crate) scene: Option<PathBuf>,

    /// Frames, such as 15, 1-100, 1-100x5, 3,-5--1 or all (0)
    ///
    /// 1-100x5 is every fifth frame, 1-100y5 all but those, 1-100:5 every fifth
    /// and then the ones in between, ever denser. Finished frames of a range or
    /// a list are not rendered again.
    #[arg(short, long, value_name = "FRAMES", help_heading = WHAT, value_parser = frames)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) frame: Option<FrameChoice>,

    /// Order of the frames: forward, reverse, or coarse (every 16th first)
    #[arg(long, value_name = "NAME", help_heading = WHAT, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = Order::Forward, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) order: Order,

    /// Share the frames with other processes that run this command on the folder
    ///
    /// They may run on any machines. Each frame is rendered by one process. If a
    /// process stops responding for TIME (60s), another one continues its frame.
    /// Returns when all frames are there.
    #[arg(long, value_name = "TIME", help_heading = WHAT, verbatim_doc_comment)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "60")]
    #[arg(value_parser = lease)]
    #[arg(conflicts_with_all = ["overwrite", "check"])]
    pub(crate) share: Option<Duration>,

    /// A region of the picture, such as 320x180+0+90
    ///
    /// Columns and rows count from the upper left corner. Its pixels are the same
    /// as in the whole picture.
    #[arg(long, value_name = "WxH+X+Y", help_heading = WHAT, value_parser = region)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) region: Option<Region>,

    /// A part of each picture, such as 3/10: the third of ten
    ///
    /// Writes a file of samples instead of a picture. `slo-rt merge` makes the
    /// picture from all parts, byte for byte the same as in a single run.
    #[arg(long, value_name = "K/N", help_heading = WHAT, value_parser = part)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["info", "keep_state"], verbatim_doc_comment)]
    pub(crate) part: Option<Part>,

    /// What is divided into parts: pixels or samples
    #[arg(long, value_name = "NAME", help_heading = WHAT, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = PartBy::Pixels, hide_default_value = true)]
    #[arg(ignore_case = true)]
    #[arg(requires = "part")]
    pub(crate) part_by: PartBy,

    /// Folder that holds the scene file (short: -id)
    ///
    /// The path of --scene starts there, and paths in the scene may not leave it.
    /// Without it they may not leave the current folder, or the folder of the
    /// scene if that lies elsewhere.
    #[arg(long, value_name = "DIR", help_heading = WHAT, requires = "scene")]
    #[arg(verbatim_doc_comment)]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long, help_heading = WHAT)]
    pub(crate) allow_outside: bool,

    /// Folder for the picture, created if missing (short: -od) [the current one]
    #[arg(long, value_name = "DIR", help_heading = WHERE, alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// Beginning of the picture's name (short: -pre) [the scene's]
    #[arg(long, value_name = "TEXT", help_heading = WHERE)]
    pub(crate) prefix: Option<String>,

    /// Add the settings and the render time to the picture's name
    #[arg(short, long, help_heading = WHERE)]
    pub(crate) info: bool,

    /// Keep a picture that is finished already, as in sequences
    ///
    /// A picture is finished if it is complete and holds the recipe of this run:
    /// scene, frame, settings and version.
    #[arg(long, help_heading = WHERE, conflicts_with_all = ["check", "overwrite"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) skip_existing: bool,

    /// Render finished pictures again, in sequences too
    #[arg(long, help_heading = WHERE, conflicts_with = "check")]
    pub(crate) overwrite: bool,

    /// Time between checkpoints of a frame, such as 5m; 0 for none (60s)
    ///
    /// A frame that was stopped or killed continues from its last checkpoint. The
    /// file lies beside the picture, and is removed when the picture is finished.
    #[arg(long, value_name = "TIME", help_heading = WHERE, default_value = "60")]
    #[arg(hide_default_value = true, allow_hyphen_values = true, verbatim_doc_comment)]
    #[arg(value_parser = interval)]
    pub(crate) checkpoint: Duration,

    /// Keep what is needed to add samples to a picture later
    ///
    /// The file lies beside the picture, with .state instead of .png or .exr. A run
    /// that asks for more samples, or less noise, continues from there.
    #[arg(long, help_heading = WHERE, verbatim_doc_comment)]
    pub(crate) keep_state: bool,

    /// Write how many samples each pixel took; #### is the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) sample_map: Option<FramePath>,

    /// Write the estimated error of each pixel; #### is the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) error_map: Option<FramePath>,

    /// What an EXR picture holds besides colours: albedo, normal
    ///
    /// For denoisers: the share of light that surfaces reflect, and the directions
    /// that they face, as channels of the same file.
    #[arg(long, value_name = "NAMES", help_heading = WHERE, hide_possible_values = true)]
    #[arg(value_enum, value_delimiter = ',', ignore_case = true, verbatim_doc_comment)]
    pub(crate) layers: Vec<LayerName>,

    #[command(flatten)]
    pub(crate) settings: SettingArgs,

    /// Time that a frame may take, such as 90s, 15m or 1h30m
    ///
    /// Samples go where the noise is, until the time is over. The recipe says how
    /// far the frame came, and --steps makes the same picture without the clock.
    #[arg(long, value_name = "TIME", help_heading = SETTINGS, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["noise", "steps", "part", "region"], verbatim_doc_comment)]
    pub(crate) time: Option<Duration>,

    /// Time that all frames together may take, such as 8h
    ///
    /// All frames become equally clean: they improve round by round until the time
    /// is over. A run that was stopped or killed continues from there, and has the
    /// rest of the time. Recipes and --steps work as with --time.
    #[arg(long, value_name = "TIME", help_heading = SETTINGS, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["time", "noise", "steps", "part", "region", "share", "info"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) total_time: Option<Duration>,

    /// How far --time or --total-time came: the two numbers in a recipe
    #[arg(long, value_name = "STEP,TILES", help_heading = SETTINGS, value_parser = steps)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with = "noise")]
    pub(crate) steps: Option<Steps>,

    /// Number of threads, or auto for all [parallelThreads of the scene, or all]
    #[arg(long, value_name = "N", help_heading = HOW, allow_hyphen_values = true)]
    #[arg(value_parser = threads)]
    pub(crate) threads: Option<Threads>,

    /// Print nothing but warnings and errors
    #[arg(short, long, help_heading = HOW)]
    pub(crate) quiet: bool,

    /// Print more at the end
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

    /// Read the scene and all its files, and report; render nothing
    #[arg(long, help_heading = INSTEAD)]
    pub(crate) check: bool,

    /// Print what would be rendered, frame by frame, and why
    #[arg(long, help_heading = INSTEAD, conflicts_with = "check")]
    pub(crate) dry_run: bool,

    /// Print how a picture was made
    ///
    /// Every PNG and EXR file of this program holds its recipe as JSON: version,
    /// hash of the scene, frame, seed, and all settings that affect the picture.
    #[arg(long, value_name = "FILE", help_heading = INSTEAD, exclusive = true)]
    #[arg(verbatim_doc_comment)]
    pub(crate) recipe: Option<PathBuf>,

    /// Print help; --help prints more
    #[arg(short, long, help_heading = INSTEAD, action = clap::ArgAction::Help)]
    help: (),

    /// Print the version
    #[arg(short = 'V', long, help_heading = INSTEAD, action = clap::ArgAction::Version)]
    version: (),
}
