//! From hits to what shading needs: points, normals, colours of images, rounding bounds.
//!
//! Tables are looked up hit by hit (`gather`); all arithmetic is done for whole columns (`find`).

mod columns;
mod find;
mod gather;

pub(crate) use columns::{NO_MATERIAL, Surfaces};
pub(crate) use find::SurfaceScratch;
