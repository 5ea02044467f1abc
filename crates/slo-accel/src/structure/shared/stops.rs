//! What rays in flight visit next, in lists by kind.

use std::marker::PhantomData;

/// What a ray visits next: a word whose highest two bits are its kind; all bits are set if the ray
/// is done.
pub(crate) trait Target: Copy {
    fn word(self) -> u32;

    fn of_word(word: u32) -> Self;
}

/// Rays in flight.
pub(crate) const IN_FLIGHT: usize = 32;

/// A ray in flight and what it visits next, written and read as one word.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop<C>(u64, PhantomData<C>);

impl<C: Target> Stop<C> {
    /// Nowhere.
    pub(crate) const NONE: Self = Self((u32::MAX as u64) << 32, PhantomData);

    #[inline(always)]
    pub(crate) fn new(place: u32, child: C) -> Self {
        Self(u64::from(child.word()) << 32 | u64::from(place), PhantomData)
    }

    /// Offset of the ray, in bytes from the first place.
    #[inline(always)]
    pub(crate) fn place(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    pub(crate) fn child(self) -> C {
        C::of_word((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn kind(self) -> usize {
        (self.0 >> 62) as usize
    }
}

/// Lists of stops by kind. Each is read from its front while stops are added to all of them: a stop
/// is read before its place is overwritten.
pub(crate) struct Stops<C> {
    lists: *mut Stop<C>,
    /// End of each list, in bytes from the first list: 16 bits a kind. They share a register, so
    /// that no length is loaded right after it was stored: the CPU would make other loads wait for
    /// such loads too.
    ends: u64,
}

/// Lists that [`Stops`] fills.
pub(crate) type Lists<C> = [[Stop<C>; IN_FLIGHT]; KINDS];

/// Kinds: two bits.
const KINDS: usize = 4;

/// Bytes of a stop, and from one list to the next.
const STOP: u64 = size_of::<u64>() as u64;
const LIST: u64 = IN_FLIGHT as u64 * STOP;

/// Bits of an end.
const END: u64 = 0xffff;

impl<C: Target> Stops<C> {
    /// Ends of empty lists.
    const EMPTY: u64 = LIST << 16 | (2 * LIST) << 32 | (3 * LIST) << 48;

    pub(crate) fn new(lists: &mut Lists<C>) -> Self {
        Self { lists: lists.as_mut_ptr().cast(), ends: Self::EMPTY }
    }

    /// Puts a ray into the list of its next stop's kind, without a branch.
    ///
    /// # Safety
    /// No list is full.
    #[inline(always)]
    pub(crate) unsafe fn push(&mut self, stop: Stop<C>) {
        let shift = 16 * stop.kind();
        let end = (self.ends >> shift & END) as usize;
        // SAFETY: the caller's.
        unsafe { *self.lists.byte_add(end) = stop };
        self.ends += STOP << shift;
    }

    /// Whether no ray stands anywhere.
    #[inline(always)]
    pub(crate) fn are_none(&self) -> bool {
        self.ends == Self::EMPTY
    }

    #[inline(always)]
    pub(crate) fn len(&self, kind: usize) -> usize {
        (((self.ends - Self::EMPTY) >> (16 * kind) & END) / STOP) as usize
    }

    /// Empties a list and returns its length. Its stops can be read until as many are added.
    #[inline(always)]
    pub(crate) fn take(&mut self, kind: usize) -> usize {
        let len = self.len(kind);
        self.ends -= (len as u64 * STOP) << (16 * kind);
        len
    }

    /// # Safety
    /// `i` is less than the list's length is or was, and fewer than `i + 1` stops were added since.
    #[inline(always)]
    pub(crate) unsafe fn get(&self, kind: usize, i: usize) -> Stop<C> {
        // SAFETY: the caller's.
        unsafe { *self.lists.add(kind * IN_FLIGHT + i) }
    }
}
