//! `--share`: processes that see the same folder share the frames out, on one machine or on many.

use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

use super::super::problem::Problem;
use super::super::render::find_out_if_writable;
use super::super::{Exit, interrupt, patience};
use super::Run;
use super::claims::{Claim, Claims, Taken, Worker};
use super::frames::shown;
use super::plan::{State, Step};

/// What came of one look at a frame.
enum Look {
    /// It is there, or can't be had.
    Settled,
    /// This process has rendered it: meanwhile others have got on.
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
    /// Does all steps that no other process does, and returns when all are done by whomever.
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
                wait(&theirs, claims.pause())?;
            }
        }
    }

    /// Looks at frames that others had; those that they still have.
    fn look_again(&mut self, theirs: Vec<Theirs>, claims: &Claims) -> Result<Vec<Theirs>, Problem> {
        let mut left = Vec::new();
        for Theirs { step, .. } in theirs {
            if let Look::Theirs(worker) = self.look(&step, claims)? {
                left.push(Theirs { step, worker });
            }
        }
        Ok(left)
    }

    /// Goes on to the first frame that is to be rendered and nobody's; false where there is none.
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

    /// Renders a frame that is to be rendered, where it is nobody's.
    fn look(&mut self, step: &Step, claims: &Claims) -> Result<Look, Problem> {
        if let State::None(_) = step.state {
            return self.step(step).map(|()| Look::Settled);
        }
        // One that died as it let go of a finished frame has left its claim.
        if !claims.is_taken(&self.claimed(step)) && self.keep_if_there(step) {
            return Ok(Look::Settled);
        }
        match self.claim(step, claims) {
            Err(problem) => {
                self.fail(step.frame, problem, true);
                Ok(Look::Settled)
            }
            Ok(Taken::Theirs(worker)) => Ok(Look::Theirs(worker)),
            Ok(Taken::Mine(claim)) => self.go_on(step, claim),
        }
    }

    /// Goes on with a frame that is this process's now, from wherever others have left it.
    fn go_on(&mut self, step: &Step, claim: Claim) -> Result<Look, Problem> {
        let frame = step.frame;
        if let Some(dead) = &claim.dead {
            self.note(format_args!("frame {frame} is taken over: no sign of life of {dead}"));
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
        self.note(format_args!("frame {frame} was taken over by another process meanwhile"));
        Ok(Look::Theirs(None))
    }

    fn keep_if_there(&mut self, step: &Step) -> bool {
        match step.state {
            State::Finished => self.keep(step.frame, &step.path, false),
            _ => return self.is_there_now(step),
        }
        true
    }

    /// What is claimed: with the time in its name a picture has another one each time.
    fn claimed(&self, step: &Step) -> PathBuf {
        self.studio.target.plain_path(step.frame)
    }

    fn claim(&self, step: &Step, claims: &Claims) -> Result<Taken, Problem> {
        find_out_if_writable(&step.path, self.before.is_none())?;
        let path = self.claimed(step);
        patience::write(&path, self.studio.terminal, || claims.take(&path))
            .map_err(|error| patience::problem(format_args!("claim `{}`", path.display()), &error))
    }

    /// Says for what frames the run waits, where these are others than last time.
    fn tell_waiting(&self, theirs: &[Theirs], told: &mut Vec<i64>) {
        let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
        if frames == *told {
            return;
        }
        self.progress.waiting(&frames);
        let first =
            theirs.iter().find_map(|theirs| Some((theirs.step.frame, theirs.worker.as_ref()?)));
        let who = first.map_or_else(String::new, |(frame, who)| format!("; {who} renders {frame}"));
        self.note(format_args!("waiting for others to finish {}{who}", shown(&frames)));
        *told = frames;
    }
}

fn wait(theirs: &[Theirs], pause: Duration) -> Result<(), Problem> {
    if interrupt::requested() {
        let frames: Vec<i64> = theirs.iter().map(|theirs| theirs.step.frame).collect();
        let message = format!("interrupted; others still render {}", shown(&frames));
        return Err(Problem::new(Exit::Stopped, message));
    }
    sleep(pause);
    Ok(())
}
