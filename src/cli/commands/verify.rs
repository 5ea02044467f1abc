//! `verify`: renders tiles of a picture again and compares the bits.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use rayon::prelude::*;
use serde_json::Value;

use crate::cli::args::VerifyArgs;
use crate::cli::base::{Exit, Problem, Terminal, counted, print};
use crate::cli::files::load;
use crate::cli::files::pictures::{NO_PICTURE, unreadable};
use crate::cli::options::Job;
use crate::cli::system::threads;
use slo_picture::film::Steps;
use slo_picture::film::{Area, FileLayer, Film, Image};
use slo_picture::output::{
    Crop, Picture, Raster, ReadError, Recipe, RestoreError, Values, is_companion, is_denoised,
    is_light_map, is_relit, read_layers, read_recipe, restore, steps_of, with_region, with_steps,
    without_outcome,
};
use slo_render::frame::{Aids, FrameScene};
use slo_render::render::{Observer, Plan, render};
use slo_scene::SceneDescription;

/// Side of the tiles that are rendered again, in pixels.
const TILE: u32 = 32;

/// Verifies all pictures, and prints a line for each.
pub(crate) fn run(args: &VerifyArgs, job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let pool = threads::pool(job.threads)?;
    pool.install(|| {
        let scene = load::scene(job, terminal)?;
        let mut tally = Tally::default();
        for path in &args.pictures {
            let verdict = verify(path, args.tiles as usize, &scene, job);
            tally.add(&verdict);
            if let Err(refusal) = &verdict {
                terminal.error(format!("`{}`: {}", path.display(), refusal.why), &[]);
            }
            print(line(path, &verdict).as_bytes()).map_err(|error| {
                Problem::new(Exit::Failed, format!("can't print the outcome: {error}"))
            })?;
        }
        tally.end()
    })
}

struct Outcome {
    tiles: usize,
    different: usize,
}

/// Why a picture can't be verified.
struct Refusal {
    exit: Exit,
    why: String,
}

type Verdict = Result<Outcome, Refusal>;

/// Formats three fields, separated by tabs.
fn line(path: &Path, verdict: &Verdict) -> String {
    let path = path.display();
    match verdict {
        Ok(Outcome { tiles, different: 0 }) => format!("same\t{path}\t{}", counted(*tiles, "tile")),
        Ok(Outcome { tiles, different }) => {
            format!("different\t{path}\t{different} of {}", counted(*tiles, "tile"))
        }
        Err(refusal) => format!("unverified\t{path}\t{}", refusal.why),
    }
}

/// Results of all pictures.
#[derive(Default)]
struct Tally {
    all: usize,
    wrong: usize,
    refused: usize,
    first_refusal: Option<Exit>,
}

impl Tally {
    fn add(&mut self, verdict: &Verdict) {
        self.all += 1;
        match verdict {
            Ok(outcome) => self.wrong += usize::from(outcome.different > 0),
            Err(refusal) => {
                self.refused += 1;
                self.first_refusal.get_or_insert(refusal.exit);
            }
        }
    }

    /// Reports the results. A wrong picture is what the command looks for, so its exit code takes
    /// precedence over the exit code of a refusal.
    fn end(self) -> Result<(), Problem> {
        let Self { all, wrong, refused, first_refusal } = self;
        let of = |count: usize| format!("{count} of {}", counted(all, "picture"));
        let mut said = Vec::new();
        if wrong > 0 {
            let (are, their) =
                if wrong == 1 { ("is", "its recipe makes") } else { ("are", "their recipes make") };
            said.push(format!("{} {are} not what {their} here", of(wrong)));
        }
        if refused > 0 {
            said.push(format!("{} can't be verified", of(refused)));
        }
        match first_refusal.filter(|_| wrong == 0) {
            _ if said.is_empty() => Ok(()),
            Some(exit) => Err(Problem::new(exit, said.join("; "))),
            None => Err(Problem::new(Exit::Failed, said.join("; "))),
        }
    }
}

