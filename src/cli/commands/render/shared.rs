//! `--share`: processes that see the same folder divide the frames among themselves, on one
//! machine or on many.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

use super::frame::find_out_if_writable;
use super::line::Line;
use super::plan::{State, Step};
use super::run::Run;
use crate::cli::base::{Exit, Problem};
use crate::cli::claims::{Claim, Claims, Taken, Worker};
use crate::cli::system::{interrupt, patience};
use crate::cli::values::named;

/// Result of a look at a frame.
enum Look {
    /// The frame is finished or has failed.
    Settled,
    /// This process has rendered it. Meanwhile the others have made progress.
    Rendered,
    /// Another process renders it.
    Theirs(Option<Worker>),
}

/// A frame that another process renders.
struct Theirs {
    step: Step,
    worker: Option<Worker>,
}

/// Frames that several processes render.
struct Share<'a, 'scope, 'env> {
    run: &'a Run<'a>,
    line: &'a mut Line<'scope, 'env>,
    claims: &'a Claims,
    /// Frames at which this process has not looked yet.
    unseen: VecDeque<Step>,
    /// Number of frames that other processes held when they were last looked at.
    held_by_others: usize,
    /// Frames of others that were told to be waited for.
    told: Vec<i64>,
}

impl Run<'_> {
    /// Renders all frames that no other process renders, and returns when every frame is done.
    ///
    /// # Errors
    /// Another process renders one of the frames from another scene or with other settings.
    pub(super) fn share(&self, steps: Vec<Step>, lease: Duration) -> Result<(), Problem> {
        let claims = &Claims::new(lease).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't start a thread: {error}"))
        })?;
        let to_render = steps.iter().filter(|step| step.is_to_render()).count();
        self.in_line(to_render, |line| {
            let (unseen, told) = (steps.into(), Vec::new());
            Share { run: line.run, line, claims, unseen, held_by_others: 0, told }.render()
        })
    }
}

