//! Ctrl-C, and the signals that ask a program to end.

use std::process;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, OnceLock};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::cli::base::{Exit, say};

/// When somebody asked to stop.
static REQUESTED: OnceLock<Instant> = OnceLock::new();
/// How long work may go on from there to an end that can be kept.
const PATIENCE: Duration = Duration::from_millis(500);
/// How long what can't be asked to stop may go on to its end.
const BUILDING_MAY_TAKE: Duration = Duration::from_secs(1);

/// What the program does, which decides about what a signal does.
static PHASE: AtomicU8 = AtomicU8::new(FREE);
/// Something that a signal ends at once.
const FREE: u8 = 0;
/// It reads the scene, and looks at what is there.
const READING: u8 = 1;
/// Work is under way that looks at [`requested`].
const WORKING: u8 = 2;
/// What is needed for a frame is built.
const BUILDING: u8 = 3;
/// It ends by a signal.
const ENDING: u8 = 4;

type Last = Box<dyn FnOnce() + Send>;
/// What is to be done before such an end.
static LAST: Mutex<Option<Last>> = Mutex::new(None);

/// Listens to SIGINT, SIGTERM, SIGHUP and SIGUSR1 from now on: to be called before there is another
/// thread.
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
    // A file beyond a limit of the user's is then an error of writing, which is reported, and does not
    // end the program in the middle of a file. Nobody waits for it.
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

/// Listens to Ctrl-C from now on, and to SIGTERM and SIGHUP on systems that have them.
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

/// Work that can't be asked to stop is given up if nothing of it can be kept anyway; that other work
/// takes its time is said.
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

/// Has `last` done before the program ends by a signal without going on to the end of what it does.
pub(crate) fn before_the_end(last: impl FnOnce() + Send + 'static) {
    *LAST.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(Box::new(last));
}

/// Whether to stop as soon as possible.
pub(crate) fn requested() -> bool {
    REQUESTED.get().is_some()
}

/// Whether to stop even if what is under way is lost.
pub(crate) fn was_long_ago() -> bool {
    REQUESTED.get().is_some_and(|since| since.elapsed() > PATIENCE)
}

/// While it lives the program reads, and the first signal ends it at once with [`Exit::Stopped`]; once
/// [`begin_work`](Self::begin_work) was called, the first signal only makes [`requested`] true. A second one,
/// or one outside of it, ends the program at once.
pub(crate) struct Guard(());

impl Guard {
    pub(crate) fn new() -> Self {
        PHASE.store(READING, Ordering::SeqCst);
        Self(())
    }

    /// From now on there is something to lose: work is under way that looks at [`requested`].
    pub(crate) fn begin_work() {
        PHASE.store(WORKING, Ordering::SeqCst);
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        PHASE.store(FREE, Ordering::SeqCst);
    }
}

/// Does what can't be asked to stop and is of no use to another run: a signal ends the program in
/// the middle of it, if it takes long.
pub(crate) fn while_building<T>(build: impl FnOnce() -> T) -> T {
    let go = |from, to| PHASE.compare_exchange(from, to, Ordering::SeqCst, Ordering::SeqCst);
    let is_guarded = go(WORKING, BUILDING).is_ok();
    let built = build();
    while is_guarded && go(BUILDING, WORKING).is_err() {
        // The program ends: what comes next is not to be begun.
        sleep(PATIENCE);
    }
    built
}
