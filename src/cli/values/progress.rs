//! Form in which the program reports its progress.

use clap::ValueEnum;

/// `--progress`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressForm {
    /// A bar on a terminal, lines elsewhere.
    #[default]
    Auto,
    /// Lines.
    Plain,
    /// A JSON object a line.
    Json,
    /// The tokens of Open Job Description.
    Openjd,
    /// Nothing.
    None,
}
