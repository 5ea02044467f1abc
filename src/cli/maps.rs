//! `--sample-map`, `--error-map`: pictures of how a picture came about; and what holds for all files
//! that are written beside the pictures.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Exit;
use super::args::FramePath;
use super::patience;
use super::problem::Problem;
use super::terminal::Terminal;
use crate::film::{Area, Display, Film};
use crate::output::{check_companion, map_format, write_error_map, write_sample_map};

/// The maps that are written with each picture.
#[derive(Clone, Debug, Default)]
pub(super) struct Maps {
    pub(super) samples: Option<FramePath>,
    pub(super) error: Option<FramePath>,
}

const SAMPLES: &str = "--sample-map";
const ERROR: &str = "--error-map";

impl Maps {
    fn all(&self) -> impl Iterator<Item = (&'static str, &FramePath)> {
        let (samples, error) = (self.samples.iter(), self.error.iter());
        samples.map(|path| (SAMPLES, path)).chain(error.map(|path| (ERROR, path)))
    }

    /// Whether none is asked for.
    pub(super) fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// Whether the names are ones of maps, of `several` frames or of one.
    ///
    /// # Errors
    /// In words for the user.
    pub(super) fn check_names(&self, several: bool) -> Result<(), String> {
        for (option, path) in self.all() {
            check_name(option, &path.of(0))?;
            if several && !path.tells_frames() {
                return Err(format!("{option}: a map of each frame needs `####` in its path"));
            }
        }
        Ok(())
    }

    /// Finds out, before anything is rendered, whether the maps of the frames can be written, where
    /// nothing else goes. Each frame comes with the path of its picture.
    ///
    /// # Errors
    /// Two files of one name; what is in the way.
    pub(super) fn check<'a>(
        &self,
        frames: impl Iterator<Item = (i64, &'a Path)> + Clone,
    ) -> Result<(), Problem> {
        if self.all().next().is_none() {
            return Ok(());
        }
        let picture = |(frame, path): (i64, &Path)| (place(path), format!("picture {frame}"));
        let mut taken: HashMap<PathBuf, String> = frames.clone().map(picture).collect();
        for (frame, _) in frames {
            for (option, path) in self.all() {
                let path = path.of(frame);
                if let Some(other) = taken.insert(place(&path), option.into()) {
                    let message = format!("{option} and {other} are both `{}`", path.display());
                    return Err(Problem::new(Exit::Usage, message));
                }
                check_path(&path)?;
            }
        }
        Ok(())
    }

    /// Writes the maps of a frame, as soon as there is room for them: of an area of a picture.
    ///
    /// # Errors
    /// The path that can't be written, and what the system says.
    pub(super) fn write(
        &self,
        frame: i64,
        film: &Film,
        (area, whole): (Area, Area),
        display: Display,
        terminal: Terminal,
    ) -> Result<(), (PathBuf, io::Error)> {
        for (option, path) in self.all() {
            let path = path.of(frame);
            let write = || match option {
                SAMPLES => write_sample_map(&path, film, area, whole),
                _ => write_error_map(&path, film, area, whole, display),
            };
            patience::write(&path, terminal, write).map_err(|error| (path.clone(), error))?;
        }
        Ok(())
    }
}

/// Whether a file can be a map by its name; `option` names it.
///
/// # Errors
/// In words for the user.
pub(super) fn check_name(option: &str, path: &Path) -> Result<(), String> {
    match map_format(path) {
        Some(_) => Ok(()),
        None => {
            let path = path.display();
            Err(format!("{option}: a map is a .png or .exr file, and `{path}` is neither"))
        }
    }
}

/// Whether a map or a sheet can be written to a path.
///
/// # Errors
/// What is in the way.
pub(super) fn check_path(path: &Path) -> Result<(), Problem> {
    check_companion(path).map_err(|error| {
        let problem =
            Problem::new(Exit::CantCreate, format!("can't create `{}`: {error}", path.display()));
        match error.kind() {
            io::ErrorKind::AlreadyExists => problem.with_help("remove it, or give another name"),
            _ => problem,
        }
    })
}

/// Refuses a path that is one of `inputs`, which are read.
///
/// # Errors
/// The one that it is.
pub(super) fn check_distinct<'a>(
    path: &Path,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), Problem> {
    let own = place(path);
    match inputs.into_iter().find(|input| place(input) == own) {
        Some(input) => {
            let message = format!("`{}` would be replaced, and it is read", input.display());
            Err(Problem::new(Exit::Usage, message))
        }
        None => Ok(()),
    }
}

/// A path by which a file is known whatever way leads to it, as far as its folders are there.
fn place(path: &Path) -> PathBuf {
    let in_folder = || {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
        Some(folder.join(path.file_name()?))
    };
    let there = fs::canonicalize(path).ok().or_else(in_folder);
    there.or_else(|| std::path::absolute(path).ok()).unwrap_or_else(|| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(samples: &Path, error: &Path) -> Maps {
        let path = |path: &Path| Some(path.to_str().unwrap().parse().unwrap());
        Maps { samples: path(samples), error: path(error) }
    }

    #[test]
    fn names_are_checked_without_the_disk() {
        let check = |samples: &str, several: bool| {
            maps(Path::new(samples), Path::new("e_#.exr")).check_names(several)
        };
        assert_eq!(check("n.png", false), Ok(()));
        assert_eq!(check("n_####.EXR", true), Ok(()));
        assert!(check("n.png", true).unwrap_err().contains("--sample-map"));
        let message = check("n.jpg", false).unwrap_err();
        assert_eq!(message, "--sample-map: a map is a .png or .exr file, and `n.jpg` is neither");
    }

    #[test]
    fn every_file_has_a_path_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let picture = at("a_00012.png");
        let check = |samples: &str, error: &str| {
            let frames = [(12, &*picture), (7, Path::new("other.png"))];
            let checked = maps(&at(samples), &at(error)).check(frames.into_iter());
            checked.map_err(|problem| (problem.exit, problem.message))
        };
        assert_eq!(check("new/n_####.png", "e_####.png"), Ok(()));
        assert!(at("new").is_dir());
        assert_eq!(check("a_#.png", "a_##.png").unwrap_err().0, Exit::Usage, "12 is 12");
        let (exit, message) = check("new/../a_#####.png", "e_####.png").unwrap_err();
        assert_eq!(exit, Exit::Usage);
        assert!(message.contains("--sample-map and picture 12"), "{message}");
        fs::write(at("n_0012.png"), "a photo").unwrap();
        assert_eq!(check("n_####.png", "e_####.png").unwrap_err().0, Exit::CantCreate);
        fs::write(at("file"), "").unwrap();
        assert_eq!(check("file/n_####.png", "e_####.png").unwrap_err().0, Exit::CantCreate);
    }
}
