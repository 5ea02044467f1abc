//! Computes what shading needs at hits: points, normals, colours of images, rounding bounds.
//!
//! Tables are read hit by hit (`gather`); all arithmetic works on whole columns (`find`, `soften`).

mod columns;
mod find;
mod gather;
mod soften;
mod tangents;

pub(crate) use columns::{NO_MATERIAL, Surfaces};
pub(crate) use find::SurfaceScratch;
