//! What is seen at a place of the picture: rendered as layers for compositors, one sample of a block.

use glam::DVec3;
use slo_picture::film::{Area, BLOCK, FileLayer, Film, MaskKind, Steps, mask_id};
use slo_render::frame::FrameScene;
use slo_render::render::{Observer, Plan, render};
use slo_scene::{Layer, SceneDescription};

/// What is seen at a place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Where, in scene space.
    pub(crate) point: DVec3,
    /// Distance along the view.
    pub(crate) depth: f64,
    /// Name of the object or lamp.
    pub(crate) object: Option<String>,
    /// Name of its material.
    pub(crate) material: Option<String>,
}

/// The layers that tell what is seen.
const LAYERS: [Layer; 4] =
    [Layer::Depth, Layer::Position, Layer::CryptoObject, Layer::CryptoMaterial];

/// The scene as it is looked at to find out what is seen: sharp and still, where the ray goes that is
/// meant.
pub(crate) fn sharp(scene: &SceneDescription) -> SceneDescription {
    let mut scene = scene.clone();
    scene.camera.film.layers = LAYERS.to_vec();
    scene.settings.noise = None;
    for segment in &mut scene.camera.segments {
        segment.lens_radius = [0.0; 2];
        segment.blur_duration = 0.0;
    }
    scene
}

/// Finds what is seen at a place of a frame of a [`sharp`] scene: `at` runs from 0 to 1, to the right and
/// down. `None` if it is nothing.
pub(crate) fn pick(scene: &SceneDescription, frame: &FrameScene, at: [f64; 2]) -> Option<Seen> {
    let film = &scene.camera.film;
    let whole = Area::whole(film.width, film.height);
    let (x, y) = pixel_at(at, film.width, film.height);
    let block = Area { x0: x / BLOCK * BLOCK, y0: y / BLOCK * BLOCK, x1: x + 1, y1: y + 1 };
    let area = block.in_blocks(&whole);
    let names = scene.layer_names();
    let film = Film::new(area, false).and_then(|film| film.with_layers(&LAYERS, &names)).ok()?;
    let plan = Plan::new(scene).in_steps(Steps::default());
    let film = render(frame, &plan, film, &Alone).film;
    let pixel = Area { x0: x, y0: y, x1: x + 1, y1: y + 1 };
    let i = ((y - area.y0) * area.width() + x - area.x0) as usize;
    let id = |kind| Some(film.first_hits().ids(kind, i)?.ranked(0)?.0);
    let object = id(MaskKind::Object)?;
    let material = id(MaskKind::Material);
    let called = |id: u32, name: &&str| mask_id(name) == id;
    let things = scene.objects.iter().map(|object| &*object.name);
    let lamps = scene.lights.iter().map(|light| &*light.name);
    let materials = scene.materials.iter().map(|material| &*material.name);
    let layer = |layer| film.layer_of(pixel, &layer).rgb[0];
    Some(Seen {
        point: DVec3::from(layer(FileLayer::Position).map(f64::from)),
        depth: layer(FileLayer::Depth)[0].into(),
        object: things.chain(lamps).find(|name| called(object, name)).map(str::to_owned),
        material: material
            .and_then(|id| materials.into_iter().find(|name| called(id, name)))
            .map(str::to_owned),
    })
}

/// The pixel at a place of a picture, whose coordinates run from 0 to 1.
pub(crate) fn pixel_at(at: [f64; 2], width: u32, height: u32) -> (u32, u32) {
    let pixel =
        |at: f64, pixels: u32| ((at.clamp(0.0, 1.0) * f64::from(pixels)) as u32).min(pixels - 1);
    (pixel(at[0], width), pixel(at[1], height))
}

/// Nobody watches one sample.
struct Alone;

impl Observer for Alone {
    fn advanced(&self, _: f64) {}
}
