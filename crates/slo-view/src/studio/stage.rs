//! The scene as it is shown: another frame, size or camera than the text says.

use glam::DVec3;
use slo_scene::animation::{Clock, KeyFrames, view_at};
use slo_scene::{Accelerator, CamSegment, SceneDescription};

use crate::camera::{Held, hold};

/// Most ranges of frames that a message names.
const MOST_RANGES: usize = 6;

/// The scene as it is shown.
#[derive(Debug)]
pub(crate) struct Stage {
    /// What the text says.
    scene: SceneDescription,
    shown: SceneDescription,
    frame: i64,
    /// What the camera moves about; `None`: what it looks at.
    pivot: Option<DVec3>,
    /// Sides of the picture as a share of the scene's.
    share: f64,
    accelerator: Option<Accelerator>,
    is_moved: bool,
}

impl Stage {
    /// Shows a frame of a scene: the first one if it has no such frame.
    pub(super) fn new(scene: SceneDescription, frame: i64) -> Self {
        let shown = scene.clone();
        let mut stage = Self {
            scene,
            shown,
            frame,
            pivot: None,
            share: 1.0,
            accelerator: None,
            is_moved: false,
        };
        stage.set_frame(frame);
        stage.dress();
        stage
    }

    /// Shows a frame of another scene in the same way: the nearest that it has.
    pub(super) fn with_scene(self, scene: SceneDescription, frame: i64) -> Self {
        let shown = scene.clone();
        let mut stage = Self { scene, shown, is_moved: false, ..self };
        stage.set_frame(frame);
        stage.dress();
        stage
    }

    /// What the text says.
    pub(crate) fn scene(&self) -> &SceneDescription {
        &self.scene
    }

    /// The scene as it is shown.
    pub(crate) fn shown(&self) -> &SceneDescription {
        &self.shown
    }

    /// The scene as it is shown. Whoever changes it changes it back.
    pub(super) fn shown_mut(&mut self) -> &mut SceneDescription {
        &mut self.shown
    }

    /// Number of the frame.
    pub(crate) fn frame(&self) -> i64 {
        self.frame
    }

    /// Sides of the picture as a share of the scene's.
    pub(crate) fn share(&self) -> f64 {
        self.share
    }

    /// The structure that is used instead of the scene's.
    pub(crate) fn accelerator(&self) -> Option<Accelerator> {
        self.accelerator
    }

    /// Whether the camera is elsewhere than the text says.
    pub(crate) fn is_moved(&self) -> bool {
        self.is_moved
    }

    /// Shows another frame: the nearest that the scene has.
    pub(super) fn set_frame(&mut self, frame: i64) {
        let clock = Clock::new(&self.scene.camera);
        let nearest = |first: i64, last: i64| frame.clamp(first, last);
        let frames = clock.segments().filter(|segment| segment.first <= segment.last);
        let frames = frames.map(|segment| nearest(segment.first, segment.last));
        self.frame = frames.min_by_key(|of| of.abs_diff(frame)).unwrap_or(frame);
    }

    /// Why there is no frame of a number; `None` if there is one.
    pub(crate) fn lacks(&self, frame: i64) -> Option<String> {
        let clock = Clock::new(&self.scene.camera);
        let ranges: Vec<[i64; 2]> = clock
            .segments()
            .filter(|segment| segment.first <= segment.last)
            .map(|segment| [segment.first, segment.last])
            .collect();
        if ranges.iter().any(|[first, last]| (*first..=*last).contains(&frame)) {
            return None;
        }
        let range = |[first, last]: &[i64; 2]| match first == last {
            true => first.to_string(),
            false => format!("{first} to {last}"),
        };
        let more = ranges.len().saturating_sub(MOST_RANGES);
        let mut named: Vec<String> = ranges.iter().take(MOST_RANGES).map(range).collect();
        named.extend((more > 0).then(|| format!("{more} other ranges")));
        Some(format!("there is no frame {frame}: the scene has {}", named.join(", ")))
    }

