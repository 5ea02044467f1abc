//! Turns a panic, which is a bug of slo-rt, into a message that helps to report it. Turns an
//! abort, in which a lack of memory ends, into an exit code.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Mutex;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

use crate::cli::base::{Exit, say};

/// Message and place of the first panic.
static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// Turns an abort into an exit code. If memory runs out, the Rust runtime prints a message and
/// aborts.
#[cfg(unix)]
fn end_aborts() {
    let always = Arc::new(AtomicBool::new(true));
    let abort = signal_hook::consts::SIGABRT;
    let _ = signal_hook::flag::register_conditional_shutdown(abort, Exit::Failed as i32, always);
}

#[cfg(not(unix))]
fn end_aborts() {}

/// Runs `body`. If any thread panics, prints a report with the version and `args`.
pub(crate) fn reported(args: &[OsString], body: impl FnOnce() -> Exit) -> Exit {
    end_aborts();
    panic::set_hook(Box::new(remember));
    let exit = panic::catch_unwind(AssertUnwindSafe(body));
    let _ = panic::take_hook();
    exit.unwrap_or_else(|_| {
        let first = FIRST.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).take();
        say(report(args, &first.unwrap_or_else(|| "no message".into())));
        Exit::Failed
    })
}

fn remember(info: &PanicHookInfo) {
    let payload = info.payload();
    let text = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    let place = info.location().map_or_else(String::new, |place| format!("\n  at {place}"));
    let backtrace = Backtrace::capture();
    let trace = match backtrace.status() {
        BacktraceStatus::Captured => format!("\n{backtrace}"),
        _ => String::new(),
    };
    let mut first = FIRST.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    first.get_or_insert_with(|| format!("{text}{place}{trace}"));
}

fn report(args: &[OsString], what: &str) -> String {
    let args: Vec<_> = args.iter().map(|arg| format!("{arg:?}")).collect();
    format!(
        "error: slo-rt has a bug: {what}\n  \
         no picture was written; please report this with the scene and these lines:\n  \
         slo-rt {} ({} {})\n  {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        args.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    // This is one test, because the hook belongs to the process.
    #[test]
    fn a_panic_becomes_an_exit_code() {
        assert_eq!(reported(&[], || Exit::BadInput), Exit::BadInput);
        assert_eq!(reported(&["slo-rt".into()], || panic!("planted {}", 7)), Exit::Failed);
        assert!(FIRST.lock().unwrap().is_none(), "the report takes the message");
        let args = ["slo-rt".into(), "-s".into(), "a b.txt".into()];
        let text = report(&args, "planted\n  at x.rs:1:2");
        assert!(text.contains("planted\n  at x.rs:1:2"));
        assert!(text.contains(env!("CARGO_PKG_VERSION")));
        assert!(text.contains(r#""slo-rt" "-s" "a b.txt""#));
    }
}
