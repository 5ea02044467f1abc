//! The scene language: what it says, how it reports mistakes, and that no text makes it fall over.

mod fuzz;
mod materials;
mod messages;
mod mistakes;