    pub(super) fn set_share(&mut self, share: f64) {
        self.share = share;
        self.dress();
    }

    pub(super) fn set_accelerator(&mut self, accelerator: Option<Accelerator>) {
        self.accelerator = accelerator;
        self.dress();
    }

    pub(super) fn set_pivot(&mut self, pivot: DVec3) {
        self.pivot = Some(pivot);
    }

    /// What the camera moves about.
    pub(super) fn pivot(&self) -> Option<DVec3> {
        self.pivot.or_else(|| Some(self.held()?.view.target))
    }

    /// The camera of this frame when the shutter opens.
    pub(crate) fn held(&self) -> Option<Held> {
        let (segment, parameter) = self.place()?;
        let segment = &self.shown.camera.segments[segment];
        Some(Held { view: view_at(segment, parameter), shutter: segment.blur_duration })
    }

    /// The path of the camera of this frame.
    pub(crate) fn path(&self) -> Option<&CamSegment> {
        let (segment, _) = self.place()?;
        self.shown.camera.segments.get(segment)
    }

    /// Moves the camera of this frame, and its path with it.
    pub(super) fn hold(&mut self, to: &Held) {
        let (Some((segment, _)), Some(from)) = (self.place(), self.held()) else { return };
        let is_finite = |point: DVec3| point.is_finite() && point.abs().max_element() < 1e12;
        if *to != from && is_finite(to.view.position) && is_finite(to.view.target) {
            hold(&mut self.shown.camera.segments[segment], &from.view, to);
            self.is_moved = true;
        }
    }

    /// The segment of this frame, as it is in the text and as it is shown, if the camera has been moved.
    pub(super) fn moved_segment(&self) -> Option<(&CamSegment, &CamSegment)> {
        if !self.is_moved {
            return None;
        }
        let (of_text, shown) = (&self.scene.camera.segments, &self.shown.camera.segments);
        let (segment, _) = self.place()?;
        Some((of_text.get(segment)?, shown.get(segment)?))
    }

    /// Takes the camera that is shown for that of the text.
    pub(super) fn keep_camera(&mut self) {
        self.scene.camera.segments.clone_from(&self.shown.camera.segments);
        self.is_moved = false;
    }

    /// Where an object is in its parent when the shutter opens: scene time, pivot, and the axes x and z.
    pub(super) fn place_of(&self, name: &str) -> Option<(f64, [DVec3; 3])> {
        let object = self.scene.objects.iter().find(|object| object.name == name)?;
        let shutter = Clock::new(&self.scene.camera).shutter(self.frame).ok()?;
        let time = shutter.scene_time(0.0);
        if object.key_frames.is_empty() {
            return Some((time, [DVec3::ZERO, DVec3::X, DVec3::Z]));
        }
        let frames = KeyFrames::new(&object.key_frames).ok()?.repeated(object.repeat);
        let pose = frames.is_rigid().then(|| frames.pose(time))?;
        Some((time, [pose.translation, pose.rotation.x_axis, pose.rotation.z_axis]))
    }

    /// Returns to the camera of the text.
    pub(super) fn reset(&mut self) {
        self.shown.camera.segments.clone_from(&self.scene.camera.segments);
        self.is_moved = false;
        self.pivot = None;
    }

    /// The segment of this frame, and how far through it the frame is.
    fn place(&self) -> Option<(usize, f64)> {
        let shutter = Clock::new(&self.scene.camera).shutter(self.frame).ok()?;
        Some((shutter.segment, shutter.segment_parameter(0.0)))
    }

    /// Applies what is chosen in the page.
    fn dress(&mut self) {
        let (film, scene) = (&mut self.shown.camera.film, &self.scene);
        let side = |pixels: u32| ((f64::from(pixels) * self.share).round() as u32).max(1);
        (film.width, film.height) = (side(scene.camera.film.width), side(scene.camera.film.height));
        film.layers.clear();
        let accelerator = self.accelerator.unwrap_or(scene.settings.accelerator);
        self.shown.settings.accelerator = accelerator;
    }
}
