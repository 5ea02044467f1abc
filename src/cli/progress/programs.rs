//! Progress for programs: a line of JSON per event, or the tokens of OpenJD.

use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};

use super::estimate::Moment;
use crate::cli::base::Problem;
use slo_picture::output::Outcome;

/// An event in a run.
#[derive(Clone, Copy, Debug)]
pub(super) enum Event<'a> {
    /// The run begins: the number of frames asked for, and of frames to be rendered.
    Sequence { frames: usize, to_render: usize },
    /// A frame was finished already.
    Found { frame: i64, path: &'a Path },
    /// A frame begins: number `index` of the frames to be rendered.
    Started { frame: i64, path: &'a Path, index: usize },
    /// A frame progresses.
    Progress { frame: i64, fraction: f64, run: Moment },
    /// A frame is in place.
    Finished { frame: i64, path: &'a Path, time: Duration, outcome: Outcome, run: Moment },
    /// A frame failed.
    Failed { frame: i64, problem: &'a Problem },
    /// Only frames of other processes are left.
    Waiting { frames: &'a [i64] },
    /// The run is over.
    Ended { rendered: usize, found: usize, failed: usize, time: Duration },
}

/// Formats an event as one line, an object with the member `event`.
pub(super) fn json_line(event: Event) -> String {
    object(event).to_string()
}

fn object(event: Event) -> Value {
    let path = |path: &Path| path.to_string_lossy().into_owned();
    let seconds = |time: Duration| (time.as_secs_f64() * 1e3).round() / 1e3;
    let share = |fraction: f64| (fraction * 1e6).round() / 1e6;
    match event {
        Event::Sequence { frames, to_render } => {
            json!({ "event": "sequence", "frames": frames, "toRender": to_render })
        }
        Event::Found { frame, path: at } => {
            json!({ "event": "found", "frame": frame, "path": path(at) })
        }
        Event::Started { frame, path: at, index } => {
            json!({ "event": "started", "frame": frame, "path": path(at), "index": index })
        }
        Event::Progress { frame, fraction, run } => json!({
            "event": "progress", "frame": frame, "fraction": share(fraction),
            "sequence": share(run.fraction), "elapsed": seconds(run.elapsed),
            "left": run.left.map(seconds),
        }),
        Event::Finished { frame, path: at, time, outcome, run } => json!({
            "event": "finished", "frame": frame, "path": path(at), "seconds": seconds(time),
            "samplesPerPixel": outcome.samples, "error": outcome.error,
            "sequence": share(run.fraction), "elapsed": seconds(run.elapsed),
            "left": run.left.map(seconds),
        }),
        Event::Failed { frame, problem: Problem { exit, message, .. } } => {
            let exit = *exit as u8;
            json!({ "event": "failed", "frame": frame, "exit": exit, "message": message })
        }
        Event::Waiting { frames } => json!({ "event": "waiting", "frames": frames }),
        Event::Ended { rendered, found, failed, time } => json!({
            "event": "ended", "rendered": rendered, "found": found, "failed": failed,
            "seconds": seconds(time),
        }),
    }
}

/// Returns the lines that OpenJD reads from a task's output.
///
/// Source: the Open Job Description specification, "How Jobs Are Run", session messages.
pub(super) fn openjd_lines(event: Event) -> Vec<String> {
    let percent = |fraction: f64| format!("openjd_progress: {:.1}", fraction * 100.0);
    match event {
        Event::Started { frame, .. } => vec![format!("openjd_status: frame {frame}")],
        Event::Progress { run, .. } | Event::Finished { run, .. } => vec![percent(run.fraction)],
        Event::Failed { problem, frame } => {
            vec![format!("openjd_fail: {}", problem.of_frame(frame).replace(['\n', '\r'], " "))]
        }
        Event::Ended { failed: 0, .. } => vec![percent(1.0)],
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::base::Exit;

    const MOMENT: Moment = Moment {
        fraction: 0.625,
        elapsed: Duration::from_millis(12_345),
        left: Some(Duration::from_secs(7)),
    };

    fn events(problem: &Problem) -> [Event<'_>; 8] {
        let path = Path::new("out/a \"b\"_00007.png");
        [
            Event::Sequence { frames: 10, to_render: 8 },
            Event::Found { frame: -1, path },
            Event::Started { frame: 7, path, index: 3 },
            Event::Progress { frame: 7, fraction: 1.0 / 3.0, run: MOMENT },
            Event::Finished {
                frame: 7,
                path,
                time: Duration::from_micros(1_234_567),
                outcome: Outcome { samples: 12.5, error: Some(0.25) },
                run: MOMENT,
            },
            Event::Failed { frame: 8, problem },
            Event::Waiting { frames: &[9, 12] },
            Event::Ended { rendered: 1, found: 2, failed: 1, time: Duration::from_secs(20) },
        ]
    }

    #[test]
    fn each_event_is_one_line_of_json() {
        let lines = events(&Problem::new(Exit::BadInput, "two\nlines")).map(json_line).join("\n");
        insta::assert_snapshot!(lines, @r#"
        {"event":"sequence","frames":10,"toRender":8}
        {"event":"found","frame":-1,"path":"out/a \"b\"_00007.png"}
        {"event":"started","frame":7,"index":3,"path":"out/a \"b\"_00007.png"}
        {"elapsed":12.345,"event":"progress","fraction":0.333333,"frame":7,"left":7.0,"sequence":0.625}
        {"elapsed":12.345,"error":0.25,"event":"finished","frame":7,"left":7.0,"path":"out/a \"b\"_00007.png","samplesPerPixel":12.5,"seconds":1.235,"sequence":0.625}
        {"event":"failed","exit":65,"frame":8,"message":"two\nlines"}
        {"event":"waiting","frames":[9,12]}
        {"event":"ended","failed":1,"found":2,"rendered":1,"seconds":20.0}
        "#);
    }

    #[test]
    fn openjd_reads_percent_status_and_failures() {
        let lines = events(&Problem::new(Exit::BadInput, "two\nlines"))
            .map(openjd_lines)
            .concat()
            .join("\n");
        insta::assert_snapshot!(lines, @r"
        openjd_status: frame 7
        openjd_progress: 62.5
        openjd_progress: 62.5
        openjd_fail: frame 8: two lines
        ");
    }
}
