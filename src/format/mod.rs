//! Scene text and mesh files as they are written: tokens, syntax tree, vertices and faces.

pub mod error;

pub use error::FileError;
