//! The picture of a light map.

use std::f32::consts::PI;

use slo_picture::film::{Film, Image};

use crate::frame::FrameScene;

/// Returns the irradiance of a frame whose pixels are the texels of a light map. Texels that are not on
/// the surface continue what lies beside them, so that interpolation finds nothing else at its edges.
pub fn light_map(frame: &FrameScene, film: &Film) -> Image {
    let mut image = film.image();
    image.rgb.iter_mut().for_each(|rgb| *rgb = rgb.map(|channel| channel * PI));
    if let Some(baked) = &frame.baked {
        let (width, height) = (image.width, image.height);
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let is_known = texels.map(|(x, y)| baked.texels.is_covered(x, y)).collect();
        fill(&mut image, is_known);
    }
    image
}

/// Gives every unknown pixel the mean of the known ones next to it, layer by layer.
fn fill(image: &mut Image, mut is_known: Vec<bool>) {
    let (width, height) = (image.width as usize, image.height as usize);
    let beside = |i: usize| {
        let (x, y) = (i % width, i / width);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    };
    let mut is_listed = is_known.clone();
    let mut layer: Vec<usize> = (0..is_known.len()).filter(|&i| is_known[i]).collect();
    loop {
        let mut next = Vec::new();
        for &i in &layer {
            for other in beside(i) {
                if !std::mem::replace(&mut is_listed[other], true) {
                    next.push(other);
                }
            }
        }
        let mean = |&i: &usize| {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for other in beside(i).filter(|&other| is_known[other]) {
                (0..3).for_each(|c| sum[c] += image.rgb[other][c]);
                count += 1.0;
            }
            sum.map(|sum| sum / count)
        };
        let means: Vec<[f32; 3]> = next.iter().map(mean).collect();
        for (&i, mean) in next.iter().zip(means) {
            image.rgb[i] = mean;
            is_known[i] = true;
        }
        if next.is_empty() {
            return;
        }
        layer = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_continue_what_is_known() {
        let mut image = Image { width: 5, height: 2, rgb: vec![[0.0; 3]; 10] };
        (image.rgb[0], image.rgb[6]) = ([1.0; 3], [3.0; 3]);
        let is_known = (0..10).map(|i| i == 0 || i == 6).collect();
        fill(&mut image, is_known);
        let found: Vec<f32> = image.rgb.iter().map(|rgb| rgb[0]).collect();
        // The first layer: (1, 0), (2, 0), (0, 1) and (2, 1).
        assert_eq!(found, [1.0, 2.0, 3.0, 3.0, 3.0, 2.0, 3.0, 3.0, 3.0, 3.0]);
        let mut nothing = image.clone();
        fill(&mut nothing, vec![false; 10]);
        assert_eq!(nothing, image);
    }
}
