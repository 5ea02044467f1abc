//! A uniform grid, traversed cell by cell.
//!
//! Sources: Fujimoto, Tanaka, Iwata, *ARTS: Accelerated Ray-Tracing System*, IEEE CG&A 1986;
//! Amanatides, Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987. It
//! departs from them in three ways:
//!
//! - The time at which a ray crosses a plane is a [span](super::ray). Where a ray passes so close to
//!   an edge of cells that rounding decides which cell comes next, all of them are visited. Each
//!   cell is still visited at most once, and almost always by a single step.
//! - A hit in a later cell is kept, since the object would only be found again there. The ray ends
//!   as soon as the next cell lies behind the nearest hit, which is the rule that a hit counts only
//!   in the cell that holds it.
//! - The box of all objects is grown by [`MARGIN`] of its size on each side. In scenes that are made
//!   of simple fractions, planes of the grid would otherwise run along faces of boxes, and which
//!   cells an object belongs to would be a matter of rounding.
//!
//! An object belongs to all cells that its box overlaps; on a plane, the cell above owns the points.

use super::counting::Counting;
use super::layout::Layout;
use super::memory::{Memory, Tests};
use super::parameters::Parameters;
use super::ray::{Cell, Line, Ray, solid};
use super::statistics::{Meter, Statistics};
use super::{MARGIN, Study};
use crate::math::Bounds;

/// Most references, and most cells: a finer grid is made coarser.
const MOST: u64 = 1 << 28;

/// A uniform grid.
#[derive(Debug)]
pub struct Grid {
    planes: Planes,
    objects: usize,
    mailbox: bool,
    /// Where the references of each cell start, and where those of the last end.
    starts: Vec<u32>,
    references: Vec<u32>,
    bytes_of_building: usize,
}

/// Where the planes of the grid are.
#[derive(Clone, Copy, Debug)]
struct Planes {
    bounds: Cell,
    /// Lengths of the sides of a cell.
    side: [f64; 3],
    cells: [u32; 3],
}

impl Planes {
    fn new(bounds: Cell, cells: [u32; 3]) -> Self {
        let size = bounds.size();
        let side = std::array::from_fn(|axis| size[axis] / f64::from(cells[axis]));
        Self { bounds, side, cells }
    }

    /// Coordinate of plane `i` of `0..=cells`.
    #[inline]
    fn plane(&self, axis: usize, i: u32) -> f64 {
        if i == self.cells[axis] {
            self.bounds.max[axis]
        } else {
            self.bounds.min[axis] + f64::from(i) * self.side[axis]
        }
    }

    /// The cell that holds a coordinate, or the nearest one.
    #[inline]
    fn cell(&self, axis: usize, x: f64) -> u32 {
        let last = self.cells[axis] - 1;
        let guess = (x - self.bounds.min[axis]) / self.side[axis];
        // As Rust converts, NaN and all that is below becomes 0.
        let mut cell = (guess as u32).min(last);
        while cell > 0 && x < self.plane(axis, cell) {
            cell -= 1;
        }
        while cell < last && x >= self.plane(axis, cell + 1) {
            cell += 1;
        }
        cell
    }

    /// The first and the last cell that a box overlaps, by axis.
    fn overlap(&self, bounds: &Bounds) -> [[u32; 2]; 3] {
        std::array::from_fn(|axis| {
            let ends = [bounds.min[axis], bounds.max[axis]];
            ends.map(|end| self.cell(axis, f64::from(end)))
        })
    }

    fn count(&self) -> u64 {
        self.cells.iter().map(|&cells| u64::from(cells)).product()
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny] = [self.cells[0] as usize, self.cells[1] as usize];
        (z as usize * ny + y as usize) * nx + x as usize
    }
}

impl Study for Grid {
    fn build(objects: &[Bounds], parameters: &Parameters) -> Self {
        let (ids, bounds) = solid(objects);
        let bounds = bounds.grown(MARGIN);
        let mut cells = match parameters.cells {
            Some(cells) => cells.map(|cells| cells.clamp(1, 1 << 20)),
            None => resolution(&bounds, ids.len(), parameters),
        };
        let planes = loop {
            let planes = Planes::new(bounds, cells);
            let overlap = |&id: &u32| {
                let overlap = planes.overlap(&objects[id as usize]);
                overlap.iter().map(|[first, last]| u64::from(last - first + 1)).product::<u64>()
            };
            let fits = planes.count() <= MOST
                && ids
                    .iter()
                    .try_fold(0u64, |sum, id| Some(sum + overlap(id)).filter(|&s| s <= MOST))
                    .is_some();
            if ids.is_empty() || fits || cells == [1; 3] {
                break planes;
            }
            cells = cells.map(|cells| cells.div_ceil(2));
        };
        fill(objects, &ids, planes, parameters.mailbox)
    }

    fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &Ray,
        memory: &mut Memory,
        counting: &mut C,
        visit: V,
    ) -> f32 {
        let (_, mut tests) = memory.begin(self.objects, self.mailbox, ray.t_max, counting, visit);
        if !self.references.is_empty() {
            self.follow(&Line::new(ray, &self.planes.bounds), &mut tests);
        }
        tests.t_max
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::new(self.objects);
        let [x, y, z] = self.planes.side;
        let area = 2.0 * (x * y + y * z + z * x);
        for ends in self.starts.windows(2) {
            statistics.add_cell((ends[1] - ends[0]) as usize, area);
        }
        statistics.cells = Some(self.planes.cells);
        statistics.finish(self.planes.bounds.area(), self.bytes(), self.bytes_of_building)
    }

    fn layout(&self) -> Option<Layout<'_>> {
        let Planes { bounds, side, cells } = self.planes;
        (!self.mailbox).then_some(Layout::Grid {
            ends: [bounds.min, bounds.max],
            side,
            cells,
            starts: &self.starts,
            references: &self.references,
        })
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.references)
    }
}

/// Numbers of cells along the axes.
///
/// By density: cubes of which as many fill the box as are wanted (after Woo). By the shortest side:
/// `shortest` times the fourth root of the number of objects along it, and cubes.
fn resolution(bounds: &Cell, objects: usize, parameters: &Parameters) -> [u32; 3] {
    let size = bounds.size();
    let greatest = size.into_iter().fold(0.0, f64::max);
    let side = if let Some(shortest) = parameters.shortest {
        let cells = f64::from(shortest) * (objects as f64).sqrt().sqrt();
        // A side that is next to nothing would ask for cells without end.
        let least = size.into_iter().fold(greatest, f64::min).max(greatest / 64.0);
        least / cells.max(1.0)
    } else {
        let density = f64::from(parameters.density.unwrap_or(3.0));
        side_by_density(size, density * objects as f64)
    };
    let cells = |size: f64| (size / side + 0.5).clamp(1.0, f64::from(1u32 << 20)) as u32;
    if side > 0.0 { size.map(cells) } else { [1; 3] }
}

/// The side of cubes of which `wanted` fill a box. Sides shorter than a cube count as long as one.
fn side_by_density(size: [f64; 3], wanted: f64) -> f64 {
    let mut sorted = size;
    sorted.sort_unstable_by(f64::total_cmp);
    let [short, middle, long] = sorted;
    let cube = cube_root(short * middle * long / wanted);
    let square = (middle * long / wanted).sqrt();
    let line = long / wanted.max(1.0);
    if cube <= short {
        cube
    } else if square <= middle {
        square
    } else {
        line
    }
}

