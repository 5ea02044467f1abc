//! How far two pictures are apart.

mod flip;

use crate::film::Image;
use crate::output::Raster;
pub use flip::flip;

/// Distances of a picture from a reference of the same size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Pixels with a value that differs.
    pub pixels: usize,
    /// Root mean square over the values as they are shown, 0 to 1.
    pub rmse: f64,
    /// Mean of (x - r)^2 / (r^2 + 0.01) over the linear values.
    pub relative_mse: f64,
    /// Decibels of a range of 1 over `rmse`; infinite for the same values.
    pub psnr: f64,
    /// Mean of [`flip()`].
    pub flip: f64,
}

/// The distances, and the map of [`flip()`], row by row; `None` where the sizes differ.
pub fn compare(picture: &Raster, reference: &Raster) -> Option<(Distances, Vec<f32>)> {
    let size = |raster: &Raster| (raster.image.width, raster.image.height);
    if size(picture) != size(reference) {
        return None;
    }
    let (shown, expected) = (picture.shown(), reference.shown());
    let mse = mean(&shown, &expected, |x, r| (x - r) * (x - r));
    let relative = |x: f64, r: f64| (x - r) * (x - r) / (r * r + 0.01);
    let map = flip(&expected, &shown);
    let different = |(a, b): &(&[f32; 3], &[f32; 3])| a != b;
    let distances = Distances {
        pixels: shown.rgb.iter().zip(&expected.rgb).filter(different).count(),
        rmse: mse.sqrt(),
        relative_mse: mean(&picture.linear(), &reference.linear(), relative),
        psnr: -10.0 * libm::log10(mse),
        flip: map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len().max(1) as f64,
    };
    Some((distances, map))
}

/// The mean over all channels of all pixels.
fn mean(picture: &Image, reference: &Image, of: impl Fn(f64, f64) -> f64) -> f64 {
    let values = |image: &Image| image.rgb.as_flattened().iter().map(|&v| f64::from(v)).collect();
    let (picture, reference): (Vec<f64>, Vec<f64>) = (values(picture), values(reference));
    let sum: f64 = picture.iter().zip(&reference).map(|(&x, &r)| of(x, r)).sum();
    sum / picture.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Values;

    fn raster(values: Values, pixel: [f32; 3]) -> Raster {
        Raster { image: Image { width: 4, height: 3, rgb: vec![pixel; 12] }, values }
    }

    #[test]
    fn distances_by_hand() {
        let (a, b) = (raster(Values::Raw, [0.5; 3]), raster(Values::Raw, [0.5, 0.5, 0.3]));
        let (distances, _) = compare(&a, &b).unwrap();
        let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-6, "{x} {y}");
        assert_eq!(distances.pixels, 12);
        close(distances.rmse, 0.2 / 3f64.sqrt());
        close(distances.relative_mse, 0.04 / (0.09 + 0.01) / 3.0);
        assert!((distances.psnr - 18.7506).abs() < 1e-3, "{}", distances.psnr);
        let (same, map) = compare(&a, &a).unwrap();
        assert_eq!((same.pixels, same.rmse, same.psnr, same.flip), (0, 0.0, f64::INFINITY, 0.0));
        assert!(map.iter().all(|&value| value == 0.0));
    }

    #[test]
    fn a_curve_is_undone_where_linear_values_count() {
        let linear = raster(Values::Linear, [0.214_041; 3]);
        let curved = raster(Values::Srgb, [0.5; 3]);
        let (distances, _) = compare(&linear, &curved).unwrap();
        assert!(distances.rmse < 1e-5 && distances.relative_mse < 1e-9, "{distances:?}");
    }

    #[test]
    fn pictures_of_two_sizes_are_not_compared() {
        let mut other = raster(Values::Raw, [0.5; 3]);
        other.image = Image { width: 3, height: 4, ..other.image };
        assert!(compare(&raster(Values::Raw, [0.5; 3]), &other).is_none());
    }
}
