//! What lies ready beside the frame that is rendered: the frame before it, whose picture may still
//! be on its way to the disk, and the next one, which may be under construction.

use std::panic::resume_unwind;
use std::thread::ScopedJoinHandle;
use std::time::{Duration, Instant};

use super::ahead::Ahead;
use crate::cli::base::Problem;
use crate::cli::files::load;
use crate::cli::options::Job;
use crate::cli::system::interrupt;
use slo_render::frame::{Aids, FrameScene};
use slo_scene::SceneDescription;

/// A thread that writes a picture. An error ends the run.
type Writing<'a> = ScopedJoinHandle<'a, Result<(), Problem>>;

/// What lies ready beside the frame that is rendered.
pub(super) struct Desk<'a> {
    /// What was built for the last frame.
    pub(super) before: Option<FrameScene>,
    /// Builds the next frame, if there is time for it.
    ahead: Option<Ahead>,
    /// The frame that probably comes next.
    pub(super) next: Option<i64>,
    writing: Option<Writing<'a>>,
    /// Time spent waiting for writing.
    pub(super) waited: Duration,
}

impl<'a> Desk<'a> {
    pub(super) fn new(before: Option<FrameScene>, ahead: Option<Ahead>) -> Self {
        Self { before, ahead, next: None, writing: None, waited: Duration::ZERO }
    }

    /// Returns a frame, which was built ahead, or is built now.
    ///
    /// While a picture is being written, nothing may end the program, so the frame is waited for
    /// after that.
    pub(super) fn frame(
        &mut self,
        job: &Job,
        scene: &SceneDescription,
        number: i64,
    ) -> Result<FrameScene, Problem> {
        if let Some(ahead) = &mut self.ahead {
            let ready = match ahead.ready() {
                None => {
                    self.written()?;
                    let ahead = self.ahead.as_mut();
                    ahead.and_then(|ahead| interrupt::while_building(|| ahead.wait()))
                }
                ready => ready,
            };
            match ready {
                Some((built, frame)) if built == number => {
                    self.before = None;
                    return frame;
                }
                // Another frame came first. What was built for this one may still fit.
                Some((_, Ok(frame))) => self.before = Some(frame),
                _ => {}
            }
        }
        self.written()?;
        let before = self.before.take().map(|frame| frame.remains());
        let (cache, parameters) = (job.cache.clone(), job.parameters());
        let aids = Aids { before, cache, parameters, ..Aids::default() };
        interrupt::while_building(|| load::frame(job.isa, scene, number, aids))
    }

    /// Returns the frame that is under construction, or ready.
    pub(super) fn built(&self) -> Option<i64> {
        self.ahead.as_ref().and_then(Ahead::frame)
    }

    /// Begins to build the next frame. Its structures are those of `built` if they fit.
    pub(super) fn begin_next(&mut self, built: &FrameScene) {
        if let (Some(ahead), Some(next)) = (&mut self.ahead, self.next) {
            ahead.begin(next, built);
        }
    }

    pub(super) fn is_writing(&self) -> bool {
        self.writing.is_some()
    }

    /// Leaves the picture of the last frame to a thread.
    pub(super) fn write(&mut self, writing: Writing<'a>) {
        self.writing = Some(writing);
    }

    /// Waits until the picture of the last frame is in place.
    ///
    /// # Errors
    /// The user interrupted the waiting.
    pub(super) fn written(&mut self) -> Result<(), Problem> {
        let Some(writing) = self.writing.take() else { return Ok(()) };
        let start = Instant::now();
        let result = writing.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.waited += start.elapsed();
        result
    }

    /// Returns what was built beside rendering, in time and in words.
    pub(super) fn ahead(self) -> Option<Ahead> {
        self.ahead
    }
}
