//! `relight`: shows rendered pictures in another light: groups of lights dimmed or coloured, another
//! exposure, another file format.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::args::{LookArgs, RelightArgs};
use crate::cli::base::{Exit, Problem, Terminal, print};
use crate::cli::files::new_folders::NewFolders;
use crate::cli::files::pictures::{NO_PICTURE, read, unreadable};
use crate::cli::values::Gain;
use slo_picture::film::{FileLayer, Image};
use slo_picture::output::{
    Picture, Values, check_writable, is_companion, is_denoised, is_relit, made_by_others,
    read_layers, read_recipe, settings_of, with_look, with_relit,
};
use slo_scene::{Look, OutputFormat};

/// Relights the pictures one after the other, and prints the paths of the results.
pub(crate) fn run(args: &RelightArgs, terminal: Terminal) -> Result<(), Problem> {
    check_gains(&args.group)?;
    if args.output.is_some() && args.pictures.len() > 1 {
        let message = "`--output` names one file, but there are several pictures";
        return Err(Problem::new(Exit::Usage, message).with_help("name a folder with `--outdir`"));
    }
    for path in &args.pictures {
        let source = Source::read(path, &args.group)?;
        let target = Target::of(&source, args)?;
        let _folders = NewFolders::of(&target.path);
        check_target(path, &target.path)?;
        write(source, &target, &args.group)?;
        let (from, to) = (path.display(), target.path.display());
        terminal.note(format_args!("relit `{from}` as `{to}`"));
        print(target.path.as_os_str().as_encoded_bytes()).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't print the picture's path: {error}"))
        })?;
    }
    Ok(())
}

/// Checks that no group is named twice.
fn check_gains(gains: &[Gain]) -> Result<(), Problem> {
    for (i, gain) in gains.iter().enumerate() {
        if let Some(other) = gains[..i].iter().find(|other| other.group == gain.group) {
            let message = format!("`--group {other}` and `--group {gain}` name the same group");
            return Err(Problem::new(Exit::Usage, message));
        }
    }
    Ok(())
}

/// A picture that is relit.
struct Source<'a> {
    path: &'a Path,
    image: Image,
    crop: Option<slo_picture::output::Crop>,
    layers: Vec<(FileLayer, Image)>,
    recipe: String,
    /// The look that it was rendered for.
    look: Look,
}

impl<'a> Source<'a> {
    /// Reads a picture whose groups of lights are to be changed, if there are `gains`.
    fn read(path: &'a Path, gains: &[Gain]) -> Result<Self, Problem> {
        let shown = path.display();
        let bad = |why: String| Problem::new(Exit::BadInput, format!("`{shown}`: {why}"));
        let raster = read(path)?;
        if raster.values != Values::Linear {
            let why = "its values are those of a screen, but relighting needs linear ones";
            return Err(bad(why.into()).with_help("render the picture with `--format exr`"));
        }
        let recipe = read_recipe(path).map_err(|error| bad(error.to_string()))?;
        if is_companion(&recipe) {
            return Err(bad(NO_PICTURE.into()));
        }
        let parsed: Value =
            serde_json::from_str(&recipe).map_err(|error| bad(error.to_string()))?;
        if is_relit(&parsed) {
            return Err(bad(
                "it is relit already; relight the picture that it was made from".into()
            ));
        }
        if is_denoised(&parsed) && !gains.is_empty() {
            let why = "it is denoised, but the light of its groups still holds the noise";
            return Err(bad(why.into()).with_help("relight the picture that it was made from"));
        }
        let Some((_, look)) = settings_of(&parsed) else {
            return Err(bad("its recipe does not name a file format".into()));
        };
        let layers = read_layers(path).map_err(|error| {
            Problem::new(unreadable(&error), format!("can't read `{shown}`: {error}"))
        })?;
        Ok(Self { path, image: raster.image, crop: raster.crop, layers, recipe, look })
    }

    /// The names of its groups of lights.
    fn groups(&self) -> impl Iterator<Item = &str> {
        self.layers.iter().filter_map(|(layer, _)| match layer {
            FileLayer::Light(group) => Some(&**group),
            _ => None,
        })
    }

    /// Checks that the picture has the groups that are to be changed.
    fn check_groups(&self, gains: &[Gain]) -> Result<(), Problem> {
        let path = self.path.display();
        let has = |gain: &&Gain| self.groups().any(|group| group == gain.group);
        let Some(unknown) = gains.iter().find(|gain| !has(gain)) else { return Ok(()) };
        if self.groups().next().is_none() {
            let message = format!("`{path}` does not keep the light of groups apart");
            return Err(Problem::new(Exit::BadInput, message)
                .with_help("render it with `--format exr --layers lights`"));
        }
        let groups: Vec<_> = self.groups().map(|group| format!("`{group}`")).collect();
        let message = format!("`{path}` has no group of lights `{}`", unknown.group);
        Err(Problem::new(Exit::Usage, message)
            .with_help(format!("its groups are {}", groups.join(", "))))
    }

