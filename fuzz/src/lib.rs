//! Fuzzers of everything that reads files or requests of others.
//!
//! Each is a file in `src/targets`: a function from bytes to nothing, which panics if a promise is broken, or takes more
//! time or memory than it may. libFuzzer looks for bytes that reach new code (`src/main.rs`). Without libFuzzer,
//! `tests/short.rs` changes the [`seeds`] at random.

use std::alloc::System;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Once, OnceLock};

use cap::Cap;
use rustix::time::{ClockId, clock_gettime};

mod changes;
mod pieces;
mod readers;
pub mod seeds;
mod targets;

pub use changes::changed;
pub use targets::{ALL, Run};

/// Whether an input is worth keeping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worth {
    /// If it reaches new code.
    Kept,
    /// In no case.
    Nothing,
}

impl From<()> for Worth {
    fn from((): ()) -> Self {
        Self::Kept
    }
}

/// Counts the memory that is in use.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// Most bytes of memory that an input may take.
const MOST_BYTES: usize = 256 << 20;
/// Most seconds of processor time that an input may take.
const MOST_SECONDS: f64 = 1.0;
/// The same of inputs of 1 MB: the marks for libFuzzer, and checks of overflows, make the code several times slower.
const MOST_SECONDS_LONG: f64 = 10.0;
/// Bytes of an input that is repeated.
const REPEATED: usize = 1 << 20;

/// Runs a reader on an input, within the limits.
///
/// With `SLO_FUZZ_LONG=1` in the environment, a part of the input is repeated until there is 1 MB of it,
/// which finds what takes more time or memory than in proportion.
///
/// # Panics
/// If the reader panics, or takes too long or too much.
pub(crate) fn within_limits(data: &[u8], read: impl FnOnce(&[u8])) {
    prepare();
    static IS_LONG: OnceLock<bool> = OnceLock::new();
    let is_long = IS_LONG.get_or_init(|| std::env::var_os("SLO_FUZZ_LONG").is_some());
    let long = is_long.then(|| repeated(data));
    let (begin, used) = (seconds(), MEMORY.allocated());
    let most = MEMORY.max_allocated();
    read(long.as_deref().unwrap_or(data));
    let (took, more) = (seconds() - begin, MEMORY.max_allocated());
    let most_seconds = if *is_long { MOST_SECONDS_LONG } else { MOST_SECONDS };
    assert!(took < most_seconds, "took {took} s");
    // The most of all inputs so far; only if it grew does it say something about this one.
    let peak = if more > most { more - used } else { 0 };
    assert!(peak < MOST_BYTES, "took {} MB", peak >> 20);
}

/// Makes this thread the only one that works: it finds the same things again, and no time goes into waiting.
/// To be called before anything else uses threads.
///
/// # Panics
/// If something else has.
pub fn prepare() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        pool.build_global().expect("a pool");
    });
}

/// The processor time of this thread.
fn seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// The input with a part of it many times; the last two bytes say which part.
fn repeated(data: &[u8]) -> Vec<u8> {
    let [data @ .., begin, end] = data else { return data.to_vec() };
    let place = |byte: &u8| data.len() * usize::from(*byte) / 255;
    let (begin, end) = (place(begin).min(place(end)), place(begin).max(place(end)));
    let part = &data[begin..end];
    let times = REPEATED.saturating_sub(data.len()).checked_div(part.len()).unwrap_or(0);
    [&data[..begin], &part.repeat(times + 1), &data[end..]].concat()
}

/// Writes a file for a reader that wants a path; every call replaces the last file of this name.
pub(crate) fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    fs::write(&path, bytes).expect("a file");
    path
}

/// A folder in memory, for this process.
pub(crate) fn folder() -> &'static Path {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let folder = folder.join(format!("slo-fuzz-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        folder
    });
    &FOLDER
}

/// Removes the folder that readers of files used. None may run afterwards.
pub fn remove_folder() {
    let _ = fs::remove_dir_all(folder());
}
