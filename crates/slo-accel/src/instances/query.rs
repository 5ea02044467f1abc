//! Rays through instances, in rounds.
//!
//! In each round all rays go on to the next box that they enter. Those that stand before the same
//! child are taken to its space, each by the map of its own placement, and the child answers them
//! as one batch. So children keep their kernels, of whatever kind they are, and a million placements
//! of one child give batches as long as a single one does.

use super::affine::Inverse;
use super::{Child, Content, Instances, MAX_DEPTH, NO_INSTANCE, nearest};
use crate::isa::Lanewise;
use crate::rays::{Coherence, Hits, LANES, NO_HIT, Rays};
use crate::simd::lanes_of;
use crate::structure::Scratch;
use crate::structure::bvh::halting::{Packets, TOGETHER, Walks};

/// Rays that are the first to go in packets: they show whether packets are worthwhile.
const PROBE: usize = 64;

/// Rays of one round before a child from which its kernels may choose: fewer have nothing in
/// common.
const ENOUGH: usize = 16;

/// Working memory of queries, one for each thread. It holds nothing between calls, so any instances
/// may use it next.
#[derive(Debug, Default)]
pub struct InstancesScratch {
    structures: Scratch,
    /// For each level of instances.
    levels: Vec<Level>,
}

#[derive(Debug, Default)]
struct Level {
    walks: Walks,
    packets: Packets,
    /// Who asks which child in this round: its index, then the place of the ray, or the number of the
    /// packet.
    turns: Vec<u64>,
    local: Local,
    answers: Answers,
}

/// Rays in the space of a child.
#[derive(Debug, Default)]
struct Local {
    rays: Rays,
    time: Vec<f32>,
}

/// What a child answers.
#[derive(Debug, Default)]
struct Answers {
    hits: Hits,
    /// Instances within the child, if it has some.
    instance: Vec<u32>,
    blocked: Vec<bool>,
}

impl Answers {
    /// The instance within the child of an answer.
    #[inline]
    fn instance(&self, child: &Child, j: usize) -> u32 {
        match child {
            Child::Structure(_) | Child::Bending(_) => 0,
            Child::Instances(_) => self.instance[j],
        }
    }
}

/// A batch of rays, their times, and the distances up to which they are followed.
#[derive(Clone, Copy)]
struct Batch<'a> {
    rays: &'a Rays,
    time: &'a [f32],
    reach: &'a [f32],
}

impl Instances {
    /// Writes the first hit of each ray with `0 < t < t_max` to `hits[0..rays.len()]`, and its
    /// instance to `instance`: [`NO_INSTANCE`] where nothing is hit. What both held before is
    /// dropped.
    ///
    /// `time` holds a time from 0 to 1 for each ray: that of the pose which it meets. `coherence`
    /// and what comes back are as for [`Structure::intersect`](crate::Structure::intersect).
    ///
    /// # Panics
    /// If `time` is shorter than the batch.
    pub fn intersect(
        &self,
        rays: &Rays,
        time: &[f32],
        coherence: Coherence,
        hits: &mut Hits,
        instance: &mut Vec<u32>,
        scratch: &mut InstancesScratch,
    ) -> Coherence {
        hits.reset(rays.len());
        self.intersect_within(rays, time, &rays.t_max, coherence, hits, instance, scratch)
    }

    /// As [`intersect`](Self::intersect), up to `reach` instead of `t_max`. Rays that hit nothing
    /// there keep what `hits` holds: it may be the hits of something else, which end the rays.
    ///
    /// # Panics
    /// If `time` is shorter than the batch, `reach` or `hits` than the batch rounded up to a
    /// multiple of [`LANES`].
    #[allow(clippy::too_many_arguments)]
    pub fn intersect_within(
        &self,
        rays: &Rays,
        time: &[f32],
        reach: &[f32],
        coherence: Coherence,
        hits: &mut Hits,
        instance: &mut Vec<u32>,
        scratch: &mut InstancesScratch,
    ) -> Coherence {
        let InstancesScratch { structures, levels } = scratch;
        levels.resize_with(MAX_DEPTH, Level::default);
        let batch = Batch { rays, time, reach };
        self.closest(batch, coherence, (hits, instance), levels, structures)
    }

    fn closest(
        &self,
        batch: Batch,
        coherence: Coherence,
        (hits, instance): (&mut Hits, &mut Vec<u32>),
        levels: &mut [Level],
        structures: &mut Scratch,
    ) -> Coherence {
        instance.clear();
        instance.resize(batch.rays.len(), NO_INSTANCE);
        let mut question = Closest { reach: batch.reach, hits, instance };
        self.ask(batch, coherence, &mut question, levels, structures)
    }

