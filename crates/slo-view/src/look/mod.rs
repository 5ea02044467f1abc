//! The picture that is looked at: coarse at first, then better and better.

mod screen;
mod shot;
mod watch;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use slo_accel::Isa;
use slo_picture::film::{Area, Film, Image, Steps};
use slo_picture::output::Outcome;
use slo_render::frame::{FrameError, FrameScene, Remains};
use slo_render::render::{Exposed, Plan, Statistics, render};
use slo_scene::{Integrator, SceneDescription};

pub(crate) use screen::bytes;
pub(crate) use shot::Shot;
use watch::Watch;

/// How long the first picture after a change may take, as far as that can be told.
const FIRST: Duration = Duration::from_millis(90);
/// The same while one change follows another.
const FOLLOWING: Duration = Duration::from_millis(30);
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

/// Renders the picture piece by piece.
#[derive(Debug)]
pub(crate) struct Looker {
    pool: Arc<ThreadPool>,
    isa: Isa,
    remains: Option<Remains>,
    stage: Stage,
    frame: Option<FrameScene>,
    film: Film,
    /// What is seen where the film has no samples.
    coarse: Option<Image>,
    /// Seconds that a sample took, by the last measurement.
    cost: f64,
    /// When the picture changed.
    since: Instant,
    /// Counts changes of the picture.
    picture: u64,
    statistics: Statistics,
    seconds: f64,
}

impl Looker {
    pub(crate) fn new(pool: Arc<ThreadPool>, isa: Isa) -> Self {
        Self {
            pool,
            isa,
            remains: None,
            stage: Stage::Done,
            frame: None,
            film: Film::default(),
            coarse: None,
            cost: 1e-6,
            since: Instant::now(),
            picture: 0,
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

    /// What frames that have been built leave to others.
    pub(crate) fn remains(&self) -> Option<Remains> {
        self.remains.clone()
    }

    /// Forgets what frames have left: the scene is another one.
    pub(crate) fn forget(&mut self) {
        self.remains = None;
    }

    /// Number of the change that is being rendered.
    pub(crate) fn picture(&self) -> u64 {
        self.picture
    }

    /// Whether the picture has all of its samples.
    pub(crate) fn is_done(&self) -> bool {
        self.stage == Stage::Done
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
        self.frame = None;
        self.since = Instant::now();
        self.picture += 1;
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
        let settings = scene.settings.clone();
        let film = &mut scene.camera.film;
        (film.width, film.height) = (whole.0.div_ceil(by), whole.1.div_ceil(by));
        let (width, height) = (film.width, film.height);
        // What takes long to prepare is for later.
        scene.settings.photons = 0.0;
        if scene.settings.integrator == Integrator::PhotonMap {
            scene.settings.integrator = Integrator::Path;
        }
        let plan = Plan::new(scene).in_steps(Steps::default());
        let built = self.build(scene, number);
        (scene.camera.film.width, scene.camera.film.height) = whole;
        scene.settings = settings;
        let built = built?;
        let film = Film::new(Area::whole(width, height), false).map_err(|_| Fault::TooLarge)?;
        let start = Instant::now();
        // The first picture is finished even if the next change is there: otherwise nothing would be seen
        // while one change follows another.
        let never = || false;
        let is_first = self.coarse.is_none();
        let watch = Watch::new(if is_first { &never } else { stop });
        let exposed = render(&built, &plan, film, &watch);
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
        if self.frame.is_none() {
            self.frame = Some(self.build(scene, number)?);
            self.film = Film::new(area, false).map_err(|_| Fault::TooLarge)?;
        }
        let Some(frame) = &self.frame else { return Ok(None) };
        let before = std::mem::take(&mut self.film);
        let had = samples(&before);
        let start = Instant::now();
        let partly = |film: &Film| show(self.shot(self.over_coarse(film), whole, None));
        let is_first = step == 0 && self.coarse.is_none();
        let never = || false;
        let watch = Watch::new(if is_first { &never } else { stop }).showing(&partly);
        let exposed =
            render(frame, &plan.clone().in_steps(Steps { done: step, tiles: 0 }), before, &watch);
        let took = samples(&exposed.film) - had;
        if step == 0 && exposed.is_complete {
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
        let outcome = Outcome::of(&self.film, area, plan.display(), self.isa);
        Ok(Some(self.shot(self.film.image(), whole, Some(outcome))))
    }

    /// Whether every pixel has as many samples as the scene allows.
    fn has_all(&self, plan: &Plan) -> bool {
        self.film.pixels().iter().all(|pixel| pixel.samples >= plan.most())
    }

    fn build(&mut self, scene: &SceneDescription, number: i64) -> Result<FrameScene, Fault> {
        let aids = slo_render::frame::Aids { before: self.remains.take(), ..Default::default() };
        let built = FrameScene::build_with(scene, number, self.isa, aids).map_err(Fault::Frame)?;
        self.remains = Some(built.remains());
        Ok(built)
    }

    fn measure(&mut self, time: Duration, samples: f64) {
        self.cost = time.as_secs_f64() / samples.max(1.0);
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
            is_done: self.stage == Stage::Done,
        }
    }
}

fn samples(film: &Film) -> f64 {
    film.pixels().iter().map(|pixel| f64::from(pixel.samples)).sum()
}
