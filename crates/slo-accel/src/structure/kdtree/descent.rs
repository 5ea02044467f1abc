//! Rays that start close together descend together to where they start, whatever their directions.
//!
//! At least half of the treelets that a bounce or a shadow ray visits are those about its origin.
//! If sixteen neighbours all start in the same child of a treelet, they descend to it together, a
//! ray to a lane; the kernel notes which of them visit other children later. At the first treelet
//! in which a plane separates them they become rays of the stream, with the later visits on their
//! stacks.
//!
//! A hierarchy whose boxes overlap has no such children. Unlike in a packet, directions are
//! arbitrary.

use std::arch::x86_64::*;

use super::flight::{Flights, Ray, Vector, axes, row};
use super::ray::Prepared;
use super::tree::MAX_DEPTH;
use super::treelet::{Child, MIDDLE, Stand, TOP, Treelet};
use crate::rays::LANES;
use crate::simd::{lanes_of, load3};

/// Fewer rays go down one by one.
const ENOUGH: u32 = 4;

/// A treelet on the way down.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Passed {
    /// The latest t at which each ray leaves it.
    far: [f32; LANES],
    treelet: Child,
    /// The child in which all rays start.
    child: usize,
    /// The rays that visit other children, too.
    lanes: u32,
}

/// Working memory: the treelets on the way down.
#[derive(Debug)]
pub(super) struct Path {
    passed: [Passed; MAX_DEPTH + 1],
    /// How many rays were brought down.
    #[cfg(test)]
    pub(super) brought_down: u32,
}

impl Default for Path {
    fn default() -> Self {
        let passed = Passed { far: [0.0; LANES], treelet: Child::ROOT, child: 0, lanes: 0 };
        Self {
            passed: [passed; MAX_DEPTH + 1],
            #[cfg(test)]
            brought_down: 0,
        }
    }
}

/// Lets those of sixteen rays descend that start together, and parks them; `ready` has each ray.
/// Returns the rays that start at the root.
///
/// # Safety
/// The CPU has the instructions of `V`; there is a free place for each ray.
#[inline(always)]
pub(super) unsafe fn descend<V: Vector>(
    path: &mut Path,
    flights: &mut Flights,
    prepared: &Prepared,
    ready: &[Ray; LANES],
    pending: u32,
) -> u32 {
    let mut left = 0;
    for base in (0..LANES).step_by(V::COUNT) {
        let set = pending >> base & ((1u64 << V::COUNT) - 1) as u32;
        // SAFETY: the caller's; there are as many lanes.
        unsafe {
            let origins = Origins::new::<V>(load3(&prepared.start, base));
            let root = flights.memory.treelet(Child::ROOT);
            if set.count_ones() < ENOUGH || origins.child_of(root).is_none() {
                left |= set << base;
                continue;
            }
            descend_from::<V>(path, flights, prepared, &ready[base..], (base, set), &origins);
        }
    }
    left
}

