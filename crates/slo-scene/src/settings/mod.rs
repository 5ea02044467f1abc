//! Settings of a scene and of its film.

/// The structure that rays are traced through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Accelerator {
    /// SAH kd-tree.
    KdTree,
    /// 8-wide bounding volume hierarchy.
    #[default]
    Bvh,
    /// obvhs's compressed wide hierarchy, the library yardstick.
    Cwbvh,
    /// Every primitive is tested.
    None,
}

impl Accelerator {
    /// All, by their names in scenes and on the command line.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("KDTREE", Self::KdTree),
        ("BVH", Self::Bvh),
        ("CWBVH", Self::Cwbvh),
        ("NONE", Self::None),
    ];

    /// The structure of a name, in any case.
    ///
    /// # Errors
    /// A name that is none of [`NAMES`](Self::NAMES).
    pub fn by_name(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|&(_, accelerator)| accelerator).ok_or_else(|| {
            format!("unknown accelerator `{name}`, expected KDTREE, BVH, CWBVH or NONE")
        })
    }
}

impl std::fmt::Display for Accelerator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = Self::NAMES.iter().find(|(_, of)| of == self).map_or("", |(name, _)| name);
        f.write_str(name)
    }
}

/// Which points the integral is sampled at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Generator {
    /// Independent uniform numbers.
    Pseudo,
    /// The thesis's XOR-scrambled (0,2)-sequence.
    ZeroTwo,
    /// Owen-scrambled (0,2)-sequences that go well together.
    #[default]
    Quasi,
}

/// A picture that goes with the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// The share of light that surfaces send back, whatever falls on them: red, green, blue from 0
    /// to 1.
    Albedo,
    /// Normals of surfaces for shading, on the side that is seen: x, y, z in the scene's axes, as
    /// long as 1 where there is one surface, and 0 where there is none.
    Normal,
}

impl Layer {
    /// All there are, in the order of files and recipes.
    pub const ALL: [Self; 2] = [Self::Albedo, Self::Normal];

    /// As in command lines, recipes, and channels of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
        }
    }
}

/// Most camera samples of a pixel, `imageSamples` times `dofSamples`: the film can add up so many.
pub const MOST_CAMERA_SAMPLES: u32 = (1 << 22) - 1;

/// How many lights a hit asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum LightSampling {
    /// One light at random, weighted by the number of lights.
    One,
    /// Every light.
    #[default]
    All,
}

/// The contrast of a sample `I` with the mean `E` (thesis 5.12 to 5.14).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Contrast {
    /// |I - E|
    #[default]
    Difference,
    /// |I - E| / E
    Weber,
    /// |I - E| / (I + E)
    Michelson,
}

/// What a refractive object does to light that passes through it on its way to a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ShadowMode {
    /// Blocks it.
    #[default]
    Opaque,
    /// Lets `refraction` of it through, unbent.
    Transparent,
}

/// The `settings` element. Counts are 1 or more.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// `generatorType`
    pub generator: Generator,
    /// `lightSamplingType`
    pub light_sampling: LightSampling,
    /// `contrastType`
    pub contrast: Contrast,
    /// `imageSamples`, per pixel.
    pub image_samples: u32,
    /// `imageMinSamples`; equal to `image_samples`: not adaptive.
    pub image_min_samples: u32,
    /// `imageContrastLimit`
    pub image_contrast_limit: f32,
    /// `dofSamples`, multiplies `image_samples`.
    pub dof_samples: u32,
    /// `softShadowSamples`, per area light at the first hit.
    pub soft_shadow_samples: u32,
    /// `diffuseReflectionSamples`, at the first hit.
    pub diffuse_reflection_samples: u32,
    /// `diffuseRefractionSamples`, at the first hit.
    pub diffuse_refraction_samples: u32,
    /// Bounces after the primary hit; 0 is none.
    pub recursion: u32,
    /// `sectionsHorizontal`; `None`: chosen by the renderer.
    pub sections_horizontal: Option<u32>,
    /// `sectionsVertical`; `None`: chosen by the renderer.
    pub sections_vertical: Option<u32>,
    /// `parallelThreads`; `None`: all that the machine has.
    pub parallel_threads: Option<u32>,
    /// `sectionsPerThread`: sections handed out at a time.
    pub sections_per_thread: u32,
    /// Radiance of a ray that hits nothing.
    pub background: [f32; 3],
    /// Seed of every random number.
    pub seed: u64,
    /// `accelerator`
    pub accelerator: Accelerator,
    /// `spatialSplits`: whether the BVH may cut triangles.
    pub spatial_splits: bool,
    /// `shadow`
    pub shadow: ShadowMode,
    /// `noise`: error at which a pixel is done; `None`: off.
    pub noise: Option<f32>,
    /// `transformSamplesPerMs`: sampled transforms per millisecond of shutter, at least.
    pub transform_samples_per_ms: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            generator: Generator::default(),
            light_sampling: LightSampling::default(),
            contrast: Contrast::default(),
            image_samples: 16,
            image_min_samples: 16,
            image_contrast_limit: 0.03,
            dof_samples: 1,
            soft_shadow_samples: 1,
            diffuse_reflection_samples: 1,
            diffuse_refraction_samples: 1,
            recursion: 3,
            sections_horizontal: None,
            sections_vertical: None,
            parallel_threads: None,
            sections_per_thread: 1,
            background: [0.0; 3],
            seed: 0,
            accelerator: Accelerator::default(),
            spatial_splits: false,
            shadow: ShadowMode::default(),
            noise: None,
            transform_samples_per_ms: 2.0,
        }
    }
}

/// File format of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum OutputFormat {
    /// 8 bits a channel.
    #[default]
    Png8,
    /// 16 bits a channel.
    Png16,
    /// 32-bit float, unclamped, linear whatever the encoding.
    Exr,
}

impl OutputFormat {
    /// What names of such files end in.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png8 | Self::Png16 => "png",
            Self::Exr => "exr",
        }
    }
}

/// How radiance becomes a PNG value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// Clamped and scaled, as the thesis.
    #[default]
    Raw,
    /// Linear light to sRGB.
    Srgb,
}

/// The `Film` element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    /// Pixels, 1 to 65536.
    pub width: u32,
    /// Pixels, 1 to 65536.
    pub height: u32,
    /// In front of the frame number in the file's name.
    pub prefix: String,
    /// File format.
    pub output: OutputFormat,
    /// Transfer curve of PNG values.
    pub encoding: Encoding,
    /// What an EXR file holds beside the colours; ascending, each once.
    pub layers: Vec<Layer>,
}
