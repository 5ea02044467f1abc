//! Pictures whose pixels are computed on demand, since a copy would take memory.

use std::fmt::{self, Debug};

use super::area::Area;
use super::grid::Film;
use super::image::Image;
use super::layers::FileLayer;

/// Three numbers for each pixel.
pub trait Pixels: Debug + Sync {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// The numbers of a pixel, counted from the upper left corner.
    fn at(&self, x: u32, y: u32) -> [f32; 3];
}

impl Pixels for Image {
    fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    fn at(&self, x: u32, y: u32) -> [f32; 3] {
        self.rgb[y as usize * self.width as usize + x as usize]
    }
}

/// An area of a film as a picture: the means of its samples, or a layer.
#[derive(Clone, Copy)]
pub struct View<'a> {
    film: &'a Film,
    area: Area,
    layer: Option<&'a FileLayer>,
}

impl<'a> View<'a> {
    /// Of an area inside the film's.
    pub fn new(film: &'a Film, area: Area) -> Self {
        Self { film, area, layer: None }
    }

    /// A layer of the area; black if the film has none.
    pub fn layer(self, layer: &'a FileLayer) -> Self {
        Self { layer: Some(layer), ..self }
    }
}

impl Pixels for View<'_> {
    fn size(&self) -> [u32; 2] {
        [self.area.width(), self.area.height()]
    }

    fn at(&self, x: u32, y: u32) -> [f32; 3] {
        let whole = self.film.area;
        let row = (self.area.y0 - whole.y0 + y) as usize;
        let i = row * whole.width() as usize + (self.area.x0 - whole.x0 + x) as usize;
        match self.layer {
            None => self.film.pixels[i].mean(),
            Some(layer) => self.film.layer_at(layer, i),
        }
    }
}

impl Debug for View<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("View").field("area", &self.area).field("layer", &self.layer).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixed::{Fixed, SignedFixed};
    use super::*;

    #[test]
    fn a_view_shows_what_an_image_holds() {
        let mut film = Film::new(Area { x0: 2, y0: 1, x1: 6, y1: 4 }, false)
            .and_then(Film::with_features)
            .unwrap();
        for i in 0..12 {
            let value = Fixed::new(i as f32 / 16.0).unwrap();
            film.at_mut(i).0.add([value, value, Fixed::new(1.0).unwrap()], 1);
            film.features_mut(i).unwrap().albedo = [SignedFixed::clamped(i as f32 / 16.0); 3];
        }
        let area = Area { x0: 3, y0: 2, x1: 5, y1: 4 };
        let view = View::new(&film, area);
        let all = |pixels: &dyn Pixels| {
            let [width, height] = pixels.size();
            let at = |i: u32| pixels.at(i % width, i / width);
            (0..width * height).map(at).collect::<Vec<_>>()
        };
        assert_eq!(all(&view), film.image_of(area).rgb);
        assert_eq!(all(&film.image_of(area)), film.image_of(area).rgb);
        for layer in [FileLayer::Albedo, FileLayer::Normal] {
            assert_eq!(all(&view.layer(&layer)), film.layer_of(area, &layer).rgb);
        }
    }
}
