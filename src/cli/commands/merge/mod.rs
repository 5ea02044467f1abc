//! `merge`: makes pictures from their parts.

mod part_names;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::args::MergeArgs;
use crate::cli::base::{Exit, Problem, Terminal, counted, print};
use crate::cli::files::new_folders::NewFolders;
use part_names::missing;
use slo_accel::Isa;
use slo_picture::film::{Area, Display, FileLayer, Layer, MergeError, Merger, Subject};
use slo_picture::output::{
    Crop, Outcome, Picture, check_writable, layers_of, read_state, read_subject, settings_of,
    with_outcome, with_region,
};
use slo_scene::{Look, OutputFormat};

/// Merges the parts of each frame, and prints the paths of the pictures.
pub(crate) fn run(args: &MergeArgs, terminal: Terminal) -> Result<(), Problem> {
    let parts = args.files.iter().map(|path| Part::read(path)).collect::<Result<Vec<_>, _>>()?;
    let mut frames: BTreeMap<i64, Vec<Part>> = BTreeMap::new();
    for part in parts {
        frames.entry(part.number("frame") as i64).or_default().push(part);
    }
    for parts in frames.values() {
        check_alike(parts)?;
    }
    let outdir = args.outdir.as_deref().unwrap_or(Path::new(""));
    let pictures = frames.values().map(|parts| Whole::of(parts, outdir));
    let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
    let _folders: Vec<_> = pictures.iter().map(|picture| NewFolders::of(&picture.path)).collect();
    check_paths(&pictures)?;
    for picture in pictures {
        picture.save()?;
        let (count, path) = (picture.parts.len(), &picture.path);
        terminal.note(format_args!("merged {} into `{}`", counted(count, "part"), path.display()));
        print(path.as_os_str().as_encoded_bytes()).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't print the picture's path: {error}"))
        })?;
    }
    Ok(())
}

/// The file of a part, before its samples are read.
struct Part {
    path: PathBuf,
    subject: Subject,
    recipe: Value,
}

impl Part {
    fn read(path: &Path) -> Result<Self, Problem> {
        let (subject, is_complete) =
            read_subject(path).map_err(|error| unreadable(path, &error))?;
        let shown = path.display();
        if !is_complete {
            let message = format!("`{shown}` is a checkpoint of an unfinished part");
            return Err(Problem::new(Exit::BadInput, message)
                .with_help("finish it with the command that makes the part"));
        }
        let recipe = serde_json::from_str(&subject.recipe).unwrap_or(Value::Null);
        let part = Self { path: path.to_owned(), subject, recipe };
        match part.recipe["version"].as_str() {
            Some(env!("CARGO_PKG_VERSION")) => Ok(part),
            other => {
                let version = other.unwrap_or("of unknown version");
                let message = format!(
                    "`{shown}` was made by slo-rt {version}, but this is {}",
                    env!("CARGO_PKG_VERSION")
                );
                Err(Problem::new(Exit::BadInput, message))
            }
        }
    }

    fn number(&self, key: &str) -> f64 {
        self.recipe[key].as_f64().unwrap_or(0.0)
    }

    /// Returns the name of the part's picture, without the extension.
    fn stem(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let known = name.rsplit_once(".pixels-").or_else(|| name.rsplit_once(".samples-"));
        known.map_or(&*name, |(stem, _)| stem).to_owned()
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> Problem {
    let exit = match error.kind() {
        std::io::ErrorKind::InvalidData => Exit::BadInput,
        std::io::ErrorKind::OutOfMemory => Exit::Failed,
        _ => Exit::NoInput,
    };
    Problem::new(exit, format!("can't read the part `{}`: {error}", path.display()))
}

/// Checks that all parts belong to the same picture.
fn check_alike(parts: &[Part]) -> Result<(), Problem> {
    let first = &parts[0];
    for part in parts {
        let lines = part.subject.recipe.lines().zip(first.subject.recipe.lines());
        let mut different = lines.filter(|(a, b)| a != b).map(|(line, _)| line);
        if part.subject.recipe != first.subject.recipe {
            let line = different.next().unwrap_or("more settings");
            let line = line.trim().trim_end_matches(',').replace('"', "");
            let (one, other) = (part.path.display(), first.path.display());
            let message = format!("`{one}` belongs to another picture than `{other}`: {line}");
            return Err(Problem::new(Exit::BadInput, message));
        }
    }
    Ok(())
}

/// The picture that the parts of one frame make.
struct Whole<'a> {
    parts: &'a [Part],
    path: PathBuf,
    crop: Option<Crop>,
    region: Area,
    format: OutputFormat,
    look: Look,
    layers: Vec<Layer>,
}

impl<'a> Whole<'a> {
    fn of(parts: &'a [Part], outdir: &Path) -> Result<Self, Problem> {
        let (first, whole) = (&parts[0], whole(&parts[0])?);
        let (Some((format, look)), Some(layers)) =
            (settings_of(&first.recipe), layers_of(&first.recipe))
        else {
            return Err(no_recipe(first));
        };
        let region = first.subject.region;
        let is_region = parts.iter().all(|part| part.subject.region == region);
        let crop = Crop::of(region, whole).filter(|_| is_region);
        let region = crop.map_or(whole, |crop| crop.area);
        let stem = first.stem();
        let stem = if crop.is_some() { &stem } else { without_region(&stem) };
        let path = outdir.join(format!("{stem}.{}", format.extension()));
        Ok(Self { parts, path, crop, region, format, look, layers })
    }

