//! Rendered pictures, in memory and as files.

use std::path::Path;

use slo_accel::Isa;
use slo_picture::film::{Display, Film, Image, srgb};
use slo_picture::output::{self, Outcome, Recipe, with_outcome};
use slo_scene::{Layer, OutputFormat, SceneDescription};

use crate::error::Error;

/// A rendered picture.
#[derive(Clone, Debug)]
pub struct Picture {
    scene: SceneDescription,
    frame: i64,
    film: Film,
    image: Image,
    layers: Vec<(Layer, Image)>,
}

impl Picture {
    pub(crate) fn new(scene: SceneDescription, frame: i64, film: Film) -> Self {
        let layers = &scene.camera.film.layers;
        let layers = layers.iter().map(|&layer| (layer, film.layer_of(film.area(), layer)));
        Self { layers: layers.collect(), image: film.image(), film, scene, frame }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.scene.camera.film.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.scene.camera.film.height
    }

    /// Returns the radiance of the pixels: red, green and blue, linear and unclamped, row by row
    /// from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.image.rgb
    }

    /// Returns the pixels clamped and encoded as sRGB: red, green and blue bytes, row by row from
    /// the top.
    pub fn srgb8(&self) -> Vec<u8> {
        let byte = |value: f32| (srgb(value.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
        self.image.rgb.iter().flatten().map(|&value| byte(value)).collect()
    }

    /// Returns a layer that was [asked for](crate::Render::layers), row by row from the top.
    pub fn layer(&self, layer: Layer) -> Option<&[[f32; 3]]> {
        let found = self.layers.iter().find(|(name, _)| *name == layer);
        found.map(|(_, image)| &image.rgb[..])
    }

    /// Returns the recipe as JSON: how the picture was made, and how clean it is. Files hold it,
    /// and `slo-rt verify` renders from it again.
    pub fn recipe(&self) -> String {
        let film = &self.scene.camera.film;
        let display = Display::of(film.output, film.encoding);
        let outcome = Outcome::of(&self.film, self.film.area(), display, Isa::best());
        with_outcome(&Recipe { scene: &self.scene, frame: self.frame }.to_json(), &outcome)
    }

    /// Writes the picture with its recipe. The extension of `path` chooses the format: the scene's
    /// format if it has this extension, or else the first format that has it. The file is complete
    /// or absent, and has the same bytes as a file that the program writes.
    ///
    /// # Errors
    /// [`Error::Format`] if no format has the extension, and [`Error::Io`].
    pub fn save(mut self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let format = self.format_for(path).ok_or_else(|| Error::Format(path.into()))?;
        self.scene.camera.film.output = format;
        let recipe = self.recipe();
        let picture = output::Picture {
            image: &self.image,
            format,
            encoding: self.scene.camera.film.encoding,
            recipe: &recipe,
            crop: None,
        };
        picture
            .save_with(path, &self.layers)
            .map_err(|source| Error::Io { path: path.into(), source })
    }

    fn format_for(&self, path: &Path) -> Option<OutputFormat> {
        let extension = path.extension()?.to_str()?;
        let ours = self.scene.camera.film.output;
        if ours.extension().eq_ignore_ascii_case(extension) {
            return Some(ours);
        }
        OutputFormat::by_extension(extension)
    }
}
