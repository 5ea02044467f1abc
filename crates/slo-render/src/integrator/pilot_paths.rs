//! Pilot paths: paths of no picture, from which the field that guides rays is learned.

use super::machine::Machine;
use super::path::Path;
use super::work::{Job, Work};
use crate::frame::FrameScene;
use crate::guiding::{Field, Record};

/// Traces the pilot paths of one thread.
#[derive(Debug, Default)]
pub struct PilotTracer {
    machine: Machine,
    path: Path,
}

impl PilotTracer {
    /// Traces the paths of some camera samples, each an entry of the work with a count of 1, guided by a
    /// field. Returns what they found, in an order that depends on the work alone; `None` if `gives_up`
    /// says to give up.
    pub fn trace(
        &mut self,
        frame: &FrameScene,
        work: &[Work],
        guide: Option<&Field>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<Vec<Record>> {
        let job = Job { guide, is_pilot: true, ..Job::new(frame, work, gives_up) };
        let Self { machine, path } = self;
        // One more for the light that the last rays find.
        let bounces = frame.settings.recursion() as usize + 1;
        machine.begin(&frame.pilot_sampler, work, bounces + 1);
        path.vertices.restart(0, 0);
        path.pilot.restart(work.len());
        machine.run(path, &job)?;
        let (_, sums, _) = machine.finish(work.len(), bounces);
        let mut found = Vec::new();
        path.pilot.report(sums, &mut found);
        Some(found)
    }
}
