//! How many light paths a pass of photons has.

use crate::frame::FrameScene;
use crate::photons::{MOST_PATHS, Photon, samples_of};

/// The light paths of one pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhotonPass {
    /// Number of light paths in all passes before, modulo 2^32.
    pub(super) first: u32,
    /// Number of light paths.
    pub(super) paths: u32,
    /// Number of slabs of time that they are dealt to.
    pub(super) slabs: u32,
}

/// Slabs of time of the first pass, if anything moves.
const SLABS: f64 = 4.0;

impl PhotonPass {
    /// Returns a pass of a frame.
    pub fn new(frame: &FrameScene, pass: u32) -> Self {
        let samples = samples_of(pass);
        let pixels = f64::from(frame.camera.width()) * f64::from(frame.camera.height());
        let before =
            |pass: u32| (f64::from(frame.settings.photons) * pixels * f64::from(pass)) as u64;
        let first = before(pass);
        // The error of a slab's length falls like that of the radius.
        let slabs = SLABS * libm::pow(f64::from(samples.start) + 1.0, 1.0 / 6.0);
        let slabs = if frame.moves() { slabs as u32 } else { 1 };
        let paths =
            (before(pass.saturating_add(1)) - first).clamp(u64::from(slabs), MOST_PATHS) as u32;
        // All slabs have the same number.
        let paths = paths - paths % slabs;
        Self { first: first as u32, paths, slabs }
    }

    /// Number of light paths.
    pub fn paths(&self) -> u32 {
        self.paths
    }

    /// Number of slabs of time.
    pub fn slabs(&self) -> u32 {
        self.slabs
    }

    /// Memory that its map takes at most, in bytes.
    pub fn most_memory(&self) -> usize {
        self.paths as usize * (size_of::<Photon>() + 16)
    }
}
