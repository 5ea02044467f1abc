//! A window onto a scene: a small server whose page shows the picture while it sharpens, and from which
//! the scene is looked at from elsewhere and changed.
//!
//! ```text
//! browser --server (token, Host, Origin, limits)--> commands --> studio --> pictures and state --> browser
//! ```
//!
//! The [`server`](serve) knows requests and no scene. The studio, a thread, owns the scene and its text,
//! and renders whenever nothing is asked of it. Nothing is written unless the person saves.

mod camera;
mod changes;
mod command;
mod document;
mod finished;
#[doc(hidden)]
pub mod fuzzing;
mod look;
mod merging;
mod pick;
mod placing;
mod sculpting;
mod server;
mod source;
mod studio;
mod watched;

pub use server::{Error, Options, serve};
pub use source::Source;
pub use watched::Watched;
