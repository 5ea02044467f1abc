//! Distributes tiles over threads: adaptive blocks, progress, stopping and continuing.

mod budget;
mod clock;
mod explain;
mod guide;
mod light_map;
mod lock;
mod observer;
mod photon_cache;
mod photon_map;
mod photons;
mod plan;
mod run;
mod sections;
mod tile;
mod whole;

pub use crate::integrator::Statistics;
pub use crate::photons::PhotonCounts;
pub use budget::{Budget, render_until};
pub use explain::{Bright, Names, Share, Step, Tally, explain, luminance, rays_of, word};
pub use light_map::light_map;
pub use observer::{Exposed, Observer};
pub use plan::{Part, Plan};
pub use whole::render;
