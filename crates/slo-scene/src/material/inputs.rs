//! The list of what a physical material takes.

use crate::attributes::schema::{Attribute, Kind};
use crate::attributes::{Fields, Value};
use crate::diagnostics::Diagnostic;

/// Defines a material from the list of its inputs: each row becomes a field, a default, two
/// attributes of the element (the value, and its image), reading, checks and a row of the
/// documentation.
///
/// `in` gives the range of values, `as` what an image is for, `needs` the input without which a value has no effect, and `also`
/// what other programs and formats call it.
macro_rules! inputs {
    (@purpose $Type:ty, $purpose:expr) => { $purpose };
    (@purpose $Type:ty) => { <$Type as Quantity>::PURPOSE };
    (
        $(#[$of:meta])*
        pub struct $Material:ident {
            $(
                $(#[doc = $about:literal])+
                $input:ident: $Type:ty = $default:expr, in $range:expr $(, as $purpose:expr)?
                $(, needs $needed:ident)? $(, also [$($other:literal),+])?;
            )+
        } with {
            $( $(#[doc = $about_other:literal])+ $field:ident: $Other:ty = $value:expr, )*
        }
    ) => {
        $(#[$of])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $Material {
            $( $(#[doc = $about])+ pub $input: Varying<$Type>, )+
            $( $(#[doc = $about_other])+ pub $field: $Other, )*
        }

        impl Default for $Material {
            fn default() -> Self {
                Self {
                    $( $input: Varying::constant($default), )+
                    $( $field: $value, )*
                }
            }
        }

        impl $Material {
            /// The attributes of all inputs, in the order of the list.
            const INPUTS: &'static [Attribute] = &[
                $(
                    $crate::material::inputs::value(
                        stringify!($input),
                        <$Type as Quantity>::KIND,
                        &[$($($other),+)?],
                    ),
                    word_or_block(
                        "NAME",
                        &Schema::new(concat!(stringify!($input), "_texture"), IMAGE),
                    )
                    .elsewhere(&[$($(
                        concat!($other, "_texture"),
                        concat!($other, "_map"),
                    )+)? concat!(stringify!($input), "_map")]),
                )+
            ];

            /// Reads all inputs.
            fn read_inputs<'a>(
                &mut self,
                fields: &mut Fields<'_, 'a, '_>,
                palette: &mut Palette<'_, 'a>,
            ) {
                $(
                    let names = [stringify!($input), concat!(stringify!($input), "_texture")];
                    self.$input = read_varying(
                        fields,
                        palette,
                        names,
                        ($default, $range),
                        inputs!(@purpose $Type $(, $purpose)?),
                    );
                )+
            }

            /// Warns of inputs that have no effect, since another one is 0.
            fn check_inputs(&self, fields: &mut Fields<'_, '_, '_>) {
                $( $(
                    let is_used = self.$needed.value.largest() > 0.0;
                    let is_given = self.$input != Varying::constant($default);
                    if is_given && !is_used {
                        $crate::material::inputs::warn_idle(
                            fields,
                            stringify!($input),
                            stringify!($needed),
                        );
                    }
                )? )+
            }

            /// Hands the image of each input to `put`.
            fn for_input_images(&self, put: &mut dyn FnMut(TextureId)) {
                $( self.$input.texture().into_iter().for_each(&mut *put); )+
            }

            /// The rows of the table of inputs in the documentation.
            #[cfg(test)]
            fn documentation() -> Vec<String> {
                vec![ $( {
                    let [default, range] = <$Type as Quantity>::documented($default, $range);
                    let about = [$($about),+].map(str::trim).join(" ");
                    let about = about.trim_end_matches('.');
                    format!("| `{}` | {default} | {range} | {about} |", stringify!($input))
                } ),+ ]
            }
        }
    };
}
pub(super) use inputs;

/// The attribute of a value.
pub(super) const fn value(
    name: &'static str,
    kind: Kind,
    elsewhere: &'static [&'static str],
) -> Attribute {
    Attribute::new(name, kind).elsewhere(elsewhere)
}

/// Warns of an input, or its image, that has no effect without another one.
pub(super) fn warn_idle(fields: &mut Fields<'_, '_, '_>, name: &str, needed: &str) {
    let image = format!("{name}_texture");
    let Some(field) = fields.get(name).or_else(|| fields.get(&image)) else { return };
    let is_broken =
        |name: &str| fields.get(name).is_some_and(|field| matches!(field.value, Value::Broken));
    if is_broken(needed) || is_broken(&format!("{needed}_texture")) {
        return;
    }
    let message = format!("`{}` has no effect without `{needed}`", field.keyword.text);
    let warning = Diagnostic::warning(message).at(field.keyword.span, "");
    let usage = fields.element.schema.attribute(needed).map(Attribute::usage).unwrap_or_default();
    let help = match fields.get(needed) {
        None => format!("write {usage}"),
        Some(_) => format!("`{needed}` is 0"),
    };
    fields.diagnostics.push(warning.help(help));
}
