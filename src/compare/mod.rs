//! How far two pictures are apart.

mod flip;

use crate::film::{Area, Image, luminance};
use crate::output::Raster;
pub use flip::flip;

/// Distances of a picture from a reference of the same size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Pixels with a value that differs, as the files have them: beyond white too.
    pub pixels: usize,
    /// Root mean square over the values as they are shown, 0 to 1.
    pub rmse: f64,
    /// Mean of (x - r)^2 / (r^2 + 0.01) over the linear values.
    pub relative_mse: f64,
    /// Mean luminance over the reference's, of the linear values: what is beside 1 is bias. 1 where
    /// both are 0.
    pub mean_ratio: f64,
    /// Decibels of a range of 1 over `rmse`; infinite where the same is shown.
    pub psnr: f64,
    /// Mean of [`flip()`].
    pub flip: f64,
}

/// What comes of comparing two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// How far they are apart.
    pub distances: Distances,
    /// [`flip()`] of the pixels that were compared, row by row.
    pub flip: Vec<f32>,
    /// These pixels.
    pub area: Area,
    /// The picture that they are in.
    pub whole: Area,
}

/// Compares the pixels that both have; `None` where the sizes differ and neither is known to be a
/// region of the other.
pub fn compare(picture: &Raster, reference: &Raster) -> Option<Comparison> {
    let (area, whole) = common(picture, reference)?;
    let of = |raster: &Raster| {
        let image = raster.cut(area).unwrap_or_else(|| raster.image.clone());
        Raster { image, values: raster.values, crop: None }
    };
    let (distances, flip) = compare_alike(&of(picture), &of(reference));
    Some(Comparison { distances, flip, area, whole })
}

/// The pixels that both have, and the picture.
fn common(a: &Raster, b: &Raster) -> Option<(Area, Area)> {
    let size = |raster: &Raster| (raster.image.width, raster.image.height);
    let is_place_known = a.crop.is_some() && b.crop.is_some();
    if size(a) == size(b) && (a.crop == b.crop || !is_place_known) {
        let known = if a.crop.is_some() { a } else { b };
        return Some((known.area(), known.whole()));
    }
    let (first, second) = (a.area(), b.area());
    let inner = if first.holds(&second) { second } else { first };
    let is_region = first.holds(&inner) && second.holds(&inner) && a.whole() == b.whole();
    is_region.then_some((inner, a.whole()))
}

/// The distances of pictures of the same size, and the map of [`flip()`].
fn compare_alike(picture: &Raster, reference: &Raster) -> (Distances, Vec<f32>) {
    let (shown, expected) = (picture.shown(), reference.shown());
    let mse = mean(&shown, &expected, |x, r| (x - r) * (x - r));
    let (linear, expected_linear) = (picture.linear(), reference.linear());
    let relative = |x: f64, r: f64| (x - r) * (x - r) / (r * r + 0.01);
    let map = flip(&expected, &shown);
    let distances = Distances {
        pixels: different(picture, reference),
        rmse: mse.sqrt(),
        relative_mse: mean(&linear, &expected_linear, relative),
        mean_ratio: ratio(total_luminance(&linear), total_luminance(&expected_linear)),
        psnr: -10.0 * libm::log10(mse),
        flip: map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len().max(1) as f64,
    };
    (distances, map)
}

/// Pixels whose values differ. Those of files that mean other things by their values are compared as
/// they are shown.
fn different(picture: &Raster, reference: &Raster) -> usize {
    let differ = |one: &Image, other: &Image| {
        one.rgb.iter().zip(&other.rgb).filter(|(one, other)| one != other).count()
    };
    match picture.values == reference.values {
        true => differ(&picture.image, &reference.image),
        false => differ(&picture.shown(), &reference.shown()),
    }
}

/// The mean over all channels of all pixels.
fn mean(picture: &Image, reference: &Image, of: impl Fn(f64, f64) -> f64) -> f64 {
    let values = |image: &Image| image.rgb.as_flattened().iter().map(|&v| f64::from(v)).collect();
    let (picture, reference): (Vec<f64>, Vec<f64>) = (values(picture), values(reference));
    let sum: f64 = picture.iter().zip(&reference).map(|(&x, &r)| of(x, r)).sum();
    sum / picture.len().max(1) as f64
}

fn total_luminance(image: &Image) -> f64 {
    image.rgb.iter().map(|&rgb| luminance(rgb)).sum()
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
