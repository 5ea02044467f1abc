//! Open Inventor, as text and binary.
//!
//! J. Wernecke, "The Inventor Mentor" (1994). Lights do not fall off with distance there, and materials are
//! those of Phong, so scenes become classical ones.

mod ascii;
mod binary;
mod classes;
mod looks;
mod nurbs;
mod outline;
mod scene;
mod shapes;
mod solids;
mod state;
mod tree;
mod view;
mod walk;

use std::rc::Rc;

use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Model, Notes, Space};
use state::State;
use tree::Node;
use walk::Walker;

/// Deepest nesting of nodes and files.
const DEEPEST: usize = 250;

/// The space of the file, where y is up.
const ROOT: usize = 0;

/// Reads a file.
pub(crate) fn read(source: &Source) -> Result<Model, ImportError> {
    let mut model = Model { is_classical: true, has_clear_shadows: true, ..Model::default() };
    model.spaces.push(Space::y_up(source.stem()));
    let nodes = nodes(source, &mut model.notes)?;
    if source.bytes.starts_with(b"#Inventor V1.0") {
        model.notes.made_up.push("what its version 1.0 means: the same as 2.1".into());
    }
    let mut walker = Walker::new(model);
    walker.all(&nodes, &mut State::default(), source)?;
    Ok(walker.finish())
}

/// Whether a file says that it is one.
pub(crate) fn is_known(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#Inventor V") || bytes.starts_with(b"#VRML V1.0 ascii")
}

/// The nodes of a file.
fn nodes(source: &Source, notes: &mut Notes) -> Result<Vec<Rc<Node>>, ImportError> {
    let end = source.bytes.iter().position(|&byte| byte == b'\n' || byte == b'\r');
    let header = &source.bytes[..end.unwrap_or(source.bytes.len())];
    if !is_known(header) {
        return Err(source.bad("it does not begin with `#Inventor V`"));
    }
    if header.windows(6).any(|word| word == b"binary") {
        return binary::read(source, notes);
    }
    ascii::read(source, &source.text(), notes)
}
