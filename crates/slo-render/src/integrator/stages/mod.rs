//! The stages of integrators. Each turns columns into columns, and has working memory of its own
//! that other stages may only read.

pub(super) mod arrived;
pub(super) mod bsdfs;
pub(super) mod camera_rays;
pub(super) mod continuation;
pub(super) mod departure;
pub(super) mod deposit;
pub(super) mod direct_light;
pub(super) mod emission;
pub(super) mod ended;
pub(super) mod features;
pub(super) mod first_hits;
pub(super) mod guiding;
pub(super) mod hemispheres;
pub(super) mod hits;
pub(super) mod lamp_light;
pub(super) mod landing;
mod light_choice;
pub(super) mod lobes;
pub(super) mod merging;
pub(super) mod passing;
pub(super) mod photon_bounce;
pub(super) mod pilot;
pub(super) mod points;
pub(super) mod scattering;
pub(super) mod stored_light;
pub(super) mod to_shaded;
pub(super) mod visibility;
