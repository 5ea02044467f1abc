//! Placements of many copies, by columns.

use glam::DVec3;

/// Where each of many copies is. Columns that nothing is said about are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Placements {
    /// Positions of the origins.
    pub positions: Vec<DVec3>,
    /// Unit quaternions x, y, z, w: how they are turned.
    pub turns: Vec<[f32; 4]>,
    /// Scales along their own axes; more than 0.
    pub scales: Vec<[f32; 3]>,
    /// Which of several originals they show.
    pub kinds: Vec<u32>,
    /// Factors of the colours of their materials: red, green, blue.
    pub tints: Vec<[f32; 3]>,
}

impl Placements {
    /// Number of copies.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Which original a copy shows.
    pub fn kind(&self, copy: usize) -> u32 {
        self.kinds.get(copy).copied().unwrap_or(0)
    }

    /// The factor of the colours of a copy.
    pub fn tint(&self, copy: usize) -> Option<[f32; 3]> {
        self.tints.get(copy).copied()
    }

    /// Bytes of memory.
    pub fn memory(&self) -> usize {
        self.positions.capacity() * size_of::<DVec3>()
            + self.turns.capacity() * size_of::<[f32; 4]>()
            + (self.scales.capacity() + self.tints.capacity()) * size_of::<[f32; 3]>()
            + self.kinds.capacity() * size_of::<u32>()
    }
}
