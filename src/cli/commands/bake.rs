//! `bake`: writes the irradiance of objects into images, by their texture coordinates.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::cli::args::BakeArgs;
use crate::cli::base::{Exit, Problem, Terminal, counted, human, megabytes, print};
use crate::cli::files::load;
use crate::cli::files::new_folders::NewFolders;
use crate::cli::options::Job;
use crate::cli::progress::{FrameProgress, Progress};
use crate::cli::system::interrupt::{self, Guard};
use crate::cli::system::{memory, patience, threads};
use slo_picture::film::{Area, Film, Pixel};
use slo_picture::output::{
    Found, Outcome, Picture, Recipe, check_writable, file_name, find_picture, made_by_others,
    remove_leftovers, with_light_map, with_outcome,
};
use slo_render::frame::FrameScene;
use slo_render::render::{Exposed, Observer, Plan, light_map, render};
use slo_scene::{OutputFormat, SceneDescription};

/// Bytes of memory for each texel, beside its sums.
const BYTES_PER_TEXEL: u64 = 64;

/// Bakes the light maps one after the other, and prints their paths.
pub(crate) fn run(args: &BakeArgs, job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let _guard = Guard::new();
    let pool = threads::pool(job.threads)?;
    let scene = pool.install(|| load::scene(job, terminal))?;
    let go = || bake_all(args, job, &scene, terminal);
    match (job.threads, scene.settings.parallel_threads) {
        (None, Some(asked)) => threads::pool(Some(asked as usize))?.install(go),
        _ => pool.install(go),
    }
}

fn bake_all(
    args: &BakeArgs,
    job: &Job,
    scene: &SceneDescription,
    terminal: Terminal,
) -> Result<(), Problem> {
    let maps = chosen(args, job, scene)?;
    let found: Vec<Found> = maps.iter().map(|map| find_picture(&map.path, &map.recipe())).collect();
    let is_done = |found: &&Found| **found == Found::Finished && !job.overwrites();
    let to_bake = maps.len() - found.iter().filter(is_done).count();
    let mut progress = Progress::new(job.progress, false, maps.len(), to_bake, terminal);
    Guard::begin_work();
    let start = Instant::now();
    let mut before = None;
    for (map, found) in maps.iter().zip(&found) {
        if is_done(&found) {
            progress.found(map.frame, &map.path, false);
            progress.suspended(|| {
                terminal.note(format_args!("`{}` is finished already", map.path.display()));
            });
        } else {
            let _folders = NewFolders::of(&map.path);
            map.check_place(job)?;
            map.check_memory()?;
            progress.call(format!("light map of {}", map.name()));
            map.bake(job, &mut progress, &mut before, terminal)?;
        }
        print(map.path.as_os_str().as_encoded_bytes()).map_err(|error| {
            Problem::new(Exit::Failed, format!("can't print the path of a light map: {error}"))
        })?;
    }
    let time = start.elapsed();
    progress.ended(to_bake, maps.len() - to_bake, 0, time);
    drop(progress);
    if to_bake > 0 {
        terminal.note(format_args!("baked {} in {}", counted(to_bake, "light map"), human(time)));
    }
    Ok(())
}

/// A light map that is asked for.
struct Map {
    /// Index of the object.
    object: usize,
    side: u32,
    frame: i64,
    /// The scene, whose film is the light map.
    scene: SceneDescription,
    path: PathBuf,
}

/// Returns the light maps that are asked for, in the order of the scene.
fn chosen(args: &BakeArgs, job: &Job, scene: &SceneDescription) -> Result<Vec<Map>, Problem> {
    for name in &args.object {
        check_object(name, scene)?;
    }
    let is_wanted = |name: &String| args.object.is_empty() || args.object.contains(name);
    let mut maps: Vec<Map> = Vec::new();
    for (number, object) in scene.objects.iter().enumerate() {
        let Some(light_map) = object.light_map.filter(|_| is_wanted(&object.name)) else {
            continue;
        };
        if object.hidden || scene.hides(object.parent) {
            continue;
        }
        let mut scene = scene.clone();
        let film = &mut scene.camera.film;
        (film.width, film.height) = (light_map.side, light_map.side);
        film.layers.clear();
        film.output = args.format.map_or(OutputFormat::Exr, |name| name.0);
        film.prefix = file_stem(&object.name);
        let name = match args.frame {
            None => format!("{}.{}", film.prefix, film.output.extension()),
            Some(frame) => {
                film.prefix.push('_');
                file_name(film, frame, None)
            }
        };
        let path = job.outdir.join(name);
        if let Some(other) = maps.iter().find(|other| other.path == path) {
            let (one, two) = (other.name(), &object.name);
            let message =
                format!("the light maps of `{one}` and `{two}` are both `{}`", path.display());
            return Err(Problem::new(Exit::BadInput, message).with_help("choose one by `--object`"));
        }
        let frame = args.frame.unwrap_or(0);
        maps.push(Map { object: number, side: light_map.side, frame, scene, path });
    }
    if maps.is_empty() {
        let message = "no object that is shown has a light map";
        return Err(Problem::new(Exit::BadInput, message)
            .with_help("write `lightMap 256` into each object whose light is wanted"));
    }
    Ok(maps)
}

