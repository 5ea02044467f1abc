//! Properties of all lobes of `material_principled`, and the albedos of whole materials.

mod albedo;
mod hits;
mod sampling;