/// Lets the rays of one register descend: a set of those from `base` on.
///
/// # Safety
/// As [`descend`]; `base` leaves enough lanes.
#[inline(always)]
unsafe fn descend_from<V: Vector>(
    path: &mut Path,
    flights: &mut Flights,
    prepared: &Prepared,
    ready: &[Ray],
    (base, set): (usize, u32),
    origins: &Origins,
) {
    // SAFETY: no way down has more treelets than there are places; rows have places for all lanes;
    // planes, axes, and children of treelets are those that exist.
    unsafe {
        let memory = flights.memory;
        let passed_by = path.passed.as_mut_ptr();
        let inverse: [V; 3] = load3(&prepared.inverse, base);
        let early: [V; 3] = load3(&prepared.early, base);
        let late: [V; 3] = load3(&prepared.late, base);
        let zero = V::splat(0.0);
        let falls = [inverse[0].lt(zero), inverse[1].lt(zero), inverse[2].lt(zero)];
        let near = V::load(prepared.near.as_ptr().add(base));
        let mut far = V::load(prepared.far.as_ptr().add(base));
        // Those that come to the child.
        let mut lanes = set;
        let mut passed = 0;
        let mut at = Child::ROOT;
        while at.is_treelet() && lanes != 0 {
            let treelet = memory.treelet(at);
            let Some((child, about)) = origins.child_of(treelet) else { break };
            let far_before = far;
            let mut others = 0;
            for (plane, side) in about {
                let axis = treelet.axis(plane);
                let position = V::splat(*treelet.planes.get_unchecked(plane));
                let inverse = *inverse.get_unchecked(axis);
                let early = position.mul_sub(inverse, *early.get_unchecked(axis));
                let late = position.mul_sub(inverse, *late.get_unchecked(axis));
                // Rays go from the child's side to the other, or may come from there if they start
                // close to the plane. NaN, no plane, is neither.
                let falls = *falls.get_unchecked(axis);
                let goes = if side == 1 { falls } else { !falls };
                let crosses = (goes & early.le(far)) | (!goes & near.le(late));
                others |= if treelet.is_empty(plane, 1 - side) { 0 } else { crosses };
                far = far.replace(goes, late.min(far));
            }
            if lanes & others != 0 {
                let now = &mut *passed_by.add(passed);
                far_before.store(now.far.as_mut_ptr());
                (now.treelet, now.child, now.lanes) = (at, child, lanes & others);
                passed += 1;
            }
            lanes &= near.le(far);
            at = *treelet.children.get_unchecked(child);
            lanes = if at == Child::EMPTY { 0 } else { lanes };
        }
        #[cfg(test)]
        {
            path.brought_down += set.count_ones();
        }
        let mut rays = [std::ptr::null_mut::<Ray>(); LANES];
        for lane in lanes_of(set) {
            rays[lane] = flights.park(&ready[lane]);
        }
        for i in 0..passed {
            let Passed { far, treelet, child, lanes } = &*passed_by.add(i);
            let treelet = memory.treelet(*treelet);
            for lane in lanes_of(*lanes) {
                let span = [prepared.near[base + lane], far[lane]];
                memory.push_cells::<V>(rays[lane], treelet, span, !(1 << child));
            }
        }
        let mut fars = [0.0; LANES];
        far.store(fars.as_mut_ptr());
        for lane in lanes_of(lanes) {
            let span = [prepared.near[base + lane], fars[lane]];
            memory.push::<V>(rays[lane], Stand { at, plane: TOP }, span);
        }
    }
}

/// Bounds of the origins of rays. The fourth numbers mean nothing.
struct Origins {
    least: [f32; 4],
    most: [f32; 4],
}

impl Origins {
    /// # Safety
    /// The CPU has the instructions of `V`.
    #[inline(always)]
    unsafe fn new<V: Vector>([x, y, z]: [V; 3]) -> Self {
        // SAFETY: the caller's.
        unsafe {
            let zero = V::splat(0.0);
            let most = V::leasts([zero.sub(x), zero.sub(y), zero.sub(z), zero]);
            Self { least: V::leasts([x, y, z, zero]), most: most.map(|least| -least) }
        }
    }

    /// The child of a treelet in which all rays start, and the planes about it, each with the side
    /// on which the child lies. None if a plane separates the rays, or one may start on it.
    ///
    /// # Safety
    /// The CPU has AVX2.
    #[inline(always)]
    unsafe fn child_of(&self, treelet: &Treelet) -> Option<(usize, [(usize, usize); 3])> {
        // SAFETY: the caller's; what is loaded as eight numbers is as long.
        let (above, between) = unsafe {
            let planes = _mm256_load_ps(treelet.planes.as_ptr());
            let axes = axes(treelet);
            let (least, most) = (row(&self.least, axes), row(&self.most, axes));
            // A plane that is not there, NaN, is between none, and none starts above it.
            let above = _mm256_cmp_ps::<_CMP_LT_OQ>(planes, least);
            let not_below = _mm256_cmp_ps::<_CMP_LE_OQ>(planes, most);
            let between = _mm256_andnot_ps(above, not_below);
            (_mm256_movemask_ps(above) as usize, _mm256_movemask_ps(between) as usize)
        };
        let sides0 = above >> TOP & 1;
        let plane1 = MIDDLE + sides0;
        let sides1 = 2 * sides0 + (above >> plane1 & 1);
        let plane2 = sides1;
        let child = 2 * sides1 + (above >> plane2 & 1);
        let about = [(TOP, sides0), (plane1, sides1 & 1), (plane2, child & 1)];
        let planes = 1 << TOP | 1 << plane1 | 1 << plane2;
        (between & planes == 0).then_some((child, about))
    }
}
