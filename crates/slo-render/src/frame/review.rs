//! The same frame, seen by a camera elsewhere.

use std::sync::OnceLock;

use super::build::is_near;
use super::compositing::Compositing;
use super::error::FrameError;
use super::looks::Look;
use super::sampled_camera::SampledCamera;
use super::scene::FrameScene;
use super::shown::Shown;
use crate::camera::Camera;
use slo_scene::SceneDescription;
use slo_scene::animation::Clock;

impl FrameScene {
    /// Returns the frame as a camera elsewhere sees it, or one with other pixels, another lens or other
    /// layers. `scene` must differ from that of the frame, and `number` be the same, in nothing else.
    /// The structures stay as they are, so this takes no time; the picture differs from that of a frame
    /// that was built in the last bits of its numbers.
    ///
    /// `None` if the frame must be built: something moves while the shutter is open, photons start where
    /// the camera looks, or the camera is too far away.
    ///
    /// # Errors
    /// Fails if the frame's time lies in no camera segment, or if nothing can be seen from the camera's
    /// view.
    pub fn seen_anew(
        self,
        scene: &SceneDescription,
        number: i64,
    ) -> Result<Option<Self>, FrameError> {
        let shutter = Clock::new(&scene.camera).shutter(number).map_err(FrameError::NoSegment)?;
        let segment = &scene.camera.segments[shutter.segment];
        let film = &scene.camera.film;
        let per_ms = scene.settings.transform_samples_per_ms;
        let path = SampledCamera::new(segment, &shutter, film, per_ms);
        let origin = self.compositing.origin;
        let moves = self.world.instances.iter().any(|instance| instance.poses.len() > 1);
        let sends = self.emission.is_some() || self.photon_lamps.is_some();
        if moves || sends || self.baked.is_some() || !is_near(&path, origin) {
            return Ok(None);
        }
        let camera = Camera::new(path.views(), origin, film.width, film.height)
            .map_err(|reason| FrameError::View { segment: segment.name.clone(), reason })?;
        let looks: Vec<Look> = (0..self.looks.len() as u32).map(|i| self.looks.of(i)).collect();
        let times = (number, &shutter);
        let compositing = match film.layers.is_empty() {
            true => Compositing::without_layers(origin),
            false => Compositing::new(scene, &Shown::of(scene)?, times, origin, &looks)?,
        };
        let (field, known_light) = (OnceLock::new(), OnceLock::new());
        Ok(Some(Self { camera, compositing, field, known_light, counting: None, ..self }))
    }
}
