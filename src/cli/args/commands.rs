//! Commands besides rendering.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgGroup, Subcommand};

use super::settings::{LookArgs, SettingArgs};
use crate::cli::values::{
    FormatName, Gain, IntegratorName, PixelAt, ProgressForm, SizeChoice, Threads, address, count,
    frame, gain, limit, noise, photons, pixel_at, samples, seed, size, threads,
};

/// What else the program does.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Put pictures together from their parts
    Merge(MergeArgs),
    /// Render some tiles of pictures again and compare the bits
    Verify(VerifyArgs),
    /// Measure how much a picture differs from a reference
    Compare(CompareArgs),
    /// Make a contact sheet of pictures
    Sheet(SheetArgs),
    /// Remove the noise from pictures with Open Image Denoise
    Denoise(DenoiseArgs),
    /// Show pictures in another light: lamps dimmed or coloured, another exposure
    Relight(RelightArgs),
    /// Turn a scene of another program (glTF, OBJ, PLY, AFF, NFF, Inventor) into scene text
    Import(ImportArgs),
    /// Write the light on objects into images, by their texture coordinates
    Bake(BakeArgs),
    /// Explain a pixel: its light by lamp, by way and by object, and where its noise comes from
    Why(WhyArgs),
    /// Show a scene in the browser: look at it from anywhere while it renders
    View(ViewArgs),
    /// Print a manual page or the completions of a shell
    Generate(GenerateArgs),
}

/// `merge`
#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// Files that `--part` made, of one frame or several
    #[arg(value_name = "FILES", required = true)]
    pub(crate) files: Vec<PathBuf>,

    /// Folder for the pictures, created if missing (short: -od) [default: .]
    #[arg(long, value_name = "DIR", alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// Print nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `verify`
#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// Pictures of slo-rt, PNG or EXR
    #[arg(value_name = "PICTURES", required = true)]
    pub(crate) pictures: Vec<PathBuf>,

    /// Scene file that they were rendered from [default: the built-in scene]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,

    /// Folder that holds the scene file (short: -id)
    #[arg(long, value_name = "DIR", requires = "scene")]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long)]
    pub(crate) allow_outside: bool,

    /// Number of tiles to render again, 32 x 32 pixels each, chosen at random
    #[arg(long, value_name = "N", default_value_t = 8, allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=u32::MAX, "8"))]
    pub(crate) tiles: u32,

    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<Threads>,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `compare`
#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    /// A picture, PNG or EXR
    pub(crate) picture: PathBuf,

    /// The reference, PNG or EXR
    pub(crate) reference: PathBuf,

    /// Write a map of FLIP, which shows where differences are visible (.png, .exr)
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,

    /// Fail if more than N pixels differ
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 0..=u64::MAX, "100"))]
    pub(crate) max_pixels: Option<u64>,

    /// Fail if the root mean square difference is above X
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_rmse: Option<f64>,

    /// Fail if the relative mean square error is above X
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_relative_mse: Option<f64>,

    /// Fail if the ratio of mean luminances differs from 1 by more than X
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_bias: Option<f64>,

    /// Fail if the mean of FLIP is above X
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_flip: Option<f64>,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `denoise`
#[derive(Debug, clap::Args)]
pub(crate) struct DenoiseArgs {
    /// Pictures of slo-rt: EXR, best with `--layers albedo,normal`, or PNG
    #[arg(value_name = "PICTURES", required = true)]
    pub(crate) pictures: Vec<PathBuf>,

    /// Folder for the denoised pictures, under the same names (short: -od) [default: beside, as NAME_denoised]
    #[arg(long, value_name = "DIR", alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// The library, such as libOpenImageDenoise.so.2 [default: where the system finds it]
    #[arg(long, value_name = "FILE")]
    pub(crate) library: Option<PathBuf>,

    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<Threads>,

    /// Print nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `relight`
#[derive(Debug, clap::Args)]
pub(crate) struct RelightArgs {
    /// EXR pictures of slo-rt; with `--layers lights` if lamps are to change
    #[arg(value_name = "PICTURES", required = true)]
    pub(crate) pictures: Vec<PathBuf>,

