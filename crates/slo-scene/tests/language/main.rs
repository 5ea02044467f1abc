//! The scene language: what it says, how it reports mistakes, and that no text makes it fall over.

mod documentation;
mod fuzz;
mod includes;
mod lamps;
mod light_maps;
mod materials;
mod meshes;
mod messages;
mod mistakes;
mod shapes;
mod spaces;
