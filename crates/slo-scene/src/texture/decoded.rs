//! What decoders of all formats have in common.

use super::image::{Alpha, Texture};
use super::texels::{Layout, Samples};
use crate::format::FileError;
use crate::memory;

/// Texels that an image may have: 16384 x 16384, which takes 0.8 GB at 8 bits a channel.
const MAX_TEXELS: u64 = 1 << 28;

/// An image, and what is odd about its file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTexture {
    /// The image.
    pub texture: Texture,
    /// What is not as its author may expect, one line each.
    pub warnings: Vec<String>,
}

/// The warning about a transparent image whose alpha no use shows.
pub(crate) const NEVER_SHOWN: &str =
    "it has transparent pixels, but alpha is not used: they show their colour";

/// Refuses images that would take more memory than a texture is worth, or than there is; decoding takes
/// so many bytes for each texel.
pub(super) fn check_size(width: u32, height: u32, bytes: u64) -> Result<(), FileError> {
    let texels = u64::from(width) * u64::from(height);
    if texels <= MAX_TEXELS {
        return memory::check(texels * bytes).map_err(|refusal| {
            FileError::whole_file(format!(
                "the image has {width} x {height} pixels and needs {refusal}"
            ))
            .with_help("scale it down")
        });
    }
    Err(FileError::whole_file(format!(
        "the image has {width} x {height} pixels, more than {MAX_TEXELS}"
    ))
    .with_help("scale it down: 16384 x 16384 pixels are the most that a texture may have"))
}

/// What to say about a file that starts right but can't be decoded.
pub(super) fn damaged(format: &str, reason: &str) -> FileError {
    FileError::whole_file(format!("the {format} image is damaged: {}", reason.trim()))
}

/// A decoded image.
pub(super) fn texture(
    width: u32,
    height: u32,
    layout: Layout,
    samples: Samples,
    alpha: Alpha,
    warnings: Vec<String>,
) -> Result<LoadedTexture, FileError> {
    let texture = Texture::new(width, height, layout, samples, alpha);
    let texture = texture.ok_or_else(|| FileError::whole_file("the image has no pixels"))?;
    Ok(LoadedTexture { texture, warnings })
}

/// Drops alpha if it is `opaque` everywhere; otherwise it is `alpha`.
pub(super) fn without_opaque_alpha<C: Copy + PartialEq>(
    layout: Layout,
    mut values: Vec<C>,
    opaque: C,
    alpha: Alpha,
) -> (Layout, Vec<C>, Alpha) {
    let channels = layout.channels();
    let without = match layout {
        Layout::Grey | Layout::Rgb => return (layout, values, Alpha::None),
        Layout::GreyAlpha => Layout::Grey,
        Layout::Rgba => Layout::Rgb,
    };
    if values.chunks_exact(channels).any(|pixel| pixel[channels - 1] != opaque) {
        return (layout, values, alpha);
    }
    let (pixels, kept) = (values.len() / channels, without.channels());
    for pixel in 0..pixels {
        values.copy_within(channels * pixel..channels * pixel + kept, kept * pixel);
    }
    values.truncate(kept * pixels);
    values.shrink_to_fit();
    (without, values, Alpha::Opaque)
}
