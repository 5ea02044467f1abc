//! The machine that integrators run on: the queues of one thread, the order in which they are
//! processed, and the sums. It is independent of light transport.

use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::account::{Account, Source};
use super::batch::{Batch, Labels, Past, Sent};
use super::chosen::Chosen;
use super::counting::Tally;
use super::queue::RayQueue;
use super::stages::hits::Hits;
use super::stages::visibility::Visibility;
use super::sums::Sums;
use super::work::{Job, SampleSum, Statistics, Work};
use crate::frame::{FrameScene, WorldScratch};
use crate::sampling::{PixelSeed, Sampler};

/// Most connections that wait while the hits of one batch send more.
const MOST_CONNECTIONS_WAITING: usize = 16 * BATCH;

/// Stages that turn rays into light and further rays.
pub(super) trait Integrator {
    /// Fills the batch with the first rays of the next paths; `seeds` are those of the slots. Returns the
    /// number of bounces before them, or `None` if all were created.
    fn start(&mut self, job: &Job<'_>, seeds: &[PixelSeed]) -> Option<u32>;

    /// The batch that is traced next.
    fn batch(&mut self) -> &mut Batch;

    /// Traces the batch, whose rays come after `depth` bounces: adds the light that they find, and queues
    /// the rays that their hits send out. Returns `None` if the work is given up.
    fn trace(&mut self, machine: &mut Machine, job: &Job<'_>, depth: u32) -> Option<()>;
}

/// Kinds of connections by their origin. A connection carries the light that it adds if nothing
/// blocks it. Connections from first hits are coherent, the others are not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Connection {
    /// Hits of camera rays.
    FromPrimary,
    /// Hits of bounces.
    FromDeeper,
}

impl Connection {
    const ALL: [Self; 2] = [Self::FromPrimary, Self::FromDeeper];

    /// Returns the kind of connections from hits after `depth` bounces.
    pub(super) fn at(depth: u32) -> Self {
        if depth == 0 { Self::FromPrimary } else { Self::FromDeeper }
    }
}

/// The queue to be processed next.
enum Next {
    Paths(u32),
    Connections(Connection),
}

/// Queues and sums of one thread.
#[derive(Debug, Default)]
pub(super) struct Machine {
    /// Queues of rays, by the number of bounces before them. The first queue stays empty, since
    /// camera rays are traced as they are created.
    paths: Vec<RayQueue>,
    /// Queues by [`Connection`].
    connections: [RayQueue; 2],
    /// Seed of the pixel of each slot.
    seeds: Vec<PixelSeed>,
    sums: Box<Sums>,
    counts: Statistics,
    visibility: Box<Visibility>,
    /// The account that is kept, if one was asked for.
    account: Option<Box<Account>>,
    /// Working memory of ray queries.
    scratch: WorldScratch,
    tally: Tally,
}

impl Machine {
    /// Begins new work with `copies` sums for each entry. Slot `i` among the first copies belongs
    /// to entry `i`.
    pub(super) fn begin(&mut self, sampler: &Sampler, work: &[Work], copies: usize) {
        self.counts = Statistics::default();
        self.tally.stop();
        self.seeds.clear();
        for _ in 0..copies {
            self.seeds.extend(work.iter().map(|w| sampler.pixel(w.x, w.y)));
        }
        self.sums.reset(self.seeds.len());
        self.queue_at(0);
    }

    /// Counts the rays of the work that has begun, if the frame asks for it.
    pub(super) fn count(&mut self, frame: &FrameScene, work: &[Work]) {
        self.tally.begin(frame, work);
    }

    /// Keeps an account of the work that was begun. Entries of work have one sample each.
    pub(super) fn keep_account(&mut self, frame: &FrameScene) {
        self.account.get_or_insert_default().begin(self.seeds.len(), frame.first_shaded);
    }

    /// Returns the account that was kept.
    pub(super) fn take_account(&mut self) -> Option<Box<Account>> {
        self.account.take()
    }

    /// Begins work without sums: rays of slot `i` start at light `i` of `lights`, and all have the same
    /// seed.
    pub(super) fn begin_light_paths(&mut self, seed: PixelSeed, lights: usize) {
        self.counts = Statistics::default();
        self.tally.stop();
        self.seeds.clear();
        self.seeds.resize(lights, seed);
        self.sums.reset(0);
        self.queue_at(0);
    }

