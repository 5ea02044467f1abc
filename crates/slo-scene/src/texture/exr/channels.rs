//! Which channels of an OpenEXR file are the image.

use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;

use super::unsupported;
use crate::format::FileError;
use crate::texture::texels::Layout;

/// What programs call the layer of an image that holds its colours, the likeliest first.
const USUAL: [&str; 10] =
    ["", "combined", "rgba", "rgb", "beauty", "composite", "image", "color", "colour", "default"];

/// Channels that an error names.
const MOST_NAMED: usize = 8;

/// The channels of an image.
#[derive(Debug, PartialEq)]
pub(super) struct Choice {
    /// The part of the file.
    pub(super) part: usize,
    pub(super) layout: Layout,
    /// Places in the list of the part's channels: red, green, blue and alpha, as the layout says.
    pub(super) channels: Vec<usize>,
}

/// The colours of the layer that is called as usual, or of the first; without colours, its grey.
///
/// # Errors
/// No channels look like an image.
pub(super) fn choose(parts: &[Header]) -> Result<Choice, FileError> {
    let flat = parts.iter().enumerate().filter(|(_, part)| !part.deep);
    let layers: Vec<_> = flat.flat_map(|(i, part)| layers(i, part, parts.len() > 1)).collect();
    if layers.is_empty() {
        return Err(unsupported("it is a deep image, which has several samples for each pixel"));
    }
    let best = |of: fn(&Layer) -> Option<Vec<usize>>| {
        let found = layers.iter().filter_map(|layer| Some((layer, of(layer)?)));
        found.min_by_key(|(layer, _)| layer.rank())
    };
    let (layer, mut channels) = match best(Layer::colors).or_else(|| best(Layer::grey)) {
        Some(found) => found,
        None => match &layers[..] {
            [only] if only.channels.len() == 1 => (only, vec![only.channels[0].0]),
            _ => return Err(no_image(&layers)),
        },
    };
    let alpha = layer.find("a").filter(|alpha| !channels.contains(alpha));
    channels.extend(alpha);
    let layout = match channels.len() {
        1 => Layout::Grey,
        2 => Layout::GreyAlpha,
        3 => Layout::Rgb,
        _ => Layout::Rgba,
    };
    Ok(Choice { part: layer.part, layout, channels })
}

/// Whether all of these channels are half floats.
pub(super) fn are_halves(part: &Header, channels: &[usize]) -> bool {
    channels.iter().all(|&channel| part.channels.list[channel].sample_type == SampleType::F16)
}

/// Channels whose names are the same up to their last dot.
struct Layer {
    part: usize,
    /// In lower case.
    name: String,
    /// Places in the list of the part, with the last parts of their names in lower case, and their
    /// whole names.
    channels: Vec<(usize, String, String)>,
}

impl Layer {
    /// The channel of a name.
    fn find(&self, name: &str) -> Option<usize> {
        self.channels.iter().find(|(_, last, _)| last == name).map(|(place, ..)| *place)
    }

    fn colors(&self) -> Option<Vec<usize>> {
        ["r", "g", "b"].into_iter().map(|name| self.find(name)).collect()
    }

    fn grey(&self) -> Option<Vec<usize>> {
        let has_chroma = self.find("ry").is_some() || self.find("by").is_some();
        if has_chroma { None } else { Some(vec![self.find("y")?]) }
    }

    /// Lower for likelier names.
    fn rank(&self) -> usize {
        let last = self.name.rsplit('.').next().unwrap_or_default();
        USUAL.iter().position(|usual| *usual == last).unwrap_or(USUAL.len())
    }
}

/// The layers of a part, in the order of its channels.
fn layers(part: usize, header: &Header, is_one_of_several: bool) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (place, channel) in header.channels.list.iter().enumerate() {
        let whole = name(channel);
        let (prefix, last) = whole.rsplit_once('.').unwrap_or(("", &whole));
        let layer = match &header.own_attributes.layer_name {
            Some(part) if prefix.is_empty() && is_one_of_several => part.to_string(),
            _ => prefix.to_owned(),
        };
        let layer = layer.to_lowercase();
        let channel = (place, last.to_lowercase(), whole.clone());
        match layers.iter_mut().find(|known| known.name == layer) {
            Some(known) => known.channels.push(channel),
            None => layers.push(Layer { part, name: layer, channels: vec![channel] }),
        }
    }
    layers
}

