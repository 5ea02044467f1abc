//! Ctrl-C, and the signals that ask a program to end.

use std::process;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, OnceLock};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::cli::base::{Exit, say};

/// Time of the first request to stop.
static REQUESTED: OnceLock<Instant> = OnceLock::new();
/// How long work may continue after the request, to reach an end that can be kept.
const PATIENCE: Duration = Duration::from_millis(500);
/// How long work that can't be asked to stop may continue after the request.
const BUILDING_MAY_TAKE: Duration = Duration::from_secs(1);

/// Phase of the program, which decides what a signal does.
static PHASE: AtomicU8 = AtomicU8::new(FREE);
/// A signal ends the program at once.
const FREE: u8 = 0;
/// The program reads the scene and looks at existing files.
const READING: u8 = 1;
/// Work is in progress that checks [`requested`].
const WORKING: u8 = 2;
/// The program builds what a frame needs.
const BUILDING: u8 = 3;
/// A signal is ending the program.
const ENDING: u8 = 4;

type Last = Box<dyn FnOnce() + Send>;
/// Action before a signal ends the program early.
static LAST: Mutex<Option<Last>> = Mutex::new(None);

/// Listens for SIGINT, SIGTERM, SIGHUP and SIGUSR1 from now on. Must be called before another
/// thread starts.
///
/// A signal that the caller ignores (`nohup`, a background job of a script) stays ignored.
#[cfg(target_os = "linux")]
pub(crate) fn listen() {
    use ctrlc::Signal;
    let mut signals = Signal::SIGINT | Signal::SIGTERM | Signal::SIGHUP | Signal::SIGUSR1;
    let ignored = ignored_signals();
    for signal in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP, Signal::SIGUSR1] {
        if (ignored >> (signal as i32 - 1)) & 1 == 1 {
            signals.remove(signal);
        }
    }
    // With SIGXFSZ blocked, a file beyond the user's size limit is a write error, which is
    // reported, and does not end the program in the middle of a file. No thread waits for this
    // signal.
    let mut blocked = signals;
    blocked.add(Signal::SIGXFSZ);
    // The signals are blocked in this thread and in all that it starts. They wait for the thread
    // that asks for them.
    if blocked.thread_block().is_ok() {
        let wait = move || {
            while signals.wait().is_ok() {
                stop();
            }
        };
        let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
    }
}

/// Returns the signals that this process ignores, with signal 1 in the lowest bit.
#[cfg(target_os = "linux")]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Listens for Ctrl-C from now on, and for SIGTERM and SIGHUP on systems that have them.
#[cfg(not(target_os = "linux"))]
pub(crate) fn listen() {
    let _ = ctrlc::try_set_handler(stop);
}

fn stop() {
    let again = REQUESTED.set(Instant::now()).is_err();
    match PHASE.load(Ordering::SeqCst) {
        _ if again => end(Exit::Interrupted, "interrupted"),
        FREE => end(Exit::Stopped, "interrupted"),
        READING => end(Exit::Stopped, "interrupted before the first frame"),
        _ => drop(std::thread::Builder::new().name("stop".into()).spawn(see_to_it)),
    }
}

fn end(exit: Exit, why: &str) -> ! {
    let last = LAST.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).take();
    if let Some(last) = last.filter(|_| exit == Exit::Stopped) {
        last();
    }
    say(format_args!("slo-rt: {why}"));
    process::exit(exit as i32);
}

/// Ends the program if it is still building, which can't be asked to stop and leaves nothing to
/// keep. If other work takes long, reports that.
fn see_to_it() {
    sleep(BUILDING_MAY_TAKE);
    if PHASE.compare_exchange(BUILDING, ENDING, Ordering::SeqCst, Ordering::SeqCst).is_ok() {
        end(
            Exit::Stopped,
            "interrupted while preparing a frame; run the same command again to continue",
        );
    }
    sleep(BUILDING_MAY_TAKE);
    say("slo-rt: stopping takes a while; a second signal ends the program at once");
}

/// Registers `last`, which runs before a signal ends the program without finishing its work.
pub(crate) fn before_the_end(last: impl FnOnce() + Send + 'static) {
    *LAST.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(Box::new(last));
}

/// Whether to stop as soon as possible.
pub(crate) fn requested() -> bool {
    REQUESTED.get().is_some()
}

/// Whether to stop even if work in progress is lost.
pub(crate) fn was_long_ago() -> bool {
    REQUESTED.get().is_some_and(|since| since.elapsed() > PATIENCE)
}

/// While the guard lives, the program reads, and the first signal ends it at once with
/// [`Exit::Stopped`]. After [`begin_work`](Self::begin_work), the first signal only makes
/// [`requested`] true. A second signal, or a signal without a guard, ends the program at once.
pub(crate) struct Guard(());

impl Guard {
    pub(crate) fn new() -> Self {
        PHASE.store(READING, Ordering::SeqCst);
        Self(())
    }

    /// Starts the phase with something to lose, in which the work checks [`requested`].
    pub(crate) fn begin_work() {
        PHASE.store(WORKING, Ordering::SeqCst);
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        PHASE.store(FREE, Ordering::SeqCst);
    }
}

/// Runs work that can't be asked to stop and is useless to another run. If it takes long, a signal
/// ends the program in the middle of it.
pub(crate) fn while_building<T>(build: impl FnOnce() -> T) -> T {
    let go = |from, to| PHASE.compare_exchange(from, to, Ordering::SeqCst, Ordering::SeqCst);
    let is_guarded = go(WORKING, BUILDING).is_ok();
    let built = build();
    while is_guarded && go(BUILDING, WORKING).is_err() {
        // The program is ending, so nothing else may begin.
        sleep(PATIENCE);
    }
    built
}
