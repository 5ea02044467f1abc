//! The picture that is looked at: coarse at first, then better and better.

mod frames;
mod overlay;
mod screen;
mod shot;
mod watch;

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use slo_accel::Isa;
use slo_picture::film::{Area, Film, Image, Steps};
use slo_picture::output::Outcome;
use slo_render::frame::{FrameError, FrameScene};
use slo_render::render::{Exposed, Plan, Statistics, render};
use slo_scene::SceneDescription;

use frames::{Frames, Purpose};
pub(crate) use overlay::{Map, Overlay};
pub(crate) use screen::bytes;
pub(crate) use shot::Shot;
use watch::Watch;

/// How long the first picture after a change may take, as far as that can be told.
const FIRST: Duration = Duration::from_millis(70);
/// The same while one change follows another.
const FOLLOWING: Duration = Duration::from_millis(30);
/// What a measurement of a sample's cost leaves of a higher one before it: other programs come and go.
const MEMORY: f64 = 0.8;
/// Most that the sides of the first picture are divided by.
const COARSEST: u32 = 16;
/// Smallest side of a coarse picture.
const LEAST_SIDE: u32 = 24;

/// What is rendered next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// One sample per pixel, of a picture whose sides are divided.
    Coarse(u32),
    /// A step of the whole picture, see [`Steps`].
    Step(u32),
    Done,
}

/// Why nothing can be shown.
#[derive(Debug)]
pub(crate) enum Fault {
    Frame(FrameError),
    TooLarge,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(error) => error.fmt(f),
            Self::TooLarge => f.write_str("there is no memory for a picture of this size"),
        }
    }
}

/// Renders the picture piece by piece.
#[derive(Debug)]
pub(crate) struct Looker {
    pool: Arc<ThreadPool>,
    isa: Isa,
    frames: Frames,
    /// Number of the scene that is looked at, see [`Purpose`].
    content: u64,
    overlay: Overlay,
    stage: Stage,
    film: Film,
    /// Steps and tests of its pixels, if they are counted.
    costs: Vec<[u64; 2]>,
    /// What is seen where the film has no samples.
    coarse: Option<Image>,
    /// Seconds that a sample took: by the last measurement, or by a slower one not long before.
    cost: f64,
    /// When the picture changed.
    since: Instant,
    /// Counts changes of the picture.
    picture: u64,
    /// Whether the next change is expected soon.
    is_moving: bool,
    /// Whether the first picture after a change has just been made, while the next change is expected.
    is_followed: bool,
    statistics: Statistics,
    seconds: f64,
}

impl Looker {
    pub(crate) fn new(pool: Arc<ThreadPool>, isa: Isa) -> Self {
        Self {
            pool,
            isa,
            frames: Frames::default(),
            content: 0,
            overlay: Overlay::None,
            stage: Stage::Done,
            film: Film::default(),
            costs: Vec::new(),
            coarse: None,
            cost: 1e-6,
            since: Instant::now(),
            picture: 0,
            is_moving: false,
            is_followed: false,
            statistics: Statistics::default(),
            seconds: 0.0,
        }
    }

    /// The threads.
    pub(crate) fn pool(&self) -> &Arc<ThreadPool> {
        &self.pool
    }

    /// The instruction set.
    pub(crate) fn isa(&self) -> Isa {
        self.isa
    }

    /// The scene is another one, and not only its camera.
    pub(crate) fn change_content(&mut self) {
        self.content += 1;
    }

    /// An object or a lamp is likely to be moved.
    pub(crate) fn set_apart(&mut self, name: Option<&str>) {
        self.frames.set_apart(name);
    }

    /// What is laid over the picture.
    pub(crate) fn overlay(&self) -> Overlay {
        self.overlay
    }

    /// Why the overlay can't be shown.
    pub(crate) fn overlay_fault(&self) -> Option<&str> {
        self.frames.uncounted()
    }

