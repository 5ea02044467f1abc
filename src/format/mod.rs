//! Scene text and mesh files as they are written: tokens, syntax tree, vertices and faces.

mod bytes;
pub mod error;
mod input;
mod lexer;
mod number;
mod parser;
mod place;
pub mod slo;
pub mod syntax;

pub(crate) use bytes::{blank_len, parse_word, quick_f64, word_len};
pub use error::FileError;
pub(crate) use input::Input;
pub use number::{NumberError, looks_like_number, parse_number};
pub use parser::parse;
pub(crate) use place::Place;
