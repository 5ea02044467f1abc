//! What packets leave for later, and what rays take with them that leave one.

use crate::accel::LANES;
use crate::accel::kdtree::MAX_DEPTH;
use crate::accel::simd::Lanes;

/// Packets go on being made while so many of sixteen lanes are in use on average.
const LANES_IN_USE: u32 = 6;

/// Steps before that is judged.
const TRIAL: u32 = 200;

/// Packets let rays go to the stream once so many lanes of each were left alone on average: packets
/// of 16, and of 8, which gain less by it.
const ALONE: [u32; 2] = [3, 10];

/// What is left for later: a part of the tree, and the parts of rays that lie in it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Later {
    pub(super) near: [f32; LANES],
    pub(super) far: [f32; LANES],
    pub(super) node: usize,
    pub(super) lanes: u32,
}

/// Working memory, and how well lanes were used.
#[derive(Debug)]
pub(in crate::accel::kdtree) struct Stack {
    pub(super) later: Box<[Later; MAX_DEPTH + 1]>,
    pub(super) steps: u32,
    pub(super) lanes: u32,
    pub(super) packets: u32,
    /// How often a lane was left alone.
    pub(super) alone: u32,
}

impl Default for Stack {
    fn default() -> Self {
        let later = Later { near: [0.0; LANES], far: [0.0; LANES], node: 0, lanes: 0 };
        let later = Box::new([later; MAX_DEPTH + 1]);
        Self { later, steps: 0, lanes: 0, packets: 0, alone: 0 }
    }
}

impl Stack {
    /// Forgets how lanes were used.
    pub(in crate::accel::kdtree) fn begin(&mut self) {
        (self.steps, self.lanes, self.packets, self.alone) = (0, 0, 0, 0);
    }

    /// Whether packets are worth their while: rays that are in many packets with few lanes in use
    /// are faster by themselves.
    pub(in crate::accel::kdtree) fn is_good<L: Lanes>(&self) -> bool {
        self.steps < TRIAL
            || u64::from(self.lanes) * LANES as u64
                >= u64::from(LANES_IN_USE * self.steps) * L::COUNT as u64
    }

    /// Whether lanes that are left alone should leave their packet: where few are, too few of them
    /// would be under way together in a stream.
    pub(in crate::accel::kdtree) fn lets_go<L: Lanes>(&self) -> bool {
        self.alone > ALONE[usize::from(L::COUNT < LANES)] * (self.packets + 4)
    }
}

/// Rays that left their packet, each with its part of the stack.
#[derive(Debug)]
#[repr(C, align(64))]
pub(in crate::accel::kdtree) struct Parking {
    /// Which of sixteen.
    pub(in crate::accel::kdtree) lanes: u32,
    /// Where each stands, and the part of it that lies there.
    pub(in crate::accel::kdtree) node: [u32; LANES],
    pub(in crate::accel::kdtree) span: [[f32; LANES]; 2],
    /// Best hits so far: t, u, v, and bits of ids.
    pub(in crate::accel::kdtree) best: [[f32; LANES]; 4],
    /// Parts of the tree that are left for later, from place 1 of each stack to before `top`; the
    /// last is the nearest.
    pub(in crate::accel::kdtree) later: [[(u32, [f32; 2]); LANES]; MAX_DEPTH + 2],
    pub(in crate::accel::kdtree) top: [u32; LANES],
}

impl Parking {
    pub(in crate::accel::kdtree) const EMPTY: Self = Self {
        lanes: 0,
        node: [0; LANES],
        span: [[0.0; LANES]; 2],
        best: [[0.0; LANES]; 4],
        later: [[(0, [0.0; 2]); LANES]; MAX_DEPTH + 2],
        top: [0; LANES],
    };
}
