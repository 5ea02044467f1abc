//! Curved surfaces: exact tests in f64.
use super::Curved;
use crate::math::Bounds;

impl Curved {
    /// The smallest box, rounded outward.
    pub fn bounds(&self) -> Bounds {
        todo!()
    }
}
