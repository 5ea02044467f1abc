//! Pictures of slo-rt: exact sums of samples, and the files that they become.
//!
//! [`film`] adds up samples, exactly and in any order. [`output`] writes picture files, each with the recipe
//! that made it, and the states that another run continues. [`compare`] and [`denoise`] work on finished
//! pictures. Nothing here knows a ray.

pub mod compare;
pub mod denoise;
pub mod film;
pub mod output;
