//! The `settings` element.

use super::entry::{Effect, choice, color, count, double, entries, flag, single, whole};
use super::value::{Bound, Value};
use super::words::{
    Accelerator, CausticFilter, Contrast, Encoding, Generator, Integrator, LightSampling,
    PhotonSeed, ShadowMode,
};

/// Most camera samples of a pixel, `imageSamples` times `dofSamples`: the film can add up so many.
pub const MOST_CAMERA_SAMPLES: u32 = (1 << 22) - 1;

/// Samples of one kind; the product with another kind still fits u32.
const MOST_SAMPLES: u32 = 65_535;
const MOST_BOUNCES: u32 = 1000;
const MOST_PHOTONS: u32 = 1 << 26;
const MOST_SECTIONS: u32 = 65_536;
const MOST_THREADS: u32 = 65_536;

entries! {
    /// The `settings` element.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub struct Settings {
        /// Which light is found.
        integrator: Integrator = Integrator::Distributed,
            choice("integrator", Effect::Samples).unless_default();
        /// Which points the integral is sampled at.
        generator: Generator = Generator::Quasi, choice("generatorType", Effect::Samples);
        /// How many lights a hit asks; `None`: the integrator's default, see
        /// [`Settings::light_sampling`].
        light_sampling: Option<LightSampling> = None,
            choice("lightSamplingType", Effect::Samples).otherwise(|settings: &Settings| {
                Value::Word(settings.integrator.light_sampling().name())
            });
        /// How a sample stands out.
        contrast: Contrast = Contrast::Difference, choice("contrastType", Effect::Count);
        /// Samples of a pixel's area.
        image_samples: u32 = 16, count("imageSamples", [1, MOST_SAMPLES], Effect::Count);
        /// The least of them; equal to `image_samples`: not adaptive.
        image_min_samples: u32 = 16, count("imageMinSamples", [1, MOST_SAMPLES], Effect::Count);
        /// The contrast from which a sample stands out.
        image_contrast_limit: f32 = 0.03,
            single("imageContrastLimit", Bound::NotNegative, Effect::Count);
        /// Samples of the lens, multiplies `image_samples`.
        dof_samples: u32 = 1, count("dofSamples", [1, MOST_SAMPLES], Effect::Count);
        /// Per area light at the first hit.
        soft_shadow_samples: u32 = 1, count("softShadowSamples", [1, MOST_SAMPLES], Effect::Samples);
        /// At the first hit.
        diffuse_reflection_samples: u32 = 1,
            count("diffuseReflectionSamples", [1, MOST_SAMPLES], Effect::Samples);
        /// At the first hit.
        diffuse_refraction_samples: u32 = 1,
            count("diffuseRefractionSamples", [1, MOST_SAMPLES], Effect::Samples);
        /// Bounces after the first hit; 0 is none. `None`: the integrator's default, see
        /// [`Settings::recursion`].
        recursion: Option<u32> = None,
            count("recursion", [0, MOST_BOUNCES], Effect::Samples)
                .otherwise(|settings: &Settings| Value::Count(settings.integrator.recursion()));
        /// Sections side by side; `None`: chosen by the renderer.
        sections_horizontal: Option<u32> = None,
            count("sectionsHorizontal", [1, MOST_SECTIONS], Effect::Nothing);
        /// Sections one below the other; `None`: chosen by the renderer.
        sections_vertical: Option<u32> = None,
            count("sectionsVertical", [1, MOST_SECTIONS], Effect::Nothing);
        /// Threads; `None`: all that the machine has.
        parallel_threads: Option<u32> = None,
            count("parallelThreads", [1, MOST_THREADS], Effect::Nothing);
        /// Sections handed out at a time.
        sections_per_thread: u32 = 1, count("sectionsPerThread", [1, u32::MAX], Effect::Nothing);
        /// Radiance of a ray that hits nothing.
        background: [f32; 3] = [0.0; 3], color("background", Effect::Samples);
        /// Seed of every random number.
        seed: u64 = 0, whole("seed", Effect::Samples).first();
        /// The structure that rays are traced through. All find the same hits but CWBVH, which may
        /// miss some.
        accelerator: Accelerator = Accelerator::Bvh,
            choice("accelerator", Effect::Samples)
                .recorded_if(|settings: &Settings| settings.accelerator == Accelerator::Cwbvh)
                .last();
        /// Whether the BVH may cut triangles.
        spatial_splits: bool = false, flag("spatialSplits", Effect::Nothing);
        /// What refractive objects do to light on its way to a hit.
        shadow: ShadowMode = ShadowMode::Opaque, choice("shadow", Effect::Samples);
        /// Error at which a pixel is done; `None`: off.
        noise: Option<f32> = None, single("noise", Bound::Error, Effect::Count).unless_default();
        /// Light paths from lamps through mirrors and glass, for each camera sample; PATH only.
        photons: f32 = 0.0, single("photons", Bound::PerSample, Effect::Samples).unless_default();
        /// Whether the numbers of photons change from frame to frame.
        photon_seed: PhotonSeed = PhotonSeed::Frame,
            choice("photonSeed", Effect::Samples).unless_default();
        /// Whether rays follow a field that was learned; PATH only.
        guide: bool = false, flag("guide", Effect::Samples).unless_default();
        /// Photons on rough surfaces, at most; this and the following: PHOTON_MAP only.
        photon_map_size: u32 = 1_000_000,
            count("photonMapSize", [1, MOST_PHOTONS], Effect::Samples).unless_default();
        /// Photons of caustics, at most.
        caustic_map_size: u32 = 1_000_000,
            count("causticMapSize", [1, MOST_PHOTONS], Effect::Samples).unless_default();
        /// Photons that the light at a point is estimated from, at most.
        photon_nearest: u32 = 200,
            count("photonNearest", [1, MOST_SAMPLES], Effect::Samples).unless_default();
        /// The distance from which they come, at most; `None`: chosen by the renderer.
        photon_distance: Option<f32> = None,
            single("photonDistance", Bound::Positive, Effect::Samples).unless_default();
        /// Photons that a caustic at a point is estimated from, at most.
        caustic_nearest: u32 = 100,
            count("causticNearest", [1, MOST_SAMPLES], Effect::Samples).unless_default();
        /// The distance from which they come, at most; `None`: chosen by the renderer.
        caustic_distance: Option<f32> = None,
            single("causticDistance", Bound::Positive, Effect::Samples).unless_default();
        /// How photons of caustics count by their distance.
        caustic_filter: CausticFilter = CausticFilter::Cone,
            choice("causticFilter", Effect::Samples).unless_default();
        /// Whether rays gather the light of the map; if not, it is shown as it is.
        gather: bool = true, flag("gather", Effect::Samples).unless_default();
        /// Rays that gather light for a record of the irradiance cache, at most.
        gather_rays: u32 = 1024,
            count("gatherRays", [1, MOST_SAMPLES], Effect::Samples).unless_default();
        /// Share by which a round of these rays changes the irradiance so little that it is the last.
        gather_limit: f32 = 0.01,
            single("gatherLimit", Bound::NotNegative, Effect::Samples).unless_default();
        /// Error that is allowed between the records of the irradiance cache; 0: there is none.
        cache_error: f32 = 0.0,
            single("cacheError", Bound::NotNegative, Effect::Samples).unless_default();
        /// Whether records count that lie in front of a point.
        cache_in_front: bool = false,
            flag("cacheInFront", Effect::Samples).unless_default();
        /// Sampled transforms per millisecond of shutter, at least.
        transform_samples_per_ms: f64 = 2.0,
            double("transformSamplesPerMs", Bound::Positive, Effect::Samples);
    }
}

