//! The plane that splits space best, of those between equal bins along each axis.

use glam::Vec4;
use rayon::prelude::*;

use super::cut::margin;
use super::room::Room;
use crate::isa::Isa;
use crate::primitives::Triangle;
use crate::primitives::triangle::POSITION_ERROR;
use crate::structure::bvh::builder::bins::PARALLEL_CHUNK;
use crate::structure::bvh::builder::boxes::{Box8, Reference};
use crate::structure::bvh::builder::heuristic::cost;

/// Bins along each axis.
pub(super) const BINS: usize = 32;

/// Least width of a bin in margins of a triangle: in narrower bins, cutting would hardly shrink
/// boxes.
const MARGINS: f32 = 8.0;

/// Least width of a bin, in units of the box's largest coordinate.
const LEAST_WIDTH: f32 = MARGINS * POSITION_ERROR;

/// A plane, and the sides that it would make.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) axis: usize,
    pub(super) at: f32,
    pub(super) cost: f32,
    /// Boxes of both sides.
    pub(super) sides: [Box8; 2],
    /// Number of references that would reach into each.
    pub(super) counts: [u32; 2],
    /// Between this plane and the next.
    width: f32,
}

impl Plane {
    /// The triangle of a reference, if cutting it pays.
    pub(super) fn cuttable<'a>(
        &self,
        reference: &Reference,
        triangles: &'a [Triangle],
    ) -> Option<&'a Triangle> {
        cuttable(reference, triangles, self.width)
    }

    /// The side of a reference that is not cut: 0 for left, 1 for right.
    pub(super) fn side(&self, reference: &Reference) -> usize {
        usize::from(reference.center()[self.axis] >= 2.0 * self.at)
    }
}

/// The triangle of a reference, if its margin is much smaller than the bins.
fn cuttable<'a>(
    reference: &Reference,
    triangles: &'a [Triangle],
    width: f32,
) -> Option<&'a Triangle> {
    let triangle = triangles.get(reference.id() as usize)?;
    (MARGINS * margin(triangle) < width).then_some(triangle)
}

/// Equal bins that fill a box.
struct Grid {
    min: Vec4,
    width: Vec4,
    /// Bins per unit of length; 0 if there is only one bin.
    scale: Vec4,
}

impl Grid {
    fn new(all: &Box8) -> Self {
        let size = all.size();
        let usable = size.cmpgt(Vec4::splat(f32::MIN_POSITIVE * 2.0 * BINS as f32))
            & size.cmplt(Vec4::splat(f32::INFINITY));
        let bins = Vec4::splat(BINS as f32);
        let largest = all.min().abs().max(all.max().abs()).truncate().max_element();
        let usable = usable & (size / bins).cmpgt(Vec4::splat(LEAST_WIDTH * largest));
        let scale = Vec4::select(usable, bins / size, Vec4::ZERO).with_w(0.0);
        Self { min: all.min(), width: size / bins, scale }
    }

    /// The bins on all axes that a point lies in.
    #[inline(always)]
    fn bins(&self, p: Vec4) -> [usize; 3] {
        let place = (p - self.min) * self.scale;
        // Too large, below 0, and NaN are settled by the conversion.
        [place.x, place.y, place.z].map(|x| (x as usize).min(BINS - 1))
    }

    /// The plane below a bin.
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.min[axis] + bin as f32 * self.width[axis]
    }
}

/// The parts of references in the bins of three axes.
#[derive(Clone)]
struct Bins {
    boxes: [[Box8; BINS]; 3],
    /// References that begin here.
    entries: [[u32; BINS]; 3],
    /// References that end here.
    exits: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self =
        Self { boxes: [[Box8::EMPTY; BINS]; 3], entries: [[0; BINS]; 3], exits: [[0; BINS]; 3] };

