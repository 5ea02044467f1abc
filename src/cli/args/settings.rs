//! Options that replace settings of the scene. Each option is one field here.

use super::help::SETTINGS;
use crate::cli::values::{
    AcceleratorName, EncodingName, FormatName, IntegratorName, SizeChoice, ToneMapName, exposure,
    noise, parameters, photons, samples, seed, size,
};
use slo_accel::study::Parameters;

/// What the command line sets instead of the scene; `apply` of the options' `Overrides` puts each in
/// its place.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct SettingArgs {
    /// File format: png, png16 or exr
    #[arg(long, value_name = "NAME", help_heading = SETTINGS, hide_possible_values = true)]
    #[arg(ignore_case = true)]
    pub(crate) format: Option<FormatName>,

    #[command(flatten, next_help_heading = SETTINGS)]
    pub(crate) look: LookArgs,

    /// Size of the picture: 320x180, 1080p, or 50% of the scene's
    #[arg(long, value_name = "WxH", help_heading = SETTINGS, value_parser = size)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) size: Option<SizeChoice>,

    /// Camera samples per pixel, in total and at most
    ///
    /// imageSamples becomes N and dofSamples becomes 1. imageMinSamples becomes N if
    /// it is larger or if the scene does not sample adaptively. The numbers of shadow
    /// and glossy samples stay as in the scene.
    #[arg(long, value_name = "N", help_heading = SETTINGS, verbatim_doc_comment)]
    #[arg(allow_hyphen_values = true, value_parser = samples)]
    pub(crate) samples: Option<u32>,

    /// Error at which a picture is clean enough, such as 0.01
    ///
    /// Measured on the values that the viewer sees: 1 is the range from black to
    /// white, 0.004 one step of 8 bits. Each block of 8 x 8 pixels takes samples
    /// until its estimated error is below E, at most --samples (4096 without it).
    #[arg(long, value_name = "E", help_heading = SETTINGS, value_parser = noise)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) noise: Option<f32>,

    /// Which light is found: distributed, path or photon_map
    ///
    /// distributed: light straight from lamps, and what mirrors, gloss and glass see.
    /// path: all light, with up to 16 bounces and one lamp a hit unless the scene sets
    /// recursion and lightSamplingType.
    #[arg(long, value_name = "NAME", help_heading = SETTINGS, hide_possible_values = true)]
    #[arg(ignore_case = true, verbatim_doc_comment)]
    pub(crate) integrator: Option<IntegratorName>,

    /// Photons per sample, for caustics of small lamps, such as 0.5
    ///
    /// Light paths from lamps through mirrors and glass, with --integrator path. 0 is
    /// none, 100 is the most.
    #[arg(long, value_name = "F", help_heading = SETTINGS, value_parser = photons)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) photons: Option<f32>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", help_heading = SETTINGS, value_parser = seed)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) seed: Option<u64>,

    /// Structure: bvh, kdtree, cwbvh, none, or one to study
    ///
    /// To study: grid, octree, median, rtree, binary, kd and boxes. All find the same
    /// hits but cwbvh, which may miss some; bvh is the fastest. By a GPU, if the
    /// program is built with the feature `gpu`: gpu_grid, gpu_kd and gpu_bvh.
    #[arg(long, value_name = "NAME", help_heading = SETTINGS, hide_possible_values = true)]
    #[arg(ignore_case = true, verbatim_doc_comment)]
    pub(crate) accelerator: Option<AcceleratorName>,

    /// Parameters of a structure to study, such as density=3,mailbox=1
    ///
    /// grid: density, shortest, cells=46x46x3, mailbox. octree: depth, leaf, mailbox.
    /// median, binary: depth, leaf. rtree: capacity. kd: depth, leaf, mailbox, stack,
    /// traversal=stack, restart, push-down or short-stack.
    #[arg(long, value_name = "LIST", help_heading = SETTINGS, value_parser = parameters)]
    #[arg(verbatim_doc_comment)]
    pub(crate) accelerator_options: Option<Parameters>,

    /// Let the BVH split long triangles: bounces faster, shadows slower
    #[arg(long, help_heading = SETTINGS)]
    pub(crate) spatial_splits: bool,
}

/// How a PNG file shows the light.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct LookArgs {
    /// Brighten a PNG picture by so many stops, such as 1.5 or -2
    ///
    /// One stop doubles the light. EXR files hold the light as it is.
    #[arg(long, value_name = "STOPS", value_parser = exposure)]
    #[arg(allow_hyphen_values = true, verbatim_doc_comment)]
    pub(crate) exposure: Option<f32>,

    /// Compress bright light in a PNG: none, or agx as in Blender
    #[arg(long, value_name = "NAME", hide_possible_values = true)]
    #[arg(ignore_case = true)]
    pub(crate) tone_map: Option<ToneMapName>,

    /// Transfer curve of a PNG picture: raw or srgb
    #[arg(long, value_name = "NAME", hide_possible_values = true)]
    #[arg(ignore_case = true)]
    pub(crate) encoding: Option<EncodingName>,
}
