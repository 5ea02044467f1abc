//! Renders one tile: its pixels take samples in steps until each has enough.

use std::ops::Range;
use std::sync::Arc;

use super::photons::Stretch;
use super::plan::Plan;
use crate::frame::FrameScene;
use crate::integrator::{Beside, SampleSum, Seen, Statistics, Traced, Tracer, Work};
use crate::photons::{PhotonLight, PhotonMaps};
use slo_accel::Isa;
use slo_picture::film::{Area, BLOCK, Film, MaskKind, Wide, base_end, split};
use slo_scene::LightGroups;

/// Most camera samples traced together. Their sums stay in the second-level cache, and there are
/// enough of them to fill the batches of deep bounces.
const SAMPLES_AT_ONCE: u32 = 16 * 1024;

/// Approximate number of camera samples of a step: the most that is lost if a run is killed, and
/// the time a thread takes to notice that it should stop.
const SAMPLES_OF_A_STEP: u32 = 128 * 1024;

/// Working memory of one thread.
#[derive(Debug, Default)]
pub(super) struct TileRenderer {
    tracer: Tracer,
    /// Samples of the tile.
    film: Film,
    /// The pixels in the order in which they are traced: block by block, and within a block in
    /// patches of 4 x 4, so that neighbours in a batch are neighbours in the picture.
    order: Vec<u32>,
    /// Ranges of `order` that are decided together and may need more samples. Each comes with its
    /// quarters, relative to its start.
    groups: Vec<(Range<usize>, Vec<Range<usize>>)>,
    steps: Vec<Step>,
    work: Vec<Work>,
    /// For each entry of `work`, its pixel.
    pixels: Vec<u32>,
    /// Number of samples in `work`.
    queued: u32,
    /// The photons that the samples use, if the frame has any.
    maps: Option<Arc<PhotonMaps>>,
    light: Option<Arc<PhotonLight>>,
    /// The number of the sample before which all pixels stop for now.
    end: u32,
    /// Samples per pixel at the beginning.
    before: f64,
    statistics: Statistics,
}

/// Samples `from..to` that a pixel takes next, numbered within its share.
#[derive(Clone, Copy, Debug)]
struct Step {
    pixel: u32,
    from: u32,
    to: u32,
}

impl TileRenderer {
    /// Begins a tile with the samples that `film` has of it, for a stretch of samples. Returns the share
    /// of the tile that is done.
    pub(super) fn begin(
        &mut self,
        isa: Isa,
        film: &Film,
        tile: Area,
        plan: &Plan,
        stretch: &Stretch,
    ) -> f64 {
        (self.maps, self.end) = (stretch.maps.clone(), stretch.end);
        self.light = stretch.light.clone();
        film.copy_to(tile, &mut self.film);
        self.clear_work();
        self.arrange(plan);
        self.before = self.mean_samples();
        match plan.uniform() {
            Some(all) => self.before / f64::from(all.max(1)),
            None if self.plan_step(isa, plan) || !self.is_done() => 0.0,
            None => 1.0,
        }
    }

    /// Returns the number of the next sample of the pixel that has the fewest among those that need
    /// more; `None` if none does.
    pub(super) fn first_open(&mut self, isa: Isa, plan: &Plan) -> Option<u32> {
        self.plan_step(isa, plan);
        let first = plan.samples().map_or(0, |share| share.start);
        self.steps.iter().map(|step| first + step.from).min()
    }

    /// Whether no pixel needs more samples, in this stretch or a later one.
    pub(super) fn is_done(&self) -> bool {
        self.groups.is_empty()
    }

    /// Returns the samples per pixel of the tile at its beginning and now.
    pub(super) fn samples(&self) -> [f64; 2] {
        [self.before, self.mean_samples()]
    }

    fn mean_samples(&self) -> f64 {
        let pixels = self.film.pixels();
        let all: u64 = pixels.iter().map(|pixel| u64::from(pixel.samples)).sum();
        all as f64 / pixels.len().max(1) as f64
    }