fn verify(path: &Path, tiles: usize, scene: &SceneDescription, job: &Job) -> Verdict {
    let bad = |why: String| Refusal { exit: Exit::BadInput, why };
    let raster = Raster::read(path).map_err(refusal)?;
    let recipe = read_recipe(path).map_err(|error| bad(error.to_string()))?;
    if is_companion(&recipe) {
        return Err(bad(NO_PICTURE.into()));
    }
    let recipe = without_outcome(&recipe);
    let parsed: Value = serde_json::from_str(&recipe).map_err(|error| bad(error.to_string()))?;
    for (is_made, how) in [(is_denoised(&parsed), "denoised"), (is_relit(&parsed), "relit")] {
        if is_made {
            return Err(bad(format!("it is {how}; verify the picture that it was made from")));
        }
    }
    if is_light_map(&parsed) {
        return Err(bad("it is a light map; `slo-rt bake` makes it again".into()));
    }
    let (scene, frame) = restore(scene, &parsed).map_err(|error| bad(mismatch(error, job)))?;
    let film = &scene.camera.film;
    let whole = Area::whole(film.width, film.height);
    let region = region(&parsed, whole).map_err(bad)?;
    let area = region.unwrap_or(whole);
    let steps = steps_of(&parsed);
    let expected = Recipe { scene: &scene, frame }.to_json();
    let expected = steps.map_or(expected.clone(), |steps| with_steps(expected, steps));
    let expected = region.map_or(expected.clone(), |region| with_region(expected, region));
    let is_placed = raster.crop.is_none_or(|crop| Some(crop) == Crop::of(area, whole));
    if expected != recipe || size(&raster.image) != (area.width(), area.height()) || !is_placed {
        return Err(bad(format!(
            "its recipe is not one that slo-rt {} makes for this scene",
            env!("CARGO_PKG_VERSION")
        )));
    }
    let colors = Raster { crop: Crop::of(area, whole), ..raster };
    let layers = read_layers(path).map_err(refusal)?;
    let expected = FileLayer::all(&film.layers, &scene.layer_names());
    let rasters = with_layers(colors, layers, &expected).map_err(bad)?;
    let built = load::frame(job.isa, &scene, frame, Aids::default())
        .map_err(|problem| Refusal { exit: problem.exit, why: problem.message })?;
    let chosen = choose(area.cells(TILE).collect(), tiles);
    let different = chosen
        .par_iter()
        .map(|&tile| {
            let again = again(&scene, &built, tile, steps)?.into_iter().map(Some);
            Ok(again.ne(rasters.iter().map(|raster| raster.cut(tile))))
        })
        .collect::<Result<Vec<bool>, String>>()
        .map_err(bad)?;
    let different = different.into_iter().filter(|&different| different).count();
    Ok(Outcome { tiles: chosen.len(), different })
}

/// Makes the refusal of a picture whose file can't be read.
fn refusal(error: ReadError) -> Refusal {
    Refusal { exit: unreadable(&error), why: error.to_string() }
}

/// Explains why a scene does not fit. Without `--scene`, the user may not know that there is a
/// built-in scene.
fn mismatch(error: RestoreError, job: &Job) -> String {
    match (error, &job.scene) {
        (RestoreError::OtherScene, None) => "it belongs to another scene; name it with `-s`".into(),
        _ => error.to_string(),
    }
}

/// Returns the colours of a picture, then its layers, which must be the expected ones.
fn with_layers(
    colors: Raster,
    layers: Vec<(FileLayer, Image)>,
    expected: &[FileLayer],
) -> Result<Vec<Raster>, String> {
    let crop = colors.crop;
    if !layers.iter().map(|(layer, _)| layer).eq(expected) {
        return Err("it does not have the layers of its recipe".into());
    }
    let layer = |(_, image)| Raster { image, values: Values::Linear, crop };
    Ok(std::iter::once(colors).chain(layers.into_iter().map(layer)).collect())
}

fn size(image: &Image) -> (u32, u32) {
    (image.width, image.height)
}

/// Returns the region that a recipe names, or `None` if it names none.
fn region(recipe: &Value, whole: Area) -> Result<Option<Area>, String> {
    let Some(region) = recipe.get("region") else { return Ok(None) };
    let number = |i: usize| region.get(i)?.as_u64().and_then(|n| u32::try_from(n).ok());
    let area = || {
        let (x0, y0) = (number(0)?, number(1)?);
        let (x1, y1) = (x0.checked_add(number(2)?)?, y0.checked_add(number(3)?)?);
        Some(Area { x0, y0, x1, y1 }).filter(|area| !area.is_empty() && whole.holds(area))
    };
    area().map(Some).ok_or_else(|| "its region is not inside the picture".into())
}

/// Chooses some of the tiles at random, with another choice in every run.
fn choose(mut tiles: Vec<Area>, count: usize) -> Vec<Area> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let mut state = now.as_nanos() as u64 ^ u64::from(std::process::id()) << 32;
    let count = count.min(tiles.len());
    for i in 0..count {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let other = i + (state >> 33) as usize % (tiles.len() - i);
        tiles.swap(i, other);
    }
    tiles.truncate(count);
    tiles
}

struct Nobody;

impl Observer for Nobody {
    fn advanced(&self, _share: f64) {}
}

/// Renders a tile now, and returns its values as a file holds them: colours, then layers.
fn again(
    scene: &SceneDescription,
    frame: &FrameScene,
    tile: Area,
    steps: Option<Steps>,
) -> Result<Vec<Image>, String> {
    let settings = &scene.camera.film;
    let plan = Plan::new(scene);
    let plan = steps.map_or(plan.clone(), |steps| plan.in_steps(steps));
    let area = tile.in_blocks(&Area::whole(settings.width, settings.height));
    let film = Film::new(area, plan.needs_spreads());
    let names = scene.layer_names();
    let film = film.and_then(|film| film.with_layers(&settings.layers, &names));
    let film =
        film.map_err(|error| format!("not enough memory: a tile needs {} bytes", error.bytes))?;
    let film = render(frame, &plan, film, &Nobody).film;
    let image = film.image_of(tile);
    let (format, look) = (settings.output, settings.look(&scene.settings));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = Picture { image: &image, format, look, recipe: "{}", crop: None };
    picture.write(&mut bytes).map_err(|error| error.to_string())?;
    let colors = Raster::from_bytes(bytes.into_inner()).map_err(|error| error.to_string())?.image;
    let layers = film.layers_of(tile, FileLayer::all(&settings.layers, &names));
    Ok(std::iter::once(colors).chain(layers.into_iter().map(|(_, image)| image)).collect())
}
