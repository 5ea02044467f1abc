//! Maps that are written beside the picture of a frame.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use super::counted::{self, Counted};
use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::files::paths::{check_path, place};
use crate::cli::system::patience;
use crate::cli::values::{Map, Maps};
use slo_picture::film::{Area, Display, Film};
use slo_picture::output::{write_cost_map, write_error_map, write_sample_map};

/// Checks before rendering whether the maps of the frames can be written to paths of their own.
/// Each frame comes with the path of its picture.
///
/// # Errors
/// Two files have the same path, or something is in the way.
pub(super) fn check<'a>(
    maps: &Maps,
    frames: impl Iterator<Item = (i64, &'a Path)> + Clone,
) -> Result<(), Problem> {
    if maps.is_empty() {
        return Ok(());
    }
    let picture = |(frame, path): (i64, &Path)| (place(path), format!("picture {frame}"));
    let mut taken: HashMap<PathBuf, String> = frames.clone().map(picture).collect();
    for (frame, _) in frames {
        for (map, path) in maps.all() {
            let (option, path) = (map.option(), path.of(frame));
            if let Some(other) = taken.insert(place(&path), option.into()) {
                let message = format!("{option} and {other} are both `{}`", path.display());
                return Err(Problem::new(Exit::Usage, message));
            }
            match map {
                Map::Counts => counted::check_path(&path)?,
                _ => check_path(&path)?,
            }
        }
    }
    Ok(())
}

/// Writes the maps of a frame, for an area of its picture, as soon as there is room for them.
///
/// # Errors
/// The path that can't be written, and the I/O error.
pub(super) fn write(
    maps: &Maps,
    frame: i64,
    film: &Film,
    counted: Option<&Counted>,
    (area, whole): (Area, Area),
    display: Display,
    terminal: Terminal,
) -> Result<(), (PathBuf, io::Error)> {
    for (map, path) in maps.all() {
        let path = path.of(frame);
        let write = || match map {
            Map::Samples => write_sample_map(&path, film, area, whole),
            Map::Error => write_error_map(&path, film, area, whole, display),
            Map::Cost => counted.map_or(Ok(()), |counted| {
                write_cost_map(&path, area, whole, &counted.costs(film, area, whole))
            }),
            Map::Counts => counted.map_or(Ok(()), |counted| counted.write(&path)),
        };
        patience::write(&path, terminal, write).map_err(|error| (path.clone(), error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn maps(samples: &Path, error: &Path) -> Maps {
        let path = |path: &Path| Some(path.to_str().unwrap().parse().unwrap());
        Maps { samples: path(samples), error: path(error), ..Maps::default() }
    }

    #[test]
    fn every_file_has_a_path_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let picture = at("a_00012.png");
        let checked = |samples: &str, error: &str| {
            let frames = [(12, &*picture), (7, Path::new("other.png"))];
            let found = check(&maps(&at(samples), &at(error)), frames.into_iter());
            found.map_err(|problem| (problem.exit, problem.message))
        };
        assert_eq!(checked("new/n_####.png", "e_####.png"), Ok(()));
        assert!(at("new").is_dir());
        assert_eq!(checked("a_#.png", "a_##.png").unwrap_err().0, Exit::Usage, "12 is 12");
        let (exit, message) = checked("new/../a_#####.png", "e_####.png").unwrap_err();
        assert_eq!(exit, Exit::Usage);
        assert!(message.contains("--sample-map and picture 12"), "{message}");
        fs::write(at("n_0012.png"), "a photo").unwrap();
        assert_eq!(checked("n_####.png", "e_####.png").unwrap_err().0, Exit::CantCreate);
        fs::write(at("file"), "").unwrap();
        assert_eq!(checked("file/n_####.png", "e_####.png").unwrap_err().0, Exit::CantCreate);
    }
}