    /// Writes to `blocked[0..rays.len()]` whether anything lies on each ray with `0 < t < t_max`;
    /// what `blocked` held before is dropped. Otherwise as [`intersect`](Self::intersect).
    ///
    /// # Panics
    /// If `time` is shorter than the batch.
    pub fn occluded(
        &self,
        rays: &Rays,
        time: &[f32],
        coherence: Coherence,
        blocked: &mut Vec<bool>,
        scratch: &mut InstancesScratch,
    ) -> Coherence {
        blocked.clear();
        blocked.resize(rays.len().next_multiple_of(LANES), false);
        self.occluded_within(rays, time, &rays.t_max, coherence, blocked, scratch)
    }

    /// As [`occluded`](Self::occluded), up to `reach` instead of `t_max`. Rays that are not blocked
    /// there keep what `blocked` holds. Rays whose reach is negative are not followed.
    ///
    /// # Panics
    /// If `time` is shorter than the batch, `reach` or `blocked` than the batch rounded up to a
    /// multiple of [`LANES`].
    pub fn occluded_within(
        &self,
        rays: &Rays,
        time: &[f32],
        reach: &[f32],
        coherence: Coherence,
        blocked: &mut [bool],
        scratch: &mut InstancesScratch,
    ) -> Coherence {
        let InstancesScratch { structures, levels } = scratch;
        levels.resize_with(MAX_DEPTH, Level::default);
        let batch = Batch { rays, time, reach };
        self.ask(batch, coherence, &mut Any { reach, blocked }, levels, structures)
    }

    fn ask<Q: Question>(
        &self,
        batch: Batch,
        coherence: Coherence,
        question: &mut Q,
        levels: &mut [Level],
        structures: &mut Scratch,
    ) -> Coherence {
        let Batch { rays, reach, .. } = batch;
        let (level, deeper) = levels.split_first_mut().expect("a scratch for each level");
        let mut habit = Habit { expected: coherence, alike: 0, unlike: 0 };
        let mut in_packets = coherence == Coherence::Coherent && Packets::exist(self.boxes.isa());
        let mut first = 0;
        while first < rays.len() {
            let most = if in_packets && first == 0 { PROBE } else { TOGETHER };
            let count = (rays.len() - first).min(most);
            if in_packets {
                level.packets.start(&self.boxes, (rays, reach), first, count);
                while !level.packets.halted().is_empty() {
                    self.packets(batch, question, &mut habit, level, deeper, structures);
                    level.packets.go_on(&self.boxes);
                }
                in_packets = level.packets.were_worthwhile(&self.boxes);
                for k in 0..level.packets.wild().len() {
                    let i = first + level.packets.wild()[k] as usize;
                    self.visit(batch, i, question, level, deeper, structures);
                }
            } else {
                level.walks.start(&self.boxes, (rays, reach), first, count);
                while !level.walks.halted().is_empty() {
                    self.round(batch, first, question, &mut habit, level, deeper, structures);
                    level.walks.go_on(&self.boxes);
                }
                for k in 0..level.walks.wild().len() {
                    let i = first + level.walks.wild()[k] as usize;
                    self.visit(batch, i, question, level, deeper, structures);
                }
            }
            first += count;
        }
        habit.found(coherence)
    }

    /// Takes one ray by itself through all boxes.
    #[cold]
    fn visit<Q: Question>(
        &self,
        batch: Batch,
        i: usize,
        question: &mut Q,
        Level { local, answers, .. }: &mut Level,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) {
        let Batch { rays, reach, .. } = batch;
        self.boxes.visit((rays.origin(i), rays.direction(i)), reach[i], |leaf| {
            let content = self.boxes.content(leaf);
            let child = &self.children[content.child as usize];
            local.clear();
            self.take_over(batch, i, content, question, local);
            question.ask(child, local, Coherence::Incoherent, answers, deeper, structures);
            question.take(answers, 0, i, (child, content.number));
            question.end(i, 0)
        });
    }

    /// Asks children about all packets that stand before one.
    fn packets<Q: Question>(
        &self,
        batch: Batch,
        question: &mut Q,
        habit: &mut Habit,
        level: &mut Level,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) {
        let Level { packets, turns, local, answers, .. } = level;
        turns.clear();
        turns.extend(packets.halted().iter().map(|&packet| {
            let content = self.boxes.content(packets.leaf(packet));
            u64::from(content.child) << 32 | u64::from(packet)
        }));
        if self.children.len() > 1 {
            turns.sort_unstable();
        }
        for turns in turns.chunk_by(|a, b| a >> 32 == b >> 32) {
            let child = &self.children[(turns[0] >> 32) as usize];
            let of = (&*packets, turns);
            self.boxes.isa().run(TakePackets { instances: self, batch, of, question, local });
            let count = local.rays.len();
            let expected = habit.expected(count);
            let found = question.ask(child, local, expected, answers, deeper, structures);
            habit.learn(count, expected, found);
            let mut j = 0;
            for &turn in turns {
                let packet = turn as u32;
                let number = self.boxes.content(packets.leaf(packet)).number;
                let (first, set) = packets.rays(packet);
                for lane in lanes_of(set) {
                    match question.take(answers, j, first + lane, (child, number)) {
                        News::None => {}
                        News::Shorter(t) => packets.shorten(packet, lane, t),
                        News::Done => packets.shorten(packet, lane, -1.0),
                    }
                    j += 1;
                }
            }
        }
    }

