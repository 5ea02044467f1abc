//! `--dry-run`: lists what would be rendered.

use super::done::exit_of;
use super::plan::{State, Step};
use crate::cli::base::{Exit, Problem, Terminal, counted, print};
use crate::cli::files::load;
use crate::cli::values::shown;

/// Prints one line per frame with its number, path and state, separated by tabs. Reports how many
/// frames are to be rendered.
///
/// # Errors
/// The error of the run, if the scene does not have all of the frames.
pub(super) fn tell(steps: Vec<Step>, terminal: Terminal) -> Result<(), Problem> {
    let line = |step: &Step| {
        let path = step.path.display();
        format!("{}\t{path}\t{}", step.frame, step.reason())
    };
    let lines: Vec<_> = steps.iter().map(line).collect();
    print(lines.join("\n").as_bytes())
        .map_err(|error| Problem::new(Exit::Failed, format!("can't print the frames: {error}")))?;
    let to_render = steps.iter().filter(|step| step.is_to_render()).count();
    let all = steps.len();
    terminal.note(format_args!("{to_render} of {} to render", counted(all, "frame")));
    let mut missing: Vec<(i64, Problem)> = steps
        .into_iter()
        .filter_map(|step| match step.state {
            State::None(error) => Some((step.frame, load::no_segment(&error))),
            _ => None,
        })
        .collect();
    match missing.len() {
        0 => Ok(()),
        1 if all == 1 => Err(missing.remove(0).1),
        none => {
            let frames: Vec<i64> = missing.iter().map(|(frame, _)| *frame).collect();
            let message = format!(
                "the scene does not have {none} of {}: {}",
                counted(all, "frame"),
                shown(&frames)
            );
            Err(Problem::new(exit_of(&missing, none == all), message))
        }
    }
}
