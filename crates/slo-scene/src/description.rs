//! The resolved scene: references followed, units scaled, defaults filled in, files loaded.
//!
//! Everything is plain data in scene space: right-handed, f64, the user's own units (`Scaling`
//! already applied). Nothing here knows a frame number, a ray or a thread.

use std::sync::Arc;

use glam::DVec3;

use crate::texture::Texture;

/// A scene that has no errors: all that its text, meshes and textures say.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// How to render.
    pub settings: Settings,
    /// The one camera.
    pub camera: Camera,
    /// Lights in the order of the text.
    pub lights: Vec<Light>,
    /// Materials in the order of the text.
    pub materials: Vec<Material>,
    /// Images that materials refer to.
    pub textures: Vec<Arc<Texture>>,
    /// Objects in the order of the text.
    pub objects: Vec<Object>,
    /// BLAKE3 over everything that can change a picture of this scene: the text and the bytes of
    /// every mesh and texture, in the order of their loading.
    pub content_hash: [u8; 32],
}

/// Index into [`SceneDescription::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// Index into [`SceneDescription::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

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

/// The `Camera` element.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Frames per second of the finished video; more than 0.
    pub fps: f64,
    /// What the camera exposes.
    pub film: Film,
    /// In order of `video_start`, without overlap; one or more.
    pub segments: Vec<CamSegment>,
}

/// The `CamSegment` element: one stretch of the video.
#[derive(Clone, Debug)]
pub struct CamSegment {
    /// The name in the text.
    pub name: String,
    /// Seconds of the finished video, half-open `[start, end)`; the last segment also owns its end.
    pub video: [f64; 2],
    /// Scene time at the start and the end.
    pub scene: [f64; 2],
    /// Control points of the Bézier curve of the camera's position; one or more.
    pub positions: Vec<DVec3>,
    /// Control points of the Bézier curve of the point that it looks at; one or more.
    pub targets: Vec<DVec3>,
    /// Upward direction at the start and the end; need not be unit.
    pub sky: [DVec3; 2],
    /// Half height of the view at distance 1 (not an angle), at the start and the end; more than 0.
    pub fov: [f64; 2],
    /// Distance of the sharp plane at the start and the end; more than 0 where the lens is open.
    pub dof: [f64; 2],
    /// Radius of the lens at the start and the end; 0 is a pinhole.
    pub lens_radius: [f64; 2],
    /// Seconds of video time that the shutter stays open; 0 or more.
    pub blur_duration: f64,
}

/// A light.
#[derive(Clone, Debug)]
pub struct Light {
    /// The name in the text.
    pub name: String,
    /// Radiance that reaches a hit; does not fall off with distance.
    pub color: [f32; 3],
    /// Where it is.
    pub shape: LightShape,
}

/// Where a light is.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// `light_point`
    Point {
        /// Position.
        position: DVec3,
    },
    /// `light_rectangle`: three consecutive corners; the fourth is `v0 + v2 - v1`.
    Rectangle {
        /// Corners.
        vertices: [DVec3; 3],
    },
}

/// A `phong_info`, resolved into the material that refers to it.
#[derive(Clone, Debug)]
pub struct Material {
    /// The name in the text.
    pub name: String,
    /// k_a
    pub ambient: [f32; 3],
    /// k_d
    pub diffuse: [f32; 3],
    /// k_s
    pub specular: [f32; 3],
    /// Exponent of the highlight.
    pub shininess: f32,
    /// k_r
    pub reflectance: f32,
    /// Spread of the reflected lobe; 0: mirror.
    pub diffuse_reflection: f32,
    /// k_t
    pub refraction: f32,
    /// Spread of the refracted lobe; 0: clear.
    pub diffuse_refraction: f32,
    /// Index of refraction inside; 1 outside. More than 0.
    pub refraction_index: f32,
    /// Multiplies ambient and diffuse.
    pub texture: Option<TextureUse>,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// The image.
    pub texture: TextureId,
    /// `scale_U`, `scale_V`: repetitions over one unit of uv.
    pub scale: [f32; 2],
}

/// A thing that can be seen.
#[derive(Clone, Debug)]
pub struct Object {
    /// The name in the text.
    pub name: String,
    /// What it is made of.
    pub material: MaterialId,
    /// What it looks like, in object space (scene space where there are no key frames).
    pub shape: Shape,
    /// In order of time; none: object space is scene space. One: a placed, still object.
    pub key_frames: Vec<KeyFrame>,
}

/// A surface, in object space.
#[derive(Clone, Debug)]
pub enum Shape {
    /// `plane`: a square of side `side` about `position`.
    Plane {
        /// Not 0; need not be unit.
        normal: DVec3,
        /// Centre of the square.
        position: DVec3,
        /// 1000 times `Scaling`.
        side: f64,
    },
    /// `sphere`
    Sphere {
        /// Centre.
        center: DVec3,
        /// More than 0.
        radius: f64,
    },
    /// `triangle`
    Triangle {
        /// Corners.
        vertices: [DVec3; 3],
    },
    /// `rectangle`: three consecutive corners; the fourth is `v0 + v2 - v1`.
    Rectangle {
        /// Corners.
        vertices: [DVec3; 3],
    },
    /// `box`: a base rectangle, raised by `height` along (v2 - v1) x (v0 - v1).
    Box {
        /// Three consecutive corners of the base.
        vertices: [DVec3; 3],
        /// Not 0.
        height: f64,
    },
    /// `cylinder`, closed.
    Cylinder {
        /// Centre of one end.
        base: DVec3,
        /// Centre of the other end.
        top: DVec3,
        /// More than 0.
        radius: f64,
    },
    /// `cone`, closed by a disc at its base.
    Cone {
        /// Centre of the disc.
        base: DVec3,
        /// Tip.
        apex: DVec3,
        /// Radius of the disc; more than 0.
        radius: f64,
    },
    /// `mesh`
    Mesh {
        /// Its triangles.
        mesh: Arc<Mesh>,
        /// Whether the vertex normals are interpolated.
        smooth: bool,
    },
}

/// Triangles with shared vertices.
///
/// `positions` are in the file's units times `Scaling`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// One per vertex.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside; no degenerate triangle is left.
    pub faces: Vec<[u32; 3]>,
    /// Unit, one per vertex, or empty where the mesh is not smooth.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; v grows upwards in the image. Empty: the mesh has none.
    pub uvs: Vec<[f32; 2]>,
    /// Indices into `uvs`, one triple per face; empty where `uvs` is.
    pub face_uvs: Vec<[u32; 3]>,
}

/// `addKframe`: where an object is at one time, and how its path bends there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KeyFrame {
    /// Scene time.
    pub time: f64,
    /// Last but one control point of the cubic that arrives.
    pub pre: Placement,
    /// The point where the arriving and the leaving cubic meet.
    pub key: Placement,
    /// Second control point of the cubic that leaves.
    pub nex: Placement,
}

/// A control point of an object's path; what is missing is filled in by `animation`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Where the origin of object space is.
    pub pivot: Option<DVec3>,
    /// Where its z axis points; need not be unit.
    pub up: Option<DVec3>,
    /// Where its x axis points; need not be unit.
    pub right: Option<DVec3>,
}
