//! How much two pictures differ.

mod flip;

use std::ops::Range;

use crate::film::{Area, Image, luminance};
use crate::output::Raster;
use flip::REACH;
pub use flip::flip;

/// Distances of a picture from a reference of the same size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Pixels with a different value in the files, beyond white too.
    pub pixels: usize,
    /// Root mean square over the values on the screen, 0 to 1.
    pub rmse: f64,
    /// Mean of (x - r)^2 / (r^2 + 0.01) over the linear values.
    pub relative_mse: f64,
    /// Mean luminance over the reference's, of the linear values: any deviation from 1 is bias. 1 if both
    /// are 0.
    pub mean_ratio: f64,
    /// Decibels of a range of 1 over `rmse`; infinite if the screen shows the same.
    pub psnr: f64,
    /// Mean of [`flip()`].
    pub flip: f64,
}

/// The result of comparing two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// How much they differ.
    pub distances: Distances,
    /// [`flip()`] of the compared pixels, row by row.
    pub flip: Vec<f32>,
    /// The compared pixels.
    pub area: Area,
    /// The picture that they are in.
    pub whole: Area,
}

/// Rows that are compared together, so that intermediate results of the whole picture take no memory.
const ROWS: u32 = 128;

/// Compares the pixels that both have; `None` if the sizes differ and neither is known to be a region
/// of the other.
pub fn compare(picture: &Raster, reference: &Raster) -> Option<Comparison> {
    let Common { area, whole, places } = common(picture, reference)?;
    let [one, other] = [Placed::new(picture, places[0]), Placed::new(reference, places[1])];
    let mut sums = Sums::default();
    let mut flip = Vec::with_capacity(area.len());
    for top in (0..area.height()).step_by(ROWS as usize) {
        let rows = top..(top + ROWS).min(area.height());
        sums.add(&one, &other, rows.clone());
        flip.extend(flip_of_rows(&one, &other, rows));
    }
    Some(Comparison { distances: sums.distances(&flip), flip, area, whole })
}

/// The pixels that two pictures have in common.
struct Common {
    area: Area,
    whole: Area,
    /// Their places in either picture.
    places: [Area; 2],
}

fn common(a: &Raster, b: &Raster) -> Option<Common> {
    let size = |raster: &Raster| (raster.image.width, raster.image.height);
    let is_place_known = a.crop.is_some() && b.crop.is_some();
    if size(a) == size(b) && (a.crop == b.crop || !is_place_known) {
        let known = if a.crop.is_some() { a } else { b };
        let (area, whole) = (known.area(), known.whole());
        return Some(Common { area, whole, places: [a.area(), b.area()] });
    }
    let (first, second) = (a.area(), b.area());
    let area = if first.holds(&second) { second } else { first };
    let is_region = first.holds(&area) && second.holds(&area) && a.whole() == b.whole();
    is_region.then_some(Common { area, whole: a.whole(), places: [area; 2] })
}

/// An area of a picture.
struct Placed<'a> {
    raster: &'a Raster,
    area: Area,
}

impl<'a> Placed<'a> {
    fn new(raster: &'a Raster, area: Area) -> Self {
        Self { raster, area }
    }

    /// The values of some of its rows, left to right.
    fn values(&self, rows: Range<u32>) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let y0 = self.area.y0;
        let area = Area { y0: y0 + rows.start, y1: y0 + rows.end, ..self.area };
        self.raster.rows(area).into_iter().flatten().flatten().copied()
    }

    /// Some of its rows as the screen shows them.
    fn shown(&self, rows: Range<u32>) -> Image {
        let (width, height) = (self.area.width(), rows.end - rows.start);
        let shown = |rgb: [f32; 3]| rgb.map(|value| self.raster.shown(value));
        Image { width, height, rgb: self.values(rows).map(shown).collect() }
    }
}

/// [`flip()`] of some rows of pictures of the same size; it depends on some rows around them.
fn flip_of_rows(picture: &Placed, reference: &Placed, rows: Range<u32>) -> Vec<f32> {
    let height = picture.area.height();
    let around = rows.start.saturating_sub(REACH)..(rows.end + REACH).min(height);
    let mut map = flip(&reference.shown(around.clone()), &picture.shown(around.clone()));
    let width = picture.area.width() as usize;
    map.truncate((rows.end - around.start) as usize * width);
    map.drain(..(rows.start - around.start) as usize * width);
    map
}

/// What is added up over all pixels.
#[derive(Default)]
struct Sums {
    all: usize,
    different: usize,
    square: f64,
    relative: f64,
    /// Luminance of the picture, and of the reference.
    luminance: [f64; 2],
}

impl Sums {
    fn add(&mut self, picture: &Placed, reference: &Placed, rows: Range<u32>) {
        let (one, other) = (picture.raster, reference.raster);
        let is_alike = one.values == other.values;
        for (x, r) in picture.values(rows.clone()).zip(reference.values(rows)) {
            let shown = [x.map(|x| one.shown(x)), r.map(|r| other.shown(r))];
            let linear = [x.map(|x| one.linear(x)), r.map(|r| other.linear(r))];
            self.all += 1;
            // Files that mean other things by their values are compared as they are shown.
            self.different += usize::from(if is_alike { x != r } else { shown[0] != shown[1] });
            let wide = |of: [[f32; 3]; 2], c: usize| of.map(|rgb: [f32; 3]| f64::from(rgb[c]));
            for [x, r] in [0, 1, 2].map(|c| wide(shown, c)) {
                self.square += (x - r) * (x - r);
            }
            for [x, r] in [0, 1, 2].map(|c| wide(linear, c)) {
                self.relative += (x - r) * (x - r) / (r * r + 0.01);
            }
            for (sum, rgb) in self.luminance.iter_mut().zip(linear) {
                *sum += luminance(rgb);
            }
        }
    }

