//! `texture`: an image file, and how it is looked up.

use std::sync::Arc;

use crate::assets::Assets;
use crate::attributes::Fields;
use crate::attributes::schema::{Schema, choice, word};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::material::{Material, MaterialKind};
use crate::settings::{Curve, Filter, Wrap};
use crate::texture::{NEVER_SHOWN, Texture};

/// `texture`
pub(super) const TEXTURE: Schema = Schema::new(
    "texture",
    &[word("filename", "PATH").required(), choice("encoding"), choice("wrap"), choice("filter")],
);

/// A texture, with the path of its file.
pub(super) struct Image<'a> {
    /// `None` if it can't be loaded, which was reported.
    pub(super) texture: Option<Arc<Texture>>,
    path: Option<(&'a str, Span)>,
}

/// Reads the element.
pub(super) fn texture<'a>(fields: &mut Fields<'_, 'a, '_>, assets: &mut Assets<'_>) -> Image<'a> {
    let encoding: Option<Curve> = fields.one_of("encoding");
    let wrap: Option<Wrap> = fields.one_of("wrap");
    let filter: Option<Filter> = fields.one_of("filter");
    let Some(path) = fields.word("filename") else {
        return Image { texture: None, path: None };
    };
    let texture = assets.texture(path, fields.diagnostics).map(|texture| {
        let as_written = Texture::clone(&texture)
            .with_wrap(wrap.unwrap_or(texture.wrap()))
            .with_filter(filter.unwrap_or(texture.filter()))
            .with_encoding(encoding);
        Arc::new(as_written)
    });
    Image { texture, path: Some((path.text, path.span)) }
}

/// Warns once for each file with transparent pixels that materials show without alpha.
pub(super) fn warn_of_alpha(
    images: &[Image<'_>],
    materials: &[Material],
    diagnostics: &mut Diagnostics,
) {
    let mut warned = Vec::new();
    for image in materials.iter().filter_map(|material| without_alpha(&material.kind)) {
        let Some(Image { texture: Some(texture), path: Some((path, span)) }) = images.get(image)
        else {
            continue;
        };
        if texture.is_transparent() && !warned.contains(path) {
            warned.push(*path);
            let message = format!("texture `{path}`: {NEVER_SHOWN}");
            diagnostics.push(Diagnostic::warning(message).at(*span, ""));
        }
    }
}

/// The image that a material shows without its alpha.
fn without_alpha(kind: &MaterialKind) -> Option<usize> {
    match kind {
        MaterialKind::Phong(phong) => Some(phong.texture?.texture.0 as usize),
        MaterialKind::Principled(_) | MaterialKind::Mix(_) => None,
    }
}
