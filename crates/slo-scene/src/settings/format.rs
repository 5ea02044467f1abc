//! File formats of pictures.

use super::choice::choices;

choices! {
    /// File format of a picture.
    pub enum OutputFormat {
        /// PNG, 8 bits a channel.
        Png8 = "PNG_IMAGE",
        /// PNG, 16 bits a channel.
        Png16 = "PNG16_IMAGE",
        /// OpenEXR, 32-bit float, unclamped, linear whatever the encoding.
        Exr = "EXR_IMAGE",
    }
}

/// What the values of a format are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileValues {
    /// Integers from black to white, on the curve of the film's encoding.
    Encoded {
        /// Bits of a value.
        bits: u32,
    },
    /// Radiance, linear and without an upper end.
    Linear {
        /// Bits of a value.
        bits: u32,
    },
}

/// What is known of a format without knowing how its files are written.
#[derive(Clone, Copy, Debug)]
struct Facts {
    kind: &'static str,
    option: &'static str,
    aliases: &'static [&'static str],
    extension: &'static str,
    values: FileValues,
    has_layers: bool,
}

impl OutputFormat {
    const fn facts(self) -> Facts {
        match self {
            Self::Png8 => Facts {
                kind: "PNG",
                option: "png",
                aliases: &["png8", "png_image"],
                extension: "png",
                values: FileValues::Encoded { bits: 8 },
                has_layers: false,
            },
            Self::Png16 => Facts {
                kind: "PNG",
                option: "png16",
                aliases: &["png16_image"],
                extension: "png",
                values: FileValues::Encoded { bits: 16 },
                has_layers: false,
            },
            Self::Exr => Facts {
                kind: "EXR",
                option: "exr",
                aliases: &["openexr", "exr_image"],
                extension: "exr",
                values: FileValues::Linear { bits: 32 },
                has_layers: true,
            },
        }
    }

    /// The kind of file, as messages call it. Several formats may have the same.
    pub const fn kind(self) -> &'static str {
        self.facts().kind
    }

    /// All kinds of files, as messages list them: "PNG or EXR".
    pub fn kinds() -> String {
        listed(Self::ALL.map(|format| format.kind().to_owned()).into())
    }

    /// All extensions, as messages list them: ".png or .exr".
    pub fn extensions() -> String {
        listed(Self::ALL.map(|format| format!(".{}", format.extension())).into())
    }

    /// The name on the command line.
    pub const fn option(self) -> &'static str {
        self.facts().option
    }

    /// Further names that the command line takes.
    pub const fn aliases(self) -> &'static [&'static str] {
        self.facts().aliases
    }

    /// What names of such files end in.
    pub const fn extension(self) -> &'static str {
        self.facts().extension
    }

    /// What its values are.
    pub const fn values(self) -> FileValues {
        self.facts().values
    }

    /// Whether its files hold layers beside the colours.
    pub const fn has_layers(self) -> bool {
        self.facts().has_layers
    }

    /// Bytes of one value of a pixel, uncompressed.
    pub const fn value_bytes(self) -> u32 {
        match self.values() {
            FileValues::Encoded { bits } | FileValues::Linear { bits } => bits / 8,
        }
    }

    /// The first format whose files have this extension, in any case.
    pub fn by_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }
}

/// "a, b or c", each once.
fn listed(mut names: Vec<String>) -> String {
    names.dedup();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_formats_have_a_name_in_common() {
        let mut names: Vec<&str> = OutputFormat::NAMES
            .iter()
            .flat_map(|(word, format)| [&[*word, format.option()], format.aliases()].concat())
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn kinds_are_listed_once() {
        assert_eq!(OutputFormat::kinds(), "PNG or EXR");
        assert_eq!(OutputFormat::extensions(), ".png or .exr");
    }

    #[test]
    fn extensions_name_the_first_of_their_formats() {
        assert_eq!(OutputFormat::by_extension("PNG"), Some(OutputFormat::Png8));
        assert_eq!(OutputFormat::by_extension("exr"), Some(OutputFormat::Exr));
        assert_eq!(OutputFormat::by_extension("tiff"), None);
    }
}
