//! Rendering of a scene to a picture.

use std::fmt;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPoolBuilder;
use slo_accel::Isa;
use slo_picture::film::{Area, Film};
use slo_render::frame::FrameScene;
use slo_render::render::{Exposed, Observer, Plan, render};
use slo_scene::settings::invalid;
use slo_scene::{Film as FilmSettings, Layer, OutputFormat, SceneDescription, Settings};

use crate::error::Error;
use crate::picture::Picture;
use crate::scene::Scene;

/// One frame of a scene to be rendered, with settings that replace the scene's.
pub struct Render<'a> {
    scene: SceneDescription,
    frame: i64,
    threads: Option<usize>,
    progress: Option<Box<dyn Fn(f64) + Sync + 'a>>,
    cancel: Option<&'a AtomicBool>,
}

impl<'a> Render<'a> {
    /// Starts with frame 0 of a scene and the scene's settings.
    pub fn new(scene: &Scene) -> Self {
        let scene = scene.description().clone();
        Self { scene, frame: 0, threads: None, progress: None, cancel: None }
    }

    /// Sets the frame. Frame `n` opens its shutter `n / fps` seconds into the video.
    #[must_use]
    pub fn frame(mut self, frame: i64) -> Self {
        self.frame = frame;
        self
    }

    /// Sets the size of the picture in pixels.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        (self.scene.camera.film.width, self.scene.camera.film.height) = (width, height);
        self
    }

    /// Sets the camera samples per pixel, instead of `imageSamples` times `dofSamples`.
    #[must_use]
    pub fn samples(mut self, samples: u32) -> Self {
        self.scene.settings.set_camera_samples(samples);
        self
    }

    /// Sets the seed of every random number.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.scene.settings.seed = seed;
        self
    }

    /// Layers that the picture has beside its colours. Not every format can hold them, see
    /// [`Picture::save`].
    #[must_use]
    pub fn layers(mut self, layers: &[Layer]) -> Self {
        let mut layers = layers.to_vec();
        layers.sort_unstable();
        layers.dedup();
        self.scene.camera.film.layers = layers;
        self
    }

    /// Sets the file format that [`save`](Self::save) writes.
    #[must_use]
    pub fn format(mut self, format: OutputFormat) -> Self {
        self.scene.camera.film.output = format;
        self
    }

    /// Changes any setting.
    #[must_use]
    pub fn settings(mut self, change: impl FnOnce(&mut Settings)) -> Self {
        change(&mut self.scene.settings);
        self
    }

    /// Changes anything about the film.
    #[must_use]
    pub fn film(mut self, change: impl FnOnce(&mut FilmSettings)) -> Self {
        change(&mut self.scene.camera.film);
        self
    }

    /// Number of threads of a pool of its own, 0 for as many as the machine has; without it, the frame is
    /// rendered on the current rayon pool. Pictures do not depend on it.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Calls a function, from any thread, with the share of the picture that is done, from 0 to 1.
    #[must_use]
    pub fn progress(mut self, progress: impl Fn(f64) + Sync + 'a) -> Self {
        self.progress = Some(Box::new(progress));
        self
    }

    /// Stops soon after `cancel` becomes true.
    #[must_use]
    pub fn cancel(mut self, cancel: &'a AtomicBool) -> Self {
        self.cancel = Some(cancel);
        self
    }

    /// Renders the frame.
    ///
    /// # Errors
    /// [`Error::Setting`] for an impossible value, [`Error::Frame`] if the scene has no such frame,
    /// [`Error::TooLarge`], [`Error::Threads`], or
    /// [`Error::Cancelled`].
    pub fn run(self) -> Result<Picture, Error> {
        match self.threads {
            None => self.expose(),
            Some(threads) => ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|error| Error::Threads(error.to_string()))?
                .install(|| self.expose()),
        }
    }

    /// Renders the frame and saves it as [`Picture::save`] does.
    ///
    /// # Errors
    /// The errors of [`run`](Self::run) and [`Picture::save`].
    pub fn save(self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.run()?.save(path)
    }

    fn expose(&self) -> Result<Picture, Error> {
        let (scene, film) = (&self.scene, &self.scene.camera.film);
        check(&scene.settings, film)?;
        crate::gpu::offer();
        let frame = FrameScene::build(scene, self.frame, Isa::best())?;
        let plan = Plan::new(scene);
        let empty = empty_film(scene, plan.needs_spreads())?;
        let watch = Watch { render: self, done: Mutex::new(0.0) };
        let Exposed { film, is_complete, .. } = render(&frame, &plan, empty, &watch);
        if !is_complete {
            return Err(Error::Cancelled);
        }
        Ok(Picture::new(scene.clone(), self.frame, film))
    }
}

/// Checks that all settings have values that a scene could give them.
fn check(settings: &Settings, film: &FilmSettings) -> Result<(), Error> {
    let wrong = invalid(settings).or_else(|| invalid(film));
    let inconsistent = (!settings.are_consistent()).then_some("imageSamples");
    wrong.or(inconsistent).map_or(Ok(()), |name| Err(Error::Setting { name }))
}

/// A film without a sample, with room for the layers.
fn empty_film(scene: &SceneDescription, with_spreads: bool) -> Result<Film, Error> {
    let &FilmSettings { width, height, ref layers, .. } = &scene.camera.film;
    let empty = Film::new(Area::whole(width, height), with_spreads);
    let empty = empty.and_then(|film| film.with_layers(layers, &scene.layer_names()));
    empty.map_err(|_| Error::TooLarge { width, height })
}

impl fmt::Debug for Render<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Render").field("frame", &self.frame).finish_non_exhaustive()
    }
}

/// Reports to the caller how far the picture is, and tells the renderer when to stop.
struct Watch<'a> {
    render: &'a Render<'a>,
    done: Mutex<f64>,
}

impl Observer for Watch<'_> {
    fn advanced(&self, share: f64) {
        if let Some(progress) = &self.render.progress {
            let mut done = self.done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            *done = (*done + share).min(1.0);
            progress(*done);
        }
    }

    fn should_stop(&self) -> bool {
        self.render.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    fn gives_up(&self) -> bool {
        self.should_stop()
    }
}
