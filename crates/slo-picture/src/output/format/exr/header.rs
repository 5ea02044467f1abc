//! What the headers of our EXR files hold.

use std::io::{self, Read, Seek};

use exr::compression::Compression;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, ChannelDescription, ChannelList, Text};
use exr::meta::header::Header;
use slo_scene::{Layer, LayerNames, LightGroups};

use super::super::container::KEYWORD;
use super::seal;
use crate::film::{FileLayer, Mask, MaskKind};

/// The channels of the colours.
pub(super) fn color_names() -> [Text; 3] {
    ["R", "G", "B"].map(Text::from)
}

/// The channels of a layer. A name is bytes of UTF-8.
pub(super) fn channel_names(layer: &FileLayer) -> Vec<Text> {
    let name = layer.name();
    let channel = |c: &&str| Text::from_slice_unchecked(format!("{name}.{c}").as_bytes());
    layer.components().iter().map(channel).collect()
}

/// The layers that a file with these headers may have beside lights, in the order of
/// [`FileLayer::all`].
pub(super) fn possible_layers(headers: &[Header]) -> impl Iterator<Item = FileLayer> {
    let names_of = |kind| {
        let attribute = Mask::manifest_attribute(kind);
        let mut texts = headers.iter().flat_map(|header| &header.own_attributes.other);
        let manifest = texts.find_map(|(name, value)| match value {
            AttributeValue::Text(text) if name.eq(attribute.as_str()) => Some(text.to_string()),
            _ => None,
        });
        Mask::of_manifest(kind, &manifest.unwrap_or_default()).names
    };
    let names = LayerNames {
        objects: names_of(MaskKind::Object),
        materials: names_of(MaskKind::Material),
        ..LayerNames::default()
    };
    let others = Layer::ALL.into_iter().filter(|layer| *layer != Layer::Lights);
    others.flat_map(move |layer| FileLayer::all(&[layer], &names))
}

/// The layers of groups of lights among these channels, in the order of [`FileLayer::all`].
pub(super) fn light_layers(channels: &ChannelList) -> Vec<FileLayer> {
    let group = |channel: &ChannelDescription| {
        let name = std::str::from_utf8(channel.name.bytes()).ok()?;
        let group = name.strip_prefix(Layer::Lights.name())?.strip_prefix('.')?;
        group.strip_suffix(".R").map(str::to_owned)
    };
    let names: Vec<String> = channels.list.iter().filter_map(group).collect();
    let groups = LightGroups::new(names.iter().map(String::as_str));
    let all = LayerNames { lights: groups, ..LayerNames::default() };
    let mut layers = FileLayer::all(&[Layer::Lights], &all);
    layers.retain(|layer| matches!(layer, FileLayer::Light(name) if names.contains(name)));
    layers
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
    let Some(mut names) = seal::names(file)? else { return Ok(true) };
    // Those of masks come last.
    names.truncate(names.len() - trailing_masks(&names));
    let place = |name: &Vec<u8>| NAMES.iter().position(|ours| ours.as_bytes() == name);
    let known: Vec<usize> = names.iter().filter_map(place).collect();
    let compression = meta.headers.first().map(|header| header.compression);
    Ok(names.len() <= NAMES.len()
        && names.len() - known.len() <= 2
        && known.is_sorted()
        && compression == Some(Compression::RLE))
}

/// The number of names at the end that are attributes of masks.
fn trailing_masks(names: &[Vec<u8>]) -> usize {
    names.iter().rev().take_while(|name| name.starts_with(seal::MASKS)).count()
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
