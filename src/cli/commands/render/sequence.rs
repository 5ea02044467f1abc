//! Frames in their order, all of them by this process.

use super::line::Line;
use super::plan::{State, Step};
use super::run::Run;
use crate::cli::base::Problem;

impl Run<'_> {
    /// Does what each of the frames needs. An error ends the run.
    pub(super) fn sequence(&self, steps: &[Step]) -> Result<(), Problem> {
        let to_render = steps.iter().filter(|step| step.is_to_render()).count();
        self.in_line(to_render, |line| {
            steps.iter().enumerate().try_for_each(|(i, step)| {
                let next = steps[i + 1..].iter().find(|step| step.is_to_render());
                line.expect(next.map(|step| step.frame));
                go_through(line, step)
            })
        })
    }
}

/// Renders a frame if it is still to do. Paths and errors are printed in the order of the frames.
fn go_through(line: &mut Line<'_, '_>, step: &Step) -> Result<(), Problem> {
    let run = line.run;
    let (path, state, was_to_render) = match &step.state {
        State::ToRender(_) => match run.state_now(step) {
            None => return line.render(step, None).map(drop),
            Some((path, state)) => (path, &{ state }, true),
        },
        state => (step.path.clone(), state, false),
    };
    line.written()?;
    run.settle(step.frame, &path, state, was_to_render);
    Ok(())
}
