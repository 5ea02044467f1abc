//! Text as it is written: words and numbers, and the tokens and syntax tree of scenes.

mod bytes;
pub mod error;
mod input;
mod lexer;
mod number;
mod parser;
mod place;
pub mod syntax;

pub(crate) use bytes::{QUOTED, blank_len, is_space, parse_word, quick_f64, quick_u32, word_len};
pub use error::FileError;
pub(crate) use input::Input;
pub use number::{NumberError, Short, looks_like_number, parse_number};
pub use parser::{parse, written};
pub(crate) use place::Place;