impl Share<'_, '_, '_> {
    fn render(&mut self) -> Result<(), Problem> {
        let mut theirs = Vec::new();
        loop {
            theirs = self.look_again(theirs)?;
            let rendered = self.next_free(&mut theirs)?;
            if !rendered && theirs.is_empty() {
                return Ok(());
            }
            if !rendered {
                self.line.written()?;
                self.tell_waiting(&theirs);
                let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
                wait_for(&frames, self.claims.pause())?;
            }
        }
    }

    /// Looks again at frames of other processes, and returns the frames that they still hold.
    fn look_again(&mut self, theirs: Vec<Theirs>) -> Result<Vec<Theirs>, Problem> {
        let mut left = Vec::new();
        self.held_by_others = theirs.len();
        for Theirs { step, .. } in theirs {
            if let Look::Theirs(worker) = self.look(&step)? {
                left.push(Theirs { step, worker });
            }
        }
        self.held_by_others = left.len();
        Ok(left)
    }

    /// Renders a frame that is still to do and unclaimed: the one that was built ahead, or the first
    /// one. Returns false if there is none.
    fn next_free(&mut self, theirs: &mut Vec<Theirs>) -> Result<bool, Problem> {
        let built = self.line.built();
        let place = self.unseen.iter().position(|step| Some(step.frame) == built);
        let mut next = place.and_then(|place| self.unseen.remove(place));
        while let Some(step) = next.or_else(|| self.unseen.pop_front()) {
            next = None;
            match self.look(&step)? {
                Look::Settled => {}
                Look::Rendered => return Ok(true),
                Look::Theirs(worker) => {
                    self.held_by_others += 1;
                    theirs.push(Theirs { step, worker });
                }
            }
        }
        Ok(false)
    }

    /// Renders a frame that is still to do, if it is unclaimed.
    fn look(&mut self, step: &Step) -> Result<Look, Problem> {
        let run = self.run;
        if let State::None(_) | State::Foreign(_) = step.state {
            run.settle(step.frame, &step.path, &step.state, false);
            return Ok(Look::Settled);
        }
        // A process that died while releasing a finished frame has left its claim, which is taken
        // over below.
        if !self.claims.is_taken(&self.claimed(step)) && self.keep_if_there(step) {
            return Ok(Look::Settled);
        }
        match self.claim_ours(step)? {
            Err(problem) => {
                run.fail(step.frame, problem, true);
                Ok(Look::Settled)
            }
            Ok(None) => Ok(Look::Settled),
            Ok(Some(Taken::Mine(claim))) => self.go_on(step, claim),
            Ok(Some(Taken::Theirs(worker))) => Ok(Look::Theirs(worker)),
            Ok(Some(Taken::Other { worker, .. })) => Ok(Look::Theirs(Some(worker))),
        }
    }

    /// Continues a frame that now belongs to this process, from wherever others have left it.
    fn go_on(&mut self, step: &Step, claim: Claim) -> Result<Look, Problem> {
        let (frame, run) = (step.frame, self.run);
        let dead = claim.dead.is_some();
        if let Some(dead) = &claim.dead {
            run.note(format_args!("taking over frame {frame}: {dead} has stopped responding"));
            run.studio.clean_up(frame, &step.path);
        }
        if self.keep_if_there(step) {
            if dead {
                run.studio.remove_checkpoint(frame);
            }
            return Ok(Look::Settled);
        }
        self.line.expect(self.probably_next());
        if self.line.render(step, Some(claim))? {
            return Ok(Look::Rendered);
        }
        run.note(format_args!("another process has taken over frame {frame}"));
        Ok(Look::Theirs(None))
    }

    /// Returns the frame that is probably free when this one is done: until then, each of the other
    /// processes takes one of those before it.
    fn probably_next(&self) -> Option<i64> {
        let mut open = self.unseen.iter().filter(|step| step.is_to_render());
        open.nth(self.held_by_others).map(|step| step.frame)
    }

    /// Reports the frames that the run waits for, if they have changed since the last report.
    fn tell_waiting(&mut self, theirs: &[Theirs]) {
        let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
        if frames == self.told {
            return;
        }
        self.run.progress.waiting(&frames);
        let first =
            theirs.iter().find_map(|theirs| Some((theirs.step.frame, theirs.worker.as_ref()?)));
        let who =
            first.map_or_else(String::new, |(frame, who)| format!("; {who} renders frame {frame}"));
        self.run
            .note(format_args!("waiting for other processes to finish {}{who}", named(&frames)));
        self.told = frames;
    }

    /// Claims a frame. If a process that renders another scene holds it, waits until that process
    /// is known to be dead. Returns `None` if the frame is finished.
    ///
    /// # Errors
    /// The process that renders another scene is alive: two versions of a scene can't share a
    /// folder.
    fn claim_ours(&self, step: &Step) -> Result<Result<Option<Taken>, Problem>, Problem> {
        let mut other: Option<Worker> = None;
        loop {
            let taken = match self.claim(step) {
                Ok(taken) => taken,
                Err(problem) if problem.exit == Exit::Stopped => return Err(problem),
                Err(problem) => return Ok(Err(problem)),
            };
            let (worker, is_alive) = match (taken, &other) {
                (Taken::Other { worker, is_alive }, _) => (worker, is_alive),
                (Taken::Mine(claim), Some(worker)) if claim.dead.is_none() => {
                    // The other process has released the frame. Unless one of ours made the
                    // picture meanwhile, that process continues with other frames.
                    match self.keep_if_there(step) {
                        true => return Ok(Ok(None)),
                        false => (worker.clone(), true),
                    }
                }
                (taken, _) => return Ok(Ok(Some(taken))),
            };
            if is_alive {
                return Err(two_versions(step.frame, &worker));
            }
            if other.is_none() {
                let frame = step.frame;
                self.run.warn(format_args!(
                    "{worker} has claimed frame {frame} for another scene or other settings; \
                     waiting to see whether it is alive"
                ));
                other = Some(worker);
            }
            wait_for(&[step.frame], self.claims.pause())?;
        }
    }

    fn keep_if_there(&self, step: &Step) -> bool {
        match step.state {
            State::Finished => self.run.keep(step.frame, &step.path, false),
            _ => return self.run.is_there_now(step),
        }
        true
    }

    /// Returns the path that is claimed. With the render time in its name, a picture would have
    /// another path each time.
    fn claimed(&self, step: &Step) -> PathBuf {
        self.run.studio.target.plain_path(step.frame)
    }

    fn claim(&self, step: &Step) -> Result<Taken, Problem> {
        find_out_if_writable(&step.path, self.line.is_first())?;
        let path = self.claimed(step);
        let recipe = self.run.studio.recipe_hash(step.frame);
        let take = || self.claims.take(&path, &recipe);
        patience::write(&path, self.run.studio.terminal, take)
            .map_err(|error| patience::problem(format_args!("claim `{}`", path.display()), &error))
    }
}

fn wait_for(frames: &[i64], pause: Duration) -> Result<(), Problem> {
    if interrupt::requested() {
        let message = format!("interrupted; other processes still render {}", named(frames));
        return Err(Problem::new(Exit::Stopped, message));
    }
    sleep(pause);
    Ok(())
}

fn two_versions(frame: i64, worker: &Worker) -> Problem {
    let message = format!(
        "{worker} renders frame {frame} from another scene or with other settings; \
         two versions can't share a folder"
    );
    Problem::new(Exit::Failed, message).with_help(
        "give this run pictures of its own with `--outdir` or `--prefix`, or stop the other one first",
    )
}