    /// Begins work of rays with a slot each, of pixels with these seeds.
    pub(super) fn begin_slots(&mut self, seeds: impl Iterator<Item = PixelSeed>) {
        self.counts = Statistics::default();
        self.tally.stop();
        self.seeds.clear();
        self.seeds.extend(seeds);
        self.sums.reset(self.seeds.len());
        self.queue_at(0);
    }

    /// Runs an integrator until no ray is left. If the work is given up, all queues are empty
    /// afterwards, and the result is `None`.
    pub(super) fn run(&mut self, integrator: &mut impl Integrator, job: &Job<'_>) -> Option<()> {
        let finished = self.run_all(integrator, job);
        if finished.is_none() {
            self.paths.clear();
            self.connections = Default::default();
        }
        finished
    }

    /// Adds up the sums of each of `len` entries; see [`Sums::fold`]. Returns them with the counts.
    pub(super) fn finish(
        &mut self,
        len: usize,
        groups: usize,
    ) -> (&[SampleSum], &[SampleSum], Statistics) {
        let (sums, of_groups) = self.sums.fold(len, groups);
        (sums, of_groups, self.counts)
    }

    fn run_all(&mut self, integrator: &mut impl Integrator, job: &Job<'_>) -> Option<()> {
        while let Some(depth) = integrator.start(job, &self.seeds) {
            self.counts.camera_rays += integrator.batch().len() as u64;
            integrator.trace(self, job, depth)?;
            self.work_off(integrator, job, BATCH)?;
        }
        self.work_off(integrator, job, 1)
    }

    /// Traces batches until every queue holds fewer than `least` rays.
    fn work_off(
        &mut self,
        integrator: &mut impl Integrator,
        job: &Job<'_>,
        least: usize,
    ) -> Option<()> {
        loop {
            job.goes_on()?;
            match self.next(least) {
                Some(Next::Paths(depth)) => {
                    self.take_paths(depth, integrator.batch());
                    integrator.trace(self, job, depth)?;
                }
                Some(Next::Connections(kind)) => self.trace_connections(job, kind),
                None => return Some(()),
            }
        }
    }

    /// Returns the queue to take the next batch from.
    ///
    /// While more rays will follow, the deepest full queue is processed first, which bounds the
    /// number of waiting rays. At the end, when all queues hold less than a batch, the shallowest
    /// is processed first, since it fills the others.
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
    /// The hits of one batch send as many as the product of lights and samples per light, which
    /// only the scene bounds. Returns `None` if the work is given up.
    pub(super) fn relieve(&mut self, job: &Job<'_>, kind: Connection) -> Option<()> {
        if self.waiting(kind) >= MOST_CONNECTIONS_WAITING {
            while self.waiting(kind) >= BATCH {
                job.goes_on()?;
                self.trace_connections(job, kind);
            }
        }
        job.goes_on()
    }

    /// Takes the next batch of connections of a kind, and adds the light of those that nothing blocks.
    fn trace_connections(&mut self, job: &Job<'_>, kind: Connection) {
        let Self { connections, visibility, scratch, counts, sums, seeds, account, tally, .. } =
            self;
        let (frame, queue) = (job.frame, &mut connections[kind as usize]);
        queue.take_batch(&mut visibility.batch);
        counts.shadow_rays += visibility.batch.len() as u64;
        visibility.trace(frame, &mut queue.habit, scratch);
        if tally.is_on() {
            tally.connections(job, &visibility.batch, scratch, &mut counts.rays);
        }
        if let Some((sent, labels, chosen)) = visibility.beyond() {
            match account {
                None => queue.append(sent, labels, chosen),
                Some(account) => {
                    let slots = account.list_passing(sent, labels, chosen);
                    queue.append(sent, &named(seeds, labels, slots, chosen), chosen);
                }
            }
        }
        let Batch { weight, labels, .. } = &visibility.batch;
        if let Some(account) = account {
            account.note_light(Source::Asked, weight, &labels.slot, visibility.batch.len());
        }
        let refused = sums.add(frame.isa, weight, &labels.slot, visibility.batch.len());
        counts.refused_contributions += refused;
    }

