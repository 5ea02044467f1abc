//! Rays on their way through boxes, each by itself. What waits for memory in one ray is hidden by the
//! steps of the others.

use super::Boxes;
use crate::isa::{Isa, Lanewise};
use crate::rays::{LANES, Rays};
use crate::simd::{lanes_of, prefetch};
use crate::structure::bvh::flights::{Line, RAY_LINES};
use crate::structure::bvh::layout::{Child, Node};
#[cfg(target_arch = "aarch64")]
use crate::structure::bvh::neon;
use crate::structure::bvh::ray::{Prepared, Ray};
use crate::structure::bvh::steps::{self, Steps};
#[cfg(target_arch = "x86_64")]
use crate::structure::bvh::x86;

/// Most rays that are on their way together.
pub(crate) const TOGETHER: usize = 1024;

/// Steps of rays before their next visits are looked up.
const TURN: usize = 16;

/// Steps through boxes that give the same bits on all instruction sets.
trait BoxSteps {
    /// As [`Steps::children`].
    ///
    /// # Safety
    /// As there.
    unsafe fn children(node: &Node, ray: &Ray, ts: *mut f32, children: *mut Child) -> usize;

    /// As [`Steps::cull`].
    ///
    /// # Safety
    /// As there.
    unsafe fn cull(ts: *mut f32, children: *mut Child, len: usize, t: f32) -> usize;

    /// As [`Steps::deal`].
    ///
    /// # Safety
    /// As there.
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]);
}

/// The steps of a stream, whose products are fused.
struct OfStream<S>(std::marker::PhantomData<S>);

impl<S: Steps> BoxSteps for OfStream<S> {
    #[inline(always)]
    unsafe fn children(node: &Node, ray: &Ray, ts: *mut f32, children: *mut Child) -> usize {
        // SAFETY: the caller's.
        unsafe { S::children(node, ray, u8::MAX, ts, children) }
    }

    #[inline(always)]
    unsafe fn cull(ts: *mut f32, children: *mut Child, len: usize, t: f32) -> usize {
        // SAFETY: the caller's.
        unsafe { S::cull(ts, children, len, t) }
    }

    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        // SAFETY: the caller's.
        unsafe { S::deal(prepared, rays) }
    }
}

/// Plain Rust, whose products are fused as those of the other sets are.
struct Portable;

impl BoxSteps for Portable {
    // All sets fuse: none gives other bits.
    #[allow(clippy::disallowed_methods)]
    unsafe fn children(node: &Node, ray: &Ray, ts: *mut f32, children: *mut Child) -> usize {
        let mut count = 0;
        for word in node.order {
            let place = (word >> ray.order_shift & 7) as usize;
            let (mut near, mut far) = (0.0f32, ray.t);
            for axis in 0..3 {
                let negative = (ray.entries[axis] >> 5 & 1) as usize;
                let entry = node.planes[2 * axis + negative][place];
                let exit = node.planes[2 * axis + 1 - negative][place];
                near = near.max(entry.mul_add(ray.inverse[axis], -ray.near[axis]));
                far = far.min(exit.mul_add(ray.inverse[axis], -ray.far[axis]));
            }
            if near <= far {
                // SAFETY: at most eight entries are written.
                unsafe {
                    *ts.add(count) = near;
                    *children.add(count) = node.children[place];
                }
                count += 1;
            }
        }
        count
    }

    #[inline(always)]
    unsafe fn cull(ts: *mut f32, children: *mut Child, len: usize, t: f32) -> usize {
        // SAFETY: the caller's.
        unsafe { steps::Portable::<false>::cull(ts, children, len, t) }
    }

    #[inline(always)]
    unsafe fn deal(prepared: &Prepared, rays: &mut [Ray; LANES]) {
        // SAFETY: the caller's.
        unsafe { steps::Portable::<false>::deal(prepared, rays) }
    }
}

