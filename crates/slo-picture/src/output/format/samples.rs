//! Pictures of tests.

use std::io;

use slo_scene::{Encoding, Look, OutputFormat};

use super::Picture;
use crate::film::Image;

/// A gradient that leaves `[0, 1]` on both sides, and one NaN.
pub(in crate::output) fn sample_image() -> Image {
    let pixel = |i: u32| [i as f32 / 8.0 - 0.5, (i * i) as f32 / 64.0, 2.0 - i as f32 / 5.0];
    let mut rgb: Vec<_> = (0..15).map(pixel).collect();
    rgb[7] = [f32::NAN, f32::INFINITY, 0.25];
    Image { width: 5, height: 3, rgb }
}

pub(in crate::output) fn bytes(format: OutputFormat, encoding: Encoding, image: &Image) -> Vec<u8> {
    let look = Look::of(encoding);
    let picture = Picture { image, format, look, recipe: "{\n  \"frame\": 5\n}", crop: None };
    let mut out = io::Cursor::new(Vec::new());
    picture.write(&mut out).unwrap();
    out.into_inner()
}