    /// Asks children about all rays that stand before one.
    #[allow(clippy::too_many_arguments)]
    fn round<Q: Question>(
        &self,
        batch: Batch,
        first: usize,
        question: &mut Q,
        habit: &mut Habit,
        level: &mut Level,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) {
        let Level { walks, turns, local, answers, .. } = level;
        turns.clear();
        if self.children.len() == 1 {
            turns.extend(walks.halted().iter().map(|&place| u64::from(place)));
        } else {
            turns.extend(walks.halted().iter().map(|&place| {
                let content = self.boxes.content(walks.leaf(place));
                u64::from(content.child) << 32 | u64::from(place)
            }));
            turns.sort_unstable();
        }
        for turns in turns.chunk_by(|a, b| a >> 32 == b >> 32) {
            let child = &self.children[(turns[0] >> 32) as usize];
            local.clear();
            for &turn in turns {
                let content = self.boxes.content(walks.leaf(turn as u32));
                self.take_over(batch, first + turn as u32 as usize, content, question, local);
            }
            let expected = habit.expected(turns.len());
            let found = question.ask(child, local, expected, answers, deeper, structures);
            habit.learn(turns.len(), expected, found);
            for (j, &turn) in turns.iter().enumerate() {
                let (place, i) = (turn as u32, first + turn as u32 as usize);
                let number = self.boxes.content(walks.leaf(place)).number;
                match question.take(answers, j, i, (child, number)) {
                    News::None => {}
                    News::Shorter(t) => walks.shorten(&self.boxes, place, t),
                    News::Done => walks.end(place),
                }
            }
        }
    }

    /// Adds a ray of the batch to those in the space of a child.
    #[inline(always)]
    fn take_over<Q: Question>(
        &self,
        Batch { rays, time, .. }: Batch,
        i: usize,
        content: &Content,
        question: &Q,
        local: &mut Local,
    ) {
        let time = time[i];
        let inverse: &Inverse = if content.poses == 1 {
            &content.inverse
        } else {
            &self.inverses[content.first_inverse as usize + nearest(time, content.poses as usize)]
        };
        let (origin, direction) = inverse.ray(rays.origin(i), rays.direction(i));
        local.rays.push(origin, direction, question.end(i, content.number));
        local.time.push(time);
    }
}

/// Takes the rays of packets to the space of the child before which they stand.
struct TakePackets<'a, Q> {
    instances: &'a Instances,
    batch: Batch<'a>,
    /// All packets, and those that go there.
    of: (&'a Packets, &'a [u64]),
    question: &'a Q,
    local: &'a mut Local,
}

impl<Q: Question> Lanewise for TakePackets<'_, Q> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { instances, batch, of: (packets, turns), question, local } = self;
        local.clear();
        let mut sixteen = [[0.0; LANES]; 6];
        for &turn in turns {
            let content = instances.boxes.content(packets.leaf(turn as u32));
            let (first, set) = packets.rays(turn as u32);
            if content.poses > 1 {
                for neighbour in lanes_of(set) {
                    instances.take_over(batch, first + neighbour, content, question, local);
                }
                continue;
            }
            content.inverse.neighbours(batch.rays, first, &mut sixteen);
            let end = local.rays.len();
            local.rays.set_len(end + set.count_ones() as usize);
            let Rays { origin, direction, t_max, .. } = &mut local.rays;
            for (to, neighbour) in (end..).zip(lanes_of(set)) {
                for axis in 0..3 {
                    origin[axis][to] = sixteen[axis][neighbour];
                    direction[axis][to] = sixteen[3 + axis][neighbour];
                }
                t_max[to] = question.end(first + neighbour, content.number);
                local.time.push(batch.time[first + neighbour]);
            }
        }
    }
}

impl Local {
    fn clear(&mut self) {
        self.rays.set_len(0);
        self.time.clear();
    }
}

/// Whether rays that are expected to be alike turn out to be so before children.
struct Habit {
    expected: Coherence,
    /// Rays of calls that found them alike, and of calls that did not.
    alike: usize,
    unlike: usize,
}

