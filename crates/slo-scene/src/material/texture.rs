//! Images as materials use them.

use crate::settings::Curve;

/// Index into the textures of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// A texture as a Phong material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// The image.
    pub texture: TextureId,
    /// `scale_U`, `scale_V`: repetitions over one unit of uv.
    pub scale: [f32; 2],
}

/// An image as a physical material uses it, for a number, a colour or normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageUse {
    /// The image.
    pub texture: TextureId,
    /// What of a texel counts. A colour of one channel is grey.
    pub channel: Channel,
    /// The curve that is removed from red, green and blue before interpolation; never from alpha.
    pub encoding: Curve,
    /// Texture coordinates are scaled, then turned, then moved: `scale_U`, `scale_V`.
    pub scale: [f32; 2],
    /// `turn_deg`, counter-clockwise, degrees.
    pub turn_deg: f32,
    /// `offset_U`, `offset_V`
    pub offset: [f32; 2],
}

/// What of a texel counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red, green and blue.
    Color,
    /// The luminance of red, green and blue.
    Luminance,
    /// One channel.
    Red,
    /// One channel.
    Green,
    /// One channel.
    Blue,
    /// One channel; 1 if the image has none.
    Alpha,
}

impl Channel {
    /// The words of the language.
    pub(super) const WORDS: [&'static str; 4] = ["R", "G", "B", "A"];

    /// The channel of a word.
    pub(super) fn by_name(word: &str) -> Option<Self> {
        match word {
            "R" => Some(Self::Red),
            "G" => Some(Self::Green),
            "B" => Some(Self::Blue),
            "A" => Some(Self::Alpha),
            _ => None,
        }
    }
}
