//! `--sample-map`, `--error-map`, `--cost-map`, `--count`: files that show how a picture was made.

use std::path::Path;

use super::frame_path::FramePath;
use slo_picture::output::map_format;

/// The maps that are written with each picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Maps {
    pub(crate) samples: Option<FramePath>,
    pub(crate) error: Option<FramePath>,
    pub(crate) cost: Option<FramePath>,
    pub(crate) counts: Option<FramePath>,
}

/// What a map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Map {
    /// How many samples each pixel took.
    Samples,
    /// The estimated error of each pixel.
    Error,
    /// What the rays of each pixel cost.
    Cost,
    /// What rays took in the structures: not a map, but a table.
    Counts,
}

impl Map {
    /// Returns the option that asks for the map.
    pub(crate) fn option(self) -> &'static str {
        match self {
            Self::Samples => "--sample-map",
            Self::Error => "--error-map",
            Self::Cost => "--cost-map",
            Self::Counts => "--count",
        }
    }
}

impl Maps {
    /// Returns the maps that are asked for, and their paths.
    pub(crate) fn all(&self) -> impl Iterator<Item = (Map, &FramePath)> {
        let all = [
            (Map::Samples, &self.samples),
            (Map::Error, &self.error),
            (Map::Cost, &self.cost),
            (Map::Counts, &self.counts),
        ];
        all.into_iter().filter_map(|(map, path)| Some((map, path.as_ref()?)))
    }

    /// Whether rays are counted.
    pub(crate) fn counts_rays(&self) -> bool {
        self.cost.is_some() || self.counts.is_some()
    }

    /// Whether no map is asked for.
    pub(crate) fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// Checks the names of the maps of one frame, or of `several`.
    ///
    /// # Errors
    /// What is wrong, in words for the user.
    pub(crate) fn check_names(&self, several: bool) -> Result<(), String> {
        for (map, path) in self.all() {
            let option = map.option();
            match map {
                Map::Counts => check_table(option, &path.of(0))?,
                _ => check_name(option, &path.of(0))?,
            }
            if several && !path.tells_frames() {
                return Err(format!("{option}: maps of several frames need `####` in their path"));
            }
        }
        Ok(())
    }
}

/// Checks whether a file can be a table by its name.
fn check_table(option: &str, path: &Path) -> Result<(), String> {
    let is_json = path.extension().is_some_and(|name| name.eq_ignore_ascii_case("json"));
    let name = path.display();
    is_json.then_some(()).ok_or_else(|| format!("{option}: `{name}` is not named as a .json file"))
}

/// Checks whether a file can be a map by its name. `option` is the option that names the file.
///
/// # Errors
/// What is wrong, in words for the user.
pub(crate) fn check_name(option: &str, path: &Path) -> Result<(), String> {
    match map_format(path) {
        Some(_) => Ok(()),
        None => {
            let path = path.display();
            Err(format!("{option}: a map is a .png or .exr file, and `{path}` is neither"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_checked_without_the_disk() {
        let check = |samples: &str, several: bool| {
            let path = |path: &str| Some(path.parse().unwrap());
            Maps { samples: path(samples), error: path("e_#.exr"), ..Maps::default() }
                .check_names(several)
        };
        assert_eq!(check("n.png", false), Ok(()));
        assert_eq!(check("n_####.EXR", true), Ok(()));
        assert!(check("n.png", true).unwrap_err().contains("--sample-map"));
        let counts = Maps { counts: "c.txt".parse().ok(), ..Maps::default() };
        assert!(counts.check_names(false).unwrap_err().contains("--count: `c.txt`"));
        let message = check("n.jpg", false).unwrap_err();
        assert_eq!(message, "--sample-map: a map is a .png or .exr file, and `n.jpg` is neither");
    }
}
