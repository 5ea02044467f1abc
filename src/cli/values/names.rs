//! Names of layers, file formats and structures.

use clap::ValueEnum;

use crate::film::Layer;
use crate::scene::{Accelerator, OutputFormat};

/// `--layers`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayerName {
    Albedo,
    Normal,
}

impl From<LayerName> for Layer {
    fn from(name: LayerName) -> Self {
        match name {
            LayerName::Albedo => Self::Albedo,
            LayerName::Normal => Self::Normal,
        }
    }
}

/// `--format`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    #[value(aliases = ["png8", "png_image"])]
    Png,
    #[value(alias = "png16_image")]
    Png16,
    #[value(aliases = ["openexr", "exr_image"])]
    Exr,
}

impl From<FormatName> for OutputFormat {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Png => Self::Png8,
            FormatName::Png16 => Self::Png16,
            FormatName::Exr => Self::Exr,
        }
    }
}

/// `--accelerator`, as the scene language names them.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum AcceleratorName {
    Kdtree,
    Bvh,
    Cwbvh,
    None,
}

impl From<AcceleratorName> for Accelerator {
    fn from(name: AcceleratorName) -> Self {
        match name {
            AcceleratorName::Kdtree => Self::KdTree,
            AcceleratorName::Bvh => Self::Bvh,
            AcceleratorName::Cwbvh => Self::Cwbvh,
            AcceleratorName::None => Self::None,
        }
    }
}
