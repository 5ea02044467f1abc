//! Photons: light that leaves lamps and passes sharp lobes, stored where it meets a rough one.
//!
//! They find what paths from the camera cannot: caustics of small lamps, seen directly, in mirrors
//! and through glass. A map is a pure function of (scene, frame, seed, pass), never of pixels,
//! tiles or threads. Paths from the camera and photons share the light of the same light path by
//! the balance heuristic (see `docs/rendering.md`), so neither has to be chosen by hand.
//!
//! Photons of `PHOTON_MAP` are others: of all light, in maps of a frame, from which irradiance is
//! estimated (`everywhere`, `flux_map`, `irradiance`), and an irradiance cache (`cache`).

mod cache;
mod counts;
mod emission;
mod everywhere;
mod flux_map;
mod hull;
mod irradiance;
mod map;
mod nearest;
mod schedule;
mod targets;

pub use cache::{CacheRecord, Gathered, Grid, IrradianceCache};
pub use counts::PhotonCounts;
pub use emission::{Emission, Emitted, Numbers};
pub use everywhere::Everywhere;
pub use flux_map::{Deposit, FluxMap, Irradiance, Rule};
pub use irradiance::{IrradianceMap, PhotonLight, irradiance_at};
pub use map::{Photon, PhotonMap, PhotonMaps, Slab};
pub use nearest::Nearest;
pub use schedule::{MOST_PATHS, pass_of, radius_share, samples_of};
pub use targets::{Sharp, Target, targets};

/// Where the light paths of `PHOTON_MAP` start.
#[derive(Clone, Debug)]
pub struct PhotonLamps {
    /// All light.
    pub all: Everywhere,
    /// Light that is sent to something sharp, if there is any.
    pub aimed: Option<Emission>,
}
