//! `--share`: processes that see the same folder divide the frames among themselves, on one
//! machine or on many.

use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

use super::frame::find_out_if_writable;
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

impl Run<'_> {
    /// Renders all frames that no other process renders, and returns when every frame is done.
    ///
    /// # Errors
    /// Another process renders one of the frames from another scene or with other settings.
    pub(super) fn share(&mut self, steps: Vec<Step>, lease: Duration) -> Result<(), Problem> {
        let claims = Claims::new(lease).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't start a thread: {error}"))
        })?;
        let mut steps = steps.into_iter();
        let mut theirs = Vec::new();
        let mut told = Vec::new();
        loop {
            theirs = self.look_again(theirs, &claims)?;
            let rendered = self.first_free(&mut steps, &mut theirs, &claims)?;
            if !rendered && theirs.is_empty() {
                return Ok(());
            }
            if !rendered {
                self.tell_waiting(&theirs, &mut told);
                let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
                wait_for(&frames, claims.pause())?;
            }
        }
    }

    /// Looks again at frames of other processes, and returns the frames that they still hold.
    fn look_again(&mut self, theirs: Vec<Theirs>, claims: &Claims) -> Result<Vec<Theirs>, Problem> {
        let mut left = Vec::new();
        for Theirs { step, .. } in theirs {
            if let Look::Theirs(worker) = self.look(&step, claims)? {
                left.push(Theirs { step, worker });
            }
        }
        Ok(left)
    }

    /// Renders the first frame that is still to do and unclaimed. Returns false if there is none.
    fn first_free(
        &mut self,
        steps: &mut impl Iterator<Item = Step>,
        theirs: &mut Vec<Theirs>,
        claims: &Claims,
    ) -> Result<bool, Problem> {
        for step in steps {
            match self.look(&step, claims)? {
                Look::Settled => {}
                Look::Rendered => return Ok(true),
                Look::Theirs(worker) => theirs.push(Theirs { step, worker }),
            }
        }
        Ok(false)
    }

    /// Renders a frame that is still to do, if it is unclaimed.
    fn look(&mut self, step: &Step, claims: &Claims) -> Result<Look, Problem> {
        if let State::None(_) | State::Foreign(_) = step.state {
            self.settle(step.frame, &step.path, &step.state, false);
            return Ok(Look::Settled);
        }
        // A process that died while releasing a finished frame has left its claim, which is taken
        // over below.
        if !claims.is_taken(&self.claimed(step)) && self.keep_if_there(step) {
            return Ok(Look::Settled);
        }
        let claimed = self.claim_ours(step, claims)?;
        match claimed {
            Err(problem) => {
                self.fail(step.frame, problem, true);
                Ok(Look::Settled)
            }
            Ok(None) => Ok(Look::Settled),
            Ok(Some(Taken::Mine(claim))) => self.go_on(step, claim),
            Ok(Some(Taken::Theirs(worker))) => Ok(Look::Theirs(worker)),
            Ok(Some(Taken::Other { worker, .. })) => Ok(Look::Theirs(Some(worker))),
        }
    }

    /// Claims a frame. If a process that renders another scene holds it, waits until that process
    /// is known to be dead. Returns `None` if the frame is finished.
    ///
    /// # Errors
    /// The process that renders another scene is alive: two versions of a scene can't share a
    /// folder.
    fn claim_ours(
        &mut self,
        step: &Step,
        claims: &Claims,
    ) -> Result<Result<Option<Taken>, Problem>, Problem> {
        let mut other: Option<Worker> = None;
        loop {
            let taken = match self.claim(step, claims) {
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
                self.warn(format_args!(
                    "{worker} has claimed frame {frame} for another scene or other settings; \
                     waiting to see whether it is alive"
                ));
                other = Some(worker);
            }
            wait_for(&[step.frame], claims.pause())?;
        }
    }

    /// Continues a frame that now belongs to this process, from wherever others have left it.
    fn go_on(&mut self, step: &Step, claim: Claim) -> Result<Look, Problem> {
        let frame = step.frame;
        if let Some(dead) = &claim.dead {
            self.note(format_args!("taking over frame {frame}: {dead} has stopped responding"));
            self.studio.clean_up(frame, &step.path);
        }
        if self.keep_if_there(step) {
            if claim.dead.is_some() {
                self.studio.remove_checkpoint(frame);
            }
            return Ok(Look::Settled);
        }
        if self.render(frame, &step.path, &|| claim.is_lost())? {
            return Ok(Look::Rendered);
        }
        self.note(format_args!("another process has taken over frame {frame}"));
        Ok(Look::Theirs(None))
    }

    fn keep_if_there(&mut self, step: &Step) -> bool {
        match step.state {
            State::Finished => self.keep(step.frame, &step.path, false),
            _ => return self.is_there_now(step),
        }
        true
    }

    /// Returns the path that is claimed. With the render time in its name, a picture would have
    /// another path each time.
    fn claimed(&self, step: &Step) -> PathBuf {
        self.studio.target.plain_path(step.frame)
    }

    fn claim(&self, step: &Step, claims: &Claims) -> Result<Taken, Problem> {
        find_out_if_writable(&step.path, self.before.is_none())?;
        let path = self.claimed(step);
        let recipe = self.studio.recipe_hash(step.frame);
        let take = || claims.take(&path, &recipe);
        patience::write(&path, self.studio.terminal, take)
            .map_err(|error| patience::problem(format_args!("claim `{}`", path.display()), &error))
    }

    /// Reports the frames that the run waits for, if they have changed since the last report.
    fn tell_waiting(&self, theirs: &[Theirs], told: &mut Vec<i64>) {
        let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
        if frames == *told {
            return;
        }
        self.progress.waiting(&frames);
        let first =
            theirs.iter().find_map(|theirs| Some((theirs.step.frame, theirs.worker.as_ref()?)));
        let who =
            first.map_or_else(String::new, |(frame, who)| format!("; {who} renders frame {frame}"));
        self.note(format_args!("waiting for other processes to finish {}{who}", named(&frames)));
        *told = frames;
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
