//! `--total-time`: all frames improve, round by round, until the time is up.

use std::time::{Duration, Instant};

use super::done::{Done, Place};
use super::frame::Limit;
use super::ledger::Ledger;
use super::plan::{Step, is_open};
use super::run::{Run, may_begin};
use super::schedule::{Known, Round, Schedule, Visit};
use crate::cli::base::{Exit, Problem, human};
use slo_picture::output::Found;

/// A frame, and its result so far in this run.
struct Take {
    step: Step,
    done: Option<Done>,
}

/// Frames in progress.
struct Rounds {
    takes: Vec<Take>,
    schedule: Schedule,
    ledger: Ledger,
    begin: Instant,
    /// Time that earlier runs have used, in seconds.
    earlier: f64,
}

impl Rounds {
    /// Returns how much of the span has passed, in seconds.
    fn passed(&self) -> f64 {
        self.earlier + self.begin.elapsed().as_secs_f64()
    }

    /// Explains why more than the span has passed, if the reason is known.
    fn late(&self, span: f64) -> Option<String> {
        let is_least = |take: &Take| {
            take.done.as_ref()?.steps.map(|s| s == slo_picture::film::Steps::default())
        };
        let has_least = self.takes.iter().any(|take| is_least(take).unwrap_or(false));
        let seconds = self.passed();
        let [passed, asked] = [seconds, span].map(|s| human(Duration::from_secs_f64(s)));
        let earlier = if self.earlier > 0.0 { ", with earlier runs" } else { "" };
        (has_least && seconds > span && passed != asked).then(|| {
            format!(
                "these frames took {passed} instead of {asked}{earlier}: \
                 every frame takes at least one sample per pixel"
            )
        })
    }

    /// Writes what is known, for a run that continues from here.
    fn note(&self) {
        let known = self.schedule.known();
        self.ledger.write(known.map(|(i, known)| (self.takes[i].step.frame, known)));
    }
}

impl Run<'_> {
    /// Renders all frames within `span`, counted from `begin`. Finished frames count as having
    /// used their share.
    pub(super) fn rounds(
        &mut self,
        steps: Vec<Step>,
        span: Duration,
        begin: Instant,
    ) -> Result<(), Problem> {
        let takes = self.takes(steps);
        if takes.is_empty() {
            return Ok(());
        }
        let share = takes.len() as f64 / (takes.len() + self.record().found) as f64;
        let ledger = Ledger::new(self.studio.job, self.studio.scene);
        let mut known = ledger.read();
        let known: Vec<Option<Known>> = takes
            .iter()
            .map(|take| known.remove(&take.step.frame).filter(|_| self.has_picture(&take.step)))
            .collect();
        let span = span.as_secs_f64() * share;
        let schedule = Schedule::new(span, known);
        let earlier = schedule.spent();
        let mut rounds = Rounds { takes, schedule, ledger, begin, earlier };
        let left = (span - rounds.passed()).max(0.0);
        self.progress.by_clock(Duration::from_secs_f64(left));
        while let Some(round) = rounds.schedule.round(rounds.passed()) {
            if !self.round(&mut rounds, &round)? {
                break;
            }
        }
        self.late = rounds.late(span);
        self.close(rounds);
        Ok(())
    }

    /// Settles the frames that are not to be rendered, and returns the others.
    fn takes(&self, steps: Vec<Step>) -> Vec<Take> {
        let (todo, settled): (Vec<_>, Vec<_>) = steps.into_iter().partition(Step::is_to_render);
        for Step { frame, path, state } in &settled {
            self.settle(*frame, path, state, false);
        }
        todo.into_iter().map(|step| Take { step, done: None }).collect()
    }

    /// Whether an earlier run left a picture of the frame that is to improve further.
    fn has_picture(&self, step: &Step) -> bool {
        let found = self.studio.target.look(step.frame, &step.path);
        found == Found::Finished && is_open(self.studio.job, &self.studio.target, step.frame)
    }

    /// Takes frames further. Returns false if none got any further.
    fn round(&mut self, rounds: &mut Rounds, round: &Round) -> Result<bool, Problem> {
        let Round { goal, frames } = round;
        let count = frames.len();
        let passed = rounds.passed();
        self.progress.suspended(|| {
            let said =
                format_args!("step {goal} for {count} of the frames; {passed:.0} s have passed");
            self.studio.terminal.detail(said);
        });
        let mut is_further = false;
        for (at, &i) in frames.iter().enumerate() {
            let (step, seconds) = rounds.schedule.limit(round, at, rounds.passed());
            self.progress.go_to(i);
            let limit = Limit { time: Duration::from_secs_f64(seconds), step };
            is_further |= self.visit(rounds, i, limit)?;
            let start = Instant::now();
            rounds.note();
            rounds.schedule.took_more(i, start.elapsed().as_secs_f64());
        }
        Ok(is_further)
    }

    /// Takes a frame further, or leaves it out for good if it fails. Returns false if the frame
    /// got no further.
    fn visit(&mut self, rounds: &mut Rounds, i: usize, limit: Limit) -> Result<bool, Problem> {
        let start = Instant::now();
        let take = &mut rounds.takes[i];
        let Step { frame, path, .. } = &take.step;
        may_begin(*frame)?;
        let (studio, before) = (&self.studio, &mut self.before);
        match studio.render(*frame, path, Some(limit), &self.progress, before, &|| false) {
            Ok(done) => {
                let visit = self.measured(&done, start.elapsed());
                take.done = Some(match take.done.take() {
                    Some(earlier) => done.after(&earlier),
                    None => done,
                });
                Ok(rounds.schedule.visited(i, &visit))
            }
            Err(problem) if problem.exit == Exit::Stopped => {
                rounds.schedule.broken_off(i, start.elapsed().as_secs_f64());
                rounds.note();
                Err(problem)
            }
            Err(problem) => {
                self.fail(*frame, problem, true);
                rounds.schedule.failed(i);
                Ok(true)
            }
        }
    }

    fn measured(&self, done: &Done, all: Duration) -> Visit {
        let film = &self.studio.scene.camera.film;
        let (width, height) = (film.width, film.height);
        let steps = done.steps.unwrap_or_default();
        let before = done.times.building.as_secs_f64();
        let sampling = (done.times.photons + done.times.rendering).as_secs_f64();
        Visit {
            done: steps.done,
            further: steps.further(width, height),
            samples: done.outcome.samples,
            taken: done.statistics.camera_rays as f64 / (f64::from(width) * f64::from(height)),
            sampling,
            before,
            after: (all.as_secs_f64() - before - sampling).max(0.0),
        }
    }

    /// Closes the frames when the time is up: their pictures are final for this run.
    fn close(&mut self, rounds: Rounds) {
        let failed: Vec<i64> = self.record().failures.iter().map(|failure| failure.0).collect();
        let mut takes = rounds.takes;
        let all = takes.len();
        takes.retain(|take| !failed.contains(&take.step.frame));
        self.progress.go_to(all - takes.len());
        for Take { step, done } in takes {
            match (self.studio.close(step.frame), done) {
                (Err(problem), _) => {
                    self.print(&step.path);
                    self.fail(step.frame, problem, true);
                }
                (Ok(()), Some(done)) => {
                    self.progress.over();
                    self.finish(step.frame, done, Place::Between);
                }
                // Its picture comes from earlier runs alone.
                (Ok(()), None) => self.keep(step.frame, &step.path, true),
            }
        }
        rounds.ledger.remove();
    }
}
