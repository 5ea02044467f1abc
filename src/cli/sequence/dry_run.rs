//! `--dry-run`: what would be rendered.

use super::super::Exit;
use super::super::problem::Problem;
use super::super::terminal::{Terminal, print};
use super::plan::Step;

/// Prints a line per frame, its fields separated by tabs: number, path, what is known of it. Says
/// how many frames are to be rendered.
pub(super) fn tell(steps: &[Step], terminal: Terminal) -> Result<(), Problem> {
    let line = |step: &Step| {
        let path = step.path.display();
        format!("{}\t{path}\t{}", step.frame, step.reason())
    };
    let lines: Vec<_> = steps.iter().map(line).collect();
    print(lines.join("\n").as_bytes())
        .map_err(|error| Problem::new(Exit::Failed, format!("can't print the frames: {error}")))?;
    let to_render = steps.iter().filter(|step| step.is_to_render()).count();
    terminal.note(format_args!("{to_render} of {} frames to render", steps.len()));
    Ok(())
}
