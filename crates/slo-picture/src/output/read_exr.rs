//! EXR pictures that are there already -> their values.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use exr::block::reader::Reader;
use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};

use super::claim::{self, ReadError};
use super::exr::channel_names;
use super::file::open_regular;
use super::seal::{self, Seal};
use super::{Crop, Raster, Values};
use crate::film::{Area, Image, Layer};

/// The colours of an EXR file.
pub(super) fn read_exr(mut input: impl BufRead + Seek) -> Result<Raster, ReadError> {
    if seal::look(&mut input)? == Seal::Broken {
        return Err(ReadError::bad("it is damaged: its checksum is wrong"));
    }
    let found = read_channels(&mut input, &["R", "G", "B"].map(str::to_owned))?;
    let Some((image, crop)) = found else {
        return Err(ReadError::bad("it has no channels R, G and B"));
    };
    Ok(Raster { image, values: Values::Linear, crop })
}

/// The layers that an EXR file has beside its colours, in the order of [`Layer::ALL`]; none of any
/// other file.
///
/// # Errors
/// What the system says, or what is wrong with the file.
pub fn read_layers(path: &Path) -> Result<Vec<(Layer, Image)>, ReadError> {
    let mut input = BufReader::new(open_regular(path)?);
    let [0x76, 0x2f, 0x31, 0x01, ..] = input.fill_buf()? else { return Ok(Vec::new()) };
    let mut layers = Vec::new();
    for layer in Layer::ALL {
        let found = read_channels(&mut input, &channel_names(layer))?;
        layers.extend(found.map(|(image, _)| (layer, image)));
    }
    Ok(layers)
}

/// Three channels of the first layer that has them, and where it lies; `None` where none has them.
fn read_channels(
    input: &mut (impl BufRead + Seek),
    names: &[String; 3],
) -> Result<Option<(Image, Option<Crop>)>, ReadError> {
    let file_bytes = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    let reader = Reader::read_from_buffered(input, false).map_err(reason)?;
    reader.headers().iter().try_for_each(|header| claim::check_layer(header, file_bytes))?;
    let Some(header) = reader.headers().iter().find(|header| has_channels(header, names)) else {
        return Ok(None);
    };
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(ReadError::bad("some of its channels have fewer values than pixels"));
    }
    let size = [header.layer_size.0, header.layer_size.1];
    let pixels = claim::pixels(size.map(|side| side as u64), file_bytes)?;
    let pixels = RefCell::new(pixels);
    let [first, second, third] = names;
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(&**first)
        .required(&**second)
        .required(&**third)
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
        return Err(ReadError::bad("its layers are not told apart"));
    }
    let image = Image { width, height, rgb };
    let crop = crop(&image, layer.attributes.layer_position, read.attributes.display_window);
    Ok(Some((image, crop)))
}

/// Whether a layer has channels of these names.
fn has_channels(header: &Header, names: &[String; 3]) -> bool {
    let has = |name: &String| header.channels.list.iter().any(|channel| channel.name.eq(name));
    names.iter().all(has)
}

/// What is wrong with an EXR file, in words for the user.
fn reason(error: exr::error::Error) -> ReadError {
    use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    match error {
        exr::error::Error::Io(error) => match error.kind() {
            UnexpectedEof => ReadError::bad("it was cut off"),
            // Places that are in no file.
            InvalidInput | InvalidData => ReadError::bad("it is damaged: its table is wrong"),
            _ => ReadError::Io(error),
        },
        error => ReadError::Bad(error.to_string()),
    }
}

/// The place of an image in the display window; `None` where it is not inside.
fn crop(image: &Image, at: Vec2<i32>, display: IntegerBounds) -> Option<Crop> {
    let offset = |at: i32, from: i32| u32::try_from(i64::from(at) - i64::from(from)).ok();
    let (x0, y0) = (offset(at.0, display.position.0)?, offset(at.1, display.position.1)?);
    let (x1, y1) = (x0.checked_add(image.width)?, y0.checked_add(image.height)?);
    let side = |length: usize| u32::try_from(length).ok();
    let whole = Area::whole(side(display.size.0)?, side(display.size.1)?);
    Crop::of(Area { x0, y0, x1, y1 }, whole)
}

#[cfg(test)]
mod tests {
    use super::super::Picture;
    use super::super::tests::sample_image;
    use super::*;
    use crate::film::Area;
    use crate::output::{Crop, Raster};
    use slo_scene::{Encoding, OutputFormat};

    #[test]
    fn what_was_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture");
        let image = sample_image();
        let layer = |factor: f32| {
            let rgb = (0..15).map(|i| [i as f32 * factor, -factor, 0.5]).collect();
            Image { width: 5, height: 3, rgb }
        };
        let layers = [(Layer::Albedo, layer(0.01)), (Layer::Normal, layer(0.05))];
        let encoding = Encoding::Raw;
        let crop = Crop::of(Area { x0: 7, y0: 2, x1: 12, y1: 5 }, Area::whole(20, 10));
        let picture = |format| Picture { image: &image, format, encoding, recipe: "{}", crop };
        let exr = picture(OutputFormat::Exr);
        for layers in [&layers[..], &layers[1..], &[]] {
            exr.save_with(&path, layers).unwrap();
            assert_eq!(read_layers(&path).unwrap(), layers);
            let colors = Raster::read(&path).unwrap();
            assert_eq!((colors.image.rgb[3], colors.crop), (image.rgb[3], crop));
        }
        exr.save_with(&path, &layers).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in 4..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_layers(&path).is_err(), "{length}");
        }
        picture(OutputFormat::Png8).save_with(&path, &layers).unwrap();
        assert_eq!(read_layers(&path).unwrap(), []);
        assert!(read_layers(&folder.path().join("none")).is_err());
    }
}
