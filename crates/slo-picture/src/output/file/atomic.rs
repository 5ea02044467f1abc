//! Files that are complete or absent.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::{Builder, NamedTempFile};

/// Creates the folder of `path`, and checks whether a file can be created at `path` by creating one
/// beside it, which is removed at once.
///
/// # Errors
/// What the system says of the folder or the file; `path` is a folder.
pub fn check_writable(path: &Path) -> io::Result<()> {
    fs::create_dir_all(folder(path)).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => io::ErrorKind::NotADirectory.into(),
        _ => error,
    })?;
    check_free(path)?;
    temporary_beside(path)?.close()
}

/// Checks whether anything but a file is in the way of a file at `path`.
///
/// # Errors
/// `path` is a folder, a device, a pipe or a link to one, or can't be the path of a file.
pub fn check_free(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(there) if !there.is_file() => Err(not_regular()),
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Opens a file for reading, but nothing that would keep the reader waiting.
///
/// # Errors
/// What the system says; `path` is a folder, a device or a pipe.
pub fn open_regular(path: &Path) -> io::Result<File> {
    match fs::metadata(path)? {
        there if there.is_file() => File::open(path),
        // Some systems open a folder, and fail when it is read.
        there if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        _ => Err(not_regular()),
    }
}

fn not_regular() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "a device or a pipe is there, no file")
}

/// Lets `write` fill a new file beside `path`, then renames it to `path`. An older file stays as it is
/// until then, and for good if anything fails. Removes what writers of `path` that were killed have
/// left.
///
/// # Errors
/// Those of `write`, and what the system says of creating, syncing or renaming.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    check_free(path)?;
    let mut temporary = temporary_beside(path)?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|error| error.error)?;
    sync_folder(folder(path));
    remove_abandoned(path);
    Ok(())
}

/// Lets `write` fill a new file beside `path`, then gives it the name `path`, if no file has it.
///
/// # Errors
/// Those of `write`, and what the system says of creating, syncing or renaming; `AlreadyExists` if
/// there is something at `path`.
pub fn write_new(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut temporary = temporary_beside(path)?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist_noclobber(path).map_err(|error| error.error)?;
    sync_folder(folder(path));
    Ok(())
}

/// Removes the temporary files of writers of `path` that were killed: those that nobody has locked, and
/// that have not changed for a minute.
pub fn remove_abandoned(path: &Path) {
    remove(path, is_abandoned);
}

/// Does the same for all of these `paths` in a folder, which is read once. The paths are asked for only if there
/// is a temporary file.
pub fn sweep_abandoned(folder: &Path, paths: impl IntoIterator<Item = PathBuf>) {
    let left = temporaries_in(folder, "");
    if left.is_empty() {
        return;
    }
    let ours: HashSet<String> = paths.into_iter().map(|path| temporary_beginning(&path)).collect();
    for file in left {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let is_ours = name.rfind('-').is_some_and(|end| ours.contains(&name[..=end]));
        if is_ours && is_abandoned(&file) {
            let _ = fs::remove_file(file);
        }
    }
}

/// Whether nobody writes a temporary file any more.
fn is_abandoned(file: &Path) -> bool {
    let Ok(file) = File::open(file) else { return false };
    let age = file.metadata().and_then(|data| data.modified()).map(|time| time.elapsed());
    // Its writer may be about to lock it.
    let is_old = age.is_ok_and(|age| age.is_ok_and(|age| age > STARTING));
    is_old && file.try_lock().is_ok()
}

/// The temporary files in a folder whose names have this beginning.
fn temporaries_in(folder: &Path, beginning: &str) -> Vec<PathBuf> {
    let is_temporary = |name: &str| {
        name.starts_with(START) && name.starts_with(beginning) && name.ends_with(TEMPORARY_END)
    };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let entries = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_temporary));
    entries.map(|entry| entry.path()).collect()
}

/// Removes the temporary files of writers of `path` that were killed. A writer that is still at work
/// fails, as if the folder were gone.
pub fn remove_leftovers(path: &Path) {
    remove(path, |_| true);
}

/// Removes those temporary files of writers of `path` for which `is_one` holds.
fn remove(path: &Path, is_one: impl Fn(&Path) -> bool) {
    for file in temporaries_in(folder(path), &temporary_beginning(path)) {
        if is_one(&file) {
            let _ = fs::remove_file(file);
        }
    }
}

/// Time in which a writer has locked its new file for sure.
const STARTING: Duration = Duration::from_secs(60);

/// How temporary names begin and end.
const START: &str = ".slo-rt-";
const TEMPORARY_END: &str = ".part";

/// The beginning of temporary names: a hash of the final name, which may be as long as names can be.
fn temporary_beginning(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    let hash = blake3::hash(name).to_hex();
    format!("{START}{}-", &hash[..8])
}

fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    // `tempfile_in` would make a file for its owner only, and put its name into every error.
    let create = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
    let beginning = temporary_beginning(path);
    let temporary =
        Builder::new().prefix(&beginning).suffix(TEMPORARY_END).make_in(folder(path), create)?;
    // Others see by it that the file is in use. Where there are no locks, they remove nothing.
    let _ = temporary.as_file().try_lock();
    Ok(temporary)
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes the renaming survive a power cut, if the system can sync folders. The file is complete and in
/// place already, so a refusal is no failure.
fn sync_folder(folder: &Path) {
    if cfg!(unix) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_written_file_is_whole_and_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "older and longer").unwrap();
        write_atomically(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_new_file_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.slo");
        write_new(&path, |file| file.write_all(b"one")).unwrap();
        let again = write_new(&path, |file| file.write_all(b"two")).unwrap_err();
        assert_eq!(again.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(names(folder.path()), ["a.slo"]);
    }

    #[test]
    fn a_failure_keeps_the_older_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "older").unwrap();
        let failed = write_atomically(&path, |file| {
            file.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"older");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn leftovers_of_one_file_can_be_removed() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other] = ["a.png", "b.png"].map(|name| folder.path().join(name));
        let leave = |path| drop(temporary_beside(path).unwrap().keep().unwrap());
        leave(&one);
        leave(&one);
        fs::write(&one, "whole").unwrap();
        leave(&other);
        remove_leftovers(&one);
        assert_eq!(names(folder.path()).len(), 2);
        remove_leftovers(&other);
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn what_nobody_writes_any_more_goes_away() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let long_ago = std::time::SystemTime::now() - 2 * STARTING;
        // Of a writer that was killed long ago, of one that is slow, and of one that has just begun.
        let killed = temporary_beside(&path).unwrap().keep().unwrap().0;
        killed.set_modified(long_ago).unwrap();
        drop(killed);
        let slow = temporary_beside(&path).unwrap();
        slow.as_file().set_modified(long_ago).unwrap();
        drop(temporary_beside(&path).unwrap().keep().unwrap());
        assert_eq!(names(folder.path()).len(), 3);
        write_atomically(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(names(folder.path()).len(), 3);
        assert!(slow.path().exists() && path.exists());
    }

    #[test]
    fn what_killed_writers_left_of_several_files_can_be_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let long_ago = std::time::SystemTime::now() - 2 * STARTING;
        for (name, is_old) in
            [("a.png", true), ("b.png", true), ("a.state", false), ("c.png", true)]
        {
            let left = temporary_beside(&path(name)).unwrap().keep().unwrap().0;
            if is_old {
                left.set_modified(long_ago).unwrap();
            }
        }
        assert_eq!(names(folder.path()).len(), 4);
        sweep_abandoned(folder.path(), ["a.png", "a.state", "b.png"].map(path));
        // One is too young, and one is of another file.
        assert_eq!(names(folder.path()).len(), 2);
        sweep_abandoned(folder.path(), ["c.png"].map(path));
        assert_eq!(names(folder.path()).len(), 1);
    }

    #[test]
    fn checking_makes_folders_and_no_file() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("a/b/c.png")).unwrap();
        assert_eq!(names(&folder.path().join("a/b")), Vec::<String>::new());
    }

    #[test]
    fn checking_finds_what_is_in_the_way() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(check_writable(&file.join("a.png")).is_err());
        assert!(check_writable(folder.path()).is_err());
        let opened = open_regular(folder.path()).unwrap_err();
        assert_eq!(opened.kind(), io::ErrorKind::IsADirectory);
        let long = "x".repeat(300);
        assert!(check_writable(&folder.path().join(long)).is_err());
        assert!(write_atomically(&folder.path().join("none/a.png"), |_| Ok(())).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_neither_replaced_nor_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        for path in [&pipe, &link] {
            assert!(check_writable(path).is_err());
            assert!(write_atomically(path, |_| Ok(())).is_err());
            assert!(open_regular(path).is_err());
        }
        let mut names = names(folder.path());
        names.sort_unstable();
        assert_eq!(names, ["link", "pipe"]);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }

    #[test]
    fn errors_are_the_words_of_the_system() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none/a.png");
        let error = write_atomically(&missing, |_| Ok(())).unwrap_err();
        assert!(error.raw_os_error().is_some(), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_what_they_may_read_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| {
            fs::metadata(folder.path().join(name)).unwrap().permissions().mode() & 0o777
        };
        fs::write(folder.path().join("plain"), "").unwrap();
        write_atomically(&folder.path().join("ours"), |_| Ok(())).unwrap();
        assert_eq!(mode("ours"), mode("plain"));
    }
}
