//! Ctrl-C, and the signals that ask a program to end.

use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::Exit;
use super::terminal::say;

/// When somebody asked to stop.
static REQUESTED: OnceLock<Instant> = OnceLock::new();
/// How long work may go on from there to an end that can be kept.
const PATIENCE: Duration = Duration::from_millis(500);
/// A [`Guard`] is there: work is under way that looks at [`requested`].
static GUARDED: AtomicBool = AtomicBool::new(false);

/// Listens to SIGINT, SIGTERM, SIGHUP and SIGUSR1 from now on: to be called before there is another
/// thread.
///
/// Where the caller has one of them ignored (`nohup`, a background job of a script), it stays
/// ignored.
#[cfg(target_os = "linux")]
pub(super) fn listen() {
    use ctrlc::Signal;
    let mut signals = Signal::SIGINT | Signal::SIGTERM | Signal::SIGHUP | Signal::SIGUSR1;
    let ignored = ignored_signals();
    for signal in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP, Signal::SIGUSR1] {
        if (ignored >> (signal as i32 - 1)) & 1 == 1 {
            signals.remove(signal);
        }
    }
    // A file beyond a limit of the user's is then an error of writing, which is told, and not the
    // end of the program in the middle of a file. Nobody waits for it.
    let mut blocked = signals;
    blocked.add(Signal::SIGXFSZ);
    // Blocked in this thread and all that it starts, they wait for the one that asks for them.
    if blocked.thread_block().is_ok() {
        let wait = move || {
            while signals.wait().is_ok() {
                stop();
            }
        };
        let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
    }
}

/// Signals that this process ignores, signal 1 in the lowest bit.
#[cfg(target_os = "linux")]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Listens to Ctrl-C, and where there is one to SIGTERM and SIGHUP, from now on.
#[cfg(not(target_os = "linux"))]
pub(super) fn listen() {
    let _ = ctrlc::try_set_handler(stop);
}

fn stop() {
    let again = REQUESTED.set(Instant::now()).is_err();
    if again || !GUARDED.load(Ordering::SeqCst) {
        say("slo-rt: interrupted");
        process::exit(Exit::Interrupted as i32);
    }
}

/// Whether to stop as soon as possible.
pub(super) fn requested() -> bool {
    REQUESTED.get().is_some()
}

/// Whether to stop even if what is under way is lost.
pub(super) fn was_long_ago() -> bool {
    REQUESTED.get().is_some_and(|since| since.elapsed() > PATIENCE)
}

/// While it lives, the first signal only makes [`requested`] true; a second one, or one outside
/// of it, ends the program at once.
pub(super) struct Guard(());

impl Guard {
    pub(super) fn new() -> Self {
        GUARDED.store(true, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        GUARDED.store(false, Ordering::SeqCst);
    }
}