    /// Changes the light of groups, and the picture with it.
    fn relight(&mut self, gains: &[Gain]) -> Result<(), Problem> {
        self.check_groups(gains)?;
        if gains.is_empty() {
            return Ok(());
        }
        for (layer, image) in &mut self.layers {
            let FileLayer::Light(group) = layer else { continue };
            let Some(gain) = gains.iter().find(|gain| gain.group == *group) else { continue };
            for rgb in &mut image.rgb {
                *rgb = [0, 1, 2].map(|c| (f64::from(rgb[c]) * gain.factors[c]) as f32);
            }
        }
        let lights: Vec<&Image> = self
            .layers
            .iter()
            .filter(|(layer, _)| matches!(layer, FileLayer::Light(_)))
            .map(|(_, image)| image)
            .collect();
        if lights.iter().any(|image| image.rgb.len() != self.image.rgb.len()) {
            let message = format!("`{}`: its layers differ in size", self.path.display());
            return Err(Problem::new(Exit::BadInput, message));
        }
        for (i, rgb) in self.image.rgb.iter_mut().enumerate() {
            let sum = |c: usize| lights.iter().map(|image| f64::from(image.rgb[i][c])).sum::<f64>();
            *rgb = [0, 1, 2].map(|c| sum(c) as f32);
        }
        Ok(())
    }
}

/// The file that is written.
struct Target {
    path: PathBuf,
    format: OutputFormat,
    look: Look,
}

impl Target {
    fn of(source: &Source, args: &RelightArgs) -> Result<Self, Problem> {
        let asked = args.format.map(|name| name.0);
        let path = match &args.output {
            Some(output) => output.clone(),
            None => beside(source.path, args.outdir.as_deref(), asked.unwrap_or(OutputFormat::Exr)),
        };
        let extension = path.extension().and_then(|extension| extension.to_str());
        let named = extension.and_then(OutputFormat::by_extension);
        let format = match (asked, named) {
            (Some(asked), Some(named)) if asked.extension() == named.extension() => asked,
            (None, Some(named)) => named,
            (Some(asked), _) => return Err(other_extension(&path, &[asked.extension()])),
            (None, None) => return Err(other_extension(&path, &["png", "exr"])),
        };
        let LookArgs { exposure, tone_map, encoding } = args.look;
        let look = Look {
            exposure: exposure.unwrap_or(source.look.exposure),
            tone_map: tone_map.map_or(source.look.tone_map, |name| name.0),
            encoding: encoding.map_or(source.look.encoding, |name| name.0),
        };
        Ok(Self { path, format, look })
    }
}

fn other_extension(path: &Path, expected: &[&str]) -> Problem {
    let message = format!("`{}` does not end in .{}", path.display(), expected.join(" or ."));
    Problem::new(Exit::Usage, message)
}

/// The path of a result without `--output`: beside the picture under another name, or in another folder
/// under the same name.
fn beside(path: &Path, outdir: Option<&Path>, format: OutputFormat) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = format.extension();
    match outdir {
        Some(folder) => folder.join(format!("{stem}.{extension}")),
        None => path.with_file_name(format!("{stem}_relit.{extension}")),
    }
}

/// Checks that the result can be written, and replaces neither its source nor a file of another program.
fn check_target(path: &Path, target: &Path) -> Result<(), Problem> {
    let shown = target.display();
    check_writable(target).map_err(|error| {
        Problem::new(Exit::CantCreate, format!("can't create `{shown}`: {error}"))
    })?;
    if let (Ok(one), Ok(other)) = (path.canonicalize(), target.canonicalize())
        && one == other
    {
        let message = format!("`{shown}` would be replaced by its relit copy");
        return Err(Problem::new(Exit::Usage, message)
            .with_help("choose another name with `--output`, or a folder with `--outdir`"));
    }
    match made_by_others(target) {
        Some(why) => {
            let message =
                format!("can't create `{shown}`: slo-rt did not make the existing file ({why})");
            Err(Problem::new(Exit::CantCreate, message).with_help("move it away"))
        }
        None => Ok(()),
    }
}

fn write(mut source: Source, target: &Target, gains: &[Gain]) -> Result<(), Problem> {
    source.relight(gains)?;
    let &Target { ref path, format, look } = target;
    let recipe = with_look(&source.recipe, format, look);
    let recipe = match gains {
        [] => recipe,
        _ => {
            let gains: Vec<_> = gains.iter().map(Gain::to_string).collect();
            with_relit(&recipe, &gains.join("; "))
        }
    };
    let Source { image, crop, layers, .. } = &source;
    let picture = Picture { image, format, look, recipe: &recipe, crop: *crop };
    picture.save_with(path, layers).map_err(|error| {
        Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", path.display()))
    })
}