    /// Lays something else over the picture. Returns whether the picture must be begun again.
    pub(crate) fn set_overlay(&mut self, overlay: Overlay) -> bool {
        let counted = self.overlay == Overlay::Cost;
        self.overlay = overlay;
        counted != (overlay == Overlay::Cost)
    }

    /// Number of the change that is being rendered.
    pub(crate) fn picture(&self) -> u64 {
        self.picture
    }

    /// Whether the picture has all of its samples.
    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    /// Whether it is better to wait a little for the next change than to make the picture finer.
    pub(crate) fn is_followed(&self) -> bool {
        self.is_followed
    }

    /// Begins a picture of a size. `is_moving`: whether the next change is expected soon.
    pub(crate) fn begin(&mut self, scene: &SceneDescription, is_moving: bool) {
        let budget = if is_moving { FOLLOWING } else { FIRST };
        let (width, height) = (scene.camera.film.width, scene.camera.film.height);
        let fits = |by: u32| {
            let pixels = f64::from(width.div_ceil(by)) * f64::from(height.div_ceil(by));
            pixels * self.cost <= budget.as_secs_f64()
        };
        let mut by = 1;
        while by < COARSEST && !fits(by) && width.min(height) / (2 * by) >= LEAST_SIDE {
            by *= 2;
        }
        self.stage = if by == 1 { Stage::Step(0) } else { Stage::Coarse(by) };
        self.film = Film::default();
        self.since = Instant::now();
        self.picture += 1;
        (self.is_moving, self.is_followed) = (is_moving, false);
        self.coarse = None;
        (self.statistics, self.seconds) = (Statistics::default(), 0.0);
    }

    /// Ends the picture: nothing can be rendered.
    pub(crate) fn end(&mut self) {
        self.stage = Stage::Done;
    }

    /// Renders the next piece of the picture, unless `stop` becomes true meanwhile. Long pieces call
    /// `show` on their way. Returns what there is to see, if there is anything new.
    pub(crate) fn advance(
        &mut self,
        scene: &mut SceneDescription,
        number: i64,
        stop: &(dyn Fn() -> bool + Sync),
        show: &(dyn Fn(Shot) + Sync),
    ) -> Result<Option<Shot>, Fault> {
        let pool = self.pool.clone();
        self.is_followed = std::mem::take(&mut self.is_moving);
        match self.stage {
            Stage::Done => Ok(None),
            Stage::Coarse(by) => pool.install(|| self.coarse(scene, number, by, stop)),
            Stage::Step(step) => pool.install(|| self.step(scene, number, step, stop, show)),
        }
    }

