//! Waiting for a disk that is full, or a folder that is gone: nothing is lost meanwhile.

use std::io;
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use super::interrupt;
use super::terminal::Terminal;

/// Between two attempts.
const PAUSE: Duration = Duration::from_secs(2);
/// How soon an interrupt is heard.
const GLANCE: Duration = Duration::from_millis(100);

/// Writes to `path` as soon as there is room for it. Says once what it waits for.
///
/// # Errors
/// What waiting does not help against, and what it is about where the user interrupts.
pub(super) fn write<T>(
    path: &Path,
    terminal: Terminal,
    mut attempt: impl FnMut() -> io::Result<T>,
) -> io::Result<T> {
    let mut said = false;
    loop {
        match attempt() {
            Err(error) if may_pass(&error) && !interrupt::requested() => {
                if !said {
                    terminal.warn(format_args!(
                        "can't write `{}`: {error}; waiting until it works, nothing is lost",
                        path.display()
                    ));
                    said = true;
                }
                pause();
            }
            other => return other,
        }
    }
}

/// Whether somebody may set it right: by making room, by mounting what was unmounted.
fn may_pass(error: &io::Error) -> bool {
    use io::ErrorKind::{NotFound, QuotaExceeded, StaleNetworkFileHandle, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | NotFound | StaleNetworkFileHandle)
}

fn pause() {
    let glances = PAUSE.as_millis() / GLANCE.as_millis();
    for _ in 0..glances {
        if interrupt::requested() {
            return;
        }
        sleep(GLANCE);
    }
}

#[cfg(test)]
mod tests {
    use super::super::args::When;
    use super::super::terminal::Verbosity;
    use super::*;

    #[test]
    fn what_may_pass_is_waited_for_and_nothing_else() {
        let terminal = Terminal::new(When::Never, Verbosity::Quiet);
        let mut attempts = 0;
        let written = write(Path::new("a"), terminal, || {
            attempts += 1;
            if attempts < 2 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(attempts) }
        });
        assert_eq!(written.unwrap(), 2);
        let denied = || -> io::Result<()> { Err(io::ErrorKind::PermissionDenied.into()) };
        let denied = write(Path::new("a"), terminal, denied);
        assert_eq!(denied.unwrap_err().kind(), io::ErrorKind::PermissionDenied);
    }
}
