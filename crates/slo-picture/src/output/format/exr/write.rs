//! Pictures -> OpenEXR files: one part, R, G, B as 32-bit floats, linear and unclamped, run lengths;
//! layers as further channels of the same part, which every program reads.

use std::io::{self, Seek, Write};

use exr::compression::Compression;
use exr::image::write::channels::WritableChannels;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, IntegerBounds, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::WritableImage;

use super::super::container::{KEYWORD, Sink};
use super::super::picture::{Crop, Picture};
use super::super::quantise::finite;
use super::header::{channel_names, color_names};
use super::{order, seal};
use crate::film::{Area, FileLayer, Mask, Pixels};

/// Writes `picture`, and `layers` of the same size.
pub(super) fn write(
    picture: &Picture,
    layers: &[(&FileLayer, &dyn Pixels)],
    mut out: &mut dyn Sink,
) -> io::Result<()> {
    write_unsealed(picture, layers, &mut out)?;
    if !masks(layers).is_empty() {
        order::sort_attributes(&mut out)?;
    }
    seal::seal(out)
}

fn write_unsealed(
    picture: &Picture,
    layers: &[(&FileLayer, &dyn Pixels)],
    out: impl Write + Seek,
) -> io::Result<()> {
    let image = picture.image;
    let [width, height] = image.size();
    if width == 0 || height == 0 {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the picture has no pixels"));
    }
    if layers.is_empty() {
        let pixel = |Vec2(x, y): Vec2<usize>| {
            let [r, g, b] = image.at(x as u32, y as u32).map(finite);
            (r, g, b)
        };
        let colors = with_header(picture, &[], SpecificChannels::rgb(pixel))?;
        return said(colors.write().non_parallel().to_unbuffered(out));
    }
    let colors = color_names().to_vec();
    let images = layers.iter().map(|(layer, image)| (channel_names(layer), *image));
    let channels = std::iter::once((colors, image)).chain(images).flat_map(|(names, image)| {
        names.into_iter().enumerate().map(move |(c, name)| {
            let mut values = Vec::with_capacity(width as usize * height as usize);
            for y in 0..height {
                values.extend((0..width).map(|x| finite(image.at(x, y)[c])));
            }
            AnyChannel::new(name, FlatSamples::F32(values))
        })
    });
    let all = with_header(picture, &masks(layers), AnyChannels::sort(channels.collect()))?;
    said(all.write().non_parallel().to_unbuffered(out))
}

/// The masks among layers.
fn masks<'a>(layers: &[(&'a FileLayer, &dyn Pixels)]) -> Vec<&'a Mask> {
    let first_rank = |(layer, _): &(&'a FileLayer, &dyn Pixels)| match layer {
        FileLayer::Rank(mask, 0) => Some(mask),
        _ => None,
    };
    layers.iter().filter_map(first_rank).collect()
}

/// Channels with their header.
fn with_header<'c, C: WritableChannels<'c> + 'c>(
    picture: &Picture,
    masks: &[&Mask],
    channels: C,
) -> io::Result<Image<exr::image::Layer<C>>> {
    let [width, height] = picture.image.size();
    let all = Area::whole(width, height);
    let Crop { area, whole } = picture.crop.unwrap_or(Crop { area: all, whole: all });
    let size = (width as usize, height as usize);
    // Noise hardly compresses: anything better than run lengths costs a tenth of a quick frame's time and
    // saves a tenth of the size.
    let encoding = Encoding {
        compression: Compression::RLE,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let of_layer = of_layer(picture.recipe, masks, area)?;
    let layer = exr::image::Layer::new(size, of_layer, encoding, channels);
    Ok(Image::new(of_image(whole), layer))
}

fn said(written: exr::error::UnitResult) -> io::Result<()> {
    written.map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other),
    })
}

/// The place of the pixels, the recipe, and the names of masks. `exr` keeps such attributes in a hash map,
/// so their order changes from run to run, unless there is only one.
fn of_layer(recipe: &str, masks: &[&Mask], area: Area) -> io::Result<LayerAttributes> {
    let text = Text::new_or_none(recipe)
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the recipe is not Latin-1"))?;
    let mut attributes = LayerAttributes {
        layer_position: Vec2(area.x0 as i32, area.y0 as i32),
        ..LayerAttributes::default()
    };
    attributes.other.insert(Text::from(KEYWORD), AttributeValue::Text(text));
    for (name, value) in masks.iter().flat_map(|mask| mask.attributes()) {
        let value = AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()));
        attributes.other.insert(Text::from_slice_unchecked(name.as_bytes()), value);
    }
    Ok(attributes)
}

/// The size of the picture, and room for the hash of the file: only one attribute is our own.
fn of_image(whole: Area) -> ImageAttributes {
    let size = Vec2(whole.width() as usize, whole.height() as usize);
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    let blank = AttributeValue::Text(Text::from(seal::BLANK));
    attributes.other.insert(Text::from(seal::KEYWORD), blank);
    attributes
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

    use super::*;
    use crate::output::format::OutputFormat;
    use crate::output::format::samples::{bytes, sample_image};

    #[test]
    fn floats_come_back_unclamped() {
        let image = sample_image();
        let file = bytes(OutputFormat::Exr, slo_scene::Encoding::Srgb, &image);
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