/// Checks that an object has a light map.
fn check_object(name: &str, scene: &SceneDescription) -> Result<(), Problem> {
    let Some(object) = scene.objects.iter().find(|object| object.name == *name) else {
        return Err(Problem::new(Exit::Usage, format!("the scene has no object `{name}`")));
    };
    if object.light_map.is_none() {
        let message = format!("`{name}` has no light map");
        return Err(
            Problem::new(Exit::Usage, message).with_help("write `lightMap 256` into the object")
        );
    }
    if object.hidden || scene.hides(object.parent) {
        let message = format!("`{name}` is hidden, so no light falls on it");
        return Err(Problem::new(Exit::Usage, message));
    }
    Ok(())
}

/// The name of an object as the beginning of a file's name.
fn file_stem(name: &str) -> String {
    let is_bad = |c: char| matches!(c, '/' | '\\') || c.is_control();
    let stem: String = name.chars().map(|c| if is_bad(c) { '_' } else { c }).collect();
    if stem.starts_with('.') { format!("_{stem}") } else { stem }
}

impl Map {
    fn name(&self) -> &str {
        &self.scene.objects[self.object].name
    }

    fn recipe(&self) -> String {
        let Self { scene, frame, .. } = self;
        with_light_map(&Recipe { scene, frame: *frame }.to_json(), self.name())
    }

    /// Checks that the file can be written.
    fn check_place(&self, job: &Job) -> Result<(), Problem> {
        let path = self.path.display();
        check_writable(&self.path).map_err(|error| {
            Problem::new(Exit::CantCreate, format!("can't create `{path}`: {error}"))
                .with_help("choose another folder with `--outdir`")
        })?;
        match made_by_others(&self.path).filter(|_| !job.overwrites()) {
            Some(why) => Err(in_the_way(&self.path, &why)),
            None => {
                remove_leftovers(&self.path);
                Ok(())
            }
        }
    }

    fn check_memory(&self) -> Result<(), Problem> {
        let texels = u64::from(self.side).pow(2);
        let needed = texels * (size_of::<Pixel>() as u64 + BYTES_PER_TEXEL);
        match memory::left().filter(|left| left.bytes < needed) {
            Some(left) => Err(self.too_large(needed, &format!(", but {left}"))),
            None => Ok(()),
        }
    }

    fn too_large(&self, bytes: u64, left: &str) -> Problem {
        let (name, needed) = (self.name(), megabytes(bytes));
        let message = format!("the light map of `{name}` needs {needed} of memory{left}");
        Problem::new(Exit::Failed, message).with_help("give it fewer texels: `lightMap N`")
    }

    /// Bakes the light map into its file. `before` is what was built for another one, and afterwards
    /// what was built for this one.
    fn bake(
        &self,
        job: &Job,
        progress: &mut Progress,
        before: &mut Option<FrameScene>,
        terminal: Terminal,
    ) -> Result<(), Problem> {
        let (start, name) = (Instant::now(), self.name());
        let build = || load::light_map(job, &self.scene, self.frame, self.object, before.take());
        let frame = interrupt::while_building(build)?.ok_or_else(|| {
            Problem::new(Exit::BadInput, format!("`{name}` has no place for a light map"))
        })?;
        let plan = Plan::new(&self.scene);
        let area = Area::whole(self.side, self.side);
        let film = Film::new(area, plan.needs_spreads());
        let film = film.map_err(|error| self.too_large(error.bytes, ""))?;
        let watch = Watch(progress.frame(self.frame, &self.path));
        let Exposed { film, is_complete, .. } = render(&frame, &plan, film, &watch);
        if !is_complete {
            let message = format!("interrupted in the light map of `{name}`");
            let help = "the same command again bakes it and those behind it";
            return Err(Problem::new(Exit::Stopped, message).with_help(help));
        }
        let image = light_map(&frame, &film);
        let outcome = Outcome::of(&film, area, plan.display(), job.isa);
        let recipe = with_outcome(&self.recipe(), &outcome);
        let settings = &self.scene.camera.film;
        let (format, look) = (settings.output, settings.look(&self.scene.settings));
        let picture = Picture { image: &image, format, look, recipe: &recipe, crop: None };
        patience::write(&self.path, terminal, || picture.save(&self.path)).map_err(|error| {
            patience::problem(format_args!("write `{}`", self.path.display()), &error)
        })?;
        *before = Some(frame);
        progress.over();
        progress.finished(self.frame, &self.path, start.elapsed(), outcome);
        Ok(())
    }
}

fn in_the_way(path: &Path, why: &str) -> Problem {
    let path = path.display();
    let message = format!("can't create `{path}`: slo-rt did not make the existing file ({why})");
    Problem::new(Exit::CantCreate, message)
        .with_help("it is left alone; move it away, or replace it with `--overwrite`")
}

/// Watches a light map for the progress.
struct Watch<'a>(FrameProgress<'a>);

impl Observer for Watch<'_> {
    fn advanced(&self, share: f64) {
        self.0.advanced(share);
    }

    fn prepared(&self, time: Duration, share: f64) {
        self.0.prepared(time, share);
    }

    fn should_stop(&self) -> bool {
        interrupt::requested()
    }

    fn gives_up(&self) -> bool {
        interrupt::requested()
    }
}