fn name(channel: &ChannelDescription) -> String {
    channel.name.to_string()
}

fn no_image(layers: &[Layer]) -> FileError {
    let names = layers.iter().flat_map(|layer| &layer.channels).map(|(.., name)| name);
    let names: Vec<_> = names.map(|name| format!("`{}`", name.escape_debug())).collect();
    let more = match names.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} others"),
    };
    let named = names[..names.len().min(MOST_NAMED)].join(", ");
    FileError::whole_file(format!(
        "the EXR image has no channels `R`, `G` and `B`, and no `Y`, but {named}{more}"
    ))
    .with_help("save it as an RGB or grey image")
}

#[cfg(test)]
mod tests {
    use exr::meta::attribute::{ChannelList, Text};
    use exr::prelude::{Compression, LineOrder, Vec2};

    use super::*;

    fn part(name: Option<&str>, channels: &[&str]) -> Header {
        let list = channels.iter().map(|n| ChannelDescription::named(*n, SampleType::F16));
        let mut header =
            Header::new(Text::from(name.unwrap_or("only")), Vec2(1, 1), list.collect());
        header.channels = ChannelList::new(header.channels.list);
        if name.is_none() {
            header.own_attributes.layer_name = None;
        }
        header.with_encoding(
            Compression::Uncompressed,
            exr::meta::BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
    }

    /// The part and the names that are chosen.
    fn chosen(parts: &[Header]) -> (usize, String) {
        let choice = choose(parts).unwrap();
        let list = &parts[choice.part].channels.list;
        let names = choice.channels.iter().map(|&channel| list[channel].name.to_string());
        (choice.part, names.collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn the_layer_of_the_usual_name_is_chosen() {
        let one = |channels: &[&str]| chosen(&[part(None, channels)]).1;
        assert_eq!(one(&["A", "B", "G", "R"]), "R G B A");
        assert_eq!(one(&["B", "G", "R", "albedo.B", "albedo.G", "albedo.R"]), "R G B");
        assert_eq!(one(&["b", "g", "r"]), "r g b");
        assert_eq!(one(&["Y"]), "Y");
        assert_eq!(one(&["A", "Y"]), "Y A");
        assert_eq!(one(&["height.V"]), "height.V");
        assert_eq!(one(&["A"]), "A");
        assert_eq!(
            one(&[
                "V.AO.B",
                "V.AO.G",
                "V.AO.R",
                "V.Combined.A",
                "V.Combined.B",
                "V.Combined.G",
                "V.Combined.R"
            ]),
            "V.Combined.R V.Combined.G V.Combined.B V.Combined.A"
        );
        assert_eq!(one(&["x.B", "x.G", "x.R", "y.B", "y.G", "y.R"]), "x.R x.G x.B");
        assert_eq!(one(&["B", "G", "R", "Y", "Z"]), "R G B");
    }

    #[test]
    fn parts_are_layers_too() {
        let rgb = ["B", "G", "R"];
        let parts = [part(Some("depth"), &["Z"]), part(Some("diffuse"), &rgb)];
        assert_eq!(chosen(&parts).0, 1);
        let parts = [part(Some("diffuse"), &rgb), part(Some("rgba"), &rgb)];
        assert_eq!(chosen(&parts).0, 1);
        let parts = [part(Some("left"), &rgb), part(Some("right"), &rgb)];
        assert_eq!(chosen(&parts).0, 0);
    }

    #[test]
    fn what_is_no_image_is_said_to_be_none() {
        let of = |channels: &[&str]| choose(&[part(None, channels)]).unwrap_err().message;
        insta::assert_snapshot!(
            of(&["Z", "id"]),
            @"the EXR image has no channels `R`, `G` and `B`, and no `Y`, but `Z`, `id`"
        );
        insta::assert_snapshot!(
            of(&["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"]),
            @"the EXR image has no channels `R`, `G` and `B`, and no `Y`, but `a`, `b`, `c`, `d`, `e`, `f`, `g`, `h` and 2 others"
        );
        of(&["BY", "RY", "Y"]);
    }
}
