//! Result that a run makes from each frame: its picture, the picture of a region, or a part of
//! either.

use std::fmt::{self, Display};
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::counted::Counted;
use super::maps;
use crate::cli::base::{Exit, Problem, Terminal};
use crate::cli::options::Job;
use crate::cli::values::{PartBy, Region};
use slo_picture::film::Steps;
use slo_picture::film::{Area, FileLayer, Film, FirstHitLayers, Layer, State, Subject, View};
use slo_picture::output::{
    Crop, Found, Info, Outcome, Picture, Recipe, file_name, find_picture, find_state,
    find_timed_picture, made_by_others, with_outcome, with_region, with_steps, write_state,
};
use slo_render::render::{Part, Plan};
use slo_scene::{LightGroups, SceneDescription};

/// What is made from each frame of a job.
#[derive(Clone, Debug)]
pub(super) struct Target<'a> {
    job: &'a Job,
    scene: &'a SceneDescription,
    plan: Plan,
    /// Area of the whole picture.
    whole: Area,
    /// Area of the picture that is asked for.
    region: Area,
}

impl<'a> Target<'a> {
    /// Makes the target that the job asks for.
    ///
    /// # Errors
    /// The region is not inside the picture, the samples can't be divided into the parts, or the
    /// file does not hold the layers.
    pub(super) fn new(job: &'a Job, scene: &'a SceneDescription) -> Result<Self, Problem> {
        let film = &scene.camera.film;
        if !film.layers.is_empty() && !film.output.has_layers() {
            let kind = film.output.kind();
            let message = format!("layers are written to EXR pictures only, but this is a {kind}");
            return Err(Problem::new(Exit::Usage, message)
                .with_help("use `--format exr`, or `output EXR_IMAGE` in the scene"));
        }
        if film.layers.contains(&Layer::Lights) {
            check_groups(&scene.light_groups())?;
        }
        let whole = Area::whole(film.width, film.height);
        let region = match job.region {
            None => whole,
            Some(region) => inside(region, whole)?,
        };
        let plan = Plan::new(scene);
        let steps = job.steps.or(job.is_timed().then(Steps::default));
        let plan = steps.map_or(plan.clone(), |steps| plan.in_steps(steps));
        let plan = match job.part {
            None => plan,
            Some((part, PartBy::Pixels)) => plan.of_part(part),
            Some((part, PartBy::Samples)) => plan.of_samples(part).ok_or_else(no_samples)?,
        };
        if plan.samples().is_some_and(|samples| samples.is_empty()) {
            let message = "there are more parts than samples per pixel, so this part has none";
            return Err(Problem::new(Exit::Usage, message)
                .with_help("divide the pixels with `--part-by pixels`"));
        }
        Ok(Self { job, scene, plan, whole, region })
    }

    /// Returns the plan: which samples are taken.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Returns the path of a frame's file. With `--info`, the name holds the render time.
    pub(super) fn path(&self, frame: i64, time: Duration) -> PathBuf {
        let (settings, least) = (&self.scene.settings, self.plan.least());
        let info = self.job.info.then_some(Info { settings, least, time });
        self.job.outdir.join(self.name(frame, info))
    }

    /// Returns the same path without what `--info` adds.
    pub(super) fn plain_path(&self, frame: i64) -> PathBuf {
        self.job.outdir.join(self.name(frame, None))
    }

    fn name(&self, frame: i64, info: Option<Info>) -> String {
        let name = file_name(&self.scene.camera.film, frame, info);
        let (stem, extension) = name.rsplit_once('.').unwrap_or((&name, ""));
        let region = match self.job.region {
            Some(region) => format!("_region={region}"),
            None => String::new(),
        };
        match self.job.part {
            None => format!("{stem}{region}.{extension}"),
            Some((Part { number, of }, by)) => {
                format!("{stem}{region}.{}-{number}-of-{of}.part", by.word())
            }
        }
    }

    /// Returns what the film of a frame is exposed for.
    pub(super) fn subject(&self, frame: i64) -> Subject {
        let layers = &self.scene.camera.film.layers;
        let has_lights = layers.contains(&Layer::Lights);
        Subject {
            recipe: self.whole_recipe(frame, self.job.steps),
            area: self.region.in_blocks(&self.whole),
            region: self.region,
            samples: self.plan.samples(),
            with_spreads: self.plan.needs_spreads(),
            with_features: layers.iter().any(|layer| layer.is_of_surfaces()),
            light_groups: has_lights.then(|| self.scene.light_groups()),
            first_hits: FirstHitLayers::of(layers, &self.scene.layer_names()),
        }
    }

    /// Looks at what exists already.
    pub(super) fn look(&self, frame: i64, path: &Path) -> Found {
        match self.job.part {
            Some(_) => find_state(path, &self.subject(frame)),
            None if self.job.is_timed() => find_timed_picture(path, &self.recipe(frame, None)),
            None => find_picture(path, &self.recipe(frame, self.job.steps)),
        }
    }

