//! Photons: light that leaves lamps and passes sharp lobes, stored where it meets a rough one.
//!
//! They find what paths from the camera cannot: caustics of small lamps, seen directly, in mirrors
//! and through glass. A map is a pure function of (scene, frame, seed, pass), never of pixels,
//! tiles or threads. Paths from the camera and photons share the light of the same light path by
//! the balance heuristic (see `docs/rendering.md`), so neither has to be chosen by hand.

mod emission;
mod map;
mod schedule;
mod targets;

pub use emission::{Emission, Emitted, Numbers};
pub use map::{Photon, PhotonMap, PhotonMaps, Slab};
pub use schedule::{pass_of, radius_share, samples_of};
pub use targets::{Sharp, Target, targets};
