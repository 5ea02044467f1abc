//! All elements of a scene text and of the files that it includes.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use slo_scene::edit::{Outline, Part, Target, path_in};

/// Most files that a scene includes.
const MOST_FILES: usize = 1000;
/// Longest text of all files, in bytes.
const LONGEST: usize = 1 << 26;

/// A text with its place.
#[derive(Clone, Debug)]
pub(crate) struct File {
    /// The folder that its paths start in, seen from the scene that is shown.
    pub(super) folder: String,
    pub(super) text: String,
}

/// What a list of things calls an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sort {
    Object,
    Lamp,
    Material,
    Camera,
    /// What only other elements need: a `phong_info` or a `texture`.
    Part,
}

/// A word of an element that leads elsewhere.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) attribute: String,
    pub(super) target: Target,
    pub(super) word: String,
    pub(super) range: Range<usize>,
}

/// An element, or a segment of a camera.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    /// Index of its text.
    pub(super) file: usize,
    pub(crate) sort: Sort,
    pub(crate) keyword: String,
    pub(crate) name: String,
    /// What words lead to it; `None` of a segment.
    pub(super) target: Option<Target>,
    pub(super) links: Vec<Link>,
    /// With its comments.
    pub(super) whole: Range<usize>,
    pub(super) range: Range<usize>,
    pub(super) name_range: Range<usize>,
}

/// All elements of a scene text and of the files that it includes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Catalog {
    pub(super) files: Vec<File>,
    pub(crate) things: Vec<Thing>,
    /// Indices of things by what leads to them and by their names; of two with a name, the first.
    by_name: BTreeMap<Target, BTreeMap<String, usize>>,
    /// Indices of what hangs in things, by the names of these.
    hanging: BTreeMap<String, Vec<usize>>,
    /// The factor of `Scaling`.
    pub(super) scaling: f64,
}

impl Catalog {
    /// Reads a text, whose paths start in a folder, and what it includes. `open` reads other files.
    ///
    /// # Errors
    /// A file can't be read.
    pub(crate) fn of(
        text: String,
        folder: &str,
        open: &dyn Fn(&str) -> Result<String, String>,
    ) -> Result<Self, String> {
        let mut catalog = Self { scaling: 1.0, ..Self::default() };
        let mut waiting = vec![(folder.to_owned(), text)];
        let mut known = BTreeSet::new();
        let mut length = 0;
        while let Some((folder, text)) = waiting.pop() {
            length += text.len();
            if known.len() > MOST_FILES || length > LONGEST {
                return Err("it and the files that it includes are too large".into());
            }
            let paths: Vec<String> =
                Outline::new(&text).includes().map(|path| path_in(&folder, path)).collect();
            catalog.add(File { folder, text });
            // The last one is read next.
            for path in paths.into_iter().rev() {
                if known.insert(path.clone()) {
                    waiting.push((folder_of(&path).to_owned(), open(&path)?));
                }
            }
        }
        Ok(catalog)
    }

    fn add(&mut self, file: File) {
        let index = self.files.len();
        self.files.push(file);
        let outline = Outline::new(&self.files[index].text);
        let mut found = Vec::new();
        for part in outline.elements() {
            if part.keyword() == "Camera" {
                let segments = part.parts("CamSegment");
                found.extend(segments.filter_map(|part| thing(&part, index)));
            } else if part.keyword() == "Scaling" {
                let numbers = part.own_numbers().unwrap_or_default();
                self.scaling = numbers.first().copied().unwrap_or(1.0);
            } else if part.target().is_some() {
                found.extend(thing(&part, index));
            }
        }
        found.into_iter().for_each(|thing| self.put(thing));
    }

    /// Index of what a name leads to.
    pub(super) fn find(&self, target: Target, name: &str) -> Option<usize> {
        self.by_name.get(&target)?.get(name).copied()
    }

    /// Indices of what hangs in a thing of a name.
    pub(super) fn hanging_in(&self, name: &str) -> &[usize] {
        self.hanging.get(name).map_or(&[], Vec::as_slice)
    }

    fn put(&mut self, thing: Thing) {
        let index = self.things.len();
        if let Some(target) = thing.target {
            self.by_name.entry(target).or_default().entry(thing.name.clone()).or_insert(index);
        }
        let parents = thing.links.iter().filter(|link| link.attribute == "parent");
        for parent in parents {
            self.hanging.entry(parent.word.clone()).or_default().push(index);
        }
        self.things.push(thing);
    }

    /// The text of a thing, without its comments.
    pub(super) fn text_of(&self, thing: &Thing) -> &str {
        self.files[thing.file].text.get(thing.range.clone()).unwrap_or_default()
    }
}

/// The folder of a path, with a `/` at its end unless it is empty.
pub(super) fn folder_of(path: &str) -> &str {
    &path[..path.rfind('/').map_or(0, |i| i + 1)]
}

fn thing(part: &Part<'_, '_>, file: usize) -> Option<Thing> {
    let keyword = part.keyword();
    let is_lamp = ["light_", "lamp_", "environment"].iter().any(|lamp| keyword.starts_with(lamp));
    let sort = match part.target() {
        None => Sort::Camera,
        Some(Target::Material) => Sort::Material,
        Some(Target::Object) if is_lamp => Sort::Lamp,
        Some(Target::Object) => Sort::Object,
        Some(_) => Sort::Part,
    };
    let link = |link: slo_scene::edit::Link<'_>| Link {
        attribute: link.attribute.to_owned(),
        target: link.target,
        word: link.word.to_owned(),
        range: link.range,
    };
    Some(Thing {
        file,
        sort,
        keyword: keyword.to_owned(),
        name: part.name()?.to_owned(),
        target: part.target(),
        links: part.links().into_iter().map(link).collect(),
        whole: part.with_comments(),
        range: part.range(),
        name_range: part.name_range()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn included_files_count_once_and_in_their_folders() {
        let open = |path: &str| match path {
            "sets/b.txt" => Ok("include c.txt include ../d.txt sphere b {}".to_owned()),
            "sets/c.txt" => Ok("include b.txt Scaling x { 3 } texture c {}".to_owned()),
            "d.txt" => Ok("lamp_sun d {}".to_owned()),
            _ => Err(format!("{path} is not there")),
        };
        let main = "include b.txt include c.txt\nCamera c { CamSegment s {} } settings s {}";
        let catalog = Catalog::of(main.into(), "sets/", &open).unwrap();
        let found: Vec<_> = catalog.things.iter().map(|of| (of.sort, &*of.name, of.file)).collect();
        let expected = [
            (Sort::Camera, "s", 0),
            (Sort::Object, "b", 1),
            (Sort::Lamp, "d", 2),
            (Sort::Part, "c", 3),
        ];
        assert_eq!(found, expected);
        assert_eq!((&*catalog.files[2].folder, catalog.scaling), ("", 3.0));
        assert!(Catalog::of("include e.txt".into(), "", &open).is_err());
    }
}
