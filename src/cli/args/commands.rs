//! What the program does beside rendering.

use std::path::PathBuf;

use clap::Subcommand;

use super::numbers::count;
use super::values::{Threads, limit, threads};

/// What else the program does.
#[derive(Debug, Subcommand)]
pub(in crate::cli) enum Command {
    /// Put parts of pictures together
    Merge(MergeArgs),
    /// Render some of a picture again and compare the bits
    Verify(VerifyArgs),
    /// Measure how far a picture is from a reference
    Compare(CompareArgs),
    /// Make a contact sheet of pictures
    Sheet(SheetArgs),
    /// Take the noise out of pictures, by Open Image Denoise
    Denoise(DenoiseArgs),
}

/// `merge`
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct MergeArgs {
    /// Files that `--part` made, of one frame or of several
    #[arg(value_name = "FILES", required = true)]
    pub(in crate::cli) files: Vec<PathBuf>,

    /// Folder for the pictures, made where missing (short: -od) [the current one]
    #[arg(long, value_name = "DIR", alias = "outdit")]
    pub(in crate::cli) outdir: Option<PathBuf>,

    /// Say nothing but warnings and errors
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,

    /// Help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `verify`
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct VerifyArgs {
    /// Pictures of slo-rt, PNG or EXR
    #[arg(value_name = "PICTURES", required = true)]
    pub(in crate::cli) pictures: Vec<PathBuf>,

    /// The scene that they were made of [the scene inside the program]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,

    /// Folder that holds the scene file (short: -id)
    #[arg(long, value_name = "DIR", requires = "scene")]
    pub(in crate::cli) indir: Option<PathBuf>,

    /// Let paths in the scene lead anywhere
    #[arg(long)]
    pub(in crate::cli) allow_outside: bool,

    /// Tiles of 32 x 32 pixels that are rendered again, chosen at random
    #[arg(long, value_name = "N", default_value_t = 8, allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=u32::MAX, "8"))]
    pub(in crate::cli) tiles: u32,

    /// Threads (all)
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(in crate::cli) threads: Option<Threads>,

    /// Help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `compare`
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct CompareArgs {
    /// A picture, PNG or EXR
    pub(in crate::cli) picture: PathBuf,

    /// The picture that it should be
    pub(in crate::cli) reference: PathBuf,

    /// Write where the difference is seen, by FLIP
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) map: Option<PathBuf>,

    /// Fail where more pixels differ
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 0..=u64::MAX, "100"))]
    pub(in crate::cli) max_pixels: Option<u64>,

    /// Fail where the root mean square difference is larger
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(in crate::cli) max_rmse: Option<f64>,

    /// Fail where the relative mean square error is larger
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(in crate::cli) max_relative_mse: Option<f64>,

    /// Fail where the mean luminance is further from the reference's, as a share of it
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(in crate::cli) max_bias: Option<f64>,

    /// Fail where the mean of FLIP is larger
    #[arg(long, value_name = "X", value_parser = limit)]
    #[arg(allow_hyphen_values = true)]
    pub(in crate::cli) max_flip: Option<f64>,

    /// Help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `denoise`
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct DenoiseArgs {
    /// Pictures of slo-rt: EXR, best with `--layers albedo,normal`, or PNG
    #[arg(value_name = "PICTURES", required = true)]
    pub(in crate::cli) pictures: Vec<PathBuf>,

    /// Folder for what comes out, under the same names (short: -od) [beside, NAME_denoised]
    #[arg(long, value_name = "DIR", alias = "outdit")]
    pub(in crate::cli) outdir: Option<PathBuf>,

    /// The library, libOpenImageDenoise.so.2 or so [where the system finds it]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) library: Option<PathBuf>,

    /// Threads (all)
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    pub(in crate::cli) threads: Option<Threads>,

    /// Say nothing but warnings and errors
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,

    /// Help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}

/// `sheet`
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct SheetArgs {
    /// Pictures, PNG or EXR, in the order in which they are to stand
    #[arg(value_name = "PICTURES", required = true)]
    pub(in crate::cli) pictures: Vec<PathBuf>,

    /// The PNG file to write
    #[arg(short, long, value_name = "FILE", default_value = "sheet.png")]
    pub(in crate::cli) output: PathBuf,

    /// Pictures in a row [as many as rows]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=1000u32, "8"))]
    pub(in crate::cli) columns: Option<u32>,

    /// Width of each picture in pixels
    #[arg(long, value_name = "N", default_value_t = 240, allow_hyphen_values = true)]
    #[arg(value_parser = |text: &str| count(text, 1..=4096u32, "240"))]
    pub(in crate::cli) width: u32,

    /// Help
    #[arg(short, long, action = clap::ArgAction::Help)]
    help: (),
}
