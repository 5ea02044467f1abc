//! Number of threads.

use super::numbers::count;

/// `--threads`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Threads {
    /// One thread per processor of the machine, whatever the scene says.
    All,
    Count(u32),
}

/// Parses a number of threads.
pub(crate) fn threads(text: &str) -> Result<Threads, String> {
    if ["auto", "all"].iter().any(|word| text.trim().eq_ignore_ascii_case(word)) {
        return Ok(Threads::All);
    }
    let count = count(text, 1..=4096, "4").map(Threads::Count);
    count.map_err(|expected| format!("{expected}, or `auto` for all processors"))
}