/// Up to [`TOGETHER`] rays on their way. A ray's place is its number among them.
#[derive(Debug)]
pub(crate) struct Walks {
    prepared: Prepared,
    /// Sixteen rays.
    ready: [Line; LANES * RAY_LINES],
    /// For each place the ray itself, then its stack: distances, then children.
    lines: Vec<Line>,
    /// Places and nodes of the rays that are on their way.
    open: Vec<(u32, Child)>,
    /// What the ray of each place stands before.
    at: Vec<Child>,
    /// Places of the rays that stand before a box, ascending.
    halted: Vec<u32>,
    /// Whether a ray has become shorter, or is done, since it halted.
    news: Vec<News>,
    /// Rays that are not tame.
    wild: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum News {
    None,
    Shorter,
    Done,
}

impl Default for Walks {
    fn default() -> Self {
        Self {
            prepared: Prepared::EMPTY,
            ready: [Line([0; 64]); LANES * RAY_LINES],
            lines: vec![],
            open: vec![],
            at: vec![],
            halted: vec![],
            news: vec![],
            wild: vec![],
        }
    }
}

impl Walks {
    /// Sets out with the `count` rays from `first` on, a multiple of [`LANES`], up to the distances
    /// in `reach`, and goes on until each has halted. Rays that are not tame do not set out.
    pub(crate) fn start<T: Copy>(
        &mut self,
        boxes: &Boxes<T>,
        (rays, reach): (&Rays, &[f32]),
        first: usize,
        count: usize,
    ) {
        assert!(count <= TOGETHER && reach.len() >= (first + count).next_multiple_of(LANES));
        // An odd number of lines, so that stacks do not compete for the same places of a cache.
        let lines = self.lines.len().max(count.next_multiple_of(LANES) * boxes.lines());
        self.lines.resize(lines, Line([0; 64]));
        self.at.clear();
        self.at.resize(count, Child::DONE);
        self.news.clear();
        self.news.resize(count, News::None);
        self.halted.clear();
        self.wild.clear();
        self.open.clear();
        if boxes.nodes.is_empty() {
            return;
        }
        self.run(boxes, Step::Start { rays, reach, first });
    }

    /// Goes on with all rays that stand before a box, until each has halted again.
    pub(crate) fn go_on<T: Copy>(&mut self, boxes: &Boxes<T>) {
        self.run(boxes, Step::GoOn);
    }

    /// Places of the rays that stand before a box, ascending.
    pub(crate) fn halted(&self) -> &[u32] {
        &self.halted
    }

    /// The box before which a halted ray stands.
    #[inline]
    pub(crate) fn leaf(&self, place: u32) -> u32 {
        self.at[place as usize].index() as u32
    }

    /// Numbers of the rays that did not set out; [`Boxes::visit`] is for them.
    pub(crate) fn wild(&self) -> &[u32] {
        &self.wild
    }

    /// Makes a halted ray shorter.
    #[inline]
    pub(crate) fn shorten<T: Copy>(&mut self, boxes: &Boxes<T>, place: u32, t: f32) {
        assert!((place as usize) < self.at.len());
        self.news[place as usize] = News::Shorter;
        // SAFETY: it is the place of a ray that has set out.
        unsafe { (*ray(&mut self.lines, boxes.lines(), place)).t = t };
    }

    /// Ends the way of a halted ray.
    #[inline]
    pub(crate) fn end(&mut self, place: u32) {
        self.news[place as usize] = News::Done;
    }

    fn run<T: Copy>(&mut self, boxes: &Boxes<T>, step: Step) {
        match boxes.isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => boxes
                .isa
                .run(Going::<T, OfStream<x86::Avx512<false, false>>>::new(self, boxes, step)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => {
                boxes.isa.run(Going::<T, OfStream<x86::Avx2<false, false>>>::new(self, boxes, step))
            }
            #[cfg(target_arch = "aarch64")]
            Isa::Neon => boxes
                .isa
                .run(Going::<T, OfStream<neon::Neon<false, false>>>::new(self, boxes, step)),
            _ => Going::<T, Portable>::new(self, boxes, step).run(),
        }
    }
}

impl<T> Boxes<T> {
    /// Lines of a place.
    #[inline(always)]
    fn lines(&self) -> usize {
        (RAY_LINES + self.stack.div_ceil(8)) | 1
    }
}

/// # Safety
/// There is such a place.
#[inline(always)]
unsafe fn ray(lines: &mut [Line], per_place: usize, place: u32) -> *mut Ray {
    // SAFETY: the caller's.
    unsafe { lines.as_mut_ptr().add(place as usize * per_place).cast() }
}

#[derive(Clone, Copy)]
enum Step<'a> {
    Start { rays: &'a Rays, reach: &'a [f32], first: usize },
    GoOn,
}

/// Work of [`Walks`] for one instruction set.
struct Going<'a, T, S> {
    walks: &'a mut Walks,
    boxes: &'a Boxes<T>,
    step: Step<'a>,
    lines: usize,
    set: std::marker::PhantomData<S>,
}

impl<'a, T: Copy, S: BoxSteps> Going<'a, T, S> {
    fn new(walks: &'a mut Walks, boxes: &'a Boxes<T>, step: Step<'a>) -> Self {
        Self { walks, boxes, step, lines: boxes.lines(), set: std::marker::PhantomData }
    }

