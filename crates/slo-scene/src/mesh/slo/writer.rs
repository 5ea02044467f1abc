//! A mesh as a `.slo` file.

use std::io::{self, BufWriter, Write};

use super::section::Section;
use crate::mesh::data::Mesh;

/// Writes a mesh with the shortest numbers that read back as the same ones.
///
/// [`read`](super::read) gives the same mesh again, bit for bit, if its counts and indices are
/// in order and its numbers finite; a mesh without triangles is written, but can't be read.
///
/// # Errors
/// `InvalidData` if a number is not finite; otherwise the error of writing to `out`.
pub fn write_slo(mesh: &Mesh, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "slo_mesh 1")?;
    write_section(&mut out, Section::Vertices, &mesh.positions, |out, p| {
        write_numbers(out, &p.to_array(), shortest_f64)
    })?;
    write_section(&mut out, Section::Faces, &mesh.faces, write_indices)?;
    if !mesh.uvs.is_empty() {
        let write_uv = |out: &mut _, uv: &[f32; 2]| write_numbers(out, uv, shortest_f32);
        write_section(&mut out, Section::Uvs, &mesh.uvs, write_uv)?;
        write_section(&mut out, Section::FaceUvs, &mesh.face_uvs, write_indices)?;
    }
    if !mesh.normals.is_empty() {
        let write_normal = |out: &mut _, n: &[f32; 3]| write_numbers(out, n, shortest_f32);
        write_section(&mut out, Section::Normals, &mesh.normals, write_normal)?;
    }
    out.flush()
}

/// A section with one thing a line.
fn write_section<W: Write, T>(
    out: &mut W,
    section: Section,
    items: &[T],
    write_item: impl Fn(&mut W, &T) -> io::Result<()>,
) -> io::Result<()> {
    writeln!(out, "{} {{", section.name())?;
    for item in items {
        write_item(out, item)?;
    }
    writeln!(out, "}}")
}

/// A line of indices.
fn write_indices(out: &mut impl Write, [i, j, k]: &[u32; 3]) -> io::Result<()> {
    writeln!(out, "{i} {j} {k}")
}

/// A line of numbers.
fn write_numbers<T: Copy + Into<f64>>(
    out: &mut impl Write,
    numbers: &[T],
    text_of: impl Fn(T) -> String,
) -> io::Result<()> {
    for (i, &number) in numbers.iter().enumerate() {
        if !number.into().is_finite() {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!("{} can't be written to a .slo mesh", number.into()),
            ));
        }
        let space = if i == 0 { "" } else { " " };
        write!(out, "{space}{}", text_of(number))?;
    }
    writeln!(out)
}

/// The fewest digits that are read as this number, with an exponent if that is shorter.
fn shortest_f64(number: f64) -> String {
    let plain = number.to_string();
    // Most numbers have few digits in front of and after the point: no second try for them.
    if plain.len() <= 8 {
        return plain;
    }
    let with_exponent = format!("{number:e}");
    if with_exponent.len() < plain.len() { with_exponent } else { plain }
}

/// As [`shortest_f64`]. Readers make an f64 first and round again, which on rare numbers is not
/// the nearest f32: such numbers are written as f64.
fn shortest_f32(number: f32) -> String {
    let plain = number.to_string();
    let with_exponent = format!("{number:e}");
    let text = if with_exponent.len() < plain.len() { with_exponent } else { plain };
    match text.parse::<f64>() {
        Ok(read) if (read as f32).to_bits() == number.to_bits() => text,
        _ => shortest_f64(f64::from(number)),
    }
}
