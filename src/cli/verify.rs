//! `verify`: renders some of a picture again and compares the bits.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use rayon::prelude::*;
use serde_json::Value;

use super::Exit;
use super::args::VerifyArgs;
use super::compare::read;
use super::load;
use super::options::Job;
use super::problem::Problem;
use super::terminal::{Terminal, print};
use crate::film::{Area, Film, Image};
use crate::frame::FrameScene;
use crate::output::{
    Picture, Raster, Recipe, is_denoised, read_layers, read_recipe, restore, steps_of, with_region,
    with_steps, without_outcome,
};
use crate::render::{Observer, Plan, Steps, render};
use crate::scene::SceneDescription;

/// Side of the squares that are rendered again.
const TILE: u32 = 32;

/// Verifies the pictures, and prints a line for each.
pub(super) fn run(args: &VerifyArgs, job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let threads = load::threads(job.threads)?;
    threads.install(|| {
        let scene = load::scene(job, terminal)?;
        let mut wrong = 0;
        for path in &args.pictures {
            let line = match verify(path, args.tiles as usize, &scene, job)? {
                Outcome { tiles, different: 0 } => {
                    format!("same\t{}\t{tiles} tiles", path.display())
                }
                Outcome { tiles, different } => {
                    wrong += 1;
                    format!("different\t{}\t{different} of {tiles} tiles", path.display())
                }
            };
            print(line.as_bytes()).map_err(|error| {
                Problem::new(Exit::Failed, format!("can't print the outcome: {error}"))
            })?;
        }
        match wrong {
            0 => Ok(()),
            _ => {
                let message = format!("{wrong} pictures are not what their recipes make here");
                Err(Problem::new(Exit::Failed, message))
            }
        }
    })
}

struct Outcome {
    tiles: usize,
    different: usize,
}

fn verify(
    path: &Path,
    tiles: usize,
    scene: &SceneDescription,
    job: &Job,
) -> Result<Outcome, Problem> {
    let shown = path.display();
    let bad = |why: String| Problem::new(Exit::BadInput, format!("`{shown}`: {why}"));
    let raster = read(path)?;
    let recipe = read_recipe(path).map_err(|error| bad(error.to_string()))?;
    let recipe = without_outcome(&recipe);
    let parsed: Value = serde_json::from_str(&recipe).map_err(|error| bad(error.to_string()))?;
    if is_denoised(&parsed) {
        return Err(bad("it is denoised: the picture that it was made of can be verified".into()));
    }
    let (scene, frame) = restore(scene, &parsed).map_err(bad)?;
    let film = &scene.camera.film;
    let whole = Area::whole(film.width, film.height);
    let region = region(&parsed, whole).ok_or_else(|| bad("its region is none".into()))?;
    let steps = steps_of(&parsed);
    let expected = Recipe { scene: &scene, frame }.to_json();
    let expected = steps.map_or(expected.clone(), |steps| with_steps(expected, steps));
    let expected = if region == whole { expected } else { with_region(expected, region) };
    if expected != recipe || (raster.image.width, raster.image.height) != size(region) {
        return Err(bad(format!(
            "its recipe is not one of slo-rt {} for this scene",
            env!("CARGO_PKG_VERSION")
        )));
    }
    let layers = read_layers(path).map_err(bad)?;
    if !layers.iter().map(|(layer, _)| layer).eq(&film.layers) {
        return Err(bad("it does not have the layers of its recipe".into()));
    }
    let images: Vec<&Image> =
        std::iter::once(&raster.image).chain(layers.iter().map(|(_, image)| image)).collect();
    let built = load::frame(job, &scene, frame, None)?;
    let chosen = choose(region.cells(TILE).collect(), tiles);
    let different = chosen
        .par_iter()
        .map(|&tile| {
            let cut = images.iter().map(|image| cut(image, region, tile));
            again(&scene, &built, tile, steps).map(|again| !again.into_iter().eq(cut))
        })
        .collect::<Result<Vec<bool>, String>>()
        .map_err(bad)?;
    let different = different.into_iter().filter(|&different| different).count();
    Ok(Outcome { tiles: chosen.len(), different })
}

fn size(area: Area) -> (u32, u32) {
    (area.width(), area.height())
}

/// The region of a recipe; all of the picture where it names none.
fn region(recipe: &Value, whole: Area) -> Option<Area> {
    let Some(region) = recipe.get("region") else { return Some(whole) };
    let number = |i: usize| region.get(i)?.as_u64().and_then(|n| u32::try_from(n).ok());
    let (x0, y0) = (number(0)?, number(1)?);
    let (x1, y1) = (x0.checked_add(number(2)?)?, y0.checked_add(number(3)?)?);
    Some(Area { x0, y0, x1, y1 }).filter(|area| whole.holds(area))
}

/// Some of the tiles, at random: another choice in every run.
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

/// The values of a tile in a file, rendered now: colours, then layers.
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
    let film = if settings.layers.is_empty() { film } else { film.and_then(Film::with_features) };
    let film = film.map_err(|error| format!("a tile needs {} bytes", error.bytes))?;
    let film = render(frame, &plan, film, &Nobody).film;
    let image = film.image_of(tile);
    let (format, encoding) = (settings.output, settings.encoding);
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = Picture { image: &image, format, encoding, recipe: "{}" };
    picture.write(&mut bytes).map_err(|error| error.to_string())?;
    let colors = Raster::from_bytes(bytes.into_inner())?.image;
    let layers = settings.layers.iter().map(|&layer| film.layer_of(tile, layer));
    Ok(std::iter::once(colors).chain(layers).collect())
}

/// A tile of a picture of a region.
fn cut(image: &Image, region: Area, tile: Area) -> Image {
    let width = image.width as usize;
    let row = |y: u32| {
        let start = (y - region.y0) as usize * width + (tile.x0 - region.x0) as usize;
        &image.rgb[start..start + tile.width() as usize]
    };
    let rgb = (tile.y0..tile.y1).flat_map(row).copied().collect();
    Image { width: tile.width(), height: tile.height(), rgb }
}
