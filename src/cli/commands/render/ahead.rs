//! Builds the next frame while one is rendered: reads the files of meshes that change their shape,
//! and builds structures.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use crate::cli::base::{Problem, megabytes};
use crate::cli::files::load;
use crate::cli::options::Job;
use crate::cli::system::{memory, threads};
use slo_accel::Isa;
use slo_accel::study::Parameters;
use slo_render::frame::{Aids, FrameScene};
use slo_scene::SceneDescription;
use slo_scene::cache::Cache;

/// Memory that building takes at its highest, in units of what stays.
const GROWTH: u64 = 4;
/// Bytes that must be left beside.
const REST: u64 = 256 << 20;
/// Address space that a thread reserves.
const PER_THREAD: u64 = 136 << 20;

/// A frame under construction, and the time it took.
type Built = (Result<FrameScene, Problem>, Duration);

/// Builds frames on threads of its own, one at a time. The system divides the processors between
/// these threads and those that render; when a frame is rendered before the next one is built, all
/// processors build.
///
/// The threads own what they need, so that an interrupted program need not wait for them.
pub(super) struct Ahead {
    pool: Arc<ThreadPool>,
    scene: Arc<SceneDescription>,
    cache: Option<Arc<Cache>>,
    isa: Isa,
    parameters: Parameters,
    under_way: Option<(i64, Receiver<Built>)>,
    /// Time spent building.
    pub(super) time: Duration,
    /// Why a frame was not built ahead, if it was for lack of memory.
    pub(super) refused: Option<String>,
}

impl Ahead {
    /// Prepares threads for building, as many as the current pool has. `None`: there is only one,
    /// which has enough to do, or no more can be had.
    pub(super) fn new(scene: &SceneDescription, job: &Job) -> Option<Self> {
        let threads = rayon::current_num_threads();
        let left = memory::left().filter(|left| left.is_of_address_space());
        if threads < 2 || left.is_some_and(|left| left.bytes < threads as u64 * PER_THREAD + REST) {
            return None;
        }
        let pool = Arc::new(threads::pool(Some(threads)).ok()?);
        let scene = Arc::new(scene.clone());
        Some(Self {
            pool,
            scene,
            cache: job.cache.clone(),
            isa: job.isa,
            parameters: job.parameters(),
            under_way: None,
            time: Duration::ZERO,
            refused: None,
        })
    }

    /// Begins to build a frame, unless memory is short. It takes what it can from `before`.
    pub(super) fn begin(&mut self, number: i64, before: &FrameScene) {
        if let Some(left) = memory::left() {
            let needed = GROWTH * before.memory() as u64 + REST;
            if left.bytes < needed {
                let needed = megabytes(needed);
                self.refused = Some(format!("{left}, and another frame may take {needed}"));
                return;
            }
        }
        let (sender, receiver) = sync_channel(1);
        let (pool, scene, isa) = (self.pool.clone(), self.scene.clone(), self.isa);
        let (before, cache) = (Some(before.remains()), self.cache.clone());
        let aids = Aids { before, cache, parameters: self.parameters, ..Aids::default() };
        let build = move || {
            let start = Instant::now();
            let frame = pool.install(|| load::frame(isa, &scene, number, aids));
            // Nobody waits for it if the run has ended.
            let _ = sender.send((frame, start.elapsed()));
        };
        let thread = thread::Builder::new().name("ahead".into()).spawn(build);
        self.under_way = thread.ok().map(|_| (number, receiver));
    }

    /// Returns the number of the frame that was begun.
    pub(super) fn frame(&self) -> Option<i64> {
        self.under_way.as_ref().map(|(number, _)| *number)
    }

    /// Returns the frame that was begun, with its number, if it is ready.
    pub(super) fn ready(&mut self) -> Option<(i64, Result<FrameScene, Problem>)> {
        let (number, receiver) = self.under_way.as_ref()?;
        let number = *number;
        match receiver.try_recv() {
            Ok(built) => Some((number, self.taken(built))),
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => None,
        }
    }

    /// Waits for the frame that was begun. `None`: there is none, or its thread died.
    pub(super) fn wait(&mut self) -> Option<(i64, Result<FrameScene, Problem>)> {
        let (number, receiver) = self.under_way.take()?;
        let built = receiver.recv().ok()?;
        Some((number, self.taken(built)))
    }

    fn taken(&mut self, (frame, time): Built) -> Result<FrameScene, Problem> {
        self.under_way = None;
        self.time += time;
        frame
    }
}
