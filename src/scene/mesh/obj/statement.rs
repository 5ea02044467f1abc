//! One line of an `.obj` file.

use super::index::{Corner, parse_corner};
use crate::format::{NumberError, parse_number};

/// What is wrong with a line, and which bytes of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) start: usize,
    pub(super) len: usize,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

/// A line that matters.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Statement {
    /// Position, uv or normal (0, 1, 2), as a line that `tobj` reads.
    Point(usize, String),
    /// Corners of a face, three or more, with the bytes where each is written.
    Face(Vec<(Corner, usize, usize)>),
}

/// Reads a line without its comment; `None` for a line that does not matter to a mesh.
/// `counts` are those of the vertices, uvs and normals so far.
///
/// # Errors
/// The first word at fault.
pub(super) fn parse(line: &[u8], counts: [u64; 3]) -> Result<Option<Statement>, Fault> {
    let start = line.len() - line.trim_ascii_start().len();
    let keyword_len = line[start..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
    let keyword = &line[start..start + keyword_len];
    if ![&b"v"[..], b"vt", b"vn", b"f"].contains(&keyword) {
        return Ok(None);
    }
    let text = str::from_utf8(line).map_err(|e| Fault {
        start: e.valid_up_to(),
        len: 1,
        message: "this is not UTF-8 text".to_owned(),
        help: None,
    })?;
    let words: Vec<_> = text[start + keyword_len..].split_ascii_whitespace().collect();
    let line = Line { text, words: &words };
    match keyword {
        b"v" => line.position(),
        b"vt" => line.point(1, "a uv", 1, 2),
        b"vn" => line.point(2, "a normal", 3, 3),
        _ => line.face(counts),
    }
    .map(Some)
}

/// The words of a line after its keyword.
struct Line<'t> {
    text: &'t str,
    words: &'t [&'t str],
}

impl Line<'_> {
    /// `v x y z`, `v x y z w`, or `v x y z r g b` with a colour that is ignored.
    fn position(&self) -> Result<Statement, Fault> {
        let size = if self.words.len() == 4 { 4 } else { 3 };
        let statement = self.point(0, "a vertex", 3, size)?;
        match self.words.get(3) {
            Some(w) if size == 4 && parse_number(w) == Ok(0.0) => {
                Err(self.fault(w, "a vertex can't have the weight 0".to_owned()))
            }
            _ => Ok(statement),
        }
    }

    /// `size` numbers after `v`, `vt` or `vn`, of which `least` must be there.
    fn point(
        &self,
        kind: usize,
        name: &str,
        least: usize,
        size: usize,
    ) -> Result<Statement, Fault> {
        if self.words.len() < least {
            return Err(self.too_few(format!("{name} has {least} numbers or more")));
        }
        let mut clean = ["v", "vt", "vn"][kind].to_owned();
        for word in self.words.iter().take(size) {
            let value = parse_number(word).map_err(|NumberError { message, help }| Fault {
                help,
                ..self.fault(word, message)
            })?;
            if kind == 1 && !(value as f32).is_finite() {
                return Err(self.fault(word, format!("`{word}` is too large for a uv")));
            }
            clean.push(' ');
            clean.push_str(word);
        }
        clean.push_str(&" 0".repeat(size.saturating_sub(self.words.len())));
        Ok(Statement::Point(kind, clean))
    }

    /// Three corners or more.
    fn face(&self, counts: [u64; 3]) -> Result<Statement, Fault> {
        if self.words.len() < 3 {
            return Err(self.too_few("a face has 3 corners or more".to_owned()));
        }
        let corner = |word: &&str| {
            let corner = parse_corner(word, counts).map_err(|message| self.fault(word, message))?;
            Ok((corner, self.start_of(word), word.len()))
        };
        self.words.iter().map(corner).collect::<Result<_, _>>().map(Statement::Face)
    }

    /// Where a word of this line starts in it.
    fn start_of(&self, word: &str) -> usize {
        (word.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize)
    }

    /// A fault of one word.
    fn fault(&self, word: &str, message: String) -> Fault {
        Fault { start: self.start_of(word), len: word.len(), message, help: None }
    }

    /// A line that ends too early.
    fn too_few(&self, message: String) -> Fault {
        let start = self.text.trim_ascii_end().len();
        let message = format!("{message}, this one has {}", self.words.len());
        Fault { start, len: 0, message, help: None }
    }
}
