//! OpenEXR: one part, R, G, B as 32-bit floats, linear and unclamped, run lengths.

use std::io::{self, Seek, Write};

use exr::compression::Compression;
use exr::image::{Blocks, Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::LineOrder;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::WritableImage;

use super::values::finite;
use super::{KEYWORD, Picture};

/// Writes `picture`.
pub(super) fn write(picture: &Picture, out: impl Write + Seek) -> io::Result<()> {
    let size = (picture.image.width as usize, picture.image.height as usize);
    if size.0 == 0 || size.1 == 0 {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the picture has no pixels"));
    }
    let pixel = |Vec2(x, y): Vec2<usize>| {
        let [r, g, b] = picture.image.rgb[y * size.0 + x].map(finite);
        (r, g, b)
    };
    let layer = Layer::new(
        size,
        attributes(picture.recipe)?,
        // Noise hardly compresses: more than run lengths costs a tenth of a quick frame's time
        // and saves a tenth of its size.
        Encoding {
            compression: Compression::RLE,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        SpecificChannels::rgb(pixel),
    );
    let written = Image::from_layer(layer).write().non_parallel().to_unbuffered(out);
    written.map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other),
    })
}

/// The recipe as the one attribute of our own: `exr` keeps such attributes in a hash map, so that
/// the order of two would change from run to run.
fn attributes(recipe: &str) -> io::Result<LayerAttributes> {
    let text = Text::new_or_none(recipe)
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the recipe is not Latin-1"))?;
    let mut attributes = LayerAttributes::default();
    attributes.other.insert(Text::from(KEYWORD), AttributeValue::Text(text));
    Ok(attributes)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bytes, sample_image};
    use super::*;
    use crate::scene::OutputFormat;
    use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

    #[test]
    fn floats_come_back_unclamped() {
        let image = sample_image();
        let file = bytes(OutputFormat::Exr, crate::scene::Encoding::Srgb, &image);
        let read = read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required("R")
            .required("G")
            .required("B")
            .collect_pixels(
                |size, _| (size, vec![[0.0; 3]; size.area()]),
                |(size, rgb): &mut (Vec2<usize>, Vec<[f32; 3]>), at, (r, g, b)| {
                    rgb[at.flat_index_for_size(*size)] = [r, g, b];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(io::Cursor::new(file))
            .unwrap();
        let (size, rgb) = read.layer_data.channel_data.pixels;
        assert_eq!((size.0, size.1), (5, 3));
        let expected: Vec<[f32; 3]> = image.rgb.iter().map(|rgb| rgb.map(finite)).collect();
        assert_eq!(rgb, expected);
    }
}
