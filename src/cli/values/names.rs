//! Names of layers, file formats, integrators and structures on the command line, as in the scene language.

use std::collections::HashMap;
use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use slo_scene::settings::Choice;
use slo_scene::{Accelerator, Integrator, Layer, OutputFormat};

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

/// `--integrator`: the words of the scene language, in any case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntegratorName(pub(crate) Integrator);

impl ValueEnum for IntegratorName {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<IntegratorName>> =
            LazyLock::new(|| Integrator::ALL.into_iter().map(IntegratorName).collect());
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(lower_case(self.0)))
    }
}

/// Returns a word of the scene language in lower case, kept for the whole run.
fn lower_case(choice: impl Choice) -> &'static str {
    static WORDS: LazyLock<HashMap<&str, String>> = LazyLock::new(|| {
        let words = Accelerator::WORDS.iter().chain(Integrator::WORDS);
        words.map(|word| (*word, word.to_ascii_lowercase())).collect()
    });
    WORDS.get(choice.name()).map_or(choice.name(), String::as_str)
}
