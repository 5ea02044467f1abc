//! Files that are looked at again and again, to see whether they have changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What is known of a file: its time and its length; `None` if it is missing.
type Seen = Option<(SystemTime, u64)>;

/// Files, as they were when they were read.
#[derive(Debug, Default)]
pub struct Watched(BTreeMap<PathBuf, Seen>);

impl Watched {
    /// Files as they are now.
    pub fn new(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let seen = |path: PathBuf| {
            let now = look_at(&path);
            (path, now)
        };
        Self(paths.into_iter().map(seen).collect())
    }

    /// Adds files as they are now. Those that are known stay as they were.
    pub fn add(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        for path in paths {
            self.0.entry(path).or_insert_with_key(|path| look_at(path));
        }
    }

    /// Whether any file is not as it was. From then on, it counts as it is now.
    pub fn have_changed(&mut self) -> bool {
        let mut changed = false;
        for (path, seen) in &mut self.0 {
            let now = look_at(path);
            changed |= now != *seen;
            *seen = now;
        }
        changed
    }
}

fn look_at(path: &Path) -> Seen {
    let data = path.metadata().ok()?;
    Some((data.modified().ok()?, data.len()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn changed_new_and_lost_files_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let (here, gone) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&here, "1").unwrap();
        let mut watched = Watched::new([here.clone(), gone.clone()]);
        assert!(!watched.have_changed());
        fs::write(&here, "12").unwrap();
        assert!(watched.have_changed() && !watched.have_changed());
        fs::write(&gone, "").unwrap();
        assert!(watched.have_changed() && !watched.have_changed());
        fs::remove_file(&gone).unwrap();
        assert!(watched.have_changed() && !watched.have_changed());
    }
}
