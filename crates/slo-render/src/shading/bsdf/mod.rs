//! What surfaces do to light: a list of lobes, each in columns over the hits of a batch.
//!
//! A hit may have several lobes, whose light adds up. Every lobe is sampled and weighted as an
//! estimator of its own: a ray that follows a lobe carries the light of this lobe alone.

mod bend;
mod coat;
mod diffuse;
mod facets;
mod fresnel;
mod ggx;
mod glass;
mod highlight;
mod list;
mod lobe;
mod metal;
mod power;
mod principled;
mod rough_diffuse;
mod sheen;
mod sheen_nodes;
mod specular;
mod tables;

use list::lobes;

pub use coat::Coat;
pub use diffuse::Diffuse;
pub use glass::Glass;
pub use highlight::Highlight;
pub use list::{WithLobe, WithLobeMut, WithLobes};
pub use lobe::{At, Lobe, SHARP, Sampled, Scattered, Share};
pub use metal::Metal;
pub use power::{Power, SHARP_INVERSE};
pub use principled::principled;
pub use rough_diffuse::RoughDiffuse;
pub use sheen::Sheen;
pub use specular::Specular;
pub use tables::facet_albedos;

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
        /// The rough diffuse base of principled materials.
        pub rough_diffuse: RoughDiffuse,
        /// The sheen of principled materials.
        pub sheen: Sheen,
        /// The clear coat of principled materials.
        pub coat: Coat,
        /// Their metal.
        pub metal: Metal,
        /// Their glass.
        pub glass: Glass,
        /// Their gloss over the diffuse base.
        pub specular: Specular,
    }
}

#[cfg(test)]
mod tests;
