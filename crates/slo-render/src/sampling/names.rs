//! Names of sample sets: hashes of everything that a sample may depend on.

use super::hash::hash2;

/// Number of pixels of a block (8 x 8) whose samples are stratified jointly.
pub(super) const BLOCK: u32 = 64;

/// Number of hits of a path that have groups of dimensions of their own.
pub(super) const HITS: usize = 3;

/// Seed of one pixel of one frame of one picture: a hash of its block of pixels, whose low bits
/// hold the pixel's place in the block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelSeed(u32);

/// Name of one set of sample points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Hash of the set's use, the same in all pixels of a block.
    pub(super) set: u32,
    /// Place of the pixel in its block.
    pub(super) at: u32,
    /// Number of bounces before the hit.
    pub(super) depth: u32,
    /// Whether points of equal number are stratified jointly along a path.
    pub(super) joint: bool,
}

impl Key {
    /// Returns a hash for the set of this pixel alone.
    #[inline(always)]
    pub(super) fn word(self) -> u32 {
        hash2(self.set, self.at)
    }
}

/// A hit of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    /// Hash of the branches that led to it; 0 for a camera ray.
    pub path: u32,
    /// Number of these branches: the bounces before the hit.
    pub depth: u32,
    /// Whether rays have sample numbers of their own, because this or an earlier hit sends several
    /// rays of one kind.
    pub split: bool,
}

impl Hit {
    /// Whether its points are stratified jointly with the points of equal number at earlier hits.
    #[inline(always)]
    pub(super) fn is_joint(self) -> bool {
        !self.split && (self.depth as usize) < HITS
    }
}

/// What a hit needs random numbers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A point on the light with this number.
    Light(u32),
    /// The choice of a light, and a point on it.
    AnyLight,
    /// A direction of the reflected lobe.
    Reflection,
    /// A direction of the refracted lobe.
    Refraction,
    /// A lobe, and a direction of it.
    Continuation,
    /// Whether a weak ray is followed.
    Survival,
    /// Whether a ray passes through, and which of two mixed materials it meets.
    Surface,
    /// Where a light path starts: a lamp, and a place on it.
    Departure,
    /// In which direction a light path starts, and when.
    Heading,
}

/// A [`Purpose`] as a word, so that loops over many hits need no branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Use(u32);

impl From<Purpose> for Use {
    fn from(purpose: Purpose) -> Self {
        Self(match purpose {
            Purpose::AnyLight => 1,
            Purpose::Reflection => 2,
            Purpose::Refraction => 3,
            Purpose::Continuation => u32::MAX,
            Purpose::Survival => u32::MAX - 1,
            Purpose::Surface => u32::MAX - 2,
            Purpose::Departure => u32::MAX - 3,
            Purpose::Heading => u32::MAX - 4,
            Purpose::Light(number) => number.wrapping_add(4),
        })
    }
}

impl PixelSeed {
    /// Creates the seed of the pixel in column `x` and row `y` of a picture with seed `picture`.
    pub(super) fn new(picture: u32, x: u32, y: u32) -> Self {
        let block = hash2(hash2(picture, x / 8), y / 8);
        // Half of the blocks are transposed.
        let (x, y) = if block >> 31 == 1 { (x, y) } else { (y, x) };
        let places = (x & 1) | (x & 2) << 1 | (x & 4) << 2;
        let places = places | (y & 1) << 1 | (y & 2) << 2 | (y & 4) << 3;
        Self(block ^ places)
    }

    /// Returns the seed as a word, for storage in arrays.
    pub fn word(self) -> u32 {
        self.0
    }

    /// Restores a seed from the result of [`word`](Self::word).
    pub fn from_word(word: u32) -> Self {
        Self(word)
    }

    /// Returns the key of the set of camera samples.
    #[inline(always)]
    pub(super) fn camera(self) -> Key {
        Key { set: self.0 / BLOCK, at: self.0 % BLOCK, depth: 0, joint: true }
    }

    /// Returns the key of the set for one purpose at one hit.
    #[inline(always)]
    pub fn key(self, hit: Hit, purpose: Purpose) -> Key {
        self.key_of(hit, purpose.into())
    }

    #[inline(always)]
    pub(super) fn key_of(self, hit: Hit, Use(word): Use) -> Key {
        Key {
            set: hash2(hash2(self.0 / BLOCK, hit.path), word),
            at: self.0 % BLOCK,
            depth: hit.depth,
            joint: hit.is_joint(),
        }
    }
}

/// Returns the code of the path that continues `path` by reflection or refraction.
#[inline(always)]
pub(crate) fn next_path(path: u32, Use(branch): Use) -> u32 {
    hash2(path, branch)
}
