//! What a `.ply` file says about itself.

use crate::format::{FileError, Input};

/// Bytes that a line of the header may have.
const MAX_LINE: usize = 1 << 14;

/// Elements and properties that a file may have together.
const MAX_PROPERTIES: usize = 4096;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The type of that name, old or new.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a binary number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether it has no fraction.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A property of each item of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    /// Type of the number, or of the numbers in the list.
    pub(super) scalar: Scalar,
    /// Type of the length of a list; `None`: one number.
    pub(super) list: Option<Scalar>,
}

/// A list of items in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// The head of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// In the order of the file.
    pub(super) elements: Vec<Element>,
    /// The image that a comment `TextureFile` names first.
    pub(super) texture: Option<String>,
}

impl Header {
    /// Reads up to and including the line `end_header`.
    ///
    /// # Errors
    /// The first line that is not understood.
    pub(super) fn read(input: &mut Input<'_>) -> Result<Self, FileError> {
        let mut encoding = None;
        let mut elements = Vec::new();
        let mut texture = None;
        let mut room = MAX_PROPERTIES;
        let line_end = expect_magic(input)?;
        loop {
            let line = next_line(input, line_end)?;
            let words: Vec<_> = line.text.split_ascii_whitespace().collect();
            if let ["element" | "property", ..] = words.as_slice() {
                room = room.checked_sub(1).ok_or_else(|| {
                    let message = format!("more than {MAX_PROPERTIES} elements and properties");
                    line.error(input, message)
                })?;
            }
            let done = match words.as_slice() {
                ["comment", "TextureFile", name @ ..] => {
                    texture.get_or_insert_with(|| name.join(" "));
                    Ok(false)
                }
                [] | ["comment" | "obj_info", ..] => Ok(false),
                ["format", name, "1.0"] => parse_encoding(name).map(|e| {
                    encoding = Some(e);
                    false
                }),
                ["element", name, count] => parse_element(name, count).map(|e| {
                    elements.push(e);
                    false
                }),
                ["property", rest @ ..] => add_property(&mut elements, rest).map(|()| false),
                ["end_header"] => Ok(true),
                _ => Err("the header of a .ply file has no such line".to_owned()),
            };
            match done {
                Ok(false) => input.advance(line.len),
                Ok(true) => {
                    let encoding =
                        encoding.ok_or_else(|| line.error(input, NO_FORMAT.to_owned()))?;
                    input.advance(line.len);
                    return Ok(Self { encoding, elements, texture });
                }
                Err(message) => return Err(line.error(input, message)),
            }
        }
    }
}

/// A header without a line `format`.
const NO_FORMAT: &str = "the header ends without a line `format ascii 1.0` or the like";

/// A line at the reading position.
struct Line {
    /// Without its end.
    text: String,
    /// Bytes, with its end.
    len: usize,
}

impl Line {
    /// An error about the whole line.
    fn error(&self, input: &mut Input<'_>, message: String) -> FileError {
        input.fault(self.text.len()).error(message, "")
    }
}

/// Consumes the first line, which is `ply`, and returns the byte that ends lines.
fn expect_magic(input: &mut Input<'_>) -> Result<u8, FileError> {
    while input.rest().len() < 5 && input.refill()? {}
    if !input.rest().starts_with(b"ply")
        || !input.rest().get(3).is_some_and(u8::is_ascii_whitespace)
    {
        return Err(FileError::whole_file("this is not a .ply file: its first line is not `ply`"));
    }
    // Old Macs ended lines with CR alone.
    let cr_alone = matches!(input.rest(), [b'p', b'l', b'y', b'\r', after, ..] if *after != b'\n');
    let line_end = if cr_alone { b'\r' } else { b'\n' };
    let line = next_line(input, line_end)?;
    input.advance(line.len);
    Ok(line_end)
}

/// The next line, which is not consumed.
fn next_line(input: &mut Input<'_>, line_end: u8) -> Result<Line, FileError> {
    let end = loop {
        let rest = input.rest();
        if let Some(end) = rest.iter().take(MAX_LINE).position(|&b| b == line_end) {
            break end;
        }
        if rest.len() >= MAX_LINE {
            return Err(input.fault(1).error("a line of the header has no end", ""));
        }
        if !input.refill()? {
            return Err(input.fault(0).error("the file ends inside of its header", ""));
        }
    };
    let text = String::from_utf8_lossy(&input.rest()[..end]).trim_ascii_end().to_owned();
    Ok(Line { text, len: end + 1 })
}

/// The encoding of a line `format`.
fn parse_encoding(name: &str) -> Result<Encoding, String> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!("`{name}` is no known format of a .ply file")),
    }
}

/// The element of a line `element`.
fn parse_element(name: &str, count: &str) -> Result<Element, String> {
    let count = count.parse().map_err(|_| format!("`{count}` is no number of elements"))?;
    if count >= u64::from(u32::MAX) && (name == "vertex" || name == "face") {
        return Err(format!("{count} is more than 32-bit indices can count"));
    }
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

/// Adds what a line `property` says to the last element.
fn add_property(elements: &mut [Element], words: &[&str]) -> Result<(), String> {
    let element = elements.last_mut().ok_or("a property before the first element")?;
    let scalar = |name: &str| {
        Scalar::named(name).ok_or_else(|| format!("`{name}` is no type of a property"))
    };
    let (name, list, scalar) = match words {
        ["list", count, item, name] => (name, Some(scalar(count)?), scalar(item)?),
        [kind, name] => (name, None, scalar(kind)?),
        _ => return Err("a property is `TYPE NAME` or `list TYPE TYPE NAME`".to_owned()),
    };
    if list.is_some_and(|list| !list.is_integer()) {
        return Err("the length of a list must have an integer type".to_owned());
    }
    if element.properties.iter().any(|property| property.name == *name) {
        return Err(format!("the property `{name}` is there twice"));
    }
    element.properties.push(Property { name: (*name).to_owned(), scalar, list });
    Ok(())
}
