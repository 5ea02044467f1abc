//! The thread that owns the scene: it does what the page asks for, and renders in between.

mod explain;
mod handles;
mod link;
mod loading;
mod offers;
mod other;
mod path;
mod requests;
mod stage;
mod state;
mod vertices;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use slo_accel::Isa;
use slo_scene::animation::{Clock, NoSegment};

use handles::Dragging;
pub(crate) use link::{Link, Message, Shown};
use loading::Loading;
use other::Other;
use stage::Stage;
use vertices::{Sculpting, Vertices};

use crate::changes;
use crate::look::Looker;
use crate::pick::Seen;
use crate::placing::Placed;
use crate::source::Source;

/// Time between two looks at the files of the scene.
const GLANCE: Duration = Duration::from_millis(250);
/// A change that follows another one so soon is part of a movement.
const MOVEMENT: Duration = Duration::from_millis(400);
/// How long to wait for the next change of a movement before the picture is made finer. Meanwhile the browser has the
/// processors, and shows the last picture.
const BETWEEN: Duration = Duration::from_millis(25);

/// What a movement of the camera is called among the changes of the text.
const CAMERA: &str = "the camera";

/// All that the thread owns.
pub(crate) struct Studio {
    link: Arc<Link>,
    inbox: Receiver<Message>,
    loading: Loading,
    /// The scene as it is shown; `None` before there is one.
    stage: Option<Stage>,
    looker: Looker,
    picked: Option<Seen>,
    /// Where the selected thing is, if it can be moved.
    placed: Option<Placed>,
    dragging: Option<Dragging>,
    /// Vertices of the selected mesh, if they are shown.
    vertices: Option<Vertices>,
    sculpting: Option<Sculpting>,
    /// Number of the drag of a control point of the camera.
    path_drag: Option<u64>,
    /// Another scene, of which things are taken over.
    other: Option<Other>,
    /// Boxes around all objects, if the scene is shown from above.
    plan: Option<serde_json::Value>,
    /// What a pixel of this picture is made of, as JSON.
    why: Option<serde_json::Value>,
    /// Why nothing can be shown, though the text has no errors.
    fault: Option<String>,
    /// Stops by which the picture is brightened, beside those of the scene.
    exposure: f32,
    /// Why the camera can't be written into the text.
    unwritten: Option<String>,
    /// The frame that is shown as soon as there is a scene.
    frame: i64,
    last_change: Instant,
    last_glance: Instant,
}

/// What follows from a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Effects {
    /// The picture is another one.
    picture: bool,
    /// The same light is shown in another way.
    exposure: bool,
    /// Something else is laid over it.
    overlay: bool,
}

impl Studio {
    /// Loads the scene and shows frame `frame`, or the scene's first if it has no such frame.
    pub(crate) fn new(
        source: Box<dyn Source>,
        frame: Option<i64>,
        pool: Arc<ThreadPool>,
        isa: Isa,
        link: Arc<Link>,
        inbox: Receiver<Message>,
    ) -> Self {
        let now = Instant::now();
        let frame = frame.unwrap_or(0);
        let mut studio = Self {
            link,
            inbox,
            loading: Loading::new(source),
            stage: None,
            looker: Looker::new(pool, isa),
            picked: None,
            placed: None,
            dragging: None,
            vertices: None,
            sculpting: None,
            path_drag: None,
            other: None,
            plan: None,
            why: None,
            fault: None,
            exposure: 0.0,
            unwritten: None,
            frame,
            last_change: now.checked_sub(MOVEMENT).unwrap_or(now),
            last_glance: now,
        };
        studio.load(frame);
        studio
    }

    /// Why the scene does not have a frame; `None` if it has it, or has errors.
    pub(crate) fn lacks(&self, frame: i64) -> Option<NoSegment> {
        let scene = self.stage.as_ref()?.scene();
        Clock::new(&scene.camera).shutter(frame).err()
    }

