//! The looks of hits, for whole batches. Each look is one word.

use super::world::{STILL, WorldHits};
use slo_accel::math::columns::Column;
use slo_accel::{Isa, Lanewise, NO_HIT};

/// What is seen of a surface: a material, or a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// Index of a material.
    Material(u32),
    /// The surface of the light with this index, from both sides.
    Light(u32),
    /// No surface.
    Nothing,
}

impl Look {
    /// The word of [`Nothing`](Self::Nothing).
    pub(crate) const NOTHING: u32 = u32::MAX;

    /// Words below this are materials; words from here on are lights.
    const LIGHTS: u32 = 1 << 31;

    /// Returns the index of the material, if it is one.
    pub(crate) fn material(self) -> Option<u32> {
        match self {
            Self::Material(index) => Some(index),
            Self::Light(_) | Self::Nothing => None,
        }
    }

    fn word(self) -> u32 {
        match self {
            Self::Material(index) => index,
            Self::Light(index) => Self::LIGHTS | index,
            Self::Nothing => Self::NOTHING,
        }
    }

    pub(crate) fn of_word(word: u32) -> Self {
        match word {
            Self::NOTHING => Self::Nothing,
            Self::LIGHTS.. => Self::Light(word & !Self::LIGHTS),
            _ => Self::Material(word),
        }
    }

    /// Whether a word means a material. It is then the material's index.
    #[inline(always)]
    pub(crate) fn is_material(word: u32) -> bool {
        word < Self::LIGHTS
    }
}

/// Looks of all objects.
#[derive(Debug)]
pub(super) struct Looks {
    /// Word of each object, and [`Look::Nothing`] at the end.
    words: Vec<u32>,
    /// Index of the object of each instance.
    of_instances: Vec<u32>,
}

impl Looks {
    pub(super) fn new(
        objects: impl Iterator<Item = Look>,
        of_instances: impl Iterator<Item = u32>,
    ) -> Self {
        let words = objects.chain([Look::Nothing]).map(Look::word).collect();
        Self { words, of_instances: of_instances.collect() }
    }

    /// Finds the looks of what the rays of a batch hit, as words. `still_objects` holds the index
    /// of the object of each still primitive.
    pub(super) fn find(
        &self,
        isa: Isa,
        still_objects: &[u32],
        found: &WorldHits,
        to: &mut Column<u32>,
    ) {
        isa.run(FindLooks { looks: self, still_objects, found, to });
    }

    /// Returns the number of objects.
    pub(super) fn len(&self) -> usize {
        self.words.len() - 1
    }

    /// Returns the look of the object with an index.
    pub(super) fn of(&self, object: u32) -> Look {
        Look::of_word(self.word_of(object))
    }

    /// Returns the look of the object with an index, as a word.
    #[inline]
    pub(super) fn word_of(&self, object: u32) -> u32 {
        self.words[object as usize]
    }
}

struct FindLooks<'a> {
    looks: &'a Looks,
    still_objects: &'a [u32],
    found: &'a WorldHits,
    to: &'a mut Column<u32>,
}

impl Lanewise for FindLooks<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { looks, still_objects, found, to } = self;
        let Looks { words, of_instances } = looks;
        let primitives = &found.hits.primitive[..];
        // First the objects.
        if let Some(last) = still_objects.len().checked_sub(1) {
            for (to, &primitive) in to.iter_mut().zip(primitives) {
                *to = still_objects[(primitive as usize).min(last)];
            }
        }
        if let Some(last) = of_instances.len().checked_sub(1) {
            for (to, &instance) in to.iter_mut().zip(&found.instance) {
                let moving = of_instances[(instance as usize).min(last)];
                *to = if instance == STILL { *to } else { moving };
            }
        }
        let last = words.len() - 1;
        for (to, &primitive) in to.iter_mut().zip(primitives) {
            let word = words[(*to as usize).min(last)];
            *to = if primitive == NO_HIT { u32::MAX } else { word };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_say_looks() {
        for look in [Look::Material(0), Look::Material(7), Look::Light(0), Look::Light(9)] {
            assert_eq!(Look::of_word(look.word()), look);
            assert_eq!(Look::is_material(look.word()), matches!(look, Look::Material(_)));
        }
        assert_eq!(Look::of_word(Look::Nothing.word()), Look::Nothing);
        assert!(!Look::is_material(Look::Nothing.word()));
    }
}
