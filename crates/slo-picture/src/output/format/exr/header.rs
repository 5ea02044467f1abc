//! What the headers of our EXR files hold.

use std::io::{self, Read, Seek};

use exr::compression::Compression;
use exr::meta::MetaData;
use slo_scene::Layer;

use super::super::container::KEYWORD;
use super::seal;

/// The channels of a layer.
pub(super) fn channel_names(layer: Layer) -> [String; 3] {
    let components = match layer {
        Layer::Albedo => ["R", "G", "B"],
        Layer::Normal => ["X", "Y", "Z"],
    };
    components.map(|component| format!("{}.{component}", layer.name()))
}

/// The attributes of our files, in their order.
const NAMES: [&str; 12] = [
    "chunkCount",
    "channels",
    "compression",
    "lineOrder",
    "displayWindow",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "dataWindow",
    "type",
    KEYWORD,
    seal::KEYWORD,
];

/// Whether the header is one of ours, perhaps damaged. Other programs write more attributes, or in
/// another order, or none of ours, and compress in another way. Damage makes one or two names unknown.
pub(super) fn is_our_header(file: impl Read + Seek, meta: &MetaData) -> io::Result<bool> {
    let Some(names) = seal::names(file)? else { return Ok(true) };
    let place = |name: &Vec<u8>| NAMES.iter().position(|ours| ours.as_bytes() == name);
    let known: Vec<usize> = names.iter().filter_map(place).collect();
    let compression = meta.headers.first().map(|header| header.compression);
    Ok(names.len() <= NAMES.len()
        && names.len() - known.len() <= 2
        && known.is_sorted()
        && compression == Some(Compression::RLE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::format::samples::{bytes, sample_image};
    use crate::output::format::{Encoding, OutputFormat};

    #[test]
    fn our_header_is_known() {
        let file = bytes(OutputFormat::Exr, Encoding::Raw, &sample_image());
        let names = seal::names(io::Cursor::new(&file)).unwrap().unwrap();
        assert_eq!(names, NAMES.map(|name| name.as_bytes().to_owned()));
        let meta = MetaData::read_from_buffered(&file[..], false).unwrap();
        assert!(is_our_header(io::Cursor::new(&file), &meta).unwrap());
    }
}