    fn distances(&self, flip: &[f32]) -> Distances {
        let values = (self.all * 3).max(1) as f64;
        let mse = self.square / values;
        Distances {
            pixels: self.different,
            rmse: mse.sqrt(),
            relative_mse: self.relative / values,
            mean_ratio: ratio(self.luminance[0], self.luminance[1]),
            psnr: -10.0 * libm::log10(mse),
            flip: flip.iter().map(|&value| f64::from(value)).sum::<f64>()
                / flip.len().max(1) as f64,
        }
    }
}

fn ratio(x: f64, r: f64) -> f64 {
    if x == r { 1.0 } else { x / r }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Crop, Values};

    fn raster(values: Values, pixel: [f32; 3]) -> Raster {
        Raster { image: Image { width: 4, height: 3, rgb: vec![pixel; 12] }, values, crop: None }
    }

    #[test]
    fn distances_by_hand() {
        let (a, b) = (raster(Values::Raw, [0.5; 3]), raster(Values::Raw, [0.5, 0.5, 0.3]));
        let distances = compare(&a, &b).unwrap().distances;
        let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-6, "{x} {y}");
        assert_eq!(distances.pixels, 12);
        close(distances.rmse, 0.2 / 3f64.sqrt());
        close(distances.relative_mse, 0.04 / (0.09 + 0.01) / 3.0);
        assert!((distances.psnr - 18.7506).abs() < 1e-3, "{}", distances.psnr);
        // Blue is a small share of luminance.
        close(distances.mean_ratio, 0.5 / (0.5 - 0.0722 * 0.2));
        let Comparison { distances: same, flip: map, .. } = compare(&a, &a).unwrap();
        assert_eq!((same.pixels, same.rmse, same.psnr, same.flip), (0, 0.0, f64::INFINITY, 0.0));
        assert!(map.iter().all(|&value| value == 0.0));
    }

    #[test]
    fn pixels_differ_beyond_white_too() {
        let (a, b) = (raster(Values::Linear, [7.0; 3]), raster(Values::Linear, [9.0; 3]));
        let distances = compare(&a, &b).unwrap().distances;
        assert_eq!((distances.pixels, distances.rmse, distances.flip), (12, 0.0, 0.0));
    }

    #[test]
    fn bias_is_a_ratio_of_means() {
        let ratio = |x: f32, r: f32| {
            let gray = |value| raster(Values::Linear, [value; 3]);
            compare(&gray(x), &gray(r)).unwrap().distances.mean_ratio
        };
        assert!((ratio(0.505, 0.5) - 1.01).abs() < 1e-6);
        assert_eq!((ratio(0.0, 0.0), ratio(1.0, 0.0)), (1.0, f64::INFINITY));
        assert!(ratio(f32::NAN, 1.0).is_nan());
    }

    #[test]
    fn a_curve_is_undone_where_linear_values_count() {
        let linear = raster(Values::Linear, [0.214_041; 3]);
        let curved = raster(Values::Srgb, [0.5; 3]);
        let distances = compare(&linear, &curved).unwrap().distances;
        assert!(distances.rmse < 1e-5 && distances.relative_mse < 1e-9, "{distances:?}");
    }

    #[test]
    fn rows_taken_in_turn_are_those_of_the_whole() {
        let picture = |seed: u32| {
            let value = |i: u32| (i.wrapping_mul(2_654_435_761) ^ seed) as f32 / u32::MAX as f32;
            let rgb = (0..7 * 300).map(|i| [value(i), value(i + 1), value(i / 7)]).collect();
            Raster { image: Image { width: 7, height: 300, rgb }, values: Values::Raw, crop: None }
        };
        let (a, b) = (picture(1), picture(0x0100_0000));
        let found = compare(&a, &b).unwrap();
        assert!(found.distances.flip > 0.0);
        assert_eq!(found.flip, flip(&b.image, &a.image));
    }

    #[test]
    fn pictures_of_two_sizes_are_not_compared() {
        let mut other = raster(Values::Raw, [0.5; 3]);
        other.image = Image { width: 3, height: 4, ..other.image };
        assert!(compare(&raster(Values::Raw, [0.5; 3]), &other).is_none());
    }

    /// A region of a picture of 4 x 3 pixels, one brighter from pixel to pixel.
    fn region(area: Area) -> Raster {
        let at = |x: u32, y: u32| [(y * 4 + x) as f32; 3];
        let rgb = (area.y0..area.y1).flat_map(|y| (area.x0..area.x1).map(move |x| at(x, y)));
        let image = Image { width: area.width(), height: area.height(), rgb: rgb.collect() };
        Raster { image, values: Values::Linear, crop: Crop::of(area, Area::whole(4, 3)) }
    }

    #[test]
    fn a_region_is_compared_with_its_place_in_the_whole() {
        let whole = region(Area::whole(4, 3));
        let part = Area { x0: 1, y0: 1, x1: 3, y1: 3 };
        for (a, b) in [(&region(part), &whole), (&whole, &region(part))] {
            let found = compare(a, b).unwrap();
            assert_eq!((found.distances.pixels, found.area, found.whole), (0, part, whole.area()));
            assert_eq!(found.flip.len(), 4);
        }
        let elsewhere = region(Area { x0: 0, x1: 2, ..part });
        assert!(compare(&region(part), &elsewhere).is_none(), "other pixels");
        let placeless = Raster { crop: None, ..region(part) };
        assert_eq!(compare(&placeless, &region(part)).unwrap().distances.pixels, 0);
        assert!(compare(&placeless, &whole).is_none());
    }
}
