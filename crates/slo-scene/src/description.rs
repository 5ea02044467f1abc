//! The resolved scene: references followed, units scaled, defaults filled in, files loaded.
//!
//! Everything is plain data in scene space: right-handed, f64, the user's own units (`Scaling`
//! already applied). Nothing here knows a frame number, a ray or a thread.

use std::sync::Arc;

use glam::DVec3;

use crate::settings::{Film, Settings};
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
