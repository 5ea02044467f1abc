//! Wavefront `.obj` meshes.
//!
//! Everything in a file becomes one mesh: objects, groups and smoothing groups do not matter.
//! Materials, colours, points, lines and free-form surfaces are left out, with a warning.

mod file;
mod index;
mod left_out;
mod lines;
mod statement;
#[cfg(test)]
mod tests;

use std::io::Read;

use file::File;
use lines::Lines;
use statement::Statement;

use crate::format::FileError;
use crate::mesh::data::LoadedMesh;

/// Reads an `.obj` mesh. Normals are kept only if `smooth` is set: a vertex with several of
/// them is then split, so that hard edges stay hard. Uvs have indices of their own.
///
/// # Errors
/// The first fault in the file, with its place; a file without faces.
pub(super) fn read(reader: &mut dyn Read, smooth: bool) -> Result<LoadedMesh, FileError> {
    let mut lines = Lines::new(reader);
    let mut file = File::default();
    while lines.advance()? {
        let parsed = statement::parse(lines.text(), file.counts());
        match parsed.map_err(|fault| lines.error(fault))? {
            None => {}
            Some(Statement::Position { position, is_colored, fault }) => {
                if let Some(fault) = fault {
                    file.not_finite.note(file.positions.len(), || lines.error(fault));
                }
                if is_colored {
                    file.left_out.color();
                }
                file.positions.push(position);
            }
            Some(Statement::Uv(uv)) => file.uvs.push(uv),
            Some(Statement::Normal(normal)) => file.normal(normal, smooth),
            Some(Statement::Face(corners)) => file.face(&corners, &lines),
            Some(Statement::Other(keyword, rest)) => {
                file.left_out.statement(keyword, rest, lines.number());
            }
        }
        if file.counts().iter().any(|&count| count > u64::from(u32::MAX)) {
            let message = format!("more vertices, uvs or normals than {}", u32::MAX);
            return Err(lines.place(0, 0).error(message, ""));
        }
    }
    file.into_mesh(smooth)
}