    /// # Safety
    /// The CPU has the instruction set of `S`.
    #[inline(always)]
    unsafe fn start(&mut self, rays: &Rays, reach: &[f32], first: usize) {
        let Walks { prepared, ready, lines, open, at, wild, .. } = &mut *self.walks;
        // SAFETY: any bits are a ray; lines are aligned as rays are, and as long as sixteen.
        let ready = unsafe { &mut *ready.as_mut_ptr().cast::<[Ray; LANES]>() };
        let count = at.len();
        for base in (0..count).step_by(LANES) {
            prepared.fill_widened(rays, reach, first + base, self.boxes.error);
            let (mut has_length, mut tame) = (0u32, 0u32);
            for lane in 0..LANES {
                has_length |= u32::from(prepared.t_max[lane] > 0.0) << lane;
                tame |= prepared.is_tame[lane] << lane;
            }
            has_length &= u32::MAX >> (32 - (count - base).min(LANES));
            tame = if self.boxes.is_tame { has_length & tame } else { 0 };
            wild.extend(lanes_of(has_length & !tame).map(|lane| (base + lane) as u32));
            if tame == 0 {
                continue;
            }
            // SAFETY: the caller's; places have room for rays and their stacks.
            unsafe {
                S::deal(prepared, ready);
                for lane in lanes_of(tame) {
                    let place = (base + lane) as u32;
                    let home = ray(lines, self.lines, place);
                    *home = ready[lane];
                    let stack = home.add(1).cast::<f32>();
                    *stack = f32::NEG_INFINITY;
                    *stack.add(self.boxes.stack).cast() = Child::DONE;
                    (*home).top = stack.add(1);
                    open.push((place, Child::node(0)));
                }
            }
        }
    }

    /// Lets all halted rays look up their next visit.
    ///
    /// # Safety
    /// As [`start`](Self::start).
    #[inline(always)]
    unsafe fn leave(&mut self) {
        let Walks { lines, open, at, halted, news, .. } = &mut *self.walks;
        open.clear();
        for &place in &*halted {
            let news = std::mem::replace(&mut news[place as usize], News::None);
            if news == News::Done {
                at[place as usize] = Child::DONE;
                continue;
            }
            // SAFETY: it is the place of a ray; a step's eight entries fit behind a stack's last.
            unsafe {
                let ray = ray(lines, self.lines, place);
                if news == News::Shorter {
                    let first = ray.add(1).cast::<f32>();
                    let len = (*ray).top.offset_from_unsigned(first);
                    let children = first.add(self.boxes.stack).cast();
                    (*ray).top = first.add(S::cull(first, children, len, (*ray).t));
                }
                let child = self.boxes.pop(ray);
                at[place as usize] = child;
                if !child.is_leaf() {
                    open.push((place, child));
                }
            }
        }
    }

    /// Moves all rays on until each has halted.
    ///
    /// # Safety
    /// As [`start`](Self::start).
    #[inline(always)]
    unsafe fn walk(&mut self) {
        let Walks { lines, open, at, halted, .. } = &mut *self.walks;
        let nodes = self.boxes.nodes.as_ptr();
        let mut len = open.len();
        while len > 0 {
            let (mut begin, mut kept) = (0, 0);
            while begin < len {
                let end = len.min(begin + TURN);
                // SAFETY: places are those of rays that have set out, nodes exist, and what is
                // written is at most as much as was read. A stack has room for a step's entries.
                unsafe {
                    for i in begin..end {
                        let (place, node) = *open.get_unchecked(i);
                        let ray = ray(lines, self.lines, place);
                        let children = (*ray).top.add(self.boxes.stack).cast();
                        let node = &*nodes.add(node.index());
                        let count = S::children(node, &*ray, (*ray).top, children);
                        (*ray).top = (*ray).top.add(count);
                    }
                    for i in begin..end {
                        let (place, _) = *open.get_unchecked(i);
                        let child = self.boxes.pop(ray(lines, self.lines, place));
                        *at.get_unchecked_mut(place as usize) = child;
                        *open.get_unchecked_mut(kept) = (place, child);
                        kept += usize::from(!child.is_leaf());
                    }
                }
                begin = end;
            }
            len = kept;
        }
        halted.clear();
        halted.extend((0..).zip(&*at).filter(|(_, child)| **child != Child::DONE).map(|(i, _)| i));
    }
}

impl<T: Copy, S: BoxSteps> Lanewise for Going<'_, T, S> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        // SAFETY: the work is run on the instruction set of `S`.
        unsafe {
            match self.step {
                Step::Start { rays, reach, first } => self.start(rays, reach, first),
                Step::GoOn => self.leave(),
            }
            self.walk();
        }
    }
}

impl<T> Boxes<T> {
    /// Pops the last entry of a ray's stack, and prefetches its node, or what is in its box.
    ///
    /// # Safety
    /// The ray's stack holds its first entry at least.
    #[inline(always)]
    unsafe fn pop(&self, ray: *mut Ray) -> Child {
        // SAFETY: the caller's.
        let child = unsafe {
            (*ray).top = (*ray).top.sub(1);
            *(*ray).top.add(self.stack).cast::<Child>()
        };
        let node = self.nodes.as_ptr().wrapping_add(child.0 as usize).cast::<u8>();
        let content = self.contents.as_ptr().wrapping_add(child.index()).cast::<u8>();
        let (at, step) = if child.is_leaf() { (content, 0) } else { (node, 64) };
        for line in 0..4 {
            prefetch::<false>(at.wrapping_add(line * step));
        }
        child
    }
}
