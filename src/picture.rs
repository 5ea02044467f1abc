//! Rendered pictures, in memory and as files.

use std::path::Path;

use slo_accel::Isa;
use slo_picture::film::{Display, FileLayer, Film, Image, MaskKind, Pixel, mask_id};
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
    layers: Vec<(FileLayer, Image)>,
}

impl Picture {
    pub(crate) fn new(scene: SceneDescription, frame: i64, film: Film) -> Self {
        let layers = FileLayer::all(&scene.camera.film.layers, &scene.layer_names());
        let layers = film.layers_of(film.area(), layers);
        Self { layers, image: film.image(), film, scene, frame }
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

    /// Returns the pixels with the exposure and the tone map of the film, clamped and encoded as sRGB:
    /// red, green and blue bytes, row by row from the top.
    pub fn srgb8(&self) -> Vec<u8> {
        self.image.srgb8(self.scene.camera.film.look(&self.scene.settings))
    }

    /// Returns a layer that was [asked for](crate::Render::layers), row by row from the top. A layer of a
    /// single number, such as [`Layer::Depth`], has it first, and then zeros. For [`Layer::Lights`], which
    /// is one layer for each group, see [`light`](Self::light), for [`Layer::Motion`], which has four
    /// numbers, [`motion`](Self::motion), and for masks [`mask`](Self::mask).
    pub fn layer(&self, layer: Layer) -> Option<&[[f32; 3]]> {
        match layer {
            Layer::Albedo => self.file_layer(&FileLayer::Albedo),
            Layer::Normal => self.file_layer(&FileLayer::Normal),
            Layer::Depth => self.file_layer(&FileLayer::Depth),
            Layer::Position => self.file_layer(&FileLayer::Position),
            Layer::Uv => self.file_layer(&FileLayer::Uv),
            Layer::Samples => self.file_layer(&FileLayer::Samples),
            Layer::Error => self.file_layer(&FileLayer::Error),
            Layer::Lights | Layer::Motion | Layer::CryptoObject | Layer::CryptoMaterial => None,
        }
    }

    /// Returns by how many pixels what camera rays hit moves to the right and up: two numbers for where
    /// it was in the frame before, minus where it is, and two for where it is, minus where it will be in
    /// the next frame. `None` unless [`Layer::Motion`] was [asked for](crate::Render::layers).
    pub fn motion(&self) -> Option<Vec<[f32; 4]>> {
        let before = self.file_layer(&FileLayer::MotionBefore)?;
        let after = self.file_layer(&FileLayer::MotionAfter)?;
        let both = before.iter().zip(after).map(|([x, y, _], [z, w, _])| [*x, *y, *z, *w]);
        Some(both.collect())
    }

    /// Returns for each pixel the share of its samples that hit an object of this name, for
    /// [`Layer::CryptoObject`], or a material of this name, for [`Layer::CryptoMaterial`]. `None` if the
    /// layer was not [asked for](crate::Render::layers), and for other layers.
    pub fn mask(&self, layer: Layer, name: &str) -> Option<Vec<f32>> {
        let kind = MaskKind::ALL.into_iter().find(|kind| kind.layer() == layer)?;
        let (id, hits) = (mask_id(name), self.film.first_hits());
        let share = |(i, pixel): (usize, &Pixel)| {
            let mut ids = hits.ids(kind, i)?.entries().iter();
            let count = ids.find(|(other, _)| *other == id).map_or(0, |(_, count)| *count);
            Some((f64::from(count) / f64::from(pixel.samples.max(1))) as f32)
        };
        self.film.pixels().iter().enumerate().map(share).collect()
    }

    /// Returns the light of a group of lights, if [`Layer::Lights`] was
    /// [asked for](crate::Render::layers), row by row from the top. The group `rest` holds all light that
    /// has no group; the sum of all groups is the picture.
    pub fn light(&self, group: &str) -> Option<&[[f32; 3]]> {
        self.file_layer(&FileLayer::Light(group.to_owned()))
    }

    fn file_layer(&self, layer: &FileLayer) -> Option<&[[f32; 3]]> {
        let found = self.layers.iter().find(|(name, _)| name == layer);
        found.map(|(_, image)| &image.rgb[..])
    }

    /// How the picture was made and how clean it is, as JSON: what files hold, and what `slo-rt verify`
    /// renders again if the scene is a file.
    pub fn recipe(&self) -> String {
        self.recipe_of(&self.scene)
    }

    /// Writes the picture with its recipe. The extension of `path` chooses the format: that of the scene
    /// if it fits, or else the first that has this extension. Formats that cannot hold layers leave them
    /// out. The file is complete or absent, and has the bytes that the program writes.
    ///
    /// # Errors
    /// [`Error::Format`] if no format has the extension, and [`Error::Io`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let format = self.format_for(path).ok_or_else(|| Error::Format(path.into()))?;
        let mut scene = self.scene.clone();
        scene.camera.film.output = format;
        let recipe = self.recipe_of(&scene);
        let picture = output::Picture {
            image: &self.image,
            format,
            look: scene.camera.film.look(&scene.settings),
            recipe: &recipe,
            crop: None,
        };
        picture
            .save_with(path, &self.layers)
            .map_err(|source| Error::Io { path: path.into(), source })
    }

    /// The recipe as if the picture were of `scene`, which may name another file format.
    fn recipe_of(&self, scene: &SceneDescription) -> String {
        let film = &scene.camera.film;
        let display = Display::of(film.output, film.look(&scene.settings));
        let outcome = Outcome::of(&self.film, self.film.area(), display, Isa::best());
        with_outcome(&Recipe { scene, frame: self.frame }.to_json(), &outcome)
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
