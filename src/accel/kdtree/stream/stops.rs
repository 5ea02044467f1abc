//! Where rays in flight stand next, in lists by kind.

use crate::accel::kdtree::treelet::Child;

/// Rays in flight.
pub(super) const IN_FLIGHT: usize = 32;

/// A ray in flight and what it stands before, written and read as one word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop(u64);

impl Stop {
    /// Nowhere.
    pub(super) const NONE: Self = Self::new(0, Child::DONE);

    #[inline(always)]
    pub(super) const fn new(place: u32, child: Child) -> Self {
        Self((child.0 as u64) << 32 | place as u64)
    }

    /// Where the ray is, in bytes from the first.
    #[inline(always)]
    pub(super) fn place(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    pub(super) fn child(self) -> Child {
        Child((self.0 >> 32) as u32)
    }
}

/// Lists of stops by kind, each worked off from its front while stops are added to all of them: a
/// stop is read before its place can be needed for another.
pub(super) struct Stops {
    lists: *mut Stop,
    /// Where each list ends, in bytes from the first list: 16 bits a kind. In a register, the
    /// length of no list is loaded from where it was just stored; the CPU would make other loads
    /// wait for such ones too.
    ends: u64,
}

/// Lists that [`Stops`] fills.
pub(super) type Lists = [[Stop; IN_FLIGHT]; KINDS];

/// Two bits of a child tell its kind.
const KINDS: usize = 4;

/// Bytes of a stop, and from one list to the next.
const STOP: u64 = size_of::<Stop>() as u64;
const LIST: u64 = IN_FLIGHT as u64 * STOP;

/// Bits of an end.
const END: u64 = 0xffff;

impl Stops {
    /// All lists end where they begin.
    const EMPTY: u64 = LIST << 16 | (2 * LIST) << 32 | (3 * LIST) << 48;

    pub(super) fn new(lists: &mut Lists) -> Self {
        Self { lists: lists.as_mut_ptr().cast(), ends: Self::EMPTY }
    }

    /// Puts a ray into the list that is right for its next stop, without a branch.
    ///
    /// # Safety
    /// No list is full.
    #[inline(always)]
    pub(super) unsafe fn push(&mut self, stop: Stop) {
        let shift = 16 * stop.child().kind();
        let end = (self.ends >> shift & END) as usize;
        // SAFETY: the caller's.
        unsafe { *self.lists.byte_add(end) = stop };
        self.ends += STOP << shift;
    }

    /// Whether no ray stands anywhere.
    #[inline(always)]
    pub(super) fn are_none(&self) -> bool {
        self.ends == Self::EMPTY
    }

    #[inline(always)]
    pub(super) fn len(&self, kind: usize) -> usize {
        (((self.ends - Self::EMPTY) >> (16 * kind) & END) / STOP) as usize
    }

    /// Empties a list; how long it was. What it held can be read until as many were added.
    #[inline(always)]
    pub(super) fn take(&mut self, kind: usize) -> usize {
        let len = self.len(kind);
        self.ends -= (len as u64 * STOP) << (16 * kind);
        len
    }

    /// # Safety
    /// `i` is less than the list's length is or was, and fewer than `i + 1` stops were added since.
    #[inline(always)]
    pub(super) unsafe fn get(&self, kind: usize, i: usize) -> Stop {
        // SAFETY: the caller's.
        unsafe { *self.lists.add(kind * IN_FLIGHT + i) }
    }
}