    fn save(&self) -> Result<(), Problem> {
        let Self { region, format, look, crop, .. } = *self;
        let film = film(self.parts, region)?;
        let recipe = self.parts[0].subject.recipe.clone();
        let recipe = crop.map_or(recipe.clone(), |_| with_region(recipe, region));
        let outcome = Outcome::of(&film, region, Display::of(format, look), Isa::best());
        let recipe = with_outcome(&recipe, &outcome);
        let image = film.image();
        let layers = FileLayer::all(&self.layers, &film.layer_names());
        let layers = film.layers_of(region, layers);
        let picture = Picture { image: &image, format, look, recipe: &recipe, crop };
        picture.save_with(&self.path, &layers).map_err(|error| {
            let path = self.path.display();
            Problem::new(Exit::CantWrite, format!("can't write `{path}`: {error}"))
        })
    }
}

/// Checks that each picture has a path of its own and can be written.
fn check_paths(pictures: &[Whole]) -> Result<(), Problem> {
    let mut taken = BTreeMap::new();
    for Whole { path, parts, .. } in pictures {
        let (shown, part) = (path.display(), &parts[0].path);
        if let Some(other) = taken.insert(path, part) {
            let (part, other) = (part.display(), other.display());
            let message = format!(
                "`{part}` and `{other}` belong to different frames, but both would become `{shown}`"
            );
            return Err(Problem::new(Exit::BadInput, message));
        }
        check_writable(path).map_err(|error| {
            Problem::new(Exit::CantCreate, format!("can't create `{shown}`: {error}"))
        })?;
    }
    Ok(())
}

fn film(parts: &[Part], region: Area) -> Result<slo_picture::film::Film, Problem> {
    let first = &parts[0].subject;
    let subject = Subject { area: region, region, samples: None, ..first.clone() };
    let all = parts[0].number("imageSamples") * parts[0].number("dofSamples");
    // If the parts together do not have enough pixels, nothing is read and no memory is allocated.
    let own = |part: &Part| part.subject.region.common(&region).len();
    let most: usize = parts.iter().map(own).sum();
    if most < region.len() {
        let lacking = counted(region.len() - most, "pixel");
        return Err(incomplete(parts, format!("{lacking} or more")));
    }
    let mut merger =
        Merger::new(&subject, all as u32).map_err(|error| explain(error.into(), parts))?;
    for (i, part) in parts.iter().enumerate() {
        let state = read_state(&part.path).map_err(|error| unreadable(&part.path, &error))?;
        merger.add(i, &state).map_err(|error| explain(error, parts))?;
    }
    merger.finish().map_err(|error| explain(error, parts))
}

/// Returns the area of the whole picture that a part belongs to.
fn whole(part: &Part) -> Result<Area, Problem> {
    let side = |key: &str| part.recipe[key].as_u64().and_then(|n| u32::try_from(n).ok());
    match (side("width"), side("height")) {
        (Some(width), Some(height)) => Ok(Area::whole(width, height)),
        _ => Err(no_recipe(part)),
    }
}

fn no_recipe(part: &Part) -> Problem {
    let message = format!("`{}` does not say which picture it is part of", part.path.display());
    Problem::new(Exit::BadInput, message)
}

fn without_region(stem: &str) -> &str {
    stem.rsplit_once("_region=").map_or(stem, |(stem, _)| stem)
}

fn explain(error: MergeError, parts: &[Part]) -> Problem {
    let name = |i: usize| parts[i].path.display();
    let message = match error {
        MergeError::Gap { pixels, first: (x, y), samples } => {
            let of = match samples.map(|range| (range.start, range.end - 1)) {
                None => String::new(),
                Some((first, last)) if first == last => format!("sample {first} of "),
                Some((first, last)) => format!("samples {first} to {last} of "),
            };
            let pixels = counted(pixels, "pixel");
            let first = if pixels == "1 pixel" { "" } else { "the first " };
            return incomplete(parts, format!("{of}{pixels}, {first}in column {x} of row {y}"));
        }
        MergeError::Overlap { parts: [a, b], at: (x, y) } => format!(
            "`{}` and `{}` have the same pixels, such as column {x} of row {y}",
            name(a),
            name(b)
        ),
        MergeError::TooBright => "the sums of the parts are larger than any rendering makes".into(),
        MergeError::TooLarge(error) => {
            let size = error.bytes as f64 / 1e9;
            let message = format!("not enough memory: the picture needs {size:.1} GB");
            return Problem::new(Exit::Failed, message);
        }
    };
    Problem::new(Exit::BadInput, message).with_help(there_are(parts))
}

/// Makes the problem that parts are missing, and with them `what`.
fn incomplete(parts: &[Part], what: String) -> Problem {
    let paths = parts.iter().filter_map(|part| part.path.file_name()?.to_str());
    let missing = missing(paths).unwrap_or_else(|| "a part is missing".into());
    let message = format!("{missing}: {what}");
    Problem::new(Exit::BadInput, message).with_help(there_are(parts))
}

/// Says how many parts were given.
fn there_are(parts: &[Part]) -> String {
    let stem = parts.first().map(Part::stem).unwrap_or_default();
    match parts.len() {
        1 => format!("there is one part of `{stem}`"),
        count => format!("there are {count} parts of `{stem}`"),
    }
}
