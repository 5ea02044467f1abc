//! One line of an `.obj` file.

use glam::DVec3;

use super::index::{Corner, Missing, parse_corner};
use crate::format::{NumberError, parse_number};
use crate::mesh::numbers::is_not_finite;

/// What is wrong with a line, and which bytes of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) start: usize,
    pub(super) len: usize,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

/// A corner of a face and the bytes where it is written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WrittenCorner {
    pub(super) corner: Corner,
    pub(super) start: usize,
    pub(super) len: usize,
    /// References to what was not defined yet.
    pub(super) missing: Vec<Missing>,
}

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Statement<'l> {
    /// A vertex, which is not finite if there is a fault.
    Position { position: DVec3, is_colored: bool, fault: Option<Fault> },
    /// Texture coordinates; NaN if one is not finite.
    Uv([f32; 2]),
    /// A direction of any length; NaN if a coordinate is not finite.
    Normal(DVec3),
    /// Corners of a face.
    Face(Vec<WrittenCorner>),
    /// Anything else: its first word and what follows.
    Other(&'l [u8], &'l [u8]),
}

/// Reads a line without its comment; `None` if it is blank.
/// `counts` are the numbers of vertices, uvs and normals so far.
///
/// # Errors
/// The first faulty word.
pub(super) fn parse(line: &[u8], counts: [u64; 3]) -> Result<Option<Statement<'_>>, Fault> {
    let start = line.len() - line.trim_ascii_start().len();
    let keyword_len = line[start..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
    let keyword = &line[start..start + keyword_len];
    if keyword.is_empty() {
        return Ok(None);
    }
    if ![&b"v"[..], b"vt", b"vn", b"f", b"fo"].contains(&keyword) {
        return Ok(Some(Statement::Other(keyword, line[start + keyword_len..].trim_ascii())));
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
        b"vt" => line.uv(),
        b"vn" => line.normal(),
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
    /// `v x y z`, `v x y z w`, or `v x y z r g b` with a colour, which is left out.
    fn position(&self) -> Result<Statement<'static>, Fault> {
        let ([x, y, z], mut fault) = self.numbers("a vertex", 3)?;
        let mut position = DVec3::new(x, y, z);
        if let [_, _, _, word] = self.words {
            let weight = match self.number(word)? {
                (weight, None) => weight,
                (_, not_finite) => {
                    fault = fault.or(not_finite);
                    f64::NAN
                }
            };
            if weight == 0.0 {
                return Err(self.fault(word, "a vertex can't have the weight 0".to_owned()));
            }
            position /= weight;
            if !position.is_finite() {
                let message = format!("a vertex with the weight `{word}` is not finite");
                fault = fault.or_else(|| Some(self.fault(word, message)));
            }
        }
        Ok(Statement::Position { position, is_colored: self.words.len() >= 6, fault })
    }

    /// `vt u`, `vt u v` or `vt u v w`, whose third number is ignored.
    fn uv(&self) -> Result<Statement<'static>, Fault> {
        let ([u, v, _], _) = self.numbers("a uv", 1)?;
        let uv = [u as f32, v as f32];
        let is_finite = uv.iter().all(|c| c.is_finite());
        Ok(Statement::Uv(if is_finite { uv } else { [f32::NAN; 2] }))
    }

    /// `vn x y z`
    fn normal(&self) -> Result<Statement<'static>, Fault> {
        let ([x, y, z], fault) = self.numbers("a normal", 3)?;
        Ok(Statement::Normal(if fault.is_none() { DVec3::new(x, y, z) } else { DVec3::NAN }))
    }

    /// Up to three numbers, of which `least` must be there. Missing ones are 0; with the first
    /// that is not finite.
    fn numbers(&self, name: &str, least: usize) -> Result<([f64; 3], Option<Fault>), Fault> {
        if self.words.len() < least {
            return Err(self.too_few(format!("{name} has {least} numbers or more")));
        }
        let mut numbers = [0.0; 3];
        let mut fault = None;
        for (number, word) in numbers.iter_mut().zip(self.words) {
            let (value, not_finite) = self.number(word)?;
            *number = value;
            fault = fault.or(not_finite);
        }
        Ok((numbers, fault))
    }

    /// The number that a word stands for; NaN and a fault if it is not finite.
    fn number(&self, word: &str) -> Result<(f64, Option<Fault>), Fault> {
        let NumberError { message, help } = match parse_number(word) {
            Ok(value) => return Ok((value, None)),
            Err(error) => error,
        };
        let fault = Fault { help, ..self.fault(word, message) };
        if is_not_finite(word) { Ok((f64::NAN, Some(fault))) } else { Err(fault) }
    }

    /// The corners of a face.
    fn face(&self, counts: [u64; 3]) -> Result<Statement<'static>, Fault> {
        let corner = |word: &&str| {
            let (corner, missing) =
                parse_corner(word, counts).map_err(|message| self.fault(word, message))?;
            Ok(WrittenCorner { corner, start: self.start_of(word), len: word.len(), missing })
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
