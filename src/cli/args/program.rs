//! Options of the program itself: what to render, where the result goes, and how to run.

use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use clap::builder::Styles;

use super::commands::Command;
use super::help::{ABOUT, EXAMPLES, EXIT_CODES, LONG_ABOUT, SETTINGS};
use super::settings::SettingArgs;
use crate::cli::base::When;
use crate::cli::values::{
    FrameChoice, FramePath, LayerName, Order, PartBy, ProgressForm, Region, Threads, bytes, frames,
    interval, lease, part, region, server, steps, threads, time,
};
use slo_picture::film::Steps;
use slo_render::render::Part;

const COMMANDS: &str = "Other commands";
const WHAT: &str = "What to render";
const WHERE: &str = "Where the result goes";
const HOW: &str = "How to run";
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

    /// Scene file [default: the built-in scene]
    #[arg(short, long, value_name = "FILE", help_heading = WHAT)]
    pub(crate) scene: Option<PathBuf>,

    /// Frames, such as 15, 1-100, 1-100x5, 3,-5--1 or all [default: 0]
    ///
    /// 1-100x5 is every fifth frame, 1-100y5 all others, and 1-100:5 every fifth,
    /// then every fourth, and so on until none is missing. Finished frames of a
    /// range or a list are not rendered again.
    #[arg(short, long, value_name = "FRAMES", help_heading = WHAT, value_parser = frames)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) frame: Option<FrameChoice>,

    /// Order of frames: forward (the default), reverse, coarse (every 16th first)
    #[arg(long, value_name = "NAME", help_heading = WHAT, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = Order::Forward, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) order: Order,

    /// Share the frames with other processes on the same output folder
    ///
    /// They run the same command, on any machines. One process renders each frame. If a
    /// process stops responding for TIME (default: 60s), another continues its frame.
    /// Each of them returns when all frames exist.
    #[arg(long, value_name = "TIME", help_heading = WHAT, verbatim_doc_comment)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "60")]
    #[arg(value_parser = lease)]
    #[arg(conflicts_with_all = ["overwrite", "check"])]
    pub(crate) share: Option<Duration>,

    /// Only a region of the picture, such as 320x180+0+90
    ///
    /// Width x height + column + row, counted from the upper left corner. Its pixels
    /// are the same as in the whole picture.
    #[arg(long, value_name = "WxH+X+Y", help_heading = WHAT, value_parser = region)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) region: Option<Region>,

    /// Only a part of each picture, such as 3/10: the third of ten
    ///
    /// Writes a file of samples instead of a picture. `slo-rt merge` makes the
    /// picture from all parts, byte for byte the same as in a single run.
    #[arg(long, value_name = "K/N", help_heading = WHAT, value_parser = part)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["info", "keep_state"], verbatim_doc_comment)]
    pub(crate) part: Option<Part>,

    /// What the parts divide: pixels or samples [default: pixels]
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

    /// Folder for pictures, made if missing (short: -od) [default: .]
    #[arg(long, value_name = "DIR", help_heading = WHERE, alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// Start of the picture's name (short: -pre) [default: the scene's]
    #[arg(long, value_name = "TEXT", help_heading = WHERE)]
    pub(crate) prefix: Option<String>,

    /// Add the settings and the render time to the picture's name
    #[arg(short, long, help_heading = WHERE)]
    pub(crate) info: bool,

    /// Keep a picture that is finished already, as sequences do
    ///
    /// A picture is finished if it is complete and holds the recipe of this run:
    /// scene, frame, settings and version.
    #[arg(long, help_heading = WHERE, conflicts_with_all = ["check", "overwrite"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) skip_existing: bool,

    /// Render finished pictures again, in sequences too
    #[arg(long, help_heading = WHERE, conflicts_with = "check")]
    pub(crate) overwrite: bool,

    /// Time between checkpoints of a frame; 0 for none [default: 60s]
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
    /// that asks for more samples, or for less noise, continues from it.
    #[arg(long, help_heading = WHERE, verbatim_doc_comment)]
    pub(crate) keep_state: bool,

    /// Write a map of the samples per pixel; #### stands for the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) sample_map: Option<FramePath>,

    /// Write a map of the estimated error; #### stands for the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) error_map: Option<FramePath>,

    /// Write a map of steps and tests of rays; #### is the frame
    #[arg(long, value_name = "FILE", help_heading = WHERE)]
    pub(crate) cost_map: Option<FramePath>,

    /// Count what rays take in the structure, to a .json file
    ///
    /// Rays, hits, steps, tests, leaves and more for each kind of ray, the same on all
    /// machines, and what the structure is made of. #### stands for the frame. Rendering
    /// takes several times as long.
    #[arg(long, value_name = "FILE", help_heading = WHERE, verbatim_doc_comment)]
    pub(crate) count: Option<FramePath>,

    /// Keep what `guide 1` learns; #### stands for the frame
    ///
    /// If the file is there, nothing is learned again: by other machines, for parts of
    /// the picture, for more samples. The picture is the same with and without it. A
    /// file of another scene, frame or version is replaced.
    #[arg(long, value_name = "FILE", help_heading = WHERE, verbatim_doc_comment)]
    pub(crate) guide_file: Option<FramePath>,

    /// Show pictures in tev while they render, such as localhost:14158
    ///
    /// The viewer gets the light as it is, tile by tile. If it can't be reached, is slow,
    /// or goes away, rendering goes on.
    #[arg(long, value_name = "ADDR", help_heading = WHERE, value_parser = server)]
    #[arg(verbatim_doc_comment)]
    pub(crate) display_server: Option<String>,

    /// Render again whenever the scene or a file of it is saved
    #[arg(long, help_heading = WHERE, requires = "scene")]
    #[arg(conflicts_with_all = ["share", "part", "total_time", "dry_run", "check", "recipe"])]
    pub(crate) watch: bool,

    /// Extra layers of an EXR picture, such as albedo,normal or depth
    ///
    /// albedo and normal tell a denoiser which share of light surfaces reflect, and
    /// which way they face. lights keeps the light of each light_group apart, for
    /// `slo-rt relight`. For compositors: depth, position, uv, motion, the masks
    /// crypto_object and crypto_material, samples and error. Layers are channels of
    /// the same file.
    #[arg(long, value_name = "NAMES", help_heading = WHERE, hide_possible_values = true)]
    #[arg(value_enum, value_delimiter = ',', ignore_case = true, verbatim_doc_comment)]
    pub(crate) layers: Vec<LayerName>,

    #[command(flatten)]
    pub(crate) settings: SettingArgs,

    /// Time that a frame may take, such as 90s, 15m or 1h30m
    ///
    /// Samples go where the noise is until the time is up. The recipe records how
    /// far the frame got, and --steps makes the same picture without the clock.
    #[arg(long, value_name = "TIME", help_heading = SETTINGS, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["noise", "steps", "part", "region"], verbatim_doc_comment)]
    pub(crate) time: Option<Duration>,

    /// Time that all frames together may take, such as 8h
    ///
    /// All frames become equally clean: they improve round by round until the time
    /// is up. If a run is stopped or killed, the same command continues it with the
    /// time that is left. Recipes and --steps work as with --time.
    #[arg(long, value_name = "TIME", help_heading = SETTINGS, value_parser = time)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["time", "noise", "steps", "part", "region", "share", "info"])]
    #[arg(verbatim_doc_comment)]
    pub(crate) total_time: Option<Duration>,

    /// How far --time or --total-time got: the two numbers in a recipe
    #[arg(long, value_name = "STEP,TILES", help_heading = SETTINGS, value_parser = steps)]
    #[arg(allow_hyphen_values = true)]
    #[arg(conflicts_with = "noise")]
    pub(crate) steps: Option<Steps>,

    /// Number of threads, or auto for all [default: the scene's, or all]
    #[arg(long, value_name = "N", help_heading = HOW, allow_hyphen_values = true)]
    #[arg(value_parser = threads)]
    pub(crate) threads: Option<Threads>,

    /// Most memory to take, such as 8GB [default: what the machine has]
    ///
    /// What would need more is refused before it is begun, with a message that says
    /// what it is. Without it, the limit is that of the control group or the machine.
    #[arg(long, value_name = "SIZE", help_heading = HOW, value_parser = bytes, global = true)]
    #[arg(verbatim_doc_comment)]
    pub(crate) memory_limit: Option<u64>,

    /// Keep what large meshes take long to work out in DIR
    ///
    /// The next run that needs the same meshes starts sooner, on all machines that
    /// see the folder. The pictures are the same.
    #[arg(long, value_name = "DIR", help_heading = HOW, verbatim_doc_comment)]
    pub(crate) cache: Option<PathBuf>,

    /// Most room that the files in --cache may take [default: 20GB]
    ///
    /// What was not used for the longest time is removed.
    #[arg(long, value_name = "SIZE", help_heading = HOW, default_value = "20GB")]
    #[arg(hide_default_value = true, value_parser = bytes, requires = "cache")]
    pub(crate) cache_size: u64,

    /// Print nothing but warnings and errors
    #[arg(short, long, help_heading = HOW)]
    pub(crate) quiet: bool,

    /// Print more at the end: phases, rays, structure
    #[arg(short, long, help_heading = HOW, conflicts_with = "quiet")]
    pub(crate) verbose: bool,

    /// Form of the progress: auto, plain, json, openjd or none [default: auto]
    #[arg(long, value_name = "FORM", help_heading = HOW, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = ProgressForm::Auto, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) progress: ProgressForm,

    /// Colour of messages: auto, always or never [default: auto]
    #[arg(long, value_name = "WHEN", help_heading = HOW, hide_possible_values = true)]
    #[arg(value_enum, default_value_t = When::Auto, hide_default_value = true)]
    #[arg(ignore_case = true)]
    pub(crate) color: When,

    /// Read the scene and all its files, report problems, render nothing
    #[arg(long, help_heading = INSTEAD)]
    pub(crate) check: bool,

    /// List the frames that would be rendered, and why
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
