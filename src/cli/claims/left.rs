//! Claims that killed runs left behind for finished frames.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use super::note::{Note, path_of};

/// Claims as they were when a run began.
#[derive(Debug)]
pub(crate) struct Left {
    claims: Vec<(PathBuf, Note)>,
    at: Instant,
}

impl Left {
    /// Collects the claims in `folder` on `pictures`, and the files of processes that died while
    /// taking over such a claim.
    pub(crate) fn look<'a>(folder: &Path, pictures: impl Iterator<Item = &'a Path>) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let names = fs::read_dir(folder).into_iter().flatten().flatten();
        let names = names.filter_map(|entry| entry.file_name().into_string().ok());
        let names: Vec<(String, String)> = names.filter_map(|name| claim_of(&name)).collect();
        let mut claims = Vec::new();
        if !names.is_empty() {
            let wanted: HashSet<_> = pictures
                .filter_map(|path| path_of(path).file_name()?.to_str().map(str::to_owned))
                .collect();
            let ours = names.into_iter().filter(|(claim, _)| wanted.contains(claim));
            let paths = ours.map(|(_, name)| folder.join(name));
            claims =
                paths.filter_map(|path| Note::read(&path).ok().map(|note| (path, note))).collect();
        }
        Self { claims, at: Instant::now() }
    }

    /// Removes the claims that have not changed since, if their owners are dead by now. All
    /// pictures are finished, so no process waits for these claims.
    pub(crate) fn sweep(&self) {
        let Some((first, _)) = self.claims.first() else { return };
        let passed = self.at.elapsed();
        let now = now_beside(first);
        for (path, note) in &self.claims {
            // It changed before the run began, and both times are of the file system's clock.
            let silence = now.and_then(|now| now.duration_since(changed(path)?).ok());
            let is_dead = passed.max(silence.unwrap_or_default()) >= note.least_silence();
            if is_dead && Note::read(path).is_ok_and(|there| there == *note) {
                let _ = fs::remove_file(path);
            }
        }
    }
}

/// When a file was last changed.
fn changed(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// The time that a file changed now has, by the clock of its file system.
fn now_beside(path: &Path) -> Option<SystemTime> {
    let file = tempfile::Builder::new().prefix(".slo-rt-now-").tempfile_in(path.parent()?).ok()?;
    changed(file.path())
}

/// Returns the claim that a file is or was meant to replace, and the file's own name.
fn claim_of(name: &str) -> Option<(String, String)> {
    const END: &str = ".claim";
    let start = name.strip_prefix(".slo-rt-")?;
    let claim = match start.strip_suffix(END) {
        Some(_) => name,
        None => &name[..name.rfind(&format!("{END}."))? + END.len()],
    };
    Some((claim.to_owned(), name.to_owned()))
}