    fn of(grid: &Grid, references: &[Reference], triangles: &[Triangle], isa: Isa) -> Self {
        match isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the set is one that the CPU has.
            Isa::Avx512 | Isa::Avx2 => unsafe { fill_avx2(grid, references, triangles) },
            _ => Self::fill(grid, references, triangles),
        }
    }

    #[inline(always)]
    fn fill(grid: &Grid, references: &[Reference], triangles: &[Triangle]) -> Self {
        let mut bins = Self::EMPTY;
        for reference in references {
            let first = grid.bins(reference.bounds().min());
            let last = grid.bins(reference.bounds().max());
            bins.add::<0>(grid, [first[0], last[0]], reference, triangles);
            bins.add::<1>(grid, [first[1], last[1]], reference, triangles);
            bins.add::<2>(grid, [first[2], last[2]], reference, triangles);
        }
        bins
    }

    /// Adds a reference that fills the bins from `first` to `last` of an axis.
    #[inline(always)]
    fn add<const AXIS: usize>(
        &mut self,
        grid: &Grid,
        [first, last]: [usize; 2],
        reference: &Reference,
        triangles: &[Triangle],
    ) {
        if first == last {
            return self.put(AXIS, first, reference);
        }
        if first + 1 == last && (reference.id() as usize) < triangles.len() {
            return self.halve::<AXIS>(grid.plane(AXIS, last), last, reference);
        }
        match cuttable(reference, triangles, grid.width[AXIS]) {
            Some(triangle) => self.spread::<AXIS>(grid, [first, last], reference, triangle),
            None => {
                let middle = grid.bins((reference.center() * 0.5).extend(0.0))[AXIS];
                self.put(AXIS, middle, reference);
            }
        }
    }

    /// Adds both parts of the box of a reference to the two bins that it fills. Boxes about the
    /// parts of the triangle would hardly be smaller.
    #[inline(always)]
    fn halve<const AXIS: usize>(&mut self, at: f32, last: usize, reference: &Reference) {
        let boxes = &mut self.boxes[AXIS];
        let [below, above] = reference.bounds().split::<AXIS>(at);
        boxes[last - 1] = boxes[last - 1].union(&below);
        boxes[last] = boxes[last].union(&above);
        self.entries[AXIS][last - 1] += 1;
        self.exits[AXIS][last] += 1;
    }

    /// Adds a whole reference to one bin.
    #[inline(always)]
    fn put(&mut self, axis: usize, bin: usize, reference: &Reference) {
        self.boxes[axis][bin] = self.boxes[axis][bin].union(reference.bounds());
        self.entries[axis][bin] += 1;
        self.exits[axis][bin] += 1;
    }

    /// Adds the part of a reference between each two planes to the bin between them.
    #[inline(always)]
    fn spread<const AXIS: usize>(
        &mut self,
        grid: &Grid,
        [first, last]: [usize; 2],
        reference: &Reference,
        triangle: &Triangle,
    ) {
        self.entries[AXIS][first] += 1;
        self.exits[AXIS][last] += 1;
        let (whole, sections) = (reference.bounds(), Sections::<AXIS>::new(triangle));
        let [low, high] = [whole.min()[AXIS], whole.max()[AXIS]];
        let boxes = &mut self.boxes[AXIS];
        let mut add = |bin: usize, part: &Box8| boxes[bin] = boxes[bin].union(part);
        for corner in sections.corners.iter().filter(|p| low <= p[AXIS] && p[AXIS] <= high) {
            add(grid.bins(*corner)[AXIS], &Box8::point(corner.truncate()).clamped(whole));
        }
        for (bin, end) in [(first, low), (last, high)] {
            if let Some(section) = sections.at(end) {
                add(bin, &section.clamped(whole));
            }
        }
        for bin in first + 1..=last {
            if let Some(section) = sections.at(grid.plane(AXIS, bin)) {
                let section = section.clamped(whole);
                add(bin - 1, &section);
                add(bin, &section);
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(&other.boxes[axis][bin]);
                self.entries[axis][bin] += other.entries[axis][bin];
                self.exits[axis][bin] += other.exits[axis][bin];
            }
        }
    }

    /// The cheapest plane of one axis that leaves at most `most` references.
    fn sweep(&self, grid: &Grid, axis: usize, most: u32) -> Option<Plane> {
        let mut right = [(Box8::EMPTY, 0); BINS];
        let (mut all, mut count) = (Box8::EMPTY, 0);
        for bin in (1..BINS).rev() {
            all = all.union(&self.boxes[axis][bin]);
            count += self.exits[axis][bin];
            right[bin] = (all, count);
        }
        let mut best: Option<Plane> = None;
        let (mut all, mut count) = (Box8::EMPTY, 0);
        for bin in 1..BINS {
            all = all.union(&self.boxes[axis][bin - 1]);
            count += self.entries[axis][bin - 1];
            let (right, right_count) = right[bin];
            let cost = cost(all.half_area(), count) + cost(right.half_area(), right_count);
            let least = best.as_ref().map_or(f32::INFINITY, |best| best.cost);
            if cost < least && count + right_count <= most {
                best = Some(Plane {
                    axis,
                    at: grid.plane(axis, bin),
                    cost,
                    sides: [all, right],
                    counts: [count, right_count],
                    width: grid.width[axis],
                });
            }
        }
        best
    }
}