    /// Returns the recipe of the picture, or of the picture of the region.
    fn recipe(&self, frame: i64, steps: Option<Steps>) -> String {
        let recipe = self.whole_recipe(frame, steps);
        if self.job.region.is_some() { with_region(recipe, self.region) } else { recipe }
    }

    fn whole_recipe(&self, frame: i64, steps: Option<Steps>) -> String {
        let recipe = Recipe { scene: self.scene, frame }.to_json();
        match steps {
            Some(steps) => with_steps(recipe, steps),
            None => recipe,
        }
    }

    /// Writes what was asked for to `path`. `steps` are the steps taken, if the clock decided
    /// them.
    ///
    /// # Errors
    /// Any I/O error; `AlreadyExists` if another program's file is there by now.
    pub(super) fn write(
        &self,
        frame: i64,
        film: &mut Film,
        steps: Option<Steps>,
        path: &Path,
    ) -> io::Result<Written> {
        if let Some(why) = made_by_others(path).filter(|_| !self.job.overwrites()) {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, NotOurs { why }.to_string()));
        }
        let outcome = Outcome::of(film, self.region, self.plan.display(), self.job.isa);
        if self.job.part.is_some() {
            // There may not be memory for two films.
            let (subject, film_of) = (self.subject(frame), mem::take(film));
            let state = State { subject, film: film_of, is_complete: true };
            let written = write_state(path, &state);
            *film = state.film;
            return written.map(|()| Written { not_finite: 0, outcome });
        }
        let image = View::new(film, self.region);
        let settings = &self.scene.camera.film;
        let (format, look) = (settings.output, settings.look(&self.scene.settings));
        let recipe = with_outcome(&self.recipe(frame, steps.or(self.job.steps)), &outcome);
        let crop = Crop::of(self.region, self.whole);
        let picture = Picture { image: &image, format, look, recipe: &recipe, crop };
        let layers = FileLayer::all(&settings.layers, &self.scene.layer_names());
        let layers: Vec<_> =
            layers.iter().map(|layer| (layer.clone(), image.layer(layer))).collect();
        picture
            .save_with(path, &layers)
            .map(|()| Written { not_finite: picture.not_finite(), outcome })
    }

    /// Writes the maps of a frame that were asked for.
    ///
    /// # Errors
    /// The path that can't be written, and the I/O error.
    pub(super) fn write_maps(
        &self,
        frame: i64,
        film: &Film,
        counted: Option<&Counted>,
        terminal: Terminal,
    ) -> Result<(), (PathBuf, io::Error)> {
        let (place, display) = ((self.region, self.whole), self.plan.display());
        maps::write(&self.job.maps, frame, film, counted, place, display, terminal)
    }
}

/// Checks that files can hold the light of these groups.
fn check_groups(groups: &LightGroups) -> Result<(), Problem> {
    let bad = |message: String| Err(Problem::new(Exit::BadInput, message));
    if groups.len() > LightGroups::MOST {
        let (count, most) = (groups.len(), LightGroups::MOST);
        return bad(format!(
            "the scene has {count} groups of lights, but `--layers lights` takes at most {most}"
        ));
    }
    match groups.names().iter().find(|name| name.len() > LightGroups::LONGEST) {
        Some(name) => {
            let start: String = name.chars().take(20).collect();
            bad(format!(
                "the name of the group of lights `{start}...` has {} bytes, but a channel's name \
                 has room for {}",
                name.len(),
                LightGroups::LONGEST
            ))
        }
        None => Ok(()),
    }
}

/// Another program's file has the name of a picture.
struct NotOurs {
    why: String,
}

impl Display for NotOurs {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "slo-rt did not make the existing file ({})", self.why)
    }
}

/// Makes the problem that a frame can't be rendered because another program's file has its name.
pub(super) fn not_ours(path: &Path, why: &str) -> Problem {
    in_the_way(path, NotOurs { why: why.to_owned() })
}

/// Makes the problem that a file is in the way of a picture and is left alone.
pub(super) fn in_the_way(path: &Path, what: impl Display) -> Problem {
    Problem::new(Exit::CantCreate, format!("can't create `{}`: {what}", path.display()))
        .with_help("it is left alone; move it away, or replace it with `--overwrite`")
}

/// A picture or a part that is in place.
pub(super) struct Written {
    /// Number of pixels that are not finite numbers.
    pub(super) not_finite: usize,
    pub(super) outcome: Outcome,
}

fn inside(region: Region, whole: Area) -> Result<Area, Problem> {
    let Region { width, height, x, y } = region;
    let area = Area { x0: x, y0: y, x1: x.saturating_add(width), y1: y.saturating_add(height) };
    if whole.holds(&area) {
        return Ok(area);
    }
    let (width, height) = (whole.width(), whole.height());
    let message =
        format!("the region {region} is not inside the picture, which has {width}x{height} pixels");
    Err(Problem::new(Exit::Usage, message))
}

fn no_samples() -> Problem {
    let message = "samples can't be divided into parts if their number differs from pixel to pixel";
    Problem::new(Exit::Usage, message).with_help(
        "divide the pixels with `--part-by pixels`, or make the numbers equal with `--samples`",
    )
}
