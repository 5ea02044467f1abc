//! What to say about a `.slo` file that can't be read.

use super::section::Section;
use super::words::{Token, Words};
use crate::format::{FileError, NumberError, Place, QUOTED, parse_word};

/// What was found, quoted, and its place.
fn found(words: &mut Words<'_>, token: Token) -> (String, Place) {
    let text = match token {
        Token::Open => "`{`".to_owned(),
        Token::Close => "`}`".to_owned(),
        Token::End => "the end of the file".to_owned(),
        Token::Word(_) => quote(words.bytes(token)),
    };
    (text, words.input.fault(token.len()))
}

/// A word in back quotes, cut if it is long.
fn quote(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * QUOTED)]).into_owned();
    let visible = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let mut quoted: String = text.chars().take(QUOTED).map(visible).collect();
    if text.chars().nth(QUOTED).is_some() {
        quoted.push('…');
    }
    format!("`{quoted}`")
}

/// "1 vertex", "2 vertices"
fn counted(count: usize, section: Section) -> String {
    let plural = if section == Section::FaceUvs { Section::Faces } else { section }.name();
    format!("{count} {}", if count == 1 { section.item() } else { plural })
}

/// The file does not begin with `slo_mesh`.
pub(super) fn no_header(words: &mut Words<'_>, token: Token) -> FileError {
    let bytes = words.bytes(token).to_vec();
    let (text, place) = found(words, token);
    if token == Token::End {
        return place.error("a .slo mesh begins with `slo_mesh 1`, but the file is empty", "");
    }
    let error = place.error(format!("a .slo mesh begins with `slo_mesh 1`, not with {text}"), "");
    match &bytes[..] {
        b"ply" => error.with_help("this looks like a PLY file: give it the extension .ply"),
        b"v" | b"o" | b"g" | b"mtllib" => {
            error.with_help("this looks like a Wavefront file: give it the extension .obj")
        }
        _ => error.with_help("the first words of the file must be `slo_mesh 1`"),
    }
}

/// `slo_mesh` is followed by something else than `1`.
pub(super) fn unknown_version(words: &mut Words<'_>, token: Token) -> FileError {
    let (text, place) = found(words, token);
    let message = match token {
        Token::End => "the file ends before the version of the .slo mesh".to_owned(),
        _ => format!("version {text} of .slo meshes is unknown"),
    };
    place.error(message, "expected `1`").with_help("the file begins with `slo_mesh 1`")
}

/// Something else where a section should begin.
pub(super) fn no_section(words: &mut Words<'_>, token: Token) -> FileError {
    let bytes = words.bytes(token).to_vec();
    let (text, place) = found(words, token);
    if token == Token::Close {
        return place.error("this `}` closes nothing", "no section is open");
    }
    let error = if token == Token::Open || parse_word(&bytes).is_ok() {
        place.error(format!("{text} is outside of any section"), "expected the name of a section")
    } else {
        place.error(format!("unknown section {text}"), "")
    };
    match similar_section(&bytes) {
        Some(section) => error.with_help(format!("did you mean `{}`?", section.name())),
        None => error.with_help(format!("the sections are {}", section_names())),
    }
}

/// The section that was probably meant.
fn similar_section(word: &[u8]) -> Option<Section> {
    let word = String::from_utf8_lossy(word).to_lowercase();
    let distance = |section: &Section| strsim::damerau_levenshtein(&word, section.name());
    Section::ALL
        .into_iter()
        .filter(|_| word.len() <= QUOTED)
        .filter(|section| distance(section) <= 1 + section.name().len() / 4)
        .min_by_key(distance)
}

/// Every section, for a sentence.
fn section_names() -> String {
    Section::ALL.map(|section| format!("`{}`", section.name())).join(", ")
}

/// A section that was there before.
pub(super) fn section_twice(words: &mut Words<'_>, section: Section, first: usize) -> FileError {
    let name = section.name();
    let place = words.input.fault(name.len());
    place
        .error(format!("the section `{name}` is there twice"), "for the second time")
        .with_help(format!("the first one is in line {first}; put both into one"))
}

/// A section without its opening brace.
pub(super) fn no_brace(words: &mut Words<'_>, section: Section, token: Token) -> FileError {
    let (text, place) = found(words, token);
    let message = format!("expected `{{` after `{}`, found {text}", section.name());
    place.error(message, "expected `{`")
}

/// A brace or the end of the file inside a section.
pub(super) fn no_number(words: &mut Words<'_>, section: Section, token: Token) -> FileError {
    let name = section.name();
    let line = words.input.pinned(section.pin()).line;
    let (text, place) = found(words, token);
    if token == Token::End {
        let message = format!("the file ends inside of `{name}`");
        let help = format!("`{name}` begins in line {line} and is never closed: is the file cut?");
        return place.error(message, "expected `}`").with_help(help);
    }
    place.error(format!("expected a number or `}}` in `{name}`, found {text}"), "")
}