    /// Finds the first hits of a batch of rays after `depth` bounces.
    pub(super) fn find_hits(&mut self, job: &Job<'_>, batch: &Batch, hits: &mut Hits, depth: u32) {
        let frame = job.frame;
        self.queue_at(depth);
        hits.trace(frame, batch, &mut self.paths[depth as usize].habit, &mut self.scratch);
        if self.tally.is_on() {
            let Self { tally, scratch, counts, .. } = self;
            tally.paths(job, batch, depth, scratch, &mut counts.rays);
        }
        if let Some(account) = &mut self.account {
            account.note_hits(frame, batch, hits);
        }
    }

    /// Seed of the pixel of each slot.
    pub(super) fn seeds(&self) -> &[PixelSeed] {
        &self.seeds
    }

    /// Queues chosen rays after `depth` bounces.
    pub(super) fn extend(&mut self, depth: u32, sent: &Sent, labels: &Labels, chosen: &Chosen) {
        if let Some(account) = &mut self.account {
            let slots = account.list_lobes(depth, sent, labels, None, chosen);
            let labels = named(&mut self.seeds, labels, slots, chosen);
            return self.queue_at(depth).append_named(sent, &labels, chosen);
        }
        self.queue_at(depth).append_named(sent, labels, chosen);
    }

    /// Queues chosen rays of paths after `depth` bounces.
    pub(super) fn extend_path(
        &mut self,
        depth: u32,
        sent: &Sent,
        labels: &Labels,
        past: &Past,
        chosen: &Chosen,
    ) {
        if let Some(account) = &mut self.account {
            let slots = account.list_lobes(depth, sent, labels, Some(past), chosen);
            let labels = named(&mut self.seeds, labels, slots, chosen);
            return self.queue_at(depth).append_path(sent, &labels, past, chosen);
        }
        self.queue_at(depth).append_path(sent, labels, past, chosen);
    }

    /// Queues chosen connections to lights; `light` tells the number of the light of each.
    pub(super) fn connect(
        &mut self,
        kind: Connection,
        sent: &Sent,
        labels: &Labels,
        chosen: &Chosen,
        light: impl Fn(usize) -> u32,
    ) {
        let queue = &mut self.connections[kind as usize];
        if let Some(account) = &mut self.account {
            let slots = account.list_connections(sent, labels, chosen, light);
            return queue.append(sent, &named(&mut self.seeds, labels, slots, chosen), chosen);
        }
        queue.append(sent, labels, chosen);
    }

    /// Takes the next batch of rays after `depth` bounces.
    fn take_paths(&mut self, depth: u32, batch: &mut Batch) {
        self.queue_at(depth).take_batch(batch);
        self.counts.bounce_rays += batch.len() as u64;
    }

    /// Adds the first `len` weighted radiances of a source, each to its slot.
    pub(super) fn add(
        &mut self,
        isa: Isa,
        source: Source,
        radiance: &Vec3s,
        slot: &Column<u32>,
        len: usize,
    ) {
        if let Some(account) = &mut self.account {
            account.note_light(source, radiance, slot, len);
        }
        self.counts.refused_contributions += self.sums.add(isa, radiance, slot, len);
    }

    fn queue_at(&mut self, depth: u32) -> &mut RayQueue {
        let depth = depth as usize;
        if self.paths.len() <= depth {
            self.paths.resize_with(depth + 1, RayQueue::default);
        }
        &mut self.paths[depth]
    }

    /// Capacity, in rays, of each queue of paths and of each queue of connections.
    #[cfg(test)]
    pub(super) fn rooms(&self) -> (Vec<usize>, Vec<usize>) {
        let rooms = |queues: &[RayQueue]| queues.iter().map(RayQueue::room).collect();
        (rooms(&self.paths), rooms(&self.connections))
    }
}

/// Returns labels with the slots that an account gives to chosen rays, which keep the seeds of the
/// slots before.
fn named(
    seeds: &mut Vec<PixelSeed>,
    labels: &Labels,
    slots: Column<u32>,
    chosen: &Chosen,
) -> Labels {
    for i in chosen.entries() {
        if slots[i] as usize == seeds.len() {
            seeds.push(seeds[labels.slot[i] as usize]);
        }
    }
    Labels { slot: slots, ..labels.clone() }
}
