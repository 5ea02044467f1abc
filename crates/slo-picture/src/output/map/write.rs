//! Maps of a picture: how many samples each pixel took, its error, its difference from another.

use std::io;
use std::path::Path;

use slo_accel::Isa;
use slo_scene::OutputFormat;
use slo_scene::settings::FileValues;

use super::companion::{self, map_format};
use crate::film::{Area, Display, Film, Image};
use crate::output::format::Crop;

/// The errors of the darkest and the brightest colour: a quarter of a step of 8 bits, and an eighth of
/// the range.
pub const ERRORS: [f32; 2] = [1.0 / 1024.0, 1.0 / 8.0];

/// Writes how many samples each pixel of an area of a picture took: as numbers to an `.exr` file, or to a `.png`
/// file in colours from dark blue for the fewest to yellow for the most, by their logarithm.
///
/// # Errors
/// Another extension; a file exists that is no earlier map or sheet; what the system says.
pub fn write_sample_map(path: &Path, film: &Film, area: Area, whole: Area) -> io::Result<()> {
    let mut counts = Vec::with_capacity(area.len());
    counts.extend(film.pixels_of(area).map(|pixel| pixel.samples as f32));
    let least = counts.iter().copied().fold(f32::INFINITY, f32::min).max(1.0);
    let most = counts.iter().copied().fold(1.0, f32::max);
    write(path, area, whole, &counts, [least, most])
}

/// Writes the estimated error of each pixel of an area of a picture as the viewer sees it, root mean square over
/// its channels: as numbers to an `.exr` file, or to a `.png` file in colours from dark blue for
/// 1/1024 and below to yellow for 1/8 and above, by its logarithm. If it is unknown, for fewer than two
/// samples, it is 1, the whole range.
///
/// # Errors
/// Another extension; a file exists that is no earlier map or sheet; what the system says.
pub fn write_error_map(
    path: &Path,
    film: &Film,
    area: Area,
    whole: Area,
    display: Display,
) -> io::Result<()> {
    let squares = display.squared_errors(Isa::best(), film.pixels_of(area));
    let errors: Vec<f32> = squares.into_iter().map(error).collect();
    write(path, area, whole, &errors, ERRORS)
}

/// Writes what the rays of each pixel of an area of a picture cost, per camera sample: steps, tests, and
/// their sum, weighted. An `.exr` file holds the three as red, green and blue; a `.png` file shows the
/// sum in colours from dark blue for the least to yellow for the most, by its logarithm.
///
/// # Errors
/// Another extension; a file exists that is no earlier map or sheet; what the system says.
pub fn write_cost_map(path: &Path, area: Area, whole: Area, costs: &[[f32; 3]]) -> io::Result<()> {
    let sums = costs.iter().map(|cost| cost[2]).filter(|&sum| sum > 0.0);
    let least = sums.clone().fold(f32::INFINITY, f32::min).min(1e9);
    let most = sums.fold(least, f32::max);
    let shown = |&[_, _, sum]: &[f32; 3]| map_color(sum, [least, most]);
    save_pixels(path, area, whole, costs, |&cost| cost, shown)
}

/// The root of a squared error, or 1, the whole range.
fn error(square: f64) -> f32 {
    if square.is_finite() { square.sqrt() as f32 } else { 1.0 }
}

/// Writes differences from 0 to 1 in an area of a picture, row by row: as numbers to an `.exr` file, or to a `.png` file in
/// colours from dark blue for 0 to yellow for 1.
///
/// # Errors
/// Another extension; a file exists that is no earlier map or sheet; what the system says.
pub fn write_difference_map(
    path: &Path,
    area: Area,
    whole: Area,
    values: &[f32],
) -> io::Result<()> {
    save(path, area, whole, values, heat)
}

/// Writes numbers that are not negative.
fn write(path: &Path, area: Area, whole: Area, values: &[f32], range: [f32; 2]) -> io::Result<()> {
    save(path, area, whole, values, |value| map_color(value, range))
}

fn save(
    path: &Path,
    area: Area,
    whole: Area,
    values: &[f32],
    color: impl Fn(f32) -> [f32; 3],
) -> io::Result<()> {
    save_pixels(path, area, whole, values, |&value| [value; 3], |&value| color(value))
}

/// Writes numbers as they are, or as colours.
fn save_pixels<T>(
    path: &Path,
    area: Area,
    whole: Area,
    values: &[T],
    numbers: impl Fn(&T) -> [f32; 3],
    color: impl Fn(&T) -> [f32; 3],
) -> io::Result<()> {
    let Some(format) = map_format(path) else {
        let message = format!("a map is a {} file", OutputFormat::extensions());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    };
    let pixel = |value: &T| match format.values() {
        FileValues::Linear { .. } => numbers(value),
        FileValues::Encoded { .. } => color(value),
    };
    let (width, height) = (area.width(), area.height());
    let image = Image { width, height, rgb: values.iter().map(pixel).collect() };
    companion::save(path, &image, format, Crop::of(area, whole))
}

/// The colour of a number between the ends of a range in a map, by its logarithm.
pub fn map_color(value: f32, [low, high]: [f32; 2]) -> [f32; 3] {
    let octaves = libm::log2f(high / low).max(1e-6);
    let place = (libm::log2f(value.max(1e-30) / low) / octaves).clamp(0.0, 1.0);
    heat(place)
}

/// A colour from dark blue over green to yellow whose lightness grows evenly.
fn heat(place: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] = [
        [0.14, 0.03, 0.33],
        [0.19, 0.29, 0.55],
        [0.12, 0.55, 0.54],
        [0.43, 0.78, 0.34],
        [0.99, 0.91, 0.15],
    ];
    let at = place.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let i = (at as usize).min(STOPS.len() - 2);
    let t = at - i as f32;
    std::array::from_fn(|c| STOPS[i][c] * (1.0 - t) + STOPS[i + 1][c] * t)
}

#[cfg(test)]
mod tests {
    use slo_scene::Look;

    use super::*;
    use crate::film::Fixed;
    use crate::output::format::Raster;

    #[test]
    fn an_error_that_nobody_knows_is_not_none() {
        let area = Area::whole(3, 1);
        let mut film = Film::new(area, false).unwrap();
        for (i, samples) in [0, 1, 2].into_iter().enumerate() {
            for _ in 0..samples {
                film.at_mut(i).0.add([Fixed::new(0.5).unwrap(); 3], 1);
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("error.exr");
        let display = Display::of(OutputFormat::Exr, Look::default());
        write_error_map(&path, &film, area, area, display).unwrap();
        assert_eq!(Raster::read(&path).unwrap().image.rgb, [1.0, 1.0, 0.0].map(|e| [e; 3]));
    }

    #[test]
    fn colours_go_from_dark_to_light() {
        let light = |value: f32| map_color(value, [16.0, 256.0]).iter().sum::<f32>();
        let values = [1.0, 16.0, 24.0, 32.0, 64.0, 128.0, 256.0, 1e9].map(light);
        assert_eq!((values[0], values[6]), (values[1], values[7]));
        assert!(values[1..7].windows(2).all(|w| w[0] < w[1]), "{values:?}");
        assert_eq!(map_color(7.0, [7.0, 7.0]), heat(0.0), "all the same");
        assert_eq!(map_color(f32::INFINITY, ERRORS), heat(1.0));
    }
}