/// A word in a section that is no number.
pub(super) fn bad_number(
    words: &mut Words<'_>,
    section: Section,
    token: Token,
    fault: NumberError,
) -> FileError {
    if let Some(error) = unclosed_section(words, section, token) {
        return error;
    }
    let place = words.input.fault(token.len());
    FileError { help: fault.help.map(String::into_boxed_str), ..place.error(fault.message, "") }
}

/// The name of a section inside of another one.
fn unclosed_section(words: &mut Words<'_>, section: Section, token: Token) -> Option<FileError> {
    let inner = Section::named(words.bytes(token))?;
    let line = words.input.pinned(section.pin()).line;
    let (text, place) = found(words, token);
    let message = format!("{text} inside of `{}`", section.name());
    let error = place.error(message, format!("expected `}}` before `{}`", inner.name()));
    Some(error.with_help(format!("`{}` begins in line {line} and is not closed", section.name())))
}

/// A word in a list of indices that is no index.
pub(super) fn bad_index(
    words: &mut Words<'_>,
    section: Section,
    target: Section,
    token: Token,
) -> FileError {
    let bytes = words.bytes(token);
    if bytes.contains(&b',') && bytes.iter().all(|b| b.is_ascii_digit() || *b == b',') {
        let separated = bytes.iter().map(|&b| if b == b',' { ' ' } else { b.into() });
        let help = format!("write `{}`", separated.collect::<String>().trim());
        let (text, place) = found(words, token);
        return place.error(format!("{text} has a comma"), "").with_help(help);
    }
    match parse_word(bytes) {
        Err(fault) => bad_number(words, section, token, fault),
        Ok(value) => {
            let (text, place) = found(words, token);
            let item = target.item();
            let label = if value < 0.0 {
                format!("the first {item} is 0")
            } else if value >= f64::from(u32::MAX) {
                "too large".to_owned()
            } else {
                "expected digits only".to_owned()
            };
            place.error(format!("{text} is not the index of a {item}"), label)
        }
    }
}

/// An index of something that is not there; `read` indices were read before it.
pub(super) fn out_of_range(
    place: Place,
    section: Section,
    read: usize,
    index: u32,
    target: Section,
    count: usize,
) -> FileError {
    let item = target.item();
    let face = read / 3;
    let there = match count {
        0 => format!("there is no {item}"),
        1 => format!("there is only {item} 0"),
        _ => format!("there are {}, 0 to {}", counted(count, target), count - 1),
    };
    place.error(
        format!("face {face} of `{}` refers to {item} {index}, but {there}", section.name()),
        "out of range",
    )
}

/// A section that ends within a group of `size` numbers, of which it has `have`.
pub(super) fn incomplete(
    words: &mut Words<'_>,
    section: Section,
    groups: usize,
    have: usize,
    size: usize,
) -> FileError {
    let (name, numbers) = (section.name(), groups * size + have);
    let place = words.input.fault(1);
    let missing = size - have;
    let plural = if missing == 1 { "" } else { "s" };
    place.error(
        format!("`{name}` has {numbers} numbers, which is not a multiple of {size}"),
        format!("{missing} number{plural} of {} {groups} missing before this", section.item()),
    )
}

/// More things than 32-bit indices can count.
pub(super) fn too_many(words: &mut Words<'_>, section: Section, count: usize) -> FileError {
    let place = words.input.fault(1);
    let message = format!("{} are more than {}", counted(count, section), u32::MAX);
    place.error(message, "").with_help("split the mesh into several files")
}

/// A file without that section.
pub(super) fn missing(section: Section) -> FileError {
    let name = section.name();
    FileError::whole_file(format!("the mesh has no section `{name}`"))
        .with_help(format!("add `{name} {{ ... }}`"))
}

/// A section with fewer than `least` things.
pub(super) fn too_few(
    words: &Words<'_>,
    section: Section,
    count: usize,
    least: usize,
) -> FileError {
    let place = words.input.pinned(section.pin());
    let message = format!("a mesh of {}", counted(count, section));
    place.error(message, format!("at least {} must be here", counted(least, section)))
}

/// Two sections that should list the same number of things.
pub(super) fn not_equal(
    words: &Words<'_>,
    section: Section,
    other: Section,
    [count, expected]: [usize; 2],
) -> FileError {
    let place = words.input.pinned(section.pin());
    let entries = if count == 1 { "entry" } else { "entries" };
    let message =
        format!("`{}` has {count} {entries} for {}", section.name(), counted(expected, other));
    let error = place.error(message, format!("one for each {} is needed", other.item()));
    if section == Section::Uvs {
        return error.with_help("with `face_uvs` there may be any number of uvs");
    }
    error
}

/// A number that was just read and does not fit f32.
pub(super) fn too_large_for_f32(words: &mut Words<'_>, section: Section, value: f64) -> FileError {
    let place = words.input.fault(0);
    let message = format!("{value:e} is too large for `{}`", section.name());
    place.error(message, format!("the number before this: at most {:e}", f32::MAX))
}
