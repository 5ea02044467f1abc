//! The field that guides rays: who learns it, and from which paths.

use std::sync::Mutex;

use rayon::prelude::*;
use slo_picture::film::{Area, BLOCK};

use super::lock::lock;
use crate::frame::FrameScene;
use crate::guiding::{Learning, Record};
use crate::integrator::{PilotTracer, Work};

/// Number of stages. Stage `n` takes `2^n` samples of each of its pixels, guided by what the stages
/// before it have found.
const STAGES: u32 = 5;

/// Most pixels of a stage.
const MOST_PIXELS: u32 = 1 << 16;

/// Paths that a thread traces at a time, and entries of its sums.
const PATHS_AT_ONCE: usize = 4096;
const MOST_SUMS: usize = 1 << 19;

/// The pixels of a stage: those of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Grid {
    step: u32,
    /// The first column and row.
    first: [u32; 2],
}

impl Grid {
    /// One pixel in four, or fewer of a large picture, others in each stage.
    fn new(width: u32, height: u32, stage: u32) -> Self {
        let mut step = 2;
        while (width / step).saturating_mul(height / step) > MOST_PIXELS {
            step *= 2;
        }
        let half = step / 2;
        let first = [[0, 0], [half, half], [half, 0], [0, half]][stage as usize % 4];
        Self { step, first }
    }

    /// Returns the pixels within an area.
    fn pixels(self, area: Area) -> impl Iterator<Item = (u32, u32)> {
        let Self { step, first: [x, y] } = self;
        let is_mine = move |at: u32, first: u32| at % step == first;
        let rows = (area.y0..area.y1).filter(move |&at| is_mine(at, y));
        rows.flat_map(move |row| {
            let columns = (area.x0..area.x1).filter(move |&at| is_mine(at, x));
            columns.map(move |column| (column, row))
        })
    }
}

/// Returns the number of all pilot paths of a picture.
pub(super) fn paths(width: u32, height: u32) -> f64 {
    let area = Area::whole(width, height);
    let of = |stage| (Grid::new(width, height, stage).pixels(area).count() << stage) as f64;
    (0..STAGES).map(of).sum()
}

/// Learns the field of a frame on the threads of the current rayon pool, unless it is known. It depends
/// on the whole picture, whatever part of it is rendered. Reports the number of paths that were traced.
/// Returns `None` if `gives_up` says to give up.
pub(super) fn learn(
    frame: &FrameScene,
    traced: &(dyn Fn(usize) + Sync),
    gives_up: &(dyn Fn() -> bool + Sync),
) -> Option<()> {
    if !frame.is_guided() || frame.field().is_some() {
        return Some(());
    }
    let (width, height) = (frame.camera.width(), frame.camera.height());
    let tracers: Vec<Mutex<PilotTracer>> =
        (0..rayon::current_num_threads()).map(|_| Mutex::default()).collect();
    let bounces = frame.settings.recursion() as usize + 2;
    let at_once = (MOST_SUMS / bounces).clamp(64, PATHS_AT_ONCE);
    let (mut learning, mut field) = (Learning::default(), None);
    for stage in 0..STAGES {
        let grid = Grid::new(width, height, stage);
        let blocks = Area::whole(width, height).cells(BLOCK * grid.step);
        let work: Vec<Work> = blocks
            .flat_map(|block| grid.pixels(block))
            .flat_map(|(x, y)| {
                let samples = (1 << stage) - 1..(2 << stage) - 1;
                samples.map(move |first| Work { x, y, first, count: 1 })
            })
            .collect();
        let found: Option<Vec<Vec<Record>>> = work
            .par_chunks(at_once)
            .map(|work| {
                let thread = rayon::current_thread_index().unwrap_or(0);
                let mut tracer = lock(&tracers[thread]);
                let records = tracer.trace(frame, work, field.as_ref(), gives_up)?;
                traced(work.len());
                Some(records)
            })
            .collect();
        learning.learn(&mut found?.concat());
        field = Some(learning.field());
    }
    // If another thread was faster, it has learned the same.
    let _ = field.map(|field| frame.field.set(field));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_see_a_quarter_of_the_pixels_each() {
        let mut seen = [0; 64];
        for stage in 0..4 {
            for (x, y) in Grid::new(8, 8, stage).pixels(Area::whole(8, 8)) {
                seen[(y * 8 + x) as usize] += 1;
            }
        }
        assert_eq!(seen, [1; 64]);
        assert_eq!(paths(256, 144), 9216.0 * 31.0);
        assert_eq!(Grid::new(1280, 720, 0).step, 4);
        let _ = paths(1, 1);
    }
}
