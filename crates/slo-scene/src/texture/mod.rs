//! Images, as their files have them.

mod decoded;
mod image;
mod jpeg;
mod load;
mod png;

pub use decoded::LoadedTexture;
pub use image::Texture;
pub use load::load;
pub use png::png_reason;
