//! Folders that are made for a file, and removed if the file is not written.

use std::fs;
use std::path::{Path, PathBuf};

/// When dropped, removes the folders of a file that did not exist before and are empty.
#[must_use]
#[derive(Debug)]
pub(crate) struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Notes the missing folders of the file at `path`. Must be called before they are made.
    pub(crate) fn of(path: &Path) -> Self {
        let folders = path.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
        Self(folders.take_while(|folder| !folder.exists()).map(Path::to_owned).collect())
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // A folder with something in it stays.
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
