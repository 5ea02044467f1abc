//! The memory that may still be taken: asked before anything large is made.
//!
//! Whoever allocates by the size of an input estimates first, and refuses with a message, since a program
//! that has run out of memory can no longer say why. Nobody is asked unless a program
//! [says whom](ask_first); the command line does.

use std::fmt::{self, Display};
use std::sync::OnceLock;

/// Bytes that may still be taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Left {
    /// How many.
    pub bytes: u64,
    /// What leaves so many, as a sentence goes on: "the memory of the machine leaves 250 MB".
    pub said: String,
}

/// Tells what may still be taken; `None` if it is not known.
pub type Ask = fn() -> Option<Left>;

static ASK: OnceLock<Ask> = OnceLock::new();

/// Less is not asked for: there is always so much.
const LEAST: u64 = 8 << 20;

/// Says whom to ask from now on. The first answer to that stays.
pub fn ask_first(ask: Ask) {
    let _ = ASK.set(ask);
}

/// Why something can't be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    needs: u64,
    left: Left,
}

impl Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} MB of memory, but {}", self.needs.div_ceil(1_000_000), self.left.said)
    }
}

/// Checks that something of so many bytes, with what is needed to make it, can be made.
///
/// # Errors
/// There is not so much left. The message goes on behind "needs".
pub fn check(bytes: u64) -> Result<(), Refusal> {
    match ASK.get() {
        Some(ask) if bytes > LEAST => of(bytes, ask()),
        _ => Ok(()),
    }
}

fn of(bytes: u64, left: Option<Left>) -> Result<(), Refusal> {
    match left {
        Some(left) if left.bytes < bytes => Err(Refusal { needs: bytes, left }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_refused() {
        let left = |bytes| Some(Left { bytes, said: "the moon leaves 1 MB".into() });
        assert_eq!(of(1 << 30, left(1 << 30)), Ok(()));
        assert_eq!(of(u64::MAX, None), Ok(()));
        let refusal = of((1 << 30) + 1, left(1 << 30)).unwrap_err();
        assert_eq!(refusal.to_string(), "1074 MB of memory, but the moon leaves 1 MB");
        assert_eq!(check(u64::MAX), Ok(()), "nobody is to be asked");
    }
}
