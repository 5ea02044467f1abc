//! Ctrl-C, and the signals that ask a program to end.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Exit;
use super::terminal::say;

/// Somebody asked to stop.
static REQUESTED: AtomicBool = AtomicBool::new(false);
/// A [`Guard`] is there: work is under way that looks at [`requested`].
static GUARDED: AtomicBool = AtomicBool::new(false);

/// Listens to SIGINT, SIGTERM and SIGHUP from now on.
///
/// Where the caller has one of them ignored (`nohup`, a background job of a script), they keep
/// what they do: nothing is on disk before a picture is whole, so that ending at once is safe.
pub(super) fn listen() {
    let _ = ctrlc::try_set_handler(|| {
        let again = REQUESTED.swap(true, Ordering::SeqCst);
        if again || !GUARDED.load(Ordering::SeqCst) {
            say("slo-rt: interrupted");
            process::exit(Exit::Interrupted as i32);
        }
    });
}

/// Whether to stop as soon as possible.
pub(super) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
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
