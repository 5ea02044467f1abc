//! A folder of things that were worked out before: parsed meshes, and structures over them.
//!
//! A file is named by a hash of everything that its content is worked out from, so nothing in the
//! folder is ever out of date, and any number of processes on any number of machines may use it at
//! once. A file appears whole, under its name, or not at all. Each part of it has a checksum. A file
//! that is damaged, cut off or foreign is reported and made again.
//!
//! Whoever reads a file checks besides that its numbers make sense: a checksum finds damage, but not
//! malice.

mod entry;
mod key;
#[cfg(test)]
mod tests;

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

pub use self::entry::Entry;
pub use self::key::{Key, hash_of};

/// Files that were used so recently are not marked as used again.
const RECENTLY: Duration = Duration::from_secs(3600);

/// Temporary files of this age belong to nobody.
const ABANDONED: Duration = Duration::from_secs(24 * 3600);

/// How the names of all files end, and those of files that are being written.
const END: &str = ".slo-cache";
const TEMPORARY_END: &str = ".slo-cache.part";

/// What is done with a warning.
type Warn = Box<dyn Fn(&str) + Send + Sync>;

/// A folder of things that were worked out before.
pub struct Cache {
    folder: PathBuf,
    /// Most bytes of all files.
    most: u64,
    warn: Warn,
    has_failed: AtomicBool,
    /// Bytes written since the folder was last looked through; `None`: it never was.
    since: Mutex<Option<u64>>,
    temporary: AtomicU64,
    found: AtomicU64,
    made: AtomicU64,
}

/// How often a cache was of use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// Things that were found.
    pub found: u64,
    /// Things that were written.
    pub made: u64,
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cache").field("folder", &self.folder).finish_non_exhaustive()
    }
}

impl Cache {
    /// A cache in a folder, which is made when it is first written to. All files together have at most
    /// `most` bytes: those that were not used for the longest time are removed. `warn` receives
    /// what the user should know; nothing that goes wrong here is an error.
    pub fn new(folder: &Path, most: u64, warn: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self {
            folder: folder.to_owned(),
            most,
            warn: Box::new(warn),
            has_failed: AtomicBool::new(false),
            since: Mutex::new(None),
            temporary: AtomicU64::new(0),
            found: AtomicU64::new(0),
            made: AtomicU64::new(0),
        }
    }

    /// How often it was of use so far.
    pub fn uses(&self) -> Uses {
        let number = |of: &AtomicU64| of.load(Ordering::Relaxed);
        Uses { found: number(&self.found), made: number(&self.made) }
    }

    /// Returns what `read` makes of the file of a key. `None` if there is none, or it can't be used;
    /// `read` returns `None` if the content makes no sense.
    pub fn get<T>(&self, key: &Key, read: impl FnOnce(&Entry) -> Option<T>) -> Option<T> {
        let path = self.path(key);
        // Opening a pipe would wait for somebody who writes.
        let is_file = fs::metadata(&path).ok()?.is_file();
        let file = if is_file { File::open(&path).ok() } else { None };
        let entry = file.and_then(|file| Entry::open(file, key));
        let content = entry.and_then(|entry| read(&entry));
        match &content {
            Some(_) => {
                self.found.fetch_add(1, Ordering::Relaxed);
                mark_as_used(&path);
                self.make_room(0);
            }
            // Another process may have removed it meanwhile, to make room.
            None if path.exists() => {
                let path = path.display();
                (self.warn)(&format!("`{path}` is damaged or no file of a cache; made again"));
            }
            None => {}
        }
        content
    }

    /// Writes the file of a key, section by section. If this fails, a warning says so, once.
    pub fn put(&self, key: &Key, sections: &[&[u8]]) {
        let size = sections.iter().map(|section| section.len() as u64).sum();
        if size > self.most {
            return;
        }
        let written = fs::create_dir_all(&self.folder).and_then(|()| self.write(key, sections));
        match written {
            Ok(()) => {
                self.made.fetch_add(1, Ordering::Relaxed);
                self.make_room(size);
            }
            Err(error) => {
                if !self.has_failed.swap(true, Ordering::Relaxed) {
                    let folder = self.folder.display();
                    (self.warn)(&format!("can't write to the cache `{folder}`: {error}"));
                }
            }
        }
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}{END}", key.name()))
    }

    fn write(&self, key: &Key, sections: &[&[u8]]) -> io::Result<()> {
        let number = self.temporary.fetch_add(1, Ordering::Relaxed);
        let name = format!("{}-{}-{number}{TEMPORARY_END}", key.name(), process::id());
        let temporary = self.folder.join(name);
        // Another machine may have the same process id.
        let mut file = File::options().write(true).create_new(true).open(&temporary)?;
        let written = file
            .write_all(&entry::head(key, sections))
            .and_then(|()| sections.iter().try_for_each(|section| file.write_all(section)))
            .and_then(|()| fs::rename(&temporary, self.path(key)));
        // It is not synced: what a power failure leaves of it has another checksum.
        written.inspect_err(|_| drop(fs::remove_file(&temporary)))
    }

    /// Removes files if all together have become too large. They are looked through at first, and again
    /// when a part of the limit was written since.
    fn make_room(&self, written: u64) {
        let mut since = self.since.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        match &mut *since {
            Some(bytes) if *bytes + written < self.most / 16 => *bytes += written,
            since => {
                *since = Some(0);
                remove_oldest(&self.folder, self.most);
            }
        }
    }
}

/// Sets the time of a file to now, if that was long ago.
fn mark_as_used(path: &Path) {
    let now = SystemTime::now();
    let modified = path.metadata().and_then(|data| data.modified());
    if modified.is_ok_and(|time| now.duration_since(time).is_ok_and(|age| age > RECENTLY)) {
        let file = File::options().append(true).open(path);
        let _ = file.and_then(|file| file.set_modified(now));
    }
}

/// Removes the files of a folder that were not used for the longest time, until all have at most
/// `most` bytes.
fn remove_oldest(folder: &Path, most: u64) {
    let now = SystemTime::now();
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let Ok(data) = entry.metadata() else { continue };
        let Ok(time) = data.modified() else { continue };
        if name.ends_with(TEMPORARY_END) {
            if now.duration_since(time).is_ok_and(|age| age > ABANDONED) {
                let _ = fs::remove_file(entry.path());
            }
        } else if name.ends_with(END) && data.is_file() {
            files.push((time, data.len(), entry.path()));
        }
    }
    files.sort();
    let mut all: u64 = files.iter().map(|file| file.1).sum();
    for (_, size, path) in files {
        if all <= most {
            return;
        }
        // If another process was faster, the room is there too.
        let _ = fs::remove_file(path);
        all -= size;
    }
}