    fn coarse(
        &mut self,
        scene: &mut SceneDescription,
        number: i64,
        by: u32,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Shot>, Fault> {
        let whole = (scene.camera.film.width, scene.camera.film.height);
        let film = &mut scene.camera.film;
        (film.width, film.height) = (whole.0.div_ceil(by), whole.1.div_ceil(by));
        let (width, height) = (film.width, film.height);
        let plan = Plan::new(scene).in_steps(Steps::default());
        let purpose = self.purpose(scene, true);
        let built = self.frames.make(scene, number, self.isa, purpose).map_err(Fault::Frame);
        (scene.camera.film.width, scene.camera.film.height) = whole;
        let built = built?;
        let film = Film::new(Area::whole(width, height), false).map_err(|_| Fault::TooLarge)?;
        let start = Instant::now();
        // The first picture is finished even if the next change is there: otherwise nothing would be seen
        // while one change follows another.
        let never = || false;
        let is_first = self.coarse.is_none();
        let watch = Watch::new(if is_first { &never } else { stop });
        let exposed = render(built, &plan, film, &watch);
        if !exposed.is_complete {
            return Ok(None);
        }
        self.measure(start.elapsed(), f64::from(width) * f64::from(height));
        self.count(&exposed, start);
        let image = exposed.film.image();
        self.coarse = Some(image.clone());
        self.stage = if by > 2 { Stage::Coarse(by / 2) } else { Stage::Step(0) };
        Ok(Some(self.shot(image, whole, None)))
    }

    fn step(
        &mut self,
        scene: &SceneDescription,
        number: i64,
        step: u32,
        stop: &(dyn Fn() -> bool + Sync),
        show: &(dyn Fn(Shot) + Sync),
    ) -> Result<Option<Shot>, Fault> {
        let whole = (scene.camera.film.width, scene.camera.film.height);
        let area = Area::whole(whole.0, whole.1);
        let plan = Plan::new(scene);
        if self.film.area() != area {
            self.film = Film::new(area, false).map_err(|_| Fault::TooLarge)?;
        }
        let before = std::mem::take(&mut self.film);
        let purpose = self.purpose(scene, false);
        let mut frames = std::mem::take(&mut self.frames);
        let frame = match frames.make(scene, number, self.isa, purpose) {
            Ok(frame) => frame,
            Err(error) => {
                self.frames = frames;
                return Err(Fault::Frame(error));
            }
        };
        let had = samples(&before);
        let start = Instant::now();
        let partly = |film: &Film| show(self.shot(self.over_coarse(film), whole, None));
        let is_first = step == 0 && self.coarse.is_none();
        let never = || false;
        let watch = Watch::new(if is_first { &never } else { stop }).showing(&partly);
        let exposed =
            render(frame, &plan.clone().in_steps(Steps { done: step, tiles: 0 }), before, &watch);
        let took = samples(&exposed.film) - had;
        let costs = frame.costs();
        self.frames = frames;
        // Counting takes longer than rendering.
        if step == 0 && exposed.is_complete && costs.is_empty() {
            self.measure(start.elapsed(), took);
        }
        self.count(&exposed, start);
        self.film = exposed.film;
        if !exposed.is_complete {
            return Ok(None);
        }
        self.stage = if step >= Steps::LAST { Stage::Done } else { Stage::Step(step + 1) };
        if took == 0.0 && step >= 3 && self.has_all(&plan) {
            self.stage = Stage::Done;
        }
        self.costs = costs;
        Ok(Some(self.shot_of_film(scene)))
    }

    /// The picture once more, for another overlay; `None` if it is still coarse.
    pub(crate) fn again(&self, scene: &SceneDescription) -> Option<Shot> {
        (!self.film.area().is_empty() && samples(&self.film) > 0.0)
            .then(|| self.shot_of_film(scene))
    }

    fn shot_of_film(&self, scene: &SceneDescription) -> Shot {
        let (film, display) = (&self.film, Plan::new(scene).display());
        let outcome = Outcome::of(film, film.area(), display, self.isa);
        let map = match self.overlay {
            Overlay::None => None,
            Overlay::Error => Some(Map::of_errors(film, display, self.isa)),
            Overlay::Samples => Some(Map::of_samples(film)),
            Overlay::Cost if self.costs.is_empty() => None,
            Overlay::Cost => Some(Map::of_costs(film, &self.costs)),
        };
        let size = (film.area().width(), film.area().height());
        Shot { map: map.map(Arc::new), ..self.shot(film.image(), size, Some(outcome)) }
    }

    /// Explains what is seen at a pixel of the picture: `work` gets its frame.
    pub(crate) fn explained<T: Send>(
        &mut self,
        scene: &SceneDescription,
        number: i64,
        work: impl FnOnce(&FrameScene) -> T + Send,
    ) -> Result<T, Fault> {
        self.with_frame(scene, number, self.purpose(scene, false), work)
    }

    /// Lends a frame without photons, of a scene that is looked at with other layers or another lens.
    pub(crate) fn lend<T: Send>(
        &mut self,
        scene: &SceneDescription,
        number: i64,
        work: impl FnOnce(&FrameScene) -> T + Send,
    ) -> Result<T, Fault> {
        let purpose = Purpose { is_sharp: true, ..self.purpose(scene, true) };
        self.with_frame(scene, number, purpose, work)
    }

    /// Makes a frame, on the threads that render, and does `work` with it.
    fn with_frame<T: Send>(
        &mut self,
        scene: &SceneDescription,
        number: i64,
        purpose: Purpose,
        work: impl FnOnce(&FrameScene) -> T + Send,
    ) -> Result<T, Fault> {
        let pool = self.pool.clone();
        let (frames, isa) = (&mut self.frames, self.isa);
        pool.install(|| frames.make(scene, number, isa, purpose).map(work)).map_err(Fault::Frame)
    }

    fn purpose(&self, scene: &SceneDescription, is_draft: bool) -> Purpose {
        let camera = &scene.camera;
        Purpose {
            content: self.content,
            picture: self.picture,
            size: [camera.film.width, camera.film.height],
            shutters: camera.segments.iter().map(|segment| segment.blur_duration).collect(),
            is_draft,
            is_sharp: false,
            counts: self.overlay == Overlay::Cost && !is_draft,
        }
    }

    /// Whether every pixel has as many samples as the scene allows.
    fn has_all(&self, plan: &Plan) -> bool {
        self.film.pixels().iter().all(|pixel| pixel.samples >= plan.most())
    }

    fn measure(&mut self, time: Duration, samples: f64) {
        self.cost = (time.as_secs_f64() / samples.max(1.0)).max(self.cost * MEMORY);
    }

    fn count(&mut self, exposed: &Exposed, start: Instant) {
        self.statistics += exposed.statistics;
        self.seconds += start.elapsed().as_secs_f64();
    }

    /// The film, with the coarse picture where it has no samples.
    fn over_coarse(&self, film: &Film) -> Image {
        let mut image = film.image();
        let Some(coarse) = &self.coarse else { return image };
        let (width, height) = (image.width as usize, image.height as usize);
        for (i, pixel) in film.pixels().iter().enumerate().filter(|(_, pixel)| pixel.samples == 0) {
            debug_assert_eq!(pixel.samples, 0);
            let x = i % width * coarse.width as usize / width;
            let y = i / width * coarse.height as usize / height;
            image.rgb[i] = coarse.rgb[y * coarse.width as usize + x];
        }
        image
    }

    fn shot(&self, image: Image, size: (u32, u32), outcome: Option<Outcome>) -> Shot {
        let Statistics { camera_rays, shadow_rays, bounce_rays, .. } = self.statistics;
        Shot {
            image: Arc::new(image),
            size: [size.0, size.1],
            picture: self.picture,
            since: self.since.elapsed(),
            samples: outcome.map(|outcome| outcome.samples),
            error: outcome.and_then(|outcome| outcome.error),
            rays: [camera_rays, shadow_rays, bounce_rays],
            seconds: self.seconds,
            map: None,
            is_done: self.stage == Stage::Done,
        }
    }
}

fn samples(film: &Film) -> f64 {
    film.pixels().iter().map(|pixel| f64::from(pixel.samples)).sum()
}

#[cfg(test)]
mod tests {
    use slo_scene::{Files, load};

    use super::*;

    #[test]
    fn a_draft_that_another_one_follows_is_not_made_finer_at_once() {
        let text = "Camera c { fps 10 Film f { width 48 height 32 prefix a_ output PNG_IMAGE }
            CamSegment all { videoStart 0 videoEnd 2 addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart .4 } }
            light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
            phong_info grey { diffuse { .5 .5 .5 } } material_phong grey { phong_info grey }
            sphere ball { center { 0 0 1 } radius 1 material grey }";
        let loaded = load("scene.txt", text, &Files::in_memory("", []));
        let mut scene = loaded.scene.expect("a scene");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let mut looker = Looker::new(Arc::new(pool), Isa::best());
        for (is_moving, after) in [(false, [false; 2]), (true, [true, false])] {
            looker.begin(&scene, is_moving);
            assert!(!looker.is_followed(), "nothing is seen yet");
            for is_followed in after {
                let shot = looker.advance(&mut scene, 0, &|| false, &|_| {}).expect("a picture");
                assert!(shot.is_some());
                assert_eq!(looker.is_followed(), is_followed);
            }
        }
    }
}