/// The cube root of a number that is not negative, the same on all machines.
fn cube_root(x: f64) -> f64 {
    let (mut low, mut high) = (0.0f64, x.max(1.0));
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle * middle * middle <= x {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Lists the objects of each cell: counts them, then puts them in their places.
fn fill(objects: &[Bounds], ids: &[u32], planes: Planes, mailbox: bool) -> Grid {
    let mut meter = Meter::default();
    let count = if ids.is_empty() { 0 } else { planes.count() as usize };
    let mut starts = vec![0u32; count + 1];
    let for_each = |id: u32, each: &mut dyn FnMut(usize)| {
        let [xs, ys, zs] = planes.overlap(&objects[id as usize]);
        for z in zs[0]..=zs[1] {
            for y in ys[0]..=ys[1] {
                for x in xs[0]..=xs[1] {
                    each(planes.index([x, y, z]));
                }
            }
        }
    };
    for &id in ids {
        for_each(id, &mut |cell| starts[cell + 1] += 1);
    }
    for cell in 0..count {
        starts[cell + 1] += starts[cell];
    }
    let mut references = vec![0u32; starts[count] as usize];
    let mut next = starts.clone();
    for &id in ids {
        for_each(id, &mut |cell| {
            references[next[cell] as usize] = id;
            next[cell] += 1;
        });
    }
    meter.take(size_of_val(ids));
    meter.take(2 * size_of_val(&*starts) + size_of_val(&*references));
    let bytes_of_building = meter.highest();
    Grid { planes, objects: objects.len(), mailbox, starts, references, bytes_of_building }
}

/// The cells of one axis that a ray is in, numbered in the order in which it enters them.
#[derive(Clone, Copy)]
struct Places {
    /// The first that the ray may not have left, and the last that it may have entered.
    first: u32,
    last: u32,
    /// When the ray has certainly left the first, and when it may enter the one after the last.
    leaves: f64,
    enters: f64,
}

impl Grid {
    fn follow<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        tests: &mut Tests<'_, C, V>,
    ) {
        let [near, far] = line.span(&self.planes.bounds, tests.t_max);
        if near > far {
            return;
        }
        let mut places = [0, 1, 2].map(|axis| self.start(line, axis, near));
        let all = places.map(|places| [places.first, places.last]);
        self.visit(line, all, tests);
        loop {
            let enters = places.map(|places| places.enters);
            let axis = if enters[0] <= enters[1] && enters[0] <= enters[2] {
                0
            } else if enters[1] <= enters[2] {
                1
            } else {
                2
            };
            let now = enters[axis];
            if now > far || now == f64::INFINITY || !tests.reaches(now) {
                return;
            }
            places[axis].last += 1;
            places[axis].enters = self.enters(line, axis, places[axis].last + 1);
            let mut cells = [[0; 2]; 3];
            for (other, places) in places.iter_mut().enumerate() {
                while places.leaves < now && places.first < places.last {
                    places.first += 1;
                    places.leaves = self.leaves(line, other, places.first);
                }
                let first = if other == axis { places.last } else { places.first };
                cells[other] = [first, places.last];
            }
            self.visit(line, cells, tests);
        }
    }

    /// The places of an axis where a ray is when it may enter the grid.
    fn start(&self, line: &Line, axis: usize, near: f64) -> Places {
        let cells = self.planes.cells[axis];
        let cell = self.planes.cell(axis, line.at(axis, near));
        let guess = if line.falls(axis) { cells - 1 - cell } else { cell };
        let (mut first, mut last) = (guess, guess);
        while first > 0 && self.leaves(line, axis, first - 1) >= near {
            first -= 1;
        }
        while first < last && self.leaves(line, axis, first) < near {
            first += 1;
        }
        while last + 1 < cells && self.enters(line, axis, last + 1) <= near {
            last += 1;
        }
        let (leaves, enters) = (self.leaves(line, axis, first), self.enters(line, axis, last + 1));
        Places { first, last, leaves, enters }
    }

    /// When a ray may enter a place of an axis; never, if there is none.
    #[inline]
    fn enters(&self, line: &Line, axis: usize, place: u32) -> f64 {
        let cells = self.planes.cells[axis];
        if place >= cells {
            return f64::INFINITY;
        }
        let plane = if line.falls(axis) { cells - place } else { place };
        line.crossing(axis, self.planes.plane(axis, plane)).early
    }

    /// When a ray has certainly left a place of an axis.
    #[inline]
    fn leaves(&self, line: &Line, axis: usize, place: u32) -> f64 {
        let plane = if line.falls(axis) { self.planes.cells[axis] - 1 - place } else { place + 1 };
        line.crossing(axis, self.planes.plane(axis, plane)).late
    }

    /// Tests the objects of cells: from the first to the last place on each axis.
    fn visit<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        line: &Line,
        [xs, ys, zs]: [[u32; 2]; 3],
        tests: &mut Tests<'_, C, V>,
    ) {
        let turned = |axis: usize, place: u32| {
            if line.falls(axis) { self.planes.cells[axis] - 1 - place } else { place }
        };
        for z in zs[0]..=zs[1] {
            for y in ys[0]..=ys[1] {
                for x in xs[0]..=xs[1] {
                    let cell = self.planes.index([turned(0, x), turned(1, y), turned(2, z)]);
                    tests.counting.step();
                    tests.leaf(&self.references[self.of(cell)]);
                }
            }
        }
    }

    #[inline]
    fn of(&self, cell: usize) -> std::ops::Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }
}
