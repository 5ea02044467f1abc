//! Names of sample sets: integers that depend on everything a sample may depend on.

use super::hash::hash2;

/// Pixels of a block whose samples belong together: 8 x 8.
pub(super) const BLOCK: u32 = 64;

/// Hits of a path that have groups of their own.
pub(super) const HITS: usize = 3;

/// The samples of one pixel of one frame under one seed: a word for its block, whose low bits are
/// the pixel's place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelSeed(u32);

/// Name of one set of sample points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// What it is for, in all pixels of a block.
    pub(super) set: u32,
    /// Place of the pixel in its block.
    pub(super) at: u32,
    /// Bounces before it.
    pub(super) depth: u32,
    /// Whether the points of the same number of a path belong together.
    pub(super) joint: bool,
}

impl Key {
    /// A word for the set of this pixel alone.
    #[inline(always)]
    pub(super) fn word(self) -> u32 {
        hash2(self.set, self.at)
    }
}

/// A hit of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    /// The code of the branches that led there; 0: none did.
    pub path: u32,
    /// How many there were.
    pub depth: u32,
    /// Whether rays have numbers of their own, since this or an earlier hit sends several of a
    /// kind.
    pub split: bool,
}

impl Hit {
    /// Whether the points of its sets belong to those of the same number before it.
    #[inline(always)]
    pub(super) fn is_joint(self) -> bool {
        !self.split && (self.depth as usize) < HITS
    }
}

/// What a hit needs random numbers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A point on the light of that number.
    Light(u32),
    /// Which light, and a point on it.
    AnyLight,
    /// A direction of the reflected lobe.
    Reflection,
    /// A direction of the refracted lobe.
    Refraction,
}

/// A [`Purpose`] as a word, so that loops over many hits need not ask which it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Use(u32);

impl From<Purpose> for Use {
    fn from(purpose: Purpose) -> Self {
        Self(match purpose {
            Purpose::AnyLight => 1,
            Purpose::Reflection => 2,
            Purpose::Refraction => 3,
            Purpose::Light(number) => number.wrapping_add(4),
        })
    }
}

impl PixelSeed {
    /// The seed of the pixel in column `x` and row `y` of a picture whose seed is `picture`.
    pub(super) fn new(picture: u32, x: u32, y: u32) -> Self {
        let block = hash2(hash2(picture, x / 8), y / 8);
        // Blocks differ in which pixel is which, too.
        let (x, y) = if block >> 31 == 1 { (x, y) } else { (y, x) };
        let places = (x & 1) | (x & 2) << 1 | (x & 4) << 2;
        let places = places | (y & 1) << 1 | (y & 2) << 2 | (y & 4) << 3;
        Self(block ^ places)
    }

    /// The seed as a word, to be kept in arrays.
    pub fn word(self) -> u32 {
        self.0
    }

    /// The seed of a word that [`word`](Self::word) gave.
    pub fn from_word(word: u32) -> Self {
        Self(word)
    }

    /// The set of camera samples.
    #[inline(always)]
    pub(super) fn camera(self) -> Key {
        Key { set: self.0 / BLOCK, at: self.0 % BLOCK, depth: 0, joint: true }
    }

    /// The set for one purpose at one hit.
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

/// The code of the path that goes on from `path` by reflection or refraction.
#[inline(always)]
pub(crate) fn next_path(path: u32, Use(branch): Use) -> u32 {
    hash2(path, branch)
}