/// Sections of a triangle by the planes across an axis.
struct Sections<const AXIS: usize> {
    /// From low to high.
    corners: [Vec4; 3],
    /// From the lowest corner to the highest, and on the two edges of the other way, for each unit
    /// of the axis.
    steps: [Vec4; 3],
}

impl<const AXIS: usize> Sections<AXIS> {
    #[inline(always)]
    fn new(triangle: &Triangle) -> Self {
        let mut corners = triangle.map(|p| p.extend(0.0));
        for (i, j) in [(0, 1), (1, 2), (0, 1)] {
            if corners[j][AXIS] < corners[i][AXIS] {
                corners.swap(i, j);
            }
        }
        let [low, middle, high] = corners;
        let step = |p: Vec4, q: Vec4| (q - p) / (q[AXIS] - p[AXIS]);
        Self { corners, steps: [step(low, high), step(low, middle), step(middle, high)] }
    }

    /// The box about the section by a plane; none if the plane does not pass between corners.
    #[inline(always)]
    fn at(&self, at: f32) -> Option<Box8> {
        let [low, middle, high] = self.corners;
        if !(low[AXIS] < at && at < high[AXIS]) {
            return None;
        }
        let straight = low + self.steps[0] * (at - low[AXIS]);
        let (from, step) = match at <= middle[AXIS] {
            true => (low, self.steps[1]),
            false => (middle, self.steps[2]),
        };
        let bent = from + step * (at - from[AXIS]);
        Some(Box8::point(straight.truncate()).union(&Box8::point(bent.truncate())))
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn fill_avx2(grid: &Grid, references: &[Reference], triangles: &[Triangle]) -> Bins {
    Bins::fill(grid, references, triangles)
}

/// The cheapest plane between bins for whose references there is room; none if there is only one
/// bin, or costs overflow.
pub(super) fn best_plane(
    all: &Box8,
    room: &Room<'_>,
    triangles: &[Triangle],
    isa: Isa,
) -> Option<Plane> {
    let (grid, references) = (Grid::new(all), room.references());
    let bins = if references.len() > 2 * PARALLEL_CHUNK {
        let chunks: Vec<Bins> = references
            .par_chunks(PARALLEL_CHUNK)
            .map(|chunk| Bins::of(&grid, chunk, triangles, isa))
            .collect();
        chunks.iter().fold(Bins::EMPTY, |mut all, chunk| {
            all.merge(chunk);
            all
        })
    } else {
        Bins::of(&grid, references, triangles, isa)
    };
    let most = (room.count + room.spare()) as u32;
    (0..3)
        .filter_map(|axis| bins.sweep(&grid, axis, most))
        .reduce(|best, next| if next.cost < best.cost { next } else { best })
}