impl Habit {
    fn expected(&self, count: usize) -> Coherence {
        if count >= ENOUGH && self.unlike <= self.alike {
            self.expected
        } else {
            Coherence::Incoherent
        }
    }

    fn learn(&mut self, count: usize, expected: Coherence, found: Coherence) {
        if expected == Coherence::Coherent {
            let rays =
                if found == Coherence::Coherent { &mut self.alike } else { &mut self.unlike };
            *rays += count;
        }
    }

    fn found(&self, coherence: Coherence) -> Coherence {
        if self.unlike > self.alike { Coherence::Incoherent } else { coherence }
    }
}

/// What an answer means for a ray.
enum News {
    None,
    Shorter(f32),
    Done,
}

/// A question about the rays of a batch.
trait Question {
    /// Where ray `i` ends for a placement whose first instance has that number; negative if the ray
    /// is done.
    fn end(&self, i: usize, number: u32) -> f32;

    /// Asks a child about rays in its space.
    fn ask(
        &mut self,
        child: &Child,
        local: &Local,
        coherence: Coherence,
        answers: &mut Answers,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) -> Coherence;

    /// Takes the child's answer about its ray `j`, which is ray `i` of the batch, at a placement
    /// whose first instance has that number.
    fn take(&mut self, answers: &Answers, j: usize, i: usize, at: (&Child, u32)) -> News;
}

/// The first hit of each ray.
struct Closest<'a> {
    reach: &'a [f32],
    hits: &'a mut Hits,
    instance: &'a mut [u32],
}

impl Question for Closest<'_> {
    #[inline(always)]
    fn end(&self, i: usize, number: u32) -> f32 {
        let (best, t) = (self.instance[i], self.hits.t[i]);
        // A hit as far away counts if its number is lower; each placement is met once.
        let end = if number < best { t.next_up() } else { t };
        if best == NO_INSTANCE { self.reach[i] } else { end }
    }

    fn ask(
        &mut self,
        child: &Child,
        local: &Local,
        coherence: Coherence,
        answers: &mut Answers,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) -> Coherence {
        let Answers { hits, instance, .. } = answers;
        match child {
            Child::Structure(structure) => {
                structure.intersect(&local.rays, coherence, hits, structures)
            }
            Child::Bending(bending) => {
                bending.intersect(&local.rays, &local.time, coherence, hits, structures)
            }
            Child::Instances(instances) => {
                hits.reset(local.rays.len());
                let (rays, time) = (&local.rays, &local.time[..]);
                let batch = Batch { rays, time, reach: &rays.t_max };
                instances.closest(batch, coherence, (hits, instance), deeper, structures)
            }
        }
    }

    #[inline(always)]
    fn take(
        &mut self,
        answers: &Answers,
        j: usize,
        i: usize,
        (child, number): (&Child, u32),
    ) -> News {
        let Hits { t, u, v, primitive } = &answers.hits;
        if primitive[j] == NO_HIT {
            return News::None;
        }
        self.hits.t[i] = t[j];
        self.hits.u[i] = u[j];
        self.hits.v[i] = v[j];
        self.hits.primitive[i] = primitive[j];
        self.instance[i] = number + answers.instance(child, j);
        News::Shorter(t[j])
    }
}

/// Whether each ray is blocked.
struct Any<'a> {
    reach: &'a [f32],
    blocked: &'a mut [bool],
}

impl Question for Any<'_> {
    #[inline(always)]
    fn end(&self, i: usize, _: u32) -> f32 {
        if self.blocked[i] { -1.0 } else { self.reach[i] }
    }

    fn ask(
        &mut self,
        child: &Child,
        local: &Local,
        coherence: Coherence,
        answers: &mut Answers,
        deeper: &mut [Level],
        structures: &mut Scratch,
    ) -> Coherence {
        let blocked = &mut answers.blocked;
        match child {
            Child::Structure(structure) => {
                structure.occluded(&local.rays, coherence, blocked, structures)
            }
            Child::Bending(bending) => {
                bending.occluded(&local.rays, &local.time, coherence, blocked, structures)
            }
            Child::Instances(instances) => {
                let (rays, time) = (&local.rays, &local.time[..]);
                blocked.clear();
                blocked.resize(rays.len().next_multiple_of(LANES), false);
                let batch = Batch { rays, time, reach: &rays.t_max };
                let mut question = Any { reach: &rays.t_max, blocked };
                instances.ask(batch, coherence, &mut question, deeper, structures)
            }
        }
    }

    #[inline(always)]
    fn take(&mut self, answers: &Answers, j: usize, i: usize, _: (&Child, u32)) -> News {
        self.blocked[i] |= answers.blocked[j];
        if answers.blocked[j] { News::Done } else { News::None }
    }
}
