//! Pictures whose pixels can be derived by hand. Each test explains how.

mod bending;
mod compositing;
mod copied;
mod crowds;
mod expectation;
mod far_away;
mod furnace;
mod layers;
mod lens;
mod light;
mod mirror;
mod motion;
mod paths;
mod photon_map;
mod refraction;
mod shadow;
mod stretched;
mod surfaces;
mod terminator;