    /// Plans the next step. Returns false if the tile is done with the stretch.
    pub(super) fn plan_step(&mut self, isa: Isa, plan: &Plan) -> bool {
        let first = plan.samples().map_or(0, |share| share.start);
        let Self { film, order, groups, steps, end, .. } = self;
        steps.clear();
        // A group that is done stays done, since only its own samples decide.
        groups.retain(|(group, quarters)| {
            let group = &order[group.clone()];
            let next = plan.next(isa, film, group, quarters);
            if let Some(to) = next {
                let to = to.min(end.saturating_sub(first));
                let from = |i: u32| film.pixels()[i as usize].samples;
                let step = |&pixel: &u32| Step { pixel, from: from(pixel), to };
                steps.extend(group.iter().map(step).filter(|step| step.from < to));
            }
            next.is_some()
        });
        let each = (SAMPLES_OF_A_STEP / self.steps.len().max(1) as u32).max(1);
        for step in &mut self.steps {
            step.to = step.to.min(step.from.saturating_add(each));
        }
        !self.steps.is_empty()
    }

    /// Takes the samples of the planned step. Returns the tile after it, counts of what was traced,
    /// and the number of samples; `None` if `gives_up` asks to give up, after which the renderer
    /// must begin again.
    pub(super) fn take_step(
        &mut self,
        frame: &FrameScene,
        plan: &Plan,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<(&Film, Statistics, u64)> {
        self.statistics = Statistics::default();
        let steps = std::mem::take(&mut self.steps);
        let mut taken = 0;
        for step in &steps {
            taken += u64::from(step.to - step.from);
            self.add_work(frame, plan, *step, gives_up)?;
        }
        self.trace(frame, plan, gives_up)?;
        self.steps = steps;
        Some((&self.film, self.statistics, taken))
    }

    /// Queues a pixel's samples in ranges that need only one sum each.
    fn add_work(
        &mut self,
        frame: &FrameScene,
        plan: &Plan,
        Step { pixel, from, to }: Step,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let mut add = |range| self.add_range(frame, plan, pixel, range, gives_up);
        if plan.needs_spreads() {
            (from..to).try_for_each(|i| add(i..i + 1))
        } else if let Some(share) = plan.samples() {
            let (from, to) = (share.start + from, share.start + to);
            let middle = base_end(plan.most()).clamp(from, to);
            add(from..middle)?;
            add(middle..to)
        } else {
            split(from, to).try_for_each(add)
        }
    }

    /// Queues one range, and traces the queue if it is long enough.
    fn add_range(
        &mut self,
        frame: &FrameScene,
        plan: &Plan,
        pixel: u32,
        mut range: Range<u32>,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let area = self.film.area();
        while !range.is_empty() {
            let count = (range.end - range.start).min(SAMPLES_AT_ONCE);
            let (x, y) = (area.x0 + pixel % area.width(), area.y0 + pixel / area.width());
            self.work.push(Work { x, y, first: range.start, count });
            self.pixels.push(pixel);
            range.start += count;
            self.queued += count;
            if self.queued >= SAMPLES_AT_ONCE {
                self.trace(frame, plan, gives_up)?;
            }
        }
        Some(())
    }

    /// Traces the queue and adds it to the film.
    fn trace(
        &mut self,
        frame: &FrameScene,
        plan: &Plan,
        gives_up: &dyn Fn() -> bool,
    ) -> Option<()> {
        let beside = Beside {
            maps: self.maps.as_deref(),
            light: self.light.as_deref(),
            features: !self.film.features().is_empty(),
            places: self.film.first_hits().layers().places,
            ids: self.film.first_hits().layers().has_ids(),
            light_groups: self.film.light_groups().map_or(0, LightGroups::len),
        };
        let Traced { sums, features, groups, places, seen, statistics } =
            self.tracer.trace(frame, &self.work, beside, gives_up)?;
        self.statistics += statistics;
        for ((work, &pixel), &sum) in self.work.iter().zip(&self.pixels).zip(sums) {
            add(&mut self.film, plan, pixel, work, sum);
        }
        for (&pixel, &more) in self.pixels.iter().zip(features) {
            if let Some(sum) = self.film.features_mut(pixel as usize) {
                *sum += more;
            }
        }
        add_lights(&mut self.film, &self.pixels, groups);
        add_first_hits(&mut self.film, &self.pixels, places, seen);
        self.clear_work();
        Some(())
    }

    fn clear_work(&mut self) {
        self.work.clear();
        self.pixels.clear();
        self.queued = 0;
    }

    fn arrange(&mut self, plan: &Plan) {
        let tile = self.film.area();
        self.order.clear();
        self.groups.clear();
        for block in tile.cells(BLOCK) {
            let start = self.order.len();
            let mut quarters = Vec::new();
            for patch in block.cells(BLOCK / 2) {
                let before = self.order.len() - start;
                self.order.extend(indices(patch, tile));
                quarters.push(before..self.order.len() - start);
            }
            if plan.group_side() == BLOCK {
                self.groups.push((start..self.order.len(), quarters));
            } else {
                self.groups.extend((start..self.order.len()).map(|i| (i..i + 1, Vec::new())));
            }
        }
    }
}

/// Adds the sum of some samples to a pixel.
fn add(film: &mut Film, plan: &Plan, pixel: u32, work: &Work, sum: SampleSum) {
    let (pixel, spread) = film.at_mut(pixel as usize);
    match plan.samples() {
        Some(_) if work.first < base_end(plan.most()) => pixel.add_base(sum, work.count),
        Some(_) => pixel.add_later(sum, work.count),
        None => pixel.add(sum, work.count),
    }
    spread.into_iter().for_each(|spread| spread.add(sum));
}

/// Adds the light of groups of lights, group by group, to the pixels of some entries of work.
fn add_lights(film: &mut Film, pixels: &[u32], groups: &[SampleSum]) {
    for (group, sums) in groups.chunks(pixels.len().max(1)).enumerate() {
        for (&pixel, sum) in pixels.iter().zip(sums) {
            if let Some(to) = film.lights_mut(pixel as usize).get_mut(group) {
                to.iter_mut().zip(sum).for_each(|(to, more)| *to += *more);
            }
        }
    }
}

/// Adds what samples hit first to the pixels of some entries of work.
fn add_first_hits(film: &mut Film, pixels: &[u32], places: &[Wide], seen: &[Seen]) {
    let hits = film.first_hits_mut();
    let columns = hits.layers().places.columns();
    for (&pixel, more) in pixels.iter().zip(places.chunks(columns.max(1))) {
        let sums = hits.places_mut(pixel as usize);
        sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
    }
    for Seen { entry, ids } in seen {
        let pixel = pixels[*entry as usize] as usize;
        for (kind, id) in MaskKind::ALL.into_iter().zip(*ids) {
            if let Some(counts) = hits.ids_mut(kind, pixel).filter(|_| id != 0) {
                // There are not as many samples as can be counted.
                let _ = counts.add(id, 1);
            }
        }
    }
}

/// Returns the indices, within a tile, of the pixels of an area of it, row by row.
fn indices(area: Area, tile: Area) -> impl Iterator<Item = u32> {
    let row = move |y| (area.x0..area.x1).map(move |x| (y - tile.y0) * tile.width() + x - tile.x0);
    (area.y0..area.y1).flat_map(row)
}

#[cfg(test)]
mod tests {
    use slo_picture::film::Fixed;

    use super::*;

    #[test]
    fn the_light_of_groups_lands_in_its_pixels() {
        let groups = LightGroups::new(["a", "b"]);
        let film = Film::new(Area::whole(2, 2), false).unwrap();
        let mut film = film.with_light_groups(groups).unwrap();
        let sums: Vec<SampleSum> = (1..=6).map(|i| [Fixed::from_units(i); 3]).collect();
        // Three entries of work; two of them are of pixel 3.
        add_lights(&mut film, &[3, 0, 3], &sums);
        let units =
            |i: usize| film.lights(i).iter().map(|sum| sum[1].units()).collect::<Vec<u64>>();
        assert_eq!([units(0), units(1), units(3)], [vec![2, 5], vec![0, 0], vec![1 + 3, 4 + 6]]);
        add_lights(&mut film, &[3, 0, 3], &[]);
        assert_eq!(film.lights(1), &[[Fixed::ZERO; 3]; 2]);
    }
}