    /// Works until nobody can ask for anything any more.
    pub(crate) fn run(mut self) {
        self.begin();
        loop {
            match self.inbox.recv_timeout(self.pause()) {
                Ok(message) => self.answer(message),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if self.last_glance.elapsed() >= GLANCE {
                self.last_glance = Instant::now();
                self.glance();
            }
            self.advance();
        }
    }

    /// How long to wait for requests before something else is done.
    fn pause(&self) -> Duration {
        if self.looker.is_done() || self.stage.is_none() {
            GLANCE
        } else if self.looker.is_followed() {
            BETWEEN
        } else {
            Duration::ZERO
        }
    }

    /// Does what is asked for, with all that is waiting, and answers with the number of the picture that
    /// shows it.
    fn answer(&mut self, first: Message) {
        let mut effects = Effects::default();
        let mut replies = Vec::new();
        let mut next = Some(first);
        while let Some(Message { command, reply }) = next {
            self.link.took();
            let refusal = match self.perform(command) {
                Ok(Effects { picture, exposure, overlay }) => {
                    effects.picture |= picture;
                    effects.exposure |= exposure;
                    effects.overlay |= overlay;
                    None
                }
                Err(why) => Some(why),
            };
            replies.push((reply, refusal));
            next = self.inbox.try_recv().ok();
        }
        if effects.picture {
            self.begin();
        } else if effects.exposure || effects.overlay {
            self.link.tone(self.look());
            let again = self.stage.as_ref().filter(|_| effects.overlay);
            if let Some(shot) = again.and_then(|stage| self.looker.again(stage.shown())) {
                self.link.show(shot, self.look());
            }
        }
        self.tell();
        for (reply, refusal) in replies {
            // Whoever asked may be gone.
            let _ = reply.send(refusal.map_or(Ok(self.looker.picture()), Err));
        }
    }

    /// Loads the scene again if a file of it has changed, and writes a camera that has come to rest into
    /// the text.
    fn glance(&mut self) {
        if self.loading.glance() && self.load(self.frame) {
            self.begin();
        }
        if self.last_change.elapsed() >= MOVEMENT {
            self.settle();
        }
        self.tell();
    }

    /// Makes the scene of the text. If it has errors, the last good one stays, and the result is false.
    fn load(&mut self, frame: i64) -> bool {
        // The text of the camera is about to be read again.
        self.settle();
        let pool = self.looker.pool().clone();
        let Some(scene) = pool.install(|| self.loading.load()) else { return false };
        self.looker.change_content();
        self.stage = Some(match self.stage.take() {
            Some(before) => before.with_scene(scene, frame),
            None => {
                let stage = Stage::new(scene, frame);
                self.frame = stage.frame();
                stage
            }
        });
        self.place();
        self.plan = self.plan.is_some().then(|| self.boxes());
        true
    }

    /// Writes a moved camera into the text.
    fn settle(&mut self) {
        let Some(stage) = &mut self.stage else { return };
        let Some((before, after)) = stage.moved_segment() else { return };
        let edits = changes::camera(self.loading.document().text(), before, after);
        match edits.and_then(|edits| self.loading.change(edits, CAMERA, true)) {
            Ok(()) => stage.keep_camera(),
            Err(why) => self.unwritten = Some(why),
        }
    }

    /// Begins the picture again.
    fn begin(&mut self) {
        let is_moving = self.last_change.elapsed() < MOVEMENT;
        self.last_change = Instant::now();
        (self.fault, self.unwritten, self.why) = (None, None, None);
        if let Some(stage) = &self.stage {
            self.looker.begin(stage.shown(), is_moving);
        }
        self.tell();
    }

    /// Renders the next piece of the picture.
    fn advance(&mut self) {
        let look = self.look();
        let (Some(stage), link) = (&mut self.stage, &self.link) else { return };
        let frame = stage.frame();
        let stop = || link.is_waited_for();
        let show = |shot| link.show(shot, look);
        match self.looker.advance(stage.shown_mut(), frame, &stop, &show) {
            Ok(Some(shot)) => self.link.show(shot, look),
            Ok(None) => {}
            Err(fault) => {
                self.looker.end();
                self.fault = Some(fault.to_string());
                self.tell();
            }
        }
    }

    /// How the picture is shown.
    fn look(&self) -> slo_scene::Look {
        let look = self.stage.as_ref().map_or_else(Default::default, |stage| {
            let scene = stage.shown();
            scene.camera.film.look(&scene.settings)
        });
        slo_scene::Look { exposure: look.exposure + self.exposure, ..look }
    }

    /// Tells the page what there is to know.
    fn tell(&self) {
        self.link.tell(state::of(&state::Known {
            loading: &self.loading,
            stage: self.stage.as_ref(),
            picked: self.picked.as_ref(),
            placed: self.placed.as_ref(),
            mesh: self.vertex_count(),
            vertices: self.vertices_to_json(),
            why: self.why.as_ref(),
            plan: self.plan.as_ref(),
            other: self.other.as_ref(),
            looker: &self.looker,
            missing: self.stage.as_ref().and_then(|stage| stage.lacks(self.frame)),
            fault: self.fault.as_deref(),
            unwritten: self.unwritten.as_deref(),
            exposure: self.exposure,
        }));
    }
}