    /// Multiply the light of a group: key=0.5, sky=1,0.8,0.6; rest is all light without a group
    #[arg(short, long, value_name = "NAME=FACTOR", value_parser = gain)]
    pub(crate) group: Vec<Gain>,

    /// The file to write, PNG or EXR, for one picture
    #[arg(short, long, value_name = "FILE", conflicts_with = "outdir")]
    pub(crate) output: Option<PathBuf>,

    /// Folder for the results, under the same names (short: -od) [default: beside, as NAME_relit]
    #[arg(long, value_name = "DIR", alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// File format: png, png16 or exr [default: the one that `--output` names, or exr]
    #[arg(long, value_name = "NAME", hide_possible_values = true, ignore_case = true)]
    pub(crate) format: Option<FormatName>,

    #[command(flatten)]
    pub(crate) look: LookArgs,

    /// Print nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `import`
#[derive(Debug, clap::Args)]
pub(crate) struct ImportArgs {
    /// A .gltf, .glb, .obj, .ply, .aff, .nff or .iv file
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    /// Folder for the scene, its meshes and images (short: -od) [default: NAME, as the file]
    #[arg(short, long, value_name = "DIR", alias = "outdir", alias = "outdit")]
    pub(crate) output: Option<PathBuf>,

    /// Replace files that exist
    #[arg(long)]
    pub(crate) overwrite: bool,

    /// Also read files that lie outside of the folder of FILE
    #[arg(long)]
    pub(crate) allow_outside: bool,

    /// Print nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `bake`
#[derive(Debug, clap::Args)]
pub(crate) struct BakeArgs {
    /// Scene file, in which objects have a `lightMap N`
    #[arg(value_name = "SCENE")]
    pub(crate) scene: PathBuf,

    /// Folder for the light maps, created if missing (short: -od) [default: .]
    #[arg(short, long, value_name = "DIR", alias = "outdit")]
    pub(crate) outdir: Option<PathBuf>,

    /// Only the light map of this object; may be given several times [default: all]
    #[arg(long, value_name = "NAME")]
    pub(crate) object: Vec<String>,

    /// The frame whose light is wanted; the files then have its number [default: 0]
    #[arg(short, long, value_name = "N", allow_hyphen_values = true, value_parser = frame)]
    pub(crate) frame: Option<i64>,

    /// Folder that holds the scene file (short: -id)
    #[arg(long, value_name = "DIR")]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long)]
    pub(crate) allow_outside: bool,

    /// Bake light maps again that are finished already
    #[arg(long)]
    pub(crate) overwrite: bool,

    /// File format: exr, png or png16 [default: exr, which holds the light as it is]
    #[arg(long, value_name = "NAME", hide_possible_values = true, ignore_case = true)]
    pub(crate) format: Option<FormatName>,

    #[command(flatten)]
    pub(crate) look: LookArgs,

    /// Samples per texel [default: those of the scene]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = samples)]
    pub(crate) samples: Option<u32>,

    /// Error at which a light map is clean enough, of irradiance / pi, such as 0.01
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = noise)]
    pub(crate) noise: Option<f32>,

    /// Which light is found: distributed, path or photon_map
    #[arg(long, value_name = "NAME", hide_possible_values = true, ignore_case = true)]
    pub(crate) integrator: Option<IntegratorName>,

    /// Photons per sample, for caustics of small lamps, with --integrator path
    #[arg(long, value_name = "F", allow_hyphen_values = true, value_parser = photons)]
    pub(crate) photons: Option<f32>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = seed)]
    pub(crate) seed: Option<u64>,

    /// Number of threads, or auto for all [default: the scene's, or all]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<Threads>,

    /// Form of the progress: auto, plain, json, openjd or none [default: auto]
    #[arg(long, value_name = "FORM", hide_possible_values = true, ignore_case = true)]
    #[arg(value_enum, default_value_t = ProgressForm::Auto, hide_default_value = true)]
    pub(crate) progress: ProgressForm,

    /// Print nothing but warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `why`
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("any_scene").args(["file", "scene"]))]
pub(crate) struct WhyArgs {
    /// Column and row of the pixel, from 0 at the upper left corner
    #[arg(value_name = "X,Y", value_parser = pixel_at)]
    pub(crate) pixel: PixelAt,

