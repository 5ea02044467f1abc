//! A picture that was a file.

use super::picture::Crop;
use crate::film::{Area, Image, linear, srgb};

/// What the values of a file mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Shares of white as the screen gets them, without a curve of the file's own.
    Raw,
    /// Shares of white on the sRGB curve.
    Srgb,
    /// Linear radiance.
    Linear,
}

/// A picture as its file holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// The values as the file holds them; encoded ones from 0 to 1.
    pub image: Image,
    /// What they mean.
    pub values: Values,
    /// Where it lies in a larger picture; `None` if it is all of it, or the file does not say.
    pub crop: Option<Crop>,
}

impl Raster {
    /// A value as the screen shows it: sRGB from 0 to 1.
    pub fn shown(&self, value: f32) -> f32 {
        match self.values {
            Values::Raw | Values::Srgb => value,
            Values::Linear => srgb(value.clamp(0.0, 1.0)),
        }
    }

    /// A value, linear; values of a file without a curve stay as they are.
    pub fn linear(&self, value: f32) -> f32 {
        match self.values {
            Values::Srgb => linear(value),
            Values::Raw | Values::Linear => value,
        }
    }

    /// All values as the screen shows them; see [`shown`](Self::shown).
    pub fn into_shown(self) -> Image {
        self.into_image(Self::shown)
    }

    /// All values, linear; see [`linear`](Self::linear).
    pub fn into_linear(self) -> Image {
        self.into_image(Self::linear)
    }

    fn into_image(mut self, change: impl Fn(&Self, f32) -> f32) -> Image {
        let mut rgb = std::mem::take(&mut self.image.rgb);
        rgb.as_flattened_mut().iter_mut().for_each(|value| *value = change(&self, *value));
        Image { rgb, ..self.image }
    }

    /// The pixels of `area`, in coordinates of the larger picture if this is a crop; `None` if some of
    /// them are not there.
    pub fn cut(&self, area: Area) -> Option<Image> {
        let rgb = self.rows(area)?.flatten().copied().collect();
        Some(Image { width: area.width(), height: area.height(), rgb })
    }

    /// The same, row by row.
    pub fn rows(&self, area: Area) -> Option<impl Iterator<Item = &[[f32; 3]]>> {
        let own = self.area();
        if !own.holds(&area) {
            return None;
        }
        let width = own.width() as usize;
        Some((area.y0..area.y1).map(move |y| {
            let start = (y - own.y0) as usize * width + (area.x0 - own.x0) as usize;
            &self.image.rgb[start..start + area.width() as usize]
        }))
    }

    /// Which pixels of the picture it holds.
    pub fn area(&self) -> Area {
        self.crop.map_or(self.whole(), |crop| crop.area)
    }

    /// All pixels of the picture.
    pub fn whole(&self) -> Area {
        let Image { width, height, .. } = self.image;
        self.crop.map_or(Area::whole(width, height), |crop| crop.whole)
    }
}
