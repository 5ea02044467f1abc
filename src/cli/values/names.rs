//! Names of layers, file formats and structures: values of the scene, and what is typed for them.
//!
//! Each `match` covers all that there are: a new one does not compile without a name.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::film::Layer;
use crate::scene::{Accelerator, OutputFormat};

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
        &[Self(OutputFormat::Png8), Self(OutputFormat::Png16), Self(OutputFormat::Exr)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self.0 {
            OutputFormat::Png8 => PossibleValue::new("png").aliases(["png8", "png_image"]),
            OutputFormat::Png16 => PossibleValue::new("png16").alias("png16_image"),
            OutputFormat::Exr => PossibleValue::new("exr").aliases(["openexr", "exr_image"]),
        })
    }
}

/// `--accelerator`, as the scene language names them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AcceleratorName(pub(crate) Accelerator);

impl ValueEnum for AcceleratorName {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<AcceleratorName>> = LazyLock::new(|| {
            Accelerator::NAMES.into_iter().map(|(_, one)| AcceleratorName(one)).collect()
        });
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self.0 {
            Accelerator::KdTree => "kdtree",
            Accelerator::Bvh => "bvh",
            Accelerator::Cwbvh => "cwbvh",
            Accelerator::None => "none",
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_accelerator_of_the_scene_language_has_its_name() {
        for ((name, _), typed) in
            Accelerator::NAMES.into_iter().zip(AcceleratorName::value_variants())
        {
            let typed = typed.to_possible_value().unwrap();
            assert_eq!(typed.get_name().to_ascii_uppercase(), name);
        }
    }
}
