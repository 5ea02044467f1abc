//! EXR files -> their values and their recipe, whoever wrote them.

use std::cell::RefCell;
use std::io;

use exr::block::reader::Reader;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};

use super::super::claim::ReadError;
use super::super::container::{KEYWORD, RecipeError, Source, Wholeness};
use super::super::picture::Crop;
use super::super::raster::{Raster, Values};
use super::claim;
use super::header::{channel_names, color_names, is_our_header, light_layers, possible_layers};
use super::seal::{self, Seal};
use crate::film::{Area, FileLayer, Image};

/// Names that no channel has.
const NO_CHANNELS: [&str; 3] = ["no first", "no second", "no third"];

/// The colours of a file.
pub(super) fn read(mut input: &mut dyn Source) -> Result<Raster, ReadError> {
    if seal::look(&mut input)? == Seal::Broken {
        return Err(ReadError::bad("it is damaged: its checksum is wrong"));
    }
    let found = read_channels(input, &color_names())?;
    let Some((image, crop)) = found else {
        return Err(ReadError::bad("it has no channels R, G and B"));
    };
    Ok(Raster { image, values: Values::Linear, crop })
}

/// The layers beside the colours, in the order of [`FileLayer::all`].
pub(super) fn read_layers(
    mut input: &mut dyn Source,
) -> Result<Vec<(FileLayer, Image)>, ReadError> {
    let headers = MetaData::read_from_buffered(&mut input, false).map_err(reason)?.headers;
    let lights = headers.iter().flat_map(|header| light_layers(&header.channels));
    let (surfaces, others): (Vec<_>, Vec<_>) = possible_layers(&headers)
        .partition(|layer| matches!(layer, FileLayer::Albedo | FileLayer::Normal));
    let mut layers = Vec::new();
    for layer in surfaces.into_iter().chain(lights).chain(others) {
        let names = channel_names(&layer);
        if !headers.iter().any(|header| has_channels(header, &names)) {
            continue;
        }
        let found = read_channels(input, &names)?;
        layers.extend(found.map(|(image, _)| (layer, image)));
    }
    Ok(layers)
}

/// The number of pixels in the header, of its largest layer.
pub(super) fn claimed_pixels(input: &mut dyn Source) -> Option<u64> {
    let headers = MetaData::read_from_buffered(input, false).ok()?.headers;
    let pixels = |header: &Header| header.layer_size.0 as u64 * header.layer_size.1 as u64;
    headers.iter().map(pixels).max()
}

/// The recipe, and whether the file is as it was written.
pub(super) fn recipe(mut input: &mut dyn Source) -> Result<(String, Wholeness), RecipeError> {
    let seal = seal::look(&mut input).map_err(RecipeError::Io)?;
    input.rewind().map_err(RecipeError::Io)?;
    let meta = MetaData::read_from_buffered(&mut input, false);
    let damaged = || RecipeError::Damaged("it is damaged: its checksum is wrong".into());
    let meta = meta.map_err(|error| match seal {
        Seal::Broken => damaged(),
        Seal::None | Seal::Whole => RecipeError::NotAPicture(error.to_string()),
    })?;
    let attributes = meta.headers.iter().flat_map(|header| {
        header.own_attributes.other.iter().chain(&header.shared_attributes.other)
    });
    let recipe = attributes.into_iter().find_map(|(name, value)| match value {
        AttributeValue::Text(text) if name.eq(KEYWORD) => Some(text.to_string()),
        _ => None,
    });
    let is_ours = is_our_header(&mut input, &meta).map_err(RecipeError::Io)?;
    match (seal, recipe) {
        (Seal::Whole, Some(recipe)) => Ok((recipe, Wholeness::Whole)),
        (Seal::Broken, _) | (Seal::None, Some(_)) if is_ours => Err(damaged()),
        (_, Some(recipe)) => Ok((recipe, Wholeness::Resaved)),
        (_, None) => Err(RecipeError::NoRecipe),
    }
}

/// One to three channels of the first layer that has them, and its place; `None` if no layer has them. The
/// numbers behind the last channel are 0.
fn read_channels(
    mut input: &mut dyn Source,
    names: &[Text],
) -> Result<Option<(Image, Option<Crop>)>, ReadError> {
    let file_bytes = input.seek(io::SeekFrom::End(0))?;
    input.rewind()?;
    let reader = Reader::read_from_buffered(&mut input, false).map_err(reason)?;
    reader.headers().iter().try_for_each(|header| claim::check(header, file_bytes))?;
    let Some(header) = reader.headers().iter().find(|header| has_channels(header, names)) else {
        return Ok(None);
    };
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(ReadError::bad("some of its channels have fewer values than pixels"));
    }
    let size = [header.layer_size.0, header.layer_size.1];
    let pixels = super::super::claim::pixels(size.map(|side| side as u64), file_bytes)?;
    let pixels = RefCell::new(pixels);
    let name = |i: usize| names.get(i).cloned().unwrap_or_else(|| NO_CHANNELS[i].into());
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(name(0))
        .optional(name(1), 0.0)
        .optional(name(2), 0.0)
        .collect_pixels(
            |size, _| (size.width(), pixels.take()),
            |(width, rgb): &mut (usize, Vec<[f32; 3]>), at, (x, y, z): (f32, f32, f32)| {
                if let Some(pixel) = rgb.get_mut(at.y() * *width + at.x()) {
                    *pixel = [x, y, z];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
        .map_err(reason)?;
    let layer = read.layer_data;
    let (width, height) = (layer.size.width() as u32, layer.size.height() as u32);
    let rgb = layer.channel_data.pixels.1;
    if rgb.len() != size[0] * size[1] || layer.size != Vec2(size[0], size[1]) {
        return Err(ReadError::bad("its layers can't be told apart"));
    }
    let image = Image { width, height, rgb };
    let crop = crop(&image, layer.attributes.layer_position, read.attributes.display_window);
    Ok(Some((image, crop)))
}

/// Whether a layer has channels of these names.
fn has_channels(header: &Header, names: &[Text]) -> bool {
    let has = |name: &Text| header.channels.list.iter().any(|channel| channel.name == *name);
    names.iter().all(has)
}

/// What is wrong with a file, in words for the user.
fn reason(error: exr::error::Error) -> ReadError {
    use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    match error {
        exr::error::Error::Io(error) => match error.kind() {
            UnexpectedEof => ReadError::bad("it was cut off"),
            // Offsets outside of the file.
            InvalidInput | InvalidData => ReadError::bad("it is damaged: its table is wrong"),
            _ => ReadError::Io(error),
        },
        error => ReadError::Bad(error.to_string()),
    }
}

/// The place of an image in the display window; `None` if it is not inside.
fn crop(image: &Image, at: Vec2<i32>, display: IntegerBounds) -> Option<Crop> {
    let offset = |at: i32, from: i32| u32::try_from(i64::from(at) - i64::from(from)).ok();
    let (x0, y0) = (offset(at.0, display.position.0)?, offset(at.1, display.position.1)?);
    let (x1, y1) = (x0.checked_add(image.width)?, y0.checked_add(image.height)?);
    let side = |length: usize| u32::try_from(length).ok();
    let whole = Area::whole(side(display.size.0)?, side(display.size.1)?);
    Crop::of(Area { x0, y0, x1, y1 }, whole)
}
