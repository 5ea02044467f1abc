//! Names of layers, file formats, integrators and structures on the command line, as in the scene language.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use slo_accel::study::Parameters;
use slo_scene::{Accelerator, Encoding, Integrator, Layer, OutputFormat, ToneMap};

/// Parses parameters of structures to study.
pub(crate) fn parameters(text: &str) -> Result<Parameters, String> {
    text.parse()
}

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

/// Defines the names of an option: the words of the scene language, in any case.
macro_rules! words {
    ($(#[$of:meta])* $Name:ident, $Word:ty) => {
        $(#[$of])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) struct $Name(pub(crate) $Word);

        impl ValueEnum for $Name {
            fn value_variants<'a>() -> &'a [Self] {
                const ALL: [$Name; <$Word>::ALL.len()] = {
                    let mut all = [$Name(<$Word>::ALL[0]); <$Word>::ALL.len()];
                    let mut i = 0;
                    while i < all.len() {
                        all[i] = $Name(<$Word>::ALL[i]);
                        i += 1;
                    }
                    all
                };
                &ALL
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                static WORDS: LazyLock<Vec<String>> =
                    LazyLock::new(|| <$Word>::ALL.map(|all| all.name().to_ascii_lowercase()).into());
                let place = <$Word>::ALL.iter().position(|all| *all == self.0);
                Some(PossibleValue::new(place.map_or(self.0.name(), |place| &WORDS[place])))
            }
        }
    };
}

words! {
    /// `--integrator`
    IntegratorName, Integrator
}

words! {
    /// `--accelerator`
    AcceleratorName, Accelerator
}

words! {
    /// `--encoding`
    EncodingName, Encoding
}

words! {
    /// `--tone-map`
    ToneMapName, ToneMap
}
