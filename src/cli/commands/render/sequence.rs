//! Frames in their order: while one is rendered, the next one is built, and the picture of the last
//! one is written.

use std::thread::{self, Scope};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::ahead::Ahead;
use super::desk::Desk;
use super::done::Place;
use super::frame::Taken;
use super::plan::{State, Step};
use super::run::{Run, may_begin};
use crate::cli::base::{Exit, Problem};
use crate::cli::system::{interrupt, memory};

/// A sequence in progress.
struct Sequence<'scope, 'env> {
    run: &'env Run<'env>,
    desk: Desk<'scope>,
    scope: &'scope Scope<'scope, 'env>,
    /// The thread that encodes pictures beside rendering; `None`: pictures are written in between.
    writer: Option<&'env ThreadPool>,
}

impl Run<'_> {
    /// Does what each of the frames needs. An error ends the run.
    pub(super) fn sequence(&self, steps: &[Step]) -> Result<(), Problem> {
        let to_render = steps.iter().filter(|step| step.is_to_render()).count();
        let (job, scene) = (self.studio.job, self.studio.scene);
        // A frame that has a time of its own gets all of it for itself.
        let overlaps = to_render > 1 && job.time.is_none();
        let ahead = overlaps.then(|| Ahead::new(scene, job)).flatten();
        let one = || ThreadPoolBuilder::new().num_threads(1).build().ok();
        let writer = ahead.as_ref().and_then(|_| one());
        thread::scope(|scope| {
            let desk = Desk::new(None, ahead);
            let mut sequence = Sequence { run: self, desk, scope, writer: writer.as_ref() };
            let result = steps.iter().enumerate().try_for_each(|(i, step)| {
                let next = steps[i + 1..].iter().find(|step| step.is_to_render());
                sequence.desk.next = next.map(|step| step.frame);
                sequence.step(step)
            });
            let written = sequence.desk.written();
            self.record().beside(sequence.desk);
            written.and(result)
        })
    }
}

impl<'scope, 'env> Sequence<'scope, 'env> {
    fn step(&mut self, step: &Step) -> Result<(), Problem> {
        let run = self.run;
        match &step.state {
            State::ToRender(_) => match run.state_now(step) {
                // Paths and errors are printed in the order of the frames.
                Some((path, state)) => {
                    self.desk.written()?;
                    run.settle(step.frame, &path, &state, true);
                    Ok(())
                }
                None => self.render(step),
            },
            state => {
                self.desk.written()?;
                run.settle(step.frame, &step.path, state, false);
                Ok(())
            }
        }
    }

    fn render(&mut self, Step { frame, path, .. }: &Step) -> Result<(), Problem> {
        may_begin(*frame)?;
        let Run { studio, progress, .. } = self.run;
        let limit = studio.limit();
        match studio.take(*frame, path, limit, progress, &mut self.desk, &|| studio.is_stale()) {
            Ok(taken) => self.develop(taken),
            Err(problem)
                if problem.exit == Exit::Stopped
                    && (interrupt::requested() || studio.is_stale()) =>
            {
                Err(problem)
            }
            Err(problem) => {
                self.desk.written()?;
                self.run.fail(*frame, problem, true);
                Ok(())
            }
        }
    }

    /// Writes the picture of a frame: beside the next frame, if there is one, and memory for two.
    fn develop(&mut self, taken: Taken) -> Result<(), Problem> {
        let earlier = self.desk.written();
        let run = self.run;
        run.progress.over();
        let needs = run.studio.needs(taken.frame, 1).memory();
        let has_room = || memory::left().is_none_or(|left| left.bytes >= needs);
        match self.writer {
            Some(writer) if earlier.is_ok() && self.desk.next.is_some() && has_room() => {
                run.progress.writes_beside();
                let write = move || writer.install(|| run.develop(taken, Place::Beside));
                self.desk.write(self.scope.spawn(write));
                Ok(())
            }
            _ => earlier.and(run.develop(taken, Place::Between)),
        }
    }
}
