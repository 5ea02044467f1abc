//! Scenes of other programs, as scene text of slo-rt with meshes and images beside it.
//!
//! [`import`] reads a file and returns text that a person can read and change, and the files that it
//! names. A module reads each format into one `Model`, and `write` turns any model into text. What a
//! file lacks (a camera, light) is made up, and what the scene language cannot say is left out; both are
//! listed.
//!
//! | format | what is read |
//! |---|---|
//! | glTF 2.0 (`.gltf`, `.glb`) | hierarchy, meshes, materials with the extensions of the Khronos group, images, lights, the first camera, animation of nodes, skins and morph targets |
//! | Wavefront (`.obj` with `.mtl`) | meshes by material, colours, images |
//! | PLY | one mesh |
//! | AFF | hierarchy, meshes, polygons, solids, fills with images, lights, splines, triangles whose corners move, the path of the camera |
//! | Open Inventor (`.iv`), text and binary | nodes with their state, shapes with faces, solids, materials, images, lights, the first camera |
//! | NFF | view, lights, fills, polygons, spheres, cylinders |

mod aff;
mod corners;
mod error;
mod files;
mod gltf;
mod images;
mod inventor;
mod model;
mod names;
mod obj;
mod ply;
mod solids;
mod straighten;
#[cfg(test)]
mod tests;
mod thin;
mod view;
mod words;
mod write;

use std::path::Path;

pub use error::ImportError;
use files::Source;
use model::Model;

/// Farthest that anything may be, in metres; the camera stands a little farther away.
const MOST_COORDINATE: f64 = 1e8;

/// A scene, ready to be written.
#[derive(Debug)]
pub struct Imported {
    /// Name of the file it came from, without its ending.
    pub name: String,
    /// Scene text. Its paths begin in the folder that it is written to.
    pub text: String,
    /// Meshes and images: paths in that folder, with `/`, and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Number of triangles, and of other shapes.
    pub shapes: (usize, usize),
    /// Number of materials.
    pub materials: usize,
    /// Number of lamps.
    pub lamps: usize,
    /// What the scene lacks.
    pub left_out: Vec<String>,
    /// What the file lacked.
    pub made_up: Vec<String>,
}

/// Reads a file of another program.
///
/// Files that it names must lie in its folder or below, unless `allow_outside` is set.
///
/// # Errors
///
/// If a file can't be read, or is damaged, or of no kind that is known.
pub fn import(path: &Path, allow_outside: bool) -> Result<Imported, ImportError> {
    let source = Source::open(path, allow_outside)?;
    let mut model = read(&source)?;
    straighten::straighten(&mut model);
    model.drop_hollow();
    if model.objects.is_empty() {
        return Err(source.bad("there is nothing to see in it: no surface"));
    }
    let far = model.bounds().map_or(0.0, |[least, most]| least.abs().max(most.abs()).max_element());
    if !far.is_finite() || far > MOST_COORDINATE {
        let message = format!("a coordinate is {far:e}, more than {MOST_COORDINATE:e}");
        return Err(source.bad(message));
    }
    model.drop_unused();
    view::complete(&mut model);
    let written = write::write(&model, &source.name());
    let left_out = model.notes.left_out.iter();
    Ok(Imported {
        name: source.stem(),
        text: written.text,
        files: written.files,
        shapes: view::counts(&model),
        materials: model.materials.len(),
        lamps: model.lamps.len(),
        left_out: left_out.map(|(what, count)| format!("{what}{}", write::times(*count))).collect(),
        made_up: model.notes.made_up,
    })
}

fn read(source: &Source) -> Result<Model, ImportError> {
    let (bytes, ending) = (&source.bytes, source.ending());
    if bytes.is_empty() {
        return Err(source.bad("the file is empty"));
    }
    if bytes.starts_with(b"glTF") || ending == "gltf" || ending == "glb" {
        return gltf::read(source);
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return ply::read(source);
    }
    if inventor::is_known(bytes) || ending == "iv" {
        return inventor::read(source);
    }
    match ending.as_str() {
        "obj" => obj::read(source),
        "nff" => aff::read(source, aff::Flavour::Nff),
        "aff" => aff::read(source, aff::Flavour::Aff),
        _ => {
            Err(source
                .bad("its format is not known: glTF, OBJ, PLY, AFF, NFF and Open Inventor are"))
        }
    }
}
