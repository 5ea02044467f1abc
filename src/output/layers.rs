//! Layers of pictures that are there.

use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

use exr::image::FlatSamples;
use exr::prelude::{ReadChannels, ReadLayers};

use super::exr::channel_names;
use super::file::open_regular;
use crate::film::{Image, Layer};

/// The layers that an EXR file has beside its colours, in the order of [`Layer::ALL`]; none of any
/// other file.
///
/// # Errors
/// What the system says, or what is wrong with the file.
pub fn read_layers(path: &Path) -> Result<Vec<(Layer, Image)>, String> {
    let mut input = BufReader::new(open_regular(path).map_err(|error| error.to_string())?);
    match input.fill_buf().map_err(|error| error.to_string())? {
        [0x76, 0x2f, 0x31, 0x01, ..] => decode(input),
        _ => Ok(Vec::new()),
    }
}

fn decode(input: impl BufRead + Seek) -> Result<Vec<(Layer, Image)>, String> {
    let read = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(input)
        .map_err(|error| error.to_string())?
        .layer_data;
    let (width, height) = (read.size.width() as u32, read.size.height() as u32);
    let samples = |name: &str| {
        let found = read.channel_data.list.iter().find(|channel| channel.name.eq(name))?;
        Some(&found.sample_data)
    };
    let layer = |layer: Layer| {
        let names = channel_names(layer);
        let [x, y, z] = [samples(&names[0])?, samples(&names[1])?, samples(&names[2])?];
        let rgb = values(x).zip(values(y)).zip(values(z)).map(|((x, y), z)| [x, y, z]).collect();
        Some((layer, Image { width, height, rgb }))
    };
    Ok(Layer::ALL.into_iter().filter_map(layer).collect())
}

fn values(samples: &FlatSamples) -> impl Iterator<Item = f32> {
    samples.values_as_f32()
}

#[cfg(test)]
mod tests {
    use super::super::Picture;
    use super::super::tests::sample_image;
    use super::*;
    use crate::film::Area;
    use crate::output::{Crop, Raster};
    use crate::scene::{Encoding, OutputFormat};

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
