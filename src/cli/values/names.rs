//! Names of layers, file formats and structures on the command line, as in the scene language.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use slo_scene::{Accelerator, Layer, OutputFormat};

/// `--layers`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LayerName(pub(crate) Layer);

impl ValueEnum for LayerName {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<LayerName>> =
            LazyLock::new(|| Layer::ALL.into_iter().map(LayerName).collect());
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()))
    }
}

/// `--format`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FormatName(pub(crate) OutputFormat);

impl ValueEnum for FormatName {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<FormatName>> =
            LazyLock::new(|| OutputFormat::ALL.into_iter().map(FormatName).collect());
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.option()).aliases(self.0.aliases()))
    }
}

/// `--accelerator`: the words of the scene language, in any case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AcceleratorName(pub(crate) Accelerator);

impl ValueEnum for AcceleratorName {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<AcceleratorName>> =
            LazyLock::new(|| Accelerator::ALL.into_iter().map(AcceleratorName).collect());
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(lower_case(self.0)))
    }
}

/// Returns the word of a structure in lower case, kept for the whole run.
fn lower_case(accelerator: Accelerator) -> &'static str {
    static WORDS: LazyLock<Vec<String>> =
        LazyLock::new(|| Accelerator::ALL.map(|all| all.name().to_ascii_lowercase()).into());
    let place = Accelerator::ALL.iter().position(|all| *all == accelerator);
    place.map_or(accelerator.name(), |place| &WORDS[place])
}
