//! Values that may vary over a surface, and how they are written.

use super::palette::Palette;
use super::texture::{ImageUse, TextureId};
use super::written_image::{Purpose, read_image};
use crate::attributes::schema::Kind;
use crate::attributes::{Bound, Fields, looks_like_bytes};
use crate::diagnostics::Diagnostic;

/// How much more light than arrives a surface may give back by the rounding of its colour.
const ROUNDING: f32 = 1e-3;

/// A value that may vary over a surface: a constant, multiplied by an image if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Varying<T> {
    /// The constant; 1 if the scene has only the image.
    pub value: T,
    /// The image.
    pub image: Option<ImageUse>,
}

impl<T> Varying<T> {
    /// The same value everywhere.
    pub const fn constant(value: T) -> Self {
        Self { value, image: None }
    }

    /// The texture, if there is an image.
    pub(super) fn texture(&self) -> Option<TextureId> {
        Some(self.image.as_ref()?.texture)
    }
}

/// A number or a colour.
pub(super) trait Quantity: Copy + PartialEq + 'static {
    /// How it is written.
    const KIND: Kind;

    /// What an image is multiplied by if no constant is written.
    const NEUTRAL: Self;

    /// What an image is for.
    const PURPOSE: Purpose;

    /// Which values make sense.
    type Range: Copy;

    /// The value of an attribute; reports one that does not make sense.
    fn read(
        fields: &mut Fields<'_, '_, '_>,
        name: &'static str,
        range: Self::Range,
    ) -> Option<Self>;

    /// The largest component.
    fn largest(self) -> f32;

    /// As documentation shows a default and a range.
    #[cfg(test)]
    fn documented(self, range: Self::Range) -> [String; 2];
}

impl Quantity for f32 {
    const KIND: Kind = Kind::Number;
    const NEUTRAL: Self = 1.0;
    const PURPOSE: Purpose = Purpose::Number;
    type Range = Bound;

    fn read(fields: &mut Fields<'_, '_, '_>, name: &'static str, range: Bound) -> Option<Self> {
        fields.number_f32(name, range)
    }

    fn largest(self) -> f32 {
        self
    }

    #[cfg(test)]
    fn documented(self, range: Bound) -> [String; 2] {
        let rule = range.broken_by(f64::NAN).unwrap_or_default();
        let range = rule.trim_start_matches("must be ").trim_start_matches("from ");
        [self.to_string(), range.to_owned()]
    }
}

/// What a colour says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ColorOf {
    /// How much of the light that arrives a surface gives back: from 0 to 1.
    Surface,
    /// Light: 0 or more.
    Light,
}

impl Quantity for [f32; 3] {
    const KIND: Kind = Kind::Vector("r g b");
    const NEUTRAL: Self = [1.0; 3];
    const PURPOSE: Purpose = Purpose::Color;
    type Range = ColorOf;

    fn read(fields: &mut Fields<'_, '_, '_>, name: &'static str, range: ColorOf) -> Option<Self> {
        let color = fields.color(name)?;
        if range == ColorOf::Surface && color.largest() > 1.0 + ROUNDING && !looks_like_bytes(color)
        {
            let message = format!("`{name}` is {}: more light than arrives", color.largest());
            let span = fields.get(name)?.keyword.span;
            let warning = Diagnostic::warning(message).at(span, "");
            fields.diagnostics.push(warning.help("colours of surfaces are from 0 to 1"));
        }
        Some(color)
    }

    fn largest(self) -> f32 {
        self.into_iter().fold(0.0, f32::max)
    }

    #[cfg(test)]
    fn documented(self, range: ColorOf) -> [String; 2] {
        let [r, g, b] = self;
        let range = if range == ColorOf::Surface { "0 to 1" } else { "0 or more" };
        [format!("`{{ {r} {g} {b} }}`"), range.to_owned()]
    }
}

/// Reads a value that may vary: its constant, and the image of the attribute `image`.
pub(super) fn read_varying<'a, T: Quantity>(
    fields: &mut Fields<'_, 'a, '_>,
    palette: &mut Palette<'_, 'a>,
    [name, image]: [&'static str; 2],
    (default, range): (T, T::Range),
    purpose: Purpose,
) -> Varying<T> {
    let constant = T::read(fields, name, range);
    let is_written = fields.get(name).is_some();
    let read = read_image(fields, palette, image, purpose);
    if let (Some(value), Some(field)) = (constant, fields.get(image))
        && value.largest() == 0.0
    {
        let message = format!("`{image}` has no effect, since `{name}` is 0");
        let warning = Diagnostic::warning(message).at(field.keyword.span, "");
        let help = format!("the image is multiplied by `{name}`: leave that out, or write 1");
        fields.diagnostics.push(warning.help(help));
    }
    let alone = read.is_some() && !is_written;
    Varying { value: constant.unwrap_or(if alone { T::NEUTRAL } else { default }), image: read }
}
