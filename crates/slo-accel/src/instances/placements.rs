//! Where children are placed, in columns.

use super::affine::Affine;

/// A list of placements: for each, which child it places, and where.
///
/// A placement has one map from the child's space, or several: these are its poses, evenly spaced
/// over the time from 0 to 1, and a ray uses the one nearest to its own time. A box is tightest
/// and numbers are most exact if the origin of the child's space is in its middle.
#[derive(Clone, Debug, Default)]
pub struct Placements {
    children: Vec<u32>,
    /// The first pose of each placement, and the number of all poses; empty if each placement has
    /// one.
    first: Vec<u32>,
    poses: Vec<Affine>,
}

impl Placements {
    /// Room for `count` placements of one pose each.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            children: Vec::with_capacity(count),
            first: vec![],
            poses: Vec::with_capacity(count),
        }
    }

    /// Adds a placement of the child of an index.
    ///
    /// # Panics
    /// If `poses` is empty, or there are 2^32 poses already.
    pub fn push(&mut self, child: u32, poses: &[Affine]) {
        assert!(!poses.is_empty(), "a placement has a pose");
        if poses.len() > 1 && self.first.is_empty() {
            self.first.extend(0..=self.children.len() as u32);
        }
        self.children.push(child);
        self.poses.extend_from_slice(poses);
        let count = u32::try_from(self.poses.len()).expect("fewer than 2^32 poses");
        if !self.first.is_empty() {
            self.first.push(count);
        }
    }

    /// Number of placements.
    #[inline]
    pub fn len(&self) -> usize {
        self.children.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.children.is_empty()
    }

    /// The index of the child of a placement.
    #[inline]
    pub fn child(&self, placement: u32) -> u32 {
        self.children[placement as usize]
    }

    /// The poses of a placement.
    #[inline]
    pub fn poses(&self, placement: u32) -> &[Affine] {
        let placement = placement as usize;
        if self.first.is_empty() {
            return std::slice::from_ref(&self.poses[placement]);
        }
        let [from, to] = [0, 1].map(|i| self.first[placement + i] as usize);
        &self.poses[from..to]
    }

    /// The pose of a placement that is nearest to a time from 0 to 1.
    #[inline]
    pub fn pose(&self, placement: u32, time: f32) -> &Affine {
        let poses = self.poses(placement);
        &poses[nearest(time, poses.len())]
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.children.as_slice())
            + size_of_val(self.first.as_slice())
            + size_of_val(self.poses.as_slice())
    }

    pub(super) fn shrink(&mut self) {
        self.children.shrink_to_fit();
        self.first.shrink_to_fit();
        self.poses.shrink_to_fit();
    }
}

/// The one of `count` poses that is nearest to a time.
#[inline(always)]
pub(super) fn nearest(time: f32, count: usize) -> usize {
    let last = count - 1;
    ((time * last as f32 + 0.5) as usize).min(last)
}
