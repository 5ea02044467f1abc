//! Finds the file that `--scene` names, and the folder that its paths may not leave.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use crate::cli::base::{Exit, Problem};
use crate::cli::options::Job;

/// Maximum length of a scene text in bytes. A longer file is no scene: meshes have files of their
/// own.
const LONGEST_TEXT: u64 = 1 << 28;

/// A scene file that was found and read.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct SceneFile {
    /// Path of the file, as messages show it.
    pub(crate) path: PathBuf,
    /// The folder that its paths may not leave.
    pub(crate) root: PathBuf,
    pub(crate) text: Vec<u8>,
}

/// Reads the scene file at `scene`.
///
/// With `--indir`, the path starts there, and the scene's paths stay there. Without it, they stay
/// in the current folder if the scene lies inside it, and in the scene's own folder otherwise.
pub(crate) fn read(scene: &Path, job: &Job) -> Result<SceneFile, Problem> {
    let path = path_of(scene, job);
    let root = match &job.indir {
        Some(indir) => indir.clone(),
        None => root_without_indir(&path),
    };
    if !job.allow_outside && !lies_inside(&path, &root) {
        let message = format!("the scene `{}` is outside of `{}`", scene.display(), root.display());
        return Err(Problem::new(Exit::Usage, message).with_help(
            "set `--indir` to a folder that holds all files of the scene, or give `--allow-outside`",
        ));
    }
    let text = read_text(&path)?;
    Ok(SceneFile { path, root, text })
}

/// Returns the path of the scene file that the job calls `scene`.
pub(crate) fn path_of(scene: &Path, job: &Job) -> PathBuf {
    job.indir.as_deref().unwrap_or(Path::new("")).join(scene)
}

fn root_without_indir(path: &Path) -> PathBuf {
    let current = std::env::current_dir().unwrap_or_default();
    match path.parent() {
        Some(folder) if !lies_inside(path, &current) => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Whether the file `path` lies inside `folder`.
fn lies_inside(path: &Path, folder: &Path) -> bool {
    path.parent().is_some_and(|parent| place(parent).starts_with(place(folder)))
}

/// Returns a folder's path from the root of the file system: without links if it exists, and
/// without dots in any case.
fn place(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = folder.canonicalize().or_else(|_| std::path::absolute(folder));
    without_dots(&absolute.unwrap_or_else(|_| folder.to_owned()))
}

/// Resolves `.` and `..` in an absolute path.
fn without_dots(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut result, component| {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                result.pop();
            }
            other => result.push(other),
        }
        result
    })
}

fn read_text(path: &Path) -> Result<Vec<u8>, Problem> {
    text(path).map_err(|error| match error.kind() {
        io::ErrorKind::FileTooLarge => {
            let message =
                format!("`{}` is not a scene file: it is longer than 256 MiB", path.display());
            Problem::new(Exit::BadInput, message)
        }
        _ => unreadable(path, &error),
    })
}

/// Reads the text of a scene.
///
/// # Errors
/// `FileTooLarge` for what can't be a scene, and any other I/O error.
pub(crate) fn text(path: &Path) -> io::Result<Vec<u8>> {
    limited(open(path)?)
}

