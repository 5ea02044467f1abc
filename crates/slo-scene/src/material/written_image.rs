//! How materials name the images that they use: `roughness_texture NAME`, or with a block that says
//! which channel counts and how the image lies on the surface.

use super::palette::Palette;
use super::texture::{Channel, ImageUse};
use crate::attributes::schema::{Attribute, choice, number, word};
use crate::attributes::{Bound, Fields, Value};
use crate::format::syntax::Word;
use crate::settings::Curve;
use crate::texture::Texture;

/// What stands in the block of an image for numbers and colours.
pub(super) const IMAGE: &[Attribute] = &[
    word("texture", "NAME").required(),
    choice("channel"),
    number("scale_U"),
    number("scale_V"),
    number("offset_U"),
    number("offset_V"),
    number("turn_deg").elsewhere(&["rotation", "turn"]),
];

/// What stands in the block of an image of normals.
pub(super) const NORMALS: &[Attribute] = &[
    word("texture", "NAME").required(),
    number("scale_U"),
    number("scale_V"),
    number("offset_U"),
    number("offset_V"),
    number("turn_deg").elsewhere(&["rotation", "turn"]),
];

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// A colour that people chose: files of 8 bits hold it with the curve of screens.
    Color,
    /// A number: the luminance, unless a channel is named.
    Number,
    /// How much of the surface is there: alpha where the image has it, otherwise a number.
    Alpha,
    /// Normals.
    Normals,
}

/// The image of an attribute; `None` if there is none, or if something is wrong, which is reported.
pub(super) fn read_image<'a>(
    fields: &mut Fields<'_, 'a, '_>,
    palette: &mut Palette<'_, 'a>,
    name: &str,
    purpose: Purpose,
) -> Option<ImageUse> {
    let field = fields.get(name)?;
    if let Value::Word(texture) = field.value {
        return image_use(palette, texture, None, purpose);
    }
    let mut block = fields.open(field)?;
    let channel = block.choice("channel", &Channel::WORDS).and_then(Channel::by_name);
    let mut number = |name, default| block.number_f32(name, Bound::Any).unwrap_or(default);
    let scale = [number("scale_U", 1.0), number("scale_V", 1.0)];
    let offset = [number("offset_U", 0.0), number("offset_V", 0.0)];
    let turn_deg = number("turn_deg", 0.0);
    let texture = block.word("texture")?;
    let image = image_use(palette, texture, channel, purpose)?;
    Some(ImageUse { scale, offset, turn_deg, ..image })
}

/// A texture, laid on a surface by its texture coordinates.
fn image_use<'a>(
    palette: &mut Palette<'_, 'a>,
    name: Word<'a>,
    channel: Option<Channel>,
    purpose: Purpose,
) -> Option<ImageUse> {
    let texture = palette.texture(name)?;
    let image = palette.image(texture);
    let has_alpha = image.is_some_and(Texture::has_alpha);
    let channel = channel.unwrap_or(match purpose {
        Purpose::Color | Purpose::Normals => Channel::Color,
        Purpose::Alpha if has_alpha => Channel::Alpha,
        Purpose::Number | Purpose::Alpha => Channel::Luminance,
    });
    // An image that can't be loaded was reported.
    let encoding = image.map_or(Curve::Raw, |image| match purpose {
        Purpose::Color => image.color_curve(),
        Purpose::Number | Purpose::Alpha | Purpose::Normals => image.data_curve(),
    });
    let (scale, offset, turn_deg) = ([1.0; 2], [0.0; 2], 0.0);
    Some(ImageUse { texture, channel, encoding, scale, turn_deg, offset })
}
