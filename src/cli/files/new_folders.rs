//! Folders that are made for a file, and are not left behind without one.

use std::fs;
use std::path::{Path, PathBuf};

/// Removes, when it is dropped, those of a file's folders that were not there before and have nothing
/// in them.
#[must_use]
#[derive(Debug)]
pub(crate) struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Of the file at `path`; to be called before they are made.
    pub(crate) fn of(path: &Path) -> Self {
        let folders = path.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
        Self(folders.take_while(|folder| !folder.exists()).map(Path::to_owned).collect())
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // Of a folder with something in it nothing is removed.
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_or_is_used_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("old")).unwrap();
        {
            let _empty = NewFolders::of(&at("old/new/deep/a.png"));
            let _used = NewFolders::of(&at("old/used/a.png"));
            fs::create_dir_all(at("old/new/deep")).unwrap();
            fs::create_dir_all(at("old/used")).unwrap();
            fs::write(at("old/used/a.png"), "").unwrap();
        }
        assert!(!at("old/new").exists());
        assert!(at("old/used/a.png").exists());
    }
}
