//! Traces batches of rays through triangles, curved surfaces and boxes.
//!
//! ```
//! use slo_accel::glam::Vec3;
//! use slo_accel::{Accelerator, Coherence, Hits, Isa, NO_HIT, Rays, Scratch, Structure};
//!
//! let triangles = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]];
//! let structure = Structure::build(Accelerator::Bvh, triangles, Isa::best());
//! let mut rays = Rays::with_capacity(2);
//! rays.push(Vec3::new(0.25, 0.5, 2.0), Vec3::NEG_Z, f32::INFINITY);
//! rays.push(Vec3::new(0.75, 0.5, 2.0), Vec3::NEG_Z, f32::INFINITY);
//! let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
//! structure.intersect(&rays, Coherence::Coherent, &mut hits, &mut scratch);
//! assert_eq!((hits.primitive[0], hits.t[0], hits.u[0], hits.v[0]), (0, 2.0, 0.25, 0.5));
//! assert_eq!(hits.primitive[1], NO_HIT);
//! ```
//!
//! - [`Primitives`] are what rays hit: triangles, and [`Curved`] surfaces that are not tessellated.
//! - A [`Structure`] is built over them, of the kind that [`Accelerator`] names, for an instruction
//!   set ([`Isa`]). It answers two questions about each of a batch of [`Rays`]: which primitive is
//!   hit first ([`intersect`](Structure::intersect), to [`Hits`]), and whether any is
//!   ([`occluded`](Structure::occluded)).
//! - A [`Device`] beside the CPU may traverse a structure ([`build_on`](Structure::build_on)); it cannot
//!   change a hit.
//! - A [`Bending`] is the same for triangles whose corners move: each ray has a time, and meets the
//!   triangles as they are then.
//! - [`Instances`] put structures, and other instances, at many places. They answer the same
//!   questions, and tell in which place a ray hits.
//! - [`study`] has textbook structures to compare, with counters.
//! - A [`BoxTree`] lists the rays that enter boxes: the upper level over several structures.
//! - [`Lanewise`] work, [`math::columns`] and [`math::elementary`] are for what a renderer does
//!   between two batches: loops over columns that are compiled once for each instruction set.
//!
//! # Promises
//!
//! All structures and all instruction sets give the same hits, bit by bit, on every CPU, for any
//! number of threads; of hits at the same distance the lowest id counts. Only
//! [`Accelerator::Cwbvh`], which is there to be measured against, may miss hits. Two triangles that
//! share an edge leave no gap between them ([`triangle`]).
//!
//! # Limits
//!
//! Coordinates, distances and weights are f32. A structure holds up to
//! [`MAX_PRIMITIVES`](Structure::MAX_PRIMITIVES) primitives. A batch may have any length; about a
//! thousand rays hide the latency of memory, and [`math::columns`] have room for exactly
//! [`BATCH`](math::columns::BATCH) entries. Kernels exist for AVX2 and AVX-512, and those of the
//! BVH for NEON; elsewhere the same algorithms run in plain Rust.
//!
//! The crate knows no materials, no scene and no file.

mod box_tree;
pub mod instances;
mod isa;
pub mod math;
mod primitives;
mod rays;
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
mod simd;
mod structure;

pub use box_tree::{BoxScratch, BoxTree};
pub use glam;
pub use instances::{Instances, InstancesScratch};
pub use isa::compress::{GROUP, Word};
pub use isa::{Isa, Lanewise};
pub use primitives::{Curved, Primitives, Triangle, curved, triangle};
pub use rays::{Coherence, Hits, LANES, NO_HIT, Rays};
pub use structure::{
    Accelerator, Bending, BuildOptions, Device, Moment, Scratch, Sections, Structure, Uploaded,
    study,
};

/// The examples of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
