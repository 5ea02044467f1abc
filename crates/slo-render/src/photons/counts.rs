//! What photons took, for the log.

/// Counts of the photons of a picture, and the memory that they took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhotonCounts {
    /// Passes of photons under `PATH`, traced anew for a stretch of samples.
    pub passes: u64,
    /// Light paths that were sent.
    pub paths: u64,
    /// Photons that they left in maps.
    pub photons: u64,
    /// Records of the irradiance cache.
    pub records: u64,
    /// Bytes of all that was held at a time, at the highest.
    pub memory: usize,
}

impl std::ops::AddAssign for PhotonCounts {
    fn add_assign(&mut self, other: Self) {
        self.passes += other.passes;
        self.paths += other.paths;
        self.photons += other.photons;
        self.records += other.records;
        self.memory = self.memory.max(other.memory);
    }
}