impl Settings {
    /// Bounces after the first hit, at most: as set, or as the integrator has it.
    pub fn recursion(&self) -> u32 {
        self.recursion.unwrap_or(self.integrator.recursion())
    }

    /// How many lights a hit asks: as set, or as the integrator has it.
    pub fn light_sampling(&self) -> LightSampling {
        self.light_sampling.unwrap_or(self.integrator.light_sampling())
    }

    /// Camera samples of a pixel, at most.
    pub fn camera_samples(&self) -> u64 {
        u64::from(self.image_samples) * u64::from(self.dof_samples)
    }

    /// Sets the camera samples of a pixel: `samples` replaces the product of `imageSamples` and
    /// `dofSamples`. Adaptive settings keep their least number of samples if it fits.
    pub fn set_camera_samples(&mut self, samples: u32) {
        let adaptive = self.image_min_samples < self.image_samples;
        let least = if adaptive { self.image_min_samples } else { samples };
        self.image_min_samples = least.min(samples);
        self.image_samples = samples;
        self.dof_samples = 1;
    }

    /// The transfer curve of films that name none.
    pub(super) fn encoding(&self) -> Encoding {
        match self.integrator {
            Integrator::Distributed => Encoding::Raw,
            Integrator::Path | Integrator::PhotonMap => Encoding::Srgb,
        }
    }

    /// Whether settings that depend on each other go together.
    pub fn are_consistent(&self) -> bool {
        self.camera_samples() <= u64::from(MOST_CAMERA_SAMPLES)
            && self.image_min_samples <= self.image_samples
    }
}
