//! What surfaces do to light: a list of lobes, each in columns over the hits of a batch.
//!
//! A hit may have several lobes, whose light adds up. Every lobe is sampled and weighted as an
//! estimator of its own: a ray that follows a lobe carries the light of this lobe alone.

mod diffuse;
mod highlight;
mod list;
mod lobe;
mod power;

use list::lobes;

pub use diffuse::Diffuse;
pub use highlight::Highlight;
pub use list::{WithLobe, WithLobeMut};
pub use lobe::{At, Lobe, Sampled, Scattered, Share};
pub use power::Power;

lobes! {
    /// The lobes of a batch of hits.
    pub struct Bsdf {
        /// Light that leaves in all directions.
        pub diffuse: Diffuse,
        /// Phong's highlight.
        pub highlight: Highlight,
        /// Phong's glossy or perfect reflection.
        pub reflection: Power,
        /// Phong's glossy or perfect refraction.
        pub refraction: Power,
    }
}
