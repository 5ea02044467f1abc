//! The machine that integrators run on: the queues of one thread, the order in which they are worked
//! off, and the sums. It knows no light.

use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::batch::{Batch, Labels, Sent};
use super::chosen::Chosen;
use super::queue::{Habit, RayQueue};
use super::sums::Sums;
use super::work::{Job, SampleSum, Statistics};
use crate::sampling::PixelSeed;

/// Most connections that wait while the hits of one batch still send others.
const MOST_CONNECTIONS_WAITING: usize = 16 * BATCH;

/// Stages that turn rays into light and further rays. Every function is `None` if the work is to be
/// given up.
pub(super) trait Integrator {
    /// Makes the first rays of the next paths and traces them; false when all are made.
    fn start_paths(&mut self, machine: &mut Machine, job: &Job<'_>) -> Option<bool>;

    /// Takes the next batch of rays with `depth` bounces behind them, and traces it.
    fn extend_paths(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()>;

    /// Takes the next batch of a kind of connections, and traces it.
    fn connect(&mut self, machine: &mut Machine, job: &Job<'_>, kind: Connection);
}

/// Rays that carry the light that they bring if nothing blocks them, by where they come from: those
/// of the first hits are coherent, the others are not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Connection {
    /// Hits of camera rays.
    FromPrimary,
    /// Hits of bounces.
    FromDeeper,
}

impl Connection {
    const ALL: [Self; 2] = [Self::FromPrimary, Self::FromDeeper];

    /// The kind of connections from hits with `depth` bounces behind them.
    pub(super) fn at(depth: u32) -> Self {
        if depth == 0 { Self::FromPrimary } else { Self::FromDeeper }
    }
}

/// A queue to be worked off.
enum Next {
    Paths(u32),
    Connections(Connection),
}

/// Queues and sums of one thread.
#[derive(Debug, Default)]
pub(super) struct Machine {
    /// Rays by the number of bounces behind them; the first queue stays empty, since camera rays are
    /// traced as they are made.
    paths: Vec<RayQueue>,
    /// By [`Connection`].
    connections: [RayQueue; 2],
    /// Seed of the pixel of each slot.
    seeds: Vec<PixelSeed>,
    sums: Box<Sums>,
    counts: Statistics,
}

impl Machine {
    /// Begins some work with `copies` sums for each entry: slot `i` of the first copies is entry
    /// `i`.
    pub(super) fn begin(&mut self, job: &Job<'_>, copies: usize) {
        let sampler = &job.frame.sampler;
        self.counts = Statistics::default();
        self.seeds.clear();
        for _ in 0..copies {
            self.seeds.extend(job.work.iter().map(|w| sampler.pixel(w.x, w.y)));
        }
        self.sums.reset(self.seeds.len());
        self.queue_at(0);
    }

    /// Runs an integrator until no ray is left. If the work is given up, nothing waits afterwards.
    pub(super) fn run(&mut self, integrator: &mut impl Integrator, job: &Job<'_>) -> Option<()> {
        let finished = self.run_all(integrator, job);
        if finished.is_none() {
            self.paths.clear();
            self.connections = Default::default();
        }
        finished
    }

    /// The sums of all copies, added up for each of `len` entries.
    pub(super) fn finish(&mut self, len: usize) -> (&[SampleSum], Statistics) {
        self.sums.fold(len);
        (self.sums.get(), self.counts)
    }

    fn run_all(&mut self, integrator: &mut impl Integrator, job: &Job<'_>) -> Option<()> {
        while integrator.start_paths(self, job)? {
            self.work_off(integrator, job, BATCH)?;
        }
        self.work_off(integrator, job, 1)
    }

    /// Traces batches until no queue holds `least` rays or more.
    fn work_off(
        &mut self,
        integrator: &mut impl Integrator,
        job: &Job<'_>,
        least: usize,
    ) -> Option<()> {
        loop {
            job.goes_on()?;
            match self.next(least) {
                Some(Next::Paths(depth)) => integrator.extend_paths(self, job, depth)?,
                Some(Next::Connections(kind)) => integrator.connect(self, job, kind),
                None => return Some(()),
            }
        }
    }

    /// The next queue to take a batch from.
    ///
    /// While more rays are to come the deepest full queue goes first, which bounds what waits. At the
    /// end, when all hold less than a batch, the shallowest goes first, since it fills the others.
    fn next(&self, least: usize) -> Option<Next> {
        let connections = |least| {
            let found = Connection::ALL.into_iter().find(|&kind| self.waiting(kind) >= least);
            found.map(Next::Connections)
        };
        let paths = |depth: usize| Next::Paths(depth as u32);
        let deepest = || self.paths.iter().rposition(|queue| queue.len() >= BATCH).map(paths);
        let shallowest = || self.paths.iter().position(|queue| queue.len() >= least).map(paths);
        connections(BATCH).or_else(deepest).or_else(shallowest).or_else(|| connections(least))
    }

    fn waiting(&self, kind: Connection) -> usize {
        self.connections[kind as usize].len()
    }

    /// Traces waiting connections of a kind if there are many.
    ///
    /// The hits of one batch send as many as there are lights and samples of each, which only the
    /// scene bounds.
    pub(super) fn relieve(
        &mut self,
        integrator: &mut impl Integrator,
        job: &Job<'_>,
        kind: Connection,
    ) {
        if self.waiting(kind) >= MOST_CONNECTIONS_WAITING {
            while self.waiting(kind) >= BATCH {
                integrator.connect(self, job, kind);
            }
        }
    }

    /// Seed of the pixel of each slot.
    pub(super) fn seeds(&self) -> &[PixelSeed] {
        &self.seeds
    }

    /// How alike the rays of `depth` usually are.
    pub(super) fn habit(&mut self, depth: u32) -> &mut Habit {
        &mut self.queue_at(depth).habit
    }

    /// How alike connections of a kind usually are.
    pub(super) fn connection_habit(&mut self, kind: Connection) -> &mut Habit {
        &mut self.connections[kind as usize].habit
    }

    /// Counts the camera rays of a batch.
    pub(super) fn count_camera_rays(&mut self, batch: &Batch) {
        self.counts.camera_rays += batch.len() as u64;
    }

    /// Queues chosen rays with `depth` bounces behind them.
    pub(super) fn extend(&mut self, depth: u32, sent: &Sent, labels: &Labels, chosen: &Chosen) {
        self.queue_at(depth).append_named(sent, labels, chosen);
    }

    /// Queues chosen connections.
    pub(super) fn connect(
        &mut self,
        kind: Connection,
        sent: &Sent,
        labels: &Labels,
        chosen: &Chosen,
    ) {
        self.connections[kind as usize].append(sent, labels, chosen);
    }

    /// Takes the next batch of rays with `depth` bounces behind them.
    pub(super) fn take_paths(&mut self, depth: u32, batch: &mut Batch) {
        self.queue_at(depth).take_batch(batch);
        self.counts.bounce_rays += batch.len() as u64;
    }

    /// Takes the next batch of connections of a kind.
    pub(super) fn take_connections(&mut self, kind: Connection, batch: &mut Batch) {
        self.connections[kind as usize].take_batch(batch);
        self.counts.shadow_rays += batch.len() as u64;
    }

    /// Adds the first `len` radiances, each to its slot.
    pub(super) fn add(&mut self, isa: Isa, radiance: &Vec3s, slot: &Column<u32>, len: usize) {
        self.counts.refused_contributions += self.sums.add(isa, radiance, slot, len);
    }

    fn queue_at(&mut self, depth: u32) -> &mut RayQueue {
        let depth = depth as usize;
        if self.paths.len() <= depth {
            self.paths.resize_with(depth + 1, RayQueue::default);
        }
        &mut self.paths[depth]
    }
    /// Rays that fit without a new allocation, of each queue of paths and of connections.
    #[cfg(test)]
    pub(super) fn rooms(&self) -> (Vec<usize>, Vec<usize>) {
        let rooms = |queues: &[RayQueue]| queues.iter().map(RayQueue::room).collect();
        (rooms(&self.paths), rooms(&self.connections))
    }
}