    /// Scene file [default: the built-in scene]
    #[arg(value_name = "SCENE")]
    pub(crate) file: Option<PathBuf>,

    /// The same, by an option
    #[arg(short, long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,

    /// Folder that holds the scene file (short: -id)
    #[arg(long, value_name = "DIR", requires = "any_scene")]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long)]
    pub(crate) allow_outside: bool,

    /// The frame [default: 0]
    #[arg(short, long, value_name = "N", allow_hyphen_values = true, value_parser = frame)]
    pub(crate) frame: Option<i64>,

    /// Size of the picture in pixels: 320x180, 1080p, 50%
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<SizeChoice>,

    /// Number of samples to explain [default: those that every pixel of the picture has]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = samples)]
    pub(crate) samples: Option<u32>,

    /// Explain this sample alone, with all of its rays
    #[arg(long, value_name = "N", allow_hyphen_values = true, conflicts_with = "samples")]
    #[arg(value_parser = |text: &str| count(text, 0..=u32::MAX - 1, "17"))]
    pub(crate) sample: Option<u32>,

    /// Which light is found: distributed, path or photon_map
    #[arg(long, value_name = "NAME", hide_possible_values = true, ignore_case = true)]
    pub(crate) integrator: Option<IntegratorName>,

    /// Photons per sample, for caustics of small lamps, with --integrator path
    #[arg(long, value_name = "F", allow_hyphen_values = true, value_parser = photons)]
    pub(crate) photons: Option<f32>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = seed)]
    pub(crate) seed: Option<u64>,

    /// How many of the brightest ways of light to list
    #[arg(long, value_name = "N", default_value_t = 8, allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 0..=1000u32, "8"))]
    pub(crate) ways: u32,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Number of threads, or auto for all [default: all]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<Threads>,

    /// Form of the progress: auto, plain, json, openjd or none [default: auto]
    #[arg(long, value_name = "FORM", hide_possible_values = true, ignore_case = true)]
    #[arg(value_enum, default_value_t = ProgressForm::Auto, hide_default_value = true)]
    pub(crate) progress: ProgressForm,

    /// Print nothing but the answer, warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `view`
#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// Scene file [default: the built-in scene]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<PathBuf>,

    /// Address and port, such as 127.0.0.1:8000 or 0.0.0.0:8000 [default: this machine, any port]
    ///
    /// Whoever has the printed address can change the scene file. Only use addresses of
    /// networks that you trust: the connection is not encrypted.
    #[arg(long, value_name = "ADDRESS", value_parser = address, verbatim_doc_comment)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) listen: Option<SocketAddr>,

    /// The first frame to be shown [default: 0]
    #[arg(short, long, value_name = "N", allow_hyphen_values = true, value_parser = frame)]
    pub(crate) frame: Option<i64>,

    /// Folder that holds the scene file (short: -id)
    #[arg(long, value_name = "DIR", requires = "scene")]
    pub(crate) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long)]
    pub(crate) allow_outside: bool,

    #[command(flatten)]
    pub(crate) settings: SettingArgs,

    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<Threads>,

    /// Print nothing but the address, warnings and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `sheet`
#[derive(Debug, clap::Args)]
pub(crate) struct SheetArgs {
    /// Pictures, PNG or EXR, in the order of the sheet
    #[arg(value_name = "PICTURES", required = true)]
    pub(crate) pictures: Vec<PathBuf>,

    /// The PNG file to write
    #[arg(short, long, value_name = "FILE", default_value = "sheet.png")]
    pub(crate) output: PathBuf,

    /// Number of pictures per row [default: as many as there are rows]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=1000u32, "8"))]
    pub(crate) columns: Option<u32>,

    /// Width of each picture in pixels
    #[arg(long, value_name = "N", default_value_t = 240, allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=4096u32, "240"))]
    pub(crate) width: u32,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `generate`
#[derive(Debug, clap::Args)]
pub(crate) struct GenerateArgs {
    /// What to print
    #[arg(value_name = "WHAT", ignore_case = true)]
    pub(crate) what: GenerateWhat,

    /// The command whose manual page to print [default: the page of the program]
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,

    /// Print help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// What `generate` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum GenerateWhat {
    Man,
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
}
