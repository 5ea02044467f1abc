//! The frame as `slo-rt` renders it: the bytes of its file.

use std::io;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use slo_accel::Isa;
use slo_picture::film::{Area, FileLayer, Film, View};
use slo_picture::output::{Outcome, Picture, Recipe, file_name, with_outcome};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, render};
use slo_scene::SceneDescription;

/// A finished frame.
#[derive(Clone, Debug)]
pub(crate) struct Finished {
    /// Name of the file.
    pub(crate) name: String,
    /// Content of the file.
    pub(crate) bytes: Arc<Vec<u8>>,
}

/// How far a frame is, and what became of it.
#[derive(Clone, Debug, Default)]
pub(crate) enum Progress {
    /// None was asked for, or it was cancelled.
    #[default]
    None,
    /// Share of the frame that is done, from 0 to 1.
    Rendering(f64),
    Finished(Finished),
    Failed(String),
}

/// A frame that is being rendered, or was.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finishing {
    progress: Arc<Mutex<Progress>>,
    cancel: Arc<AtomicBool>,
}

impl Finishing {
    /// Starts to render a frame, on a thread of its own. `changed` is called whenever there is news.
    pub(crate) fn start(
        scene: SceneDescription,
        number: i64,
        pool: Arc<ThreadPool>,
        isa: Isa,
        changed: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let this = Self::default();
        this.set(Progress::Rendering(0.0));
        let finishing = this.clone();
        let work = move || {
            let result = pool.install(|| finishing.render(&scene, number, isa, &changed));
            finishing.set(match result {
                Ok(Some(finished)) => Progress::Finished(finished),
                Ok(None) => Progress::None,
                Err(why) => Progress::Failed(why),
            });
            changed();
        };
        if let Err(error) = std::thread::Builder::new().name("finish".into()).spawn(work) {
            this.set(Progress::Failed(format!("can't start a thread: {error}")));
        }
        this
    }

    /// Stops rendering.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// How far the frame is.
    pub(crate) fn progress(&self) -> Progress {
        self.progress.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).clone()
    }

    fn set(&self, progress: Progress) {
        *self.progress.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = progress;
    }

    /// Renders a frame to the bytes of a file; `None` if it was cancelled.
    fn render(
        &self,
        scene: &SceneDescription,
        number: i64,
        isa: Isa,
        changed: &(dyn Fn() + Sync),
    ) -> Result<Option<Finished>, String> {
        let frame = FrameScene::build(scene, number, isa).map_err(|error| error.to_string())?;
        let plan = Plan::new(scene);
        let settings = &scene.camera.film;
        let whole = Area::whole(settings.width, settings.height);
        let names = scene.layer_names();
        let film = Film::new(whole, plan.needs_spreads())
            .and_then(|film| film.with_layers(&settings.layers, &names))
            .map_err(|_| "there is no memory for a picture of this size".to_owned())?;
        let watch = Watch { finishing: self, changed, done: Mutex::new((0.0, 0)) };
        let exposed = render(&frame, &plan, film, &watch);
        if !exposed.is_complete {
            return Ok(None);
        }
        let bytes = file(scene, number, &exposed.film, &plan, isa);
        let bytes = bytes.map_err(|error| format!("can't make the file: {error}"))?;
        let name = file_name(settings, number, None);
        Ok(Some(Finished { name, bytes: Arc::new(bytes) }))
    }
}

/// Returns the bytes of the file of a picture.
fn file(
    scene: &SceneDescription,
    number: i64,
    film: &Film,
    plan: &Plan,
    isa: Isa,
) -> io::Result<Vec<u8>> {
    let settings = &scene.camera.film;
    let area = film.area();
    let outcome = Outcome::of(film, area, plan.display(), isa);
    let recipe = with_outcome(&Recipe { scene, frame: number }.to_json(), &outcome);
    let image = View::new(film, area);
    let (format, look) = (settings.output, settings.look(&scene.settings));
    let picture = Picture { image: &image, format, look, recipe: &recipe, crop: None };
    let layers = FileLayer::all(&settings.layers, &scene.layer_names());
    let layers: Vec<_> = layers.iter().map(|layer| (layer.clone(), image.layer(layer))).collect();
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("picture");
    picture.save_with(&path, &layers)?;
    std::fs::read(&path)
}

/// Passes progress on, a hundredth at a time.
struct Watch<'a> {
    finishing: &'a Finishing,
    changed: &'a (dyn Fn() + Sync),
    /// Share that is done, and the hundredths that were passed on.
    done: Mutex<(f64, u32)>,
}

impl Observer for Watch<'_> {
    fn advanced(&self, share: f64) {
        let mut done = self.done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        done.0 = (done.0 + share).min(1.0);
        let hundredths = (done.0 * 100.0) as u32;
        if hundredths > done.1 {
            done.1 = hundredths;
            self.finishing.set(Progress::Rendering(done.0));
            (self.changed)();
        }
    }

    fn should_stop(&self) -> bool {
        self.finishing.cancel.load(Ordering::Relaxed)
    }

    fn gives_up(&self) -> bool {
        self.should_stop()
    }
}
