//! Content of an `.obj` file that its mesh leaves out.

use crate::format::QUOTED;
use crate::mesh::warnings::sentence;

/// Statements that do not change the shape; leaving them out needs no warning.
const SILENT: [&[u8]; 16] = [
    b"o",
    b"g",
    b"s",
    b"mg",
    b"lod",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"deg",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
];

/// Statements of free-form curves and surfaces.
const FREE_FORM: [&[u8]; 11] = [
    b"vp", b"cstype", b"curv", b"curv2", b"surf", b"bmat", b"step", b"ctech", b"stech", b"bzp",
    b"bsp",
];

/// Statements that say what a surface looks like, beside `mtllib` and `usemtl`.
const LOOKS: [&[u8]; 4] = [b"usemap", b"maplib", b"shadow_obj", b"trace_obj"];

/// Content that was found and left out.
#[derive(Debug, Default)]
pub(super) struct LeftOut {
    /// What the file says first of its materials.
    materials: Option<String>,
    colors: bool,
    lines: usize,
    points: usize,
    free_form: bool,
    /// The first statement of an unknown kind, and its line.
    unknown: Option<(String, usize)>,
}

impl LeftOut {
    /// Takes note of a vertex with a colour.
    pub(super) fn color(&mut self) {
        self.colors = true;
    }

    /// Takes note of a statement: its first word, what follows, and the number of its line.
    pub(super) fn statement(&mut self, keyword: &[u8], rest: &[u8], line: usize) {
        match keyword {
            b"l" => self.lines += 1,
            b"p" => self.points += 1,
            b"mtllib" | b"usemtl" => {
                if self.materials.is_none() || keyword == b"mtllib" {
                    self.materials = Some(format!("{} {}", quoted(keyword), quoted(rest)));
                }
            }
            _ if LOOKS.contains(&keyword) => {
                self.materials.get_or_insert_with(|| quoted(keyword));
            }
            _ if FREE_FORM.contains(&keyword) => self.free_form = true,
            _ if SILENT.contains(&keyword) => {}
            // The end of a text of DOS, or of a block of a disk.
            [0 | 0x1a, ..] => {}
            _ => {
                self.unknown.get_or_insert_with(|| (quoted(keyword), line));
            }
        }
    }

    /// The first statement of an unknown kind, and its line.
    pub(super) fn unknown(&self) -> Option<&(String, usize)> {
        self.unknown.as_ref()
    }

    /// One line for the user, if anything visible was left out.
    pub(super) fn warning(&self) -> Option<String> {
        let counted = |count: usize, what: &str| match count {
            0 => None,
            1 => Some(format!("1 {what}")),
            _ => Some(format!("{count} {what}s")),
        };
        let parts = [
            self.materials.as_ref().map(|said| format!("materials (`{}`)", said.trim_end())),
            self.colors.then(|| "colours of vertices".to_owned()),
            counted(self.lines, "line"),
            counted(self.points, "point"),
            self.free_form.then(|| "free-form curves and surfaces".to_owned()),
            self.unknown.as_ref().map(|(word, line)| {
                format!("statements of an unknown kind (the first is `{word}` in line {line})")
            }),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("left out: {}", sentence(&parts)))
    }
}

/// Words of a file for a message, cut if they are long.
fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * QUOTED)]);
    text.chars().take(QUOTED).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
