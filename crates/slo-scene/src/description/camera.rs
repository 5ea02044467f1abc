//! The camera: its film, and stretches of the video.

use glam::DVec3;

use crate::settings::Film;

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
    /// Distance of the sharp plane at the start and the end; more than 0 if the lens is open.
    pub dof: [f64; 2],
    /// Radius of the lens at the start and the end; 0 is a pinhole.
    pub lens_radius: [f64; 2],
    /// Seconds of video time that the shutter stays open; 0 or more.
    pub blur_duration: f64,
}
