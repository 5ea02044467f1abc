//! Which technique finds the light of lamps with an area: rays to them, or rays that follow lobes.

/// How rays to lamps and rays that follow lobes share the light of lamps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Techniques {
    /// Both find it, weighted by the balance heuristic for each lobe.
    ///
    /// Source: E. Veach and L. Guibas, "Optimally Combining Sampling Techniques" (1995).
    #[default]
    Combined,
    /// Only rays to lamps find it.
    Asked,
    /// Only rays that follow lobes find it.
    Hit,
    /// Rays to lamps find it for diffuse lobes, rays that follow lobes for the others.
    Separate,
}

impl Techniques {
    /// Returns the weight of rays to lamps for a lobe, and the share of the lobe's density in the
    /// denominator of the balance heuristic.
    pub fn asked(self, is_diffuse: bool) -> (f32, f32) {
        match self {
            Self::Combined => (1.0, 1.0),
            Self::Asked => (1.0, 0.0),
            Self::Hit => (0.0, 0.0),
            Self::Separate => (if is_diffuse { 1.0 } else { 0.0 }, 0.0),
        }
    }

    /// Returns the weight of a ray that followed a lobe, with a density per solid angle, to a lamp
    /// that rays sample with the density `by_light`.
    pub fn hit(self, is_diffuse: bool, density: f32, by_light: f32) -> f32 {
        match self {
            Self::Combined => density / (density + by_light),
            Self::Asked => 0.0,
            Self::Hit => 1.0,
            Self::Separate => {
                if is_diffuse {
                    0.0
                } else {
                    1.0
                }
            }
        }
    }
}