/// Reads what may be the text of a scene to its end, as [`text`] does.
pub(crate) fn limited(reader: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(LONGEST_TEXT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST_TEXT {
        return Err(io::ErrorKind::FileTooLarge.into());
    }
    Ok(bytes)
}

/// Opens a file. Refuses folders, which some systems can open too.
fn open(path: &Path) -> io::Result<File> {
    let file = File::open(path)?;
    if file.metadata()?.is_dir() { Err(io::ErrorKind::IsADirectory.into()) } else { Ok(file) }
}

fn unreadable(path: &Path, error: &io::Error) -> Problem {
    let shown = path.display();
    let exit = match error.kind() {
        io::ErrorKind::OutOfMemory => Exit::Failed,
        _ => Exit::NoInput,
    };
    let problem = Problem::new(exit, format!("can't read the scene `{shown}`: {error}"));
    match error.kind() {
        io::ErrorKind::NotFound => similar(path).into_iter().fold(problem, |problem, name| {
            problem.with_help(format!("did you mean `{}`?", name.display()))
        }),
        _ => problem,
    }
}

/// Returns up to three files in the folder of `path` whose names are similar to its name, the most
/// similar first.
fn similar(path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let Ok(entries) = fs::read_dir(folder.unwrap_or(Path::new("."))) else { return Vec::new() };
    let wanted = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut found: Vec<(f64, PathBuf)> = entries
        .take(10_000)
        .flatten()
        .filter(|entry| !entry.path().is_dir())
        .map(|entry| entry.file_name())
        .map(|name| (likeness(&wanted, &name.to_string_lossy().to_lowercase()), name))
        .filter(|(likeness, _)| *likeness > 0.75)
        .map(|(likeness, name)| (likeness, path.with_file_name(name)))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    found.into_iter().take(3).map(|(_, path)| path).collect()
}

/// Returns the similarity of two names: 1 for the same name, 0 for names with nothing in common. A
/// forgotten extension counts little.
fn likeness(wanted: &str, name: &str) -> f64 {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    strsim::normalized_damerau_levenshtein(wanted, name)
        .max(strsim::normalized_damerau_levenshtein(wanted, stem) - 0.01)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::options::job;

    fn scene_folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("scenes")).unwrap();
        for name in ["table.txt", "tables.txt", "rose.txt"] {
            fs::write(folder.path().join("scenes").join(name), "žluťoučký").unwrap();
        }
        folder
    }

    fn helps(scene: &Path) -> Vec<String> {
        let problem = read(scene, &job()).unwrap_err();
        assert_eq!(problem.exit, Exit::NoInput);
        problem.help
    }

    #[test]
    fn indir_holds_the_scene() {
        let folder = scene_folder();
        let job = Job { indir: Some(folder.path().into()), ..job() };
        let found = read(Path::new("scenes/table.txt"), &job).unwrap();
        assert_eq!(found.path, folder.path().join("scenes/table.txt"));
        assert_eq!(found.root, folder.path());
        assert_eq!(found.text, "žluťoučký".as_bytes());
    }

    #[test]
    fn a_scene_outside_of_the_current_folder_has_its_own_as_root() {
        let folder = scene_folder();
        let found = read(&folder.path().join("scenes/table.txt"), &job()).unwrap();
        assert_eq!(found.root, folder.path().join("scenes"));
    }

    #[test]
    fn a_scene_inside_the_current_folder_has_that_as_root() {
        let found = read(Path::new("src/../Cargo.toml"), &job()).unwrap();
        assert_eq!(found.root, Path::new("."));
        let absolute = std::path::absolute("src/lib.rs").unwrap();
        assert_eq!(read(&absolute, &job()).unwrap().root, Path::new("."));
    }

    #[test]
    fn a_scene_that_leaves_indir_needs_permission() {
        let folder = scene_folder();
        let inside = Job { indir: Some(folder.path().join("scenes")), ..job() };
        fs::write(folder.path().join("outside.txt"), "").unwrap();
        let scene = Path::new("../outside.txt");
        let problem = read(scene, &inside).unwrap_err();
        assert_eq!(problem.exit, Exit::Usage);
        assert!(
            problem.help[0].contains("`--indir`") && problem.help[0].contains("`--allow-outside`")
        );
        let absolute = folder.path().join("outside.txt");
        assert_eq!(read(&absolute, &inside).unwrap_err().exit, Exit::Usage);
        let allowed = Job { allow_outside: true, ..inside };
        assert!(read(scene, &allowed).is_ok() && read(&absolute, &allowed).is_ok());
    }

    #[test]
    fn an_absolute_scene_inside_indir_is_fine() {
        let folder = scene_folder();
        let job = Job { indir: Some(folder.path().into()), ..job() };
        assert!(read(&folder.path().join("scenes/rose.txt"), &job).is_ok());
    }

    #[test]
    fn missing_scenes_get_suggestions() {
        let scenes = scene_folder().keep().join("scenes");
        let expected = |name: &str| format!("did you mean `{}`?", scenes.join(name).display());
        assert_eq!(helps(&scenes.join("tabel.txt"))[0], expected("table.txt"));
        assert_eq!(helps(&scenes.join("Table")), [expected("table.txt"), expected("tables.txt")]);
        assert_eq!(helps(&scenes.join("dragonfly.txt")), [""; 0]);
        assert_eq!(helps(&scenes.join("none/table.txt")), [""; 0]);
        assert_eq!(helps(&scenes), [""; 0], "a folder");
        fs::remove_dir_all(scenes.parent().unwrap()).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn an_endless_file_ends() {
        let problem = read(Path::new("/dev/zero"), &job()).unwrap_err();
        assert_eq!(problem.exit, Exit::BadInput);
    }
}
