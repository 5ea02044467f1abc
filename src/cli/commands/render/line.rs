//! Frames in a line: while one is rendered, the next one is built, and the picture of the last one
//! is written.

use std::thread::{self, Scope};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::ahead::Ahead;
use super::desk::Desk;
use super::done::Place;
use super::frame::Taken;
use super::plan::Step;
use super::run::{Run, may_begin};
use crate::cli::base::{Exit, Problem};
use crate::cli::claims::Claim;
use crate::cli::system::{interrupt, memory};

/// Frames that are rendered one after the other.
pub(super) struct Line<'scope, 'env> {
    pub(super) run: &'env Run<'env>,
    desk: Desk<'scope>,
    scope: &'scope Scope<'scope, 'env>,
    /// The thread that encodes pictures beside rendering; `None`: pictures are written in between.
    writer: Option<&'env ThreadPool>,
}

impl Run<'_> {
    /// Runs `work`, which renders `to_render` frames at most, and waits until all pictures are in
    /// place.
    pub(super) fn in_line(
        &self,
        to_render: usize,
        work: impl FnOnce(&mut Line<'_, '_>) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        let (job, scene) = (self.studio.job, self.studio.scene);
        // A frame that has a time of its own gets all of it for itself.
        let overlaps = to_render > 1 && job.time.is_none();
        let ahead = overlaps.then(|| Ahead::new(scene, job)).flatten();
        let one = || ThreadPoolBuilder::new().num_threads(1).build().ok();
        let writer = ahead.as_ref().and_then(|_| one());
        thread::scope(|scope| {
            let desk = Desk::new(None, ahead);
            let mut line = Line { run: self, desk, scope, writer: writer.as_ref() };
            let result = work(&mut line);
            let written = line.desk.written();
            self.record().beside(line.desk);
            written.and(result)
        })
    }
}

impl Line<'_, '_> {
    /// Says which frame probably comes after the one that is rendered next.
    pub(super) fn expect(&mut self, frame: Option<i64>) {
        self.desk.next = frame;
    }

    /// Returns the frame that is being built, or is built already.
    pub(super) fn built(&self) -> Option<i64> {
        self.desk.built()
    }

    /// Whether no frame has been built yet.
    pub(super) fn is_first(&self) -> bool {
        self.desk.before.is_none()
    }

    /// Waits until the picture of the last frame is in place.
    ///
    /// # Errors
    /// The user interrupted the waiting.
    pub(super) fn written(&mut self) -> Result<(), Problem> {
        self.desk.written()
    }

    /// Renders a frame as long as it belongs to this process. Returns false if it no longer does.
    /// `claim` is held until its picture is in place.
    ///
    /// # Errors
    /// The user interrupted it, or the files of the scene have changed.
    pub(super) fn render(&mut self, step: &Step, claim: Option<Claim>) -> Result<bool, Problem> {
        let Step { frame, path, .. } = step;
        may_begin(*frame)?;
        let Run { studio, progress, .. } = self.run;
        let limit = studio.limit();
        let is_lost = || studio.is_stale() || claim.as_ref().is_some_and(Claim::is_lost);
        match studio.take(*frame, path, limit, progress, &mut self.desk, &is_lost) {
            Ok(taken) => self.develop(taken, claim)?,
            Err(problem) if problem.exit == Exit::Stopped => {
                let ends = interrupt::requested() || studio.is_stale();
                return if ends { Err(problem) } else { Ok(false) };
            }
            Err(problem) => {
                self.desk.written()?;
                self.run.fail(*frame, problem, true);
            }
        }
        Ok(true)
    }

    /// Writes the picture of a frame: beside the next frame, if there is one, and memory for two.
    fn develop(&mut self, taken: Taken, claim: Option<Claim>) -> Result<(), Problem> {
        let earlier = self.desk.written();
        let run = self.run;
        run.progress.over();
        let needs = run.studio.needs(taken.frame, 1).memory();
        let has_room = || memory::left().is_none_or(|left| left.bytes >= needs);
        match self.writer {
            Some(writer) if earlier.is_ok() && self.desk.next.is_some() && has_room() => {
                run.progress.writes_beside();
                let write = move || {
                    let written = writer.install(|| run.develop(taken, Place::Beside));
                    drop(claim);
                    written
                };
                self.desk.write(self.scope.spawn(write));
                Ok(())
            }
            _ => earlier.and(run.develop(taken, Place::Between)),
        }
    }
}
