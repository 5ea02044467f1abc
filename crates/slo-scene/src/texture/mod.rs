//! Images, as their files have them.

mod decoded;
mod exr;
mod hdr;
mod image;
mod jpeg;
mod load;
mod png;
mod srgb;
mod texels;
mod unusable;

pub use decoded::LoadedTexture;
pub(crate) use decoded::NEVER_SHOWN;
pub use image::Texture;
pub use load::load;
pub use png::png_reason;
