//! Maps over the picture: where its error is, and what its pixels take.

use serde_json::{Value, json};
use slo_accel::Isa;
use slo_picture::film::{Display, Film};
use slo_picture::output::{ERRORS, map_color};

/// How much of a pixel is the colour of the map; the rest is the picture in grey.
const SHARE: f32 = 0.7;

/// What is laid over the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Overlay {
    #[default]
    None,
    /// Estimated error of each pixel.
    Error,
    /// Samples of each pixel.
    Samples,
    /// Steps and tests of the rays of each pixel, for each sample.
    Cost,
}

impl Overlay {
    /// All, with their words.
    const ALL: [(Self, &str); 4] = [
        (Self::None, ""),
        (Self::Error, "error"),
        (Self::Samples, "samples"),
        (Self::Cost, "cost"),
    ];

    /// The overlay of a word.
    pub(crate) fn read(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known)| *known == word).map(|(overlay, _)| *overlay)
    }

    /// The word of the overlay.
    pub(crate) fn word(self) -> &'static str {
        Self::ALL.iter().find(|(overlay, _)| *overlay == self).map_or("", |(_, word)| word)
    }
}

/// A number for each pixel, and the range that its colours span.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) overlay: Overlay,
    values: Vec<f32>,
    range: [f32; 2],
}

impl Map {
    /// The estimated errors of a film as a display shows them. They are 1, the whole range, where
    /// nobody knows them.
    pub(super) fn of_errors(film: &Film, display: Display, isa: Isa) -> Self {
        let squares = display.squared_errors(isa, film.pixels());
        let error = |square: f64| if square.is_finite() { square.sqrt() as f32 } else { 1.0 };
        let values = squares.into_iter().map(error).collect();
        Self { overlay: Overlay::Error, values, range: ERRORS }
    }

    /// The numbers of samples of a film.
    pub(super) fn of_samples(film: &Film) -> Self {
        let values = film.pixels().iter().map(|pixel| pixel.samples as f32).collect();
        Self::between_ends(Overlay::Samples, values)
    }

    /// What the rays of each pixel took: steps and tests.
    pub(super) fn of_costs(film: &Film, costs: &[[u64; 2]]) -> Self {
        let cost = |(pixel, [steps, tests]): (&slo_picture::film::Pixel, &[u64; 2])| {
            (steps + tests) as f32 / pixel.samples.max(1) as f32
        };
        Self::between_ends(Overlay::Cost, film.pixels().iter().zip(costs).map(cost).collect())
    }

    fn between_ends(overlay: Overlay, values: Vec<f32>) -> Self {
        let full = || values.iter().copied().filter(|value| *value > 0.0);
        let least = full().fold(f32::INFINITY, f32::min).clamp(1e-3, 1e9);
        let most = full().fold(least, f32::max);
        Self { overlay, values, range: [least, most] }
    }

    /// What the page says about the colours.
    pub(super) fn legend(&self) -> Value {
        json!({ "overlay": self.overlay.word(), "least": self.range[0], "most": self.range[1] })
    }

    /// Lays the colours over the bytes of a picture of as many pixels.
    pub(crate) fn over(&self, bytes: &mut [u8]) {
        for (pixel, value) in bytes.chunks_exact_mut(3).zip(&self.values) {
            let grey: f32 = pixel.iter().map(|byte| f32::from(*byte) / 3.0).sum();
            let color = map_color(*value, self.range);
            for (byte, part) in pixel.iter_mut().zip(color) {
                *byte = (part * 255.0 * SHARE + grey * (1.0 - SHARE) + 0.5) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use slo_picture::film::{Area, Fixed};
    use slo_scene::{Look, OutputFormat};

    use super::*;

    #[test]
    fn the_map_shows_where_samples_are() {
        let mut film = Film::new(Area::whole(2, 1), false).unwrap();
        for (pixel, samples) in [(0, 1), (1, 16)] {
            for _ in 0..samples {
                film.at_mut(pixel).0.add([Fixed::new(0.5).unwrap(); 3], 1);
            }
        }
        let map = Map::of_samples(&film);
        assert_eq!(map.legend(), json!({ "overlay": "samples", "least": 1.0, "most": 16.0 }));
        let mut bytes = [100; 6];
        map.over(&mut bytes);
        let sum = |pixel: &[u8]| pixel.iter().map(|byte| u32::from(*byte)).sum::<u32>();
        assert!(sum(&bytes[3..]) > 2 * sum(&bytes[..3]), "{bytes:?}");
        let costs = Map::of_costs(&film, &[[6, 2], [32, 32]]);
        assert_eq!(costs.values, [8.0, 4.0]);
        let display = Display::of(OutputFormat::Png8, Look::default());
        let error = Map::of_errors(&film, display, Isa::best());
        assert_eq!((error.values[0], error.range), (1.0, ERRORS));
    }

    #[test]
    fn overlays_have_words() {
        for (overlay, word) in Overlay::ALL {
            assert_eq!((Overlay::read(word), overlay.word()), (Some(overlay), word));
        }
        assert_eq!(Overlay::read("heat"), None);
    }
}
