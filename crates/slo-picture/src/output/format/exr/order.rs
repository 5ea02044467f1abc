//! The order of attributes in the header of an EXR file.
//!
//! `exr` writes attributes of our own in the order of a hash map, which changes from run to run. Equal
//! pictures have equal bytes, so they are sorted in the file. The header keeps its length.

use std::io::{self, Read, Seek, SeekFrom, Write};

use super::super::container::KEYWORD;
use super::seal::{self, Attributes};

/// Bytes of the header that are read first.
const PIECE: usize = 1 << 16;

/// Sorts the attributes: those of EXR as they are, the recipe, the hash, and masks by their names.
pub(super) fn sort_attributes(mut file: impl Read + Write + Seek) -> io::Result<()> {
    let mut start = Vec::new();
    file.rewind()?;
    let end = loop {
        let (before, more) = (start.len(), start.len().max(PIECE));
        Read::take(&mut file, more as u64).read_to_end(&mut start)?;
        let mut attributes = Attributes::of(&start);
        attributes.by_ref().for_each(drop);
        if attributes.is_whole {
            break attributes.at;
        }
        if start.len() == before {
            return Err(io::ErrorKind::InvalidData.into());
        }
    };
    let mut attributes = Vec::new();
    let mut begin = HEAD;
    for (name, value) in Attributes::of(&start) {
        attributes.push((place(name), &start[begin..value.end]));
        begin = value.end;
    }
    attributes.sort_by_key(|(place, _)| *place);
    let sorted: Vec<u8> = attributes.iter().flat_map(|(_, bytes)| *bytes).copied().collect();
    debug_assert_eq!(sorted.len(), end - HEAD);
    file.seek(SeekFrom::Start(HEAD as u64))?;
    file.write_all(&sorted)
}

/// Bytes of the magic number and the version.
const HEAD: usize = 8;

/// Attributes are sorted by this; those for which it is equal stay as they are.
fn place(name: &[u8]) -> (u8, &[u8]) {
    match name {
        _ if name == KEYWORD.as_bytes() => (1, b""),
        _ if name == seal::KEYWORD.as_bytes() => (2, b""),
        _ if name.starts_with(seal::MASKS) => (3, name),
        _ => (0, b""),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use slo_scene::{LayerNames, Look, MaskNames, OutputFormat};

    use super::*;
    use crate::film::{FileLayer, Image, Layer};
    use crate::output::format::samples::sample_image;
    use crate::output::format::{Picture, Raster};

    fn file(names: usize) -> Vec<u8> {
        let names: Vec<String> = (0..names).map(|i| format!("a rather long name {i}")).collect();
        let names = || MaskNames::new(names.iter().map(String::as_str));
        let names = LayerNames { objects: names(), materials: names(), ..LayerNames::default() };
        let image = sample_image();
        let layers = FileLayer::all(&[Layer::CryptoObject, Layer::CryptoMaterial], &names);
        let layers: Vec<(FileLayer, Image)> =
            layers.into_iter().map(|layer| (layer, image.clone())).collect();
        let (format, look) = (OutputFormat::Exr, Look::default());
        let picture = Picture { image: &image, format, look, recipe: "{}", crop: None };
        let mut out = Cursor::new(Vec::new());
        picture.write_with(&mut out, &layers).unwrap();
        out.into_inner()
    }

    #[test]
    fn the_order_is_the_same_in_every_run() {
        for names in [0, 3, 20_000] {
            let whole = file(names);
            let found: Vec<_> = Attributes::of(&whole).map(|(name, _)| name.to_owned()).collect();
            assert_eq!(found.len(), 20);
            assert_eq!(found[10], KEYWORD.as_bytes());
            assert_eq!(found[11], seal::KEYWORD.as_bytes());
            assert!(found[12..].is_sorted() && found[12].starts_with(seal::MASKS));
            for _ in 0..3 {
                assert!(file(names) == whole, "{names} names");
            }
            assert_eq!(Raster::from_bytes(whole).unwrap().image.width, sample_image().width);
        }
    }
}
