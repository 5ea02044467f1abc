//! Sections of a `.slo` file, put together to a mesh.

use std::io::Read;

use super::faults;
use super::indices::Indices;
use super::section::{Pinned, Section};
use super::values::{next_f32, next_f64};
use super::words::{Token, Words};
use crate::format::FileError;
use crate::mesh::data::Mesh;

/// Reads a `.slo` mesh as it is written: degenerate triangles are still there, normals have any
/// length and may be missing, positions are in the file's units.
///
/// Memory: the mesh, and a window of 256 KB over the file. Every position is the f64 nearest to the
/// decimal number in the file; uvs and normals are then rounded to f32.
///
/// # Errors
/// The first fault in the file, with its place.
pub fn read(reader: &mut dyn Read) -> Result<Mesh, FileError> {
    let mut words = Words::new(reader)?;
    read_header(&mut words)?;
    let mut file = File::new();
    while let Some(section) = file.next_section(&mut words)? {
        file.read_section(section, &mut words)?;
    }
    file.finish(&words)
}

/// Consumes `slo_mesh 1`.
fn read_header(words: &mut Words<'_>) -> Result<(), FileError> {
    let token = words.peek()?;
    if words.bytes(token) != b"slo_mesh" {
        return Err(faults::no_header(words, token));
    }
    words.input.advance(token.len());
    let token = words.peek()?;
    if words.bytes(token) != b"1" {
        return Err(faults::unknown_version(words, token));
    }
    words.input.advance(token.len());
    Ok(())
}

/// The part of the file read so far.
struct File {
    mesh: Mesh,
    /// Line of each section that was met, in the order of [`Section::ALL`].
    lines: [Option<usize>; Section::ALL.len()],
    vertex_indices: Indices,
    uv_indices: Indices,
}

impl File {
    /// Nothing yet.
    fn new() -> Self {
        Self {
            mesh: Mesh::default(),
            lines: [None; Section::ALL.len()],
            vertex_indices: Indices::into_section(Section::Vertices, Pinned::LargestVertex),
            uv_indices: Indices::into_section(Section::Uvs, Pinned::LargestUv),
        }
    }

    /// Consumes the name and the `{` of the next section; `None` at the end of the file.
    fn next_section(&mut self, words: &mut Words<'_>) -> Result<Option<Section>, FileError> {
        let token = words.peek()?;
        if token == Token::End {
            return Ok(None);
        }
        let Some(section) = Section::named(words.bytes(token)) else {
            return Err(faults::no_section(words, token));
        };
        let place = words.input.here(token.len());
        if let Some(first) = self.lines[section as usize].replace(place.line) {
            return Err(faults::section_twice(words, section, first));
        }
        words.input.pin(section.pin(), words.input.offset());
        words.input.advance(token.len());
        let token = words.peek()?;
        if token != Token::Open {
            return Err(faults::no_brace(words, section, token));
        }
        words.input.advance(token.len());
        Ok(Some(section))
    }

    /// Reads what is between the braces of a section.
    fn read_section(&mut self, section: Section, words: &mut Words<'_>) -> Result<(), FileError> {
        let mesh = &mut self.mesh;
        match section {
            Section::Vertices => {
                read_groups(section, words, next_f64, &mut mesh.positions)?;
                self.vertex_indices.set_count(mesh.positions.len());
            }
            Section::Uvs => {
                read_groups(section, words, next_f32, &mut mesh.uvs)?;
                self.uv_indices.set_count(mesh.uvs.len());
            }
            Section::Normals => read_groups(section, words, next_f32, &mut mesh.normals)?,
            Section::Faces => {
                let next = |words: &mut _, section| self.vertex_indices.next(words, section);
                read_groups(section, words, next, &mut mesh.faces)?;
            }
            Section::FaceUvs => {
                let next = |words: &mut _, section| self.uv_indices.next(words, section);
                read_groups(section, words, next, &mut mesh.face_uvs)?;
            }
        }
        Ok(())
    }

    /// The mesh, after what can be checked only when all sections are known.
    fn finish(mut self, words: &Words<'_>) -> Result<Mesh, FileError> {
        self.require(Section::Vertices)?;
        self.require(Section::Faces)?;
        self.check_count(words, Section::Vertices, 3)?;
        self.check_count(words, Section::Faces, 1)?;
        self.vertex_indices.check(words, Section::Faces)?;
        if self.has(Section::Normals) {
            self.check_equal(words, Section::Normals, Section::Vertices)?;
        }
        if self.has(Section::FaceUvs) {
            self.require(Section::Uvs)?;
            self.check_equal(words, Section::FaceUvs, Section::Faces)?;
            self.uv_indices.check(words, Section::FaceUvs)?;
        } else if self.has(Section::Uvs) {
            self.check_equal(words, Section::Uvs, Section::Vertices)?;
            self.mesh.face_uvs.clone_from(&self.mesh.faces);
        }
        Ok(self.mesh)
    }

    /// Whether the file has that section.
    fn has(&self, section: Section) -> bool {
        self.lines[section as usize].is_some()
    }

    /// Number of items in a section.
    fn count(&self, section: Section) -> usize {
        match section {
            Section::Vertices => self.mesh.positions.len(),
            Section::Faces => self.mesh.faces.len(),
            Section::Uvs => self.mesh.uvs.len(),
            Section::FaceUvs => self.mesh.face_uvs.len(),
            Section::Normals => self.mesh.normals.len(),
        }
    }

    /// Refuses a file without that section.
    fn require(&self, section: Section) -> Result<(), FileError> {
        if self.has(section) { Ok(()) } else { Err(faults::missing(section)) }
    }

    /// Refuses a section that lists fewer than `least`.
    fn check_count(
        &self,
        words: &Words<'_>,
        section: Section,
        least: usize,
    ) -> Result<(), FileError> {
        let count = self.count(section);
        if count >= least { Ok(()) } else { Err(faults::too_few(words, section, count, least)) }
    }

    /// Refuses a section that does not list one thing for each of another section.
    fn check_equal(
        &self,
        words: &Words<'_>,
        section: Section,
        other: Section,
    ) -> Result<(), FileError> {
        let counts = [self.count(section), self.count(other)];
        if counts[0] == counts[1] {
            return Ok(());
        }
        Err(faults::not_equal(words, section, other, counts))
    }
}

/// Reads numbers up to the closing brace, `N` at a time.
fn read_groups<'r, T: Copy + Default, G: From<[T; N]>, const N: usize>(
    section: Section,
    words: &mut Words<'r>,
    mut next: impl FnMut(&mut Words<'r>, Section) -> Result<Option<T>, FileError>,
    groups: &mut Vec<G>,
) -> Result<(), FileError> {
    loop {
        let mut group = [T::default(); N];
        for (have, slot) in group.iter_mut().enumerate() {
            match next(words, section)? {
                Some(value) => *slot = value,
                None if have == 0 => return close(words, section, groups.len()),
                None => return Err(faults::incomplete(words, section, groups.len(), have, N)),
            }
        }
        groups.push(G::from(group));
    }
}

/// Consumes the closing brace of a section with so many things.
fn close(words: &mut Words<'_>, section: Section, count: usize) -> Result<(), FileError> {
    if u32::try_from(count).is_err() {
        return Err(faults::too_many(words, section, count));
    }
    words.input.advance(Token::Close.len());
    Ok(())
}
