//! Steps of both instruction sets against plain arithmetic.

use std::arch::x86_64::{__m256, __m512};

use rand::{RngExt, SeedableRng, rngs::StdRng};

use super::*;
use crate::isa::Isa;
use crate::structure::kdtree::ray::Prepared;
use crate::structure::kdtree::treelet::{Child, Stand, TOP, Treelet, WIDTH, cells_of};

/// What a step pushes: children and spans, from far to near.
type Pushed = Vec<(u32, [f32; 2])>;

/// Follows a ray plane by plane.
fn expected(treelet: &Treelet, ray: &Ray, stand: Stand, span: [f32; 2], pushed: &mut Pushed) {
    let Stand { at, plane } = stand;
    if at != Child::ROOT {
        if at != Child::treelet(EMPTY) {
            pushed.push((at.0, span));
        }
        return;
    }
    let axis = treelet.axis(plane);
    let [near, far] = span;
    #[allow(clippy::disallowed_methods)] // as the steps do, in one operation
    let time = |less: f32| treelet.planes[plane].mul_add(ray.inverse[axis], -less);
    let (early, late) = (time(ray.early[axis]), time(ray.late[axis]));
    let falls = usize::from(ray.inverse[axis] < 0.0);
    if far >= early {
        let stand = treelet.beyond(at, plane, 1 - falls);
        expected(treelet, ray, stand, [early.max(near), far], pushed);
    }
    if near <= late {
        let stand = treelet.beyond(at, plane, falls);
        expected(treelet, ray, stand, [near, late.min(far)], pushed);
    }
}

/// Stands for a child that is not there.
const EMPTY: usize = 1;

/// A treelet with some planes missing, the children below them, and some others.
fn treelet(rng: &mut StdRng) -> Treelet {
    let mut treelet = Treelet::EMPTY;
    for plane in (0..=TOP).rev() {
        let is_below_missing = (plane + 1..=TOP)
            .any(|p| treelet.planes[p].is_nan() && cells_of(p) & cells_of(plane) != 0);
        if !is_below_missing && (plane == TOP || rng.random_range(0..4) > 0) {
            let axis = rng.random_range(0..3);
            treelet.set_plane(plane, axis, rng.random_range(-1.0..1.0), [false; 2]);
        }
    }
    for child in 0..WIDTH {
        let missing = (0..=TOP).filter(|&p| treelet.planes[p].is_nan());
        let is_first = missing
            .filter(|&p| cells_of(p) >> child & 1 == 1)
            .all(|p| cells_of(p).trailing_zeros() as usize == child);
        let is_there = is_first && rng.random_range(0..5) > 0;
        treelet.children[child] = if is_there { Child::treelet(100 + child) } else { Child::EMPTY };
    }
    treelet
}

fn ray(rng: &mut StdRng) -> Ray {
    let mut ray = Ray::new(&Prepared::EMPTY, 0);
    for axis in 0..3 {
        ray.inverse[axis] = rng.random_range(0.5..3.0f32).copysign(rng.random_range(-1.0..1.0));
        ray.early[axis] = rng.random_range(-1.0..1.0);
        ray.late[axis] = ray.early[axis] - rng.random_range(0.0..0.01);
    }
    ray
}

/// # Safety
/// The CPU has the instructions of `V`.
#[inline(always)]
unsafe fn check<V: Vector>() {
    let rng = &mut StdRng::seed_from_u64(5);
    let mut room = vec![Line::EMPTY; 64];
    for _ in 0..20_000 {
        let (treelet, ray) = (treelet(rng), ray(rng));
        let span = [rng.random_range(-3.0..1.0), rng.random_range(-1.0..4.0f32)];
        if span[0] > span[1] {
            continue;
        }
        // Children that are not there are told from the root, of which steps know nothing.
        let mut told = treelet;
        told.children = treelet
            .children
            .map(|child| if child == Child::EMPTY { Child::treelet(EMPTY) } else { child });
        let among = cells_of([TOP, TOP, 4, 5, 0, 3][rng.random_range(0..6)]);
        let mut pushed = vec![];
        expected(&told, &ray, told.at_plane(Child::ROOT, TOP), span, &mut pushed);
        pushed.retain(|&(child, _)| {
            (0..WIDTH).any(|c| among >> c & 1 == 1 && treelet.children[c].0 == child)
        });
        let (mut free, mut parked) = (vec![0], vec![]);
        let lines = [treelet];
        let memory = Memory { words: lines.as_ptr().cast(), places: room.as_mut_ptr(), stack: 32 };
        let mut flights = Flights { memory, free: &mut free, parked: &mut parked };
        // SAFETY: the caller's; the room is enough for a ray and its stack.
        let found: Pushed = unsafe {
            let ray = flights.park(&ray);
            let count = memory.push_cells::<V>(ray, &lines[0], span, among);
            (0..count).map(|i| memory.entry(ray, 1 + i)).collect()
        };
        assert_eq!(found, pushed, "{treelet:?} {ray:?} {span:?}");
        let t = rng.random_range(span[0]..span[1]);
        // SAFETY: as above.
        let left: Pushed = unsafe {
            let ray = memory.ray(0);
            (*ray).t = t;
            memory.cull::<V>(ray);
            (1..(*ray).top as usize).map(|i| memory.entry(ray, i)).collect()
        };
        let kept = pushed.iter().filter(|(_, [near, _])| *near <= t);
        let kept: Pushed = kept.map(|&(child, [near, far])| (child, [near, far.min(t)])).collect();
        assert_eq!(left, kept);
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn check_avx2() {
    // SAFETY: those are the instructions.
    unsafe { check::<__m256>() }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn check_avx512() {
    // SAFETY: those are the instructions.
    unsafe { check::<__m512>() }
}

#[test]
fn steps_go_plane_by_plane() {
    // SAFETY: the CPU has the instructions.
    unsafe {
        if Isa::Avx2.is_available() {
            check_avx2();
        }
        if Isa::Avx512.is_available() {
            check_avx512();
        }
    }
}
