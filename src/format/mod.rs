//! Scene text and mesh files as they are written: tokens, syntax tree, vertices and faces.

pub mod error;
mod lexer;
mod number;
mod parser;
pub mod syntax;

pub use error::FileError;
pub use number::{NumberError, looks_like_number, parse_number};
pub use parser::parse;
