//! Compares pictures with theory, with a plain recursive renderer, and with each other.

mod accounts;
mod analytic;
mod any_split;
mod counting;
mod determinism;
mod estimators;
mod guiding;
mod light_maps;
mod oracle;
mod photons;
mod support;
