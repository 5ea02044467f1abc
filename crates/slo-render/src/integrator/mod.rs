//! Turns batches of weighted rays into radiance. Independent of files and threads.
//!
//! A sample is a sum over a tree of rays. Every ray carries the weight that the radiance arriving
//! along it has for the pixel, so results need not be passed back up the tree. A hit adds its own
//! light and queues the rays that it sends out. The queues are processed a batch at a time until
//! none is left. Sums are exact, so their order does not matter.
//!
//! - `machine` holds the queues, decides which batch comes next, and adds up the light. It is
//!   independent of light transport.
//! - `stages` turn columns into columns, each with its own working memory.
//! - An `account` lists the rays of a sample and the light that each brought, on request.
//! - The integrators, `distributed`, `path` and `photon_map`, list their stages and how they branch.

mod account;
mod batch;
mod branching;
mod chosen;
mod counting;
mod distributed;
mod hemisphere;
mod light_paths;
mod machine;
mod path;
mod photon_map;
mod photon_pass;
mod pilot_paths;
mod queue;
mod ray_kind;
mod roulette;
mod stages;
mod sums;
mod tracer;
mod vertices;
mod work;

pub use account::{Account, AccountHit, AccountRay, Gain, Leg, Source};
pub use hemisphere::HemisphereTracer;
pub use light_paths::PhotonTracer;
pub use photon_pass::PhotonPass;
pub use pilot_paths::PilotTracer;
pub use ray_kind::RayKind;
pub use stages::departure::Flux;
pub use stages::hemispheres::Probe;
pub use tracer::Tracer;
pub use work::{Beside, SampleSum, Seen, Statistics, Traced, Work};
