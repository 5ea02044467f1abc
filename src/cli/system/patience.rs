//! Waits if a disk is full or a folder is gone, so that nothing is lost meanwhile.

use std::fmt::Display;
use std::io;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::interrupt;
use crate::cli::base::{Exit, Problem, Terminal};

/// Time between two attempts.
const PAUSE: Duration = Duration::from_secs(2);
/// Time between two checks for an interrupt.
const GLANCE: Duration = Duration::from_millis(100);
/// How long to wait after errors that may come from a broken disk or from a file server that
/// restarts.
const A_WHILE: Duration = Duration::from_secs(60);

/// How long waiting for an error to pass may be worthwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hope {
    /// Waiting does not help.
    None,
    /// The error passes soon or never.
    ForAWhile,
    /// Somebody may fix the cause, by making room or by mounting what was unmounted.
    Lasting,
}

/// Writes to `path` as soon as that works. Reports what it waits for.
///
/// # Errors
/// An error that waiting does not help against, or, if the user interrupts the waiting, the error
/// that it waited for. [`problem`] tells the two apart.
pub(crate) fn write<T>(
    path: &Path,
    terminal: Terminal,
    mut attempt: impl FnMut() -> io::Result<T>,
) -> io::Result<T> {
    let mut said = None;
    let mut since = Instant::now();
    loop {
        let error = match attempt() {
            Err(error) if !interrupt::requested() => error,
            other => return other,
        };
        let kind = (error.kind(), error.raw_os_error());
        if said != Some(kind) {
            since = Instant::now();
        }
        let until = match hope(&error) {
            Hope::None => return Err(error),
            Hope::ForAWhile if since.elapsed() >= A_WHILE => return Err(error),
            Hope::ForAWhile => "trying again for a minute",
            Hope::Lasting => "waiting until it works, nothing is lost",
        };
        if said.replace(kind) != Some(kind) {
            terminal.warn(format_args!("can't write `{}`: {error}; {until}", path.display()));
        }
        pause();
    }
}

/// Makes the problem of a failed attempt to `what` (a verb and its object). The exit code is 75 if
/// the user interrupted the waiting.
pub(crate) fn problem(what: impl Display, error: &io::Error) -> Problem {
    if interrupt::requested() && may_pass(error) {
        let message = format!("interrupted while waiting to {what}: {error}");
        return Problem::new(Exit::Stopped, message);
    }
    Problem::new(Exit::CantWrite, format!("can't {what}: {error}"))
}

/// Whether an error may pass.
pub(crate) fn may_pass(error: &io::Error) -> bool {
    hope(error) != Hope::None
}

fn hope(error: &io::Error) -> Hope {
    use io::ErrorKind::{
        ConnectionAborted, ConnectionReset, HostUnreachable, NetworkDown, NetworkUnreachable,
        NotADirectory, NotConnected, NotFound, OutOfMemory, PermissionDenied, QuotaExceeded,
        ReadOnlyFilesystem, ResourceBusy, StaleNetworkFileHandle, StorageFull, TimedOut,
        WouldBlock,
    };
    match error.kind() {
        StorageFull
        | QuotaExceeded
        | NotFound
        | NotADirectory
        | StaleNetworkFileHandle
        | PermissionDenied
        | ReadOnlyFilesystem
        | TimedOut
        | ConnectionReset
        | ConnectionAborted
        | NotConnected
        | HostUnreachable
        | NetworkUnreachable
        | NetworkDown => Hope::Lasting,
        ResourceBusy | OutOfMemory | WouldBlock => Hope::ForAWhile,
        _ if error.raw_os_error().is_some_and(is_of_the_device) => Hope::ForAWhile,
        _ => Hope::None,
    }
}

/// Whether a device fails, is gone, or is reached through a network (ENXIO, ENODEV, EIO), or too
/// many files are open (ENFILE, EMFILE). The standard library has no names for these errors.
fn is_of_the_device(code: i32) -> bool {
    cfg!(unix) && matches!(code, 5 | 6 | 19 | 23 | 24)
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
    use super::*;
    use crate::cli::base::{Verbosity, When};

    #[test]
    fn what_may_pass_is_waited_for_and_nothing_else() {
        let terminal = Terminal::new(When::Never, Verbosity::Quiet);
        let mut attempts = 0;
        let written = write(Path::new("a"), terminal, || {
            attempts += 1;
            if attempts < 2 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(attempts) }
        });
        assert_eq!(written.unwrap(), 2);
        let too_large = || -> io::Result<()> { Err(io::ErrorKind::FileTooLarge.into()) };
        let too_large = write(Path::new("a"), terminal, too_large);
        assert_eq!(too_large.unwrap_err().kind(), io::ErrorKind::FileTooLarge);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn errors_of_the_system_have_their_hope() {
        let check = |code: i32, expected| {
            let error = io::Error::from_raw_os_error(code);
            assert_eq!(hope(&error), expected, "{error}");
        };
        // EPERM, ENOENT, EACCES, ENOTDIR, ENOSPC, EROFS, ENOTCONN, ETIMEDOUT, EHOSTUNREACH,
        // ESTALE, EDQUOT.
        for code in [1, 2, 13, 20, 28, 30, 107, 110, 113, 116, 122] {
            check(code, Hope::Lasting);
        }
        // EIO, ENXIO, EAGAIN, ENOMEM, EBUSY, ENODEV, ENFILE, EMFILE.
        for code in [5, 6, 11, 12, 16, 19, 23, 24] {
            check(code, Hope::ForAWhile);
        }
        // EISDIR, EINVAL, EFBIG, ENAMETOOLONG, ELOOP.
        for code in [21, 22, 27, 36, 40] {
            check(code, Hope::None);
        }
    }
}
