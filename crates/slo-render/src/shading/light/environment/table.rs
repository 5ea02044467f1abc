//! How an image of the sky is sampled: an even density in each cell of a grid.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use glam::Vec3;

use crate::shading::light::lamp::luminance;
use crate::shading::texture::{elevation_v, equirect_direction, sample_equirect};
use slo_accel::math::columns::select;
use slo_accel::math::elementary::sin_cos_turns;
use slo_scene::Texture;

/// Most cells along the width of the table.
const MOST_COLUMNS: u32 = 2048;

/// Most cells along the height of the table.
const MOST_ROWS: u32 = 1024;

/// Cells in which a small image is divided, at least.
const LEAST_ROWS: u32 = 64;

/// Chances are multiples of 1 over this, so that their sums are exact in f32.
const UNITS: u32 = 1 << 24;

/// Intervals of equal length in which the search among so many sums begins.
const SUMS_PER_START: usize = 4;

/// An image counts as even if no cell is brighter than this times the mean: there is nothing to aim
/// at.
const EVEN: f32 = 1.01;

/// The least chance of a row, and of a cell in its row, in units. It keeps light from being lost
/// where the table says that it is dark.
const LEAST_UNITS: u32 = 16;

/// Which light of an image rays to it are to find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyShare {
    /// All: no rays follow diffuse lobes.
    All,
    /// What exceeds the mean. The rest is found by rays that follow lobes, which need no help where
    /// the sky is even.
    ///
    /// Source: O. Karlik et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple
    /// Importance Sampling" (2019).
    AboveMean,
}

/// The density of an equirectangular image, by its luminance times its solid angle.
#[derive(Clone, Debug)]
pub struct SkyTable {
    share: SkyShare,
    columns: u32,
    rows: u32,
    /// Sum of the chances of the rows above each row, from the top, and 1.
    row_sums: Vec<f32>,
    row_starts: Vec<u16>,
    /// For each row, the sum of the chances of the cells to the left of each cell, and 1.
    cell_sums: Vec<f32>,
    cell_starts: Vec<u16>,
    /// For each row, its upper edge and its lower edge minus this: versines of the angle from +z,
    /// in the lower half from -z.
    edges: Vec<[f32; 2]>,
    /// Luminance of the mean radiance that rays are to find.
    mean: f32,
}

/// A [`SkyTable`] as loops use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableView<'a> {
    table: &'a SkyTable,
}

impl SkyTable {
    /// Makes the table of an image.
    pub fn new(texture: &Texture, share: SkyShare) -> Self {
        let (columns, rows, mut weights) = weights(texture);
        let edge = |row: u32| {
            let is_upper = 2 * row < rows;
            let versine = |from_top: u32| {
                let from_pole = if is_upper { from_top } else { rows - from_top };
                let sine = libm::sin(0.5 * PI * f64::from(from_pole) / f64::from(rows));
                2.0 * sine * sine
            };
            let (start, end) = (versine(row), versine(row + 1));
            [start, end - start]
        };
        if share == SkyShare::AboveMean {
            let lines = weights.chunks_exact(columns as usize).zip(0..rows);
            let sums = lines.map(|(cells, row)| {
                cells.iter().map(|w| f64::from(*w)).sum::<f64>() * edge(row)[1].abs()
            });
            let mean = (sums.sum::<f64>() / (2.0 * f64::from(columns))) as f32;
            if weights.iter().any(|weight| *weight > EVEN * mean) {
                weights.iter_mut().for_each(|weight| *weight = (*weight - mean).max(0.0));
            }
        }
        let (mut cell_sums, mut row_weights) = (Vec::new(), Vec::new());
        for (row, cells) in weights.chunks_exact(columns as usize).enumerate() {
            let sum = push_sums(cells.iter().map(|w| f64::from(*w)), &mut cell_sums);
            row_weights.push(sum * edge(row as u32)[1].abs());
        }
        let mut row_sums = Vec::new();
        let sum = push_sums(row_weights.iter().copied(), &mut row_sums);
        let edges = (0..rows).map(|row| edge(row).map(|x| x as f32)).collect();
        let mean = (sum / (2.0 * f64::from(columns))) as f32;
        let (mut row_starts, mut cell_starts) = (Vec::new(), Vec::new());
        push_starts(&row_sums, &mut row_starts);
        for sums in cell_sums.chunks_exact(columns as usize + 1) {
            push_starts(sums, &mut cell_starts);
        }
        Self { share, columns, rows, row_sums, row_starts, cell_sums, cell_starts, edges, mean }
    }

    /// Returns which light rays are to find.
    pub(super) fn share(&self) -> SkyShare {
        self.share
    }

    pub(super) fn view(&self) -> TableView<'_> {
        TableView { table: self }
    }

    /// Returns the bytes that it takes.
    pub fn memory(&self) -> usize {
        (self.row_sums.len() + self.cell_sums.len()) * 4
            + (self.row_starts.len() + self.cell_starts.len()) * 2
            + self.edges.len() * 8
    }
}

/// Appends the sums of chances in proportion to weights: 0, and one for each weight; the last is 1.
/// Returns the sum of the weights.
fn push_sums(weights: impl Iterator<Item = f64> + Clone, to: &mut Vec<f32>) -> f64 {
    let count = weights.clone().count();
    let sum: f64 = weights.clone().sum();
    let shared = f64::from(UNITS) - count as f64 * f64::from(LEAST_UNITS);
    let mut before = 0.0;
    to.push(0.0);
    for (number, weight) in (1..).zip(weights) {
        before += weight;
        let share = if sum > 0.0 { before / sum } else { f64::from(number) / count as f64 };
        let units = (shared * share.min(1.0)).floor() + f64::from(number) * f64::from(LEAST_UNITS);
        let units = if number as usize == count { f64::from(UNITS) } else { units };
        to.push((units / f64::from(UNITS)) as f32);
    }
    sum
}

/// Returns the number of columns and of rows of the table of an image, and the mean luminance of
/// each cell, from the top left.
fn weights(texture: &Texture) -> (u32, u32, Vec<f32>) {
    let curve = texture.color_curve();
    let (width, height) = (texture.width(), texture.height());
    if height < LEAST_ROWS || width < 2 * LEAST_ROWS {
        // Cells that lie in one quarter of a texel, where the image is linear in u and in v.
        let parts = |size: u32, least: u32| 2 * size * least.div_ceil(2 * size);
        let columns = parts(width, 2 * LEAST_ROWS).min(MOST_COLUMNS);
        let rows = parts(height, LEAST_ROWS).min(MOST_ROWS);
        let middle = |i: u32, of: u32| (i as f32 + 0.5) / of as f32;
        let cell = |row: u32, column: u32| {
            let v = 1.0 - middle(row, rows);
            let way = equirect_direction(middle(column, columns), v);
            luminance(sample_equirect(texture, curve, way).into())
        };
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        return (columns, rows, cells.map(|(row, column)| cell(row, column)).collect());
    }
    let (columns, rows) = (width.min(MOST_COLUMNS), height.min(MOST_ROWS));
    let mut to = vec![0.0; columns as usize * rows as usize];
    let lines = |y: u32| -> Vec<f32> {
        let line: Vec<f32> =
            (0..width).map(|x| luminance(texture.decoded(x, y, curve).into())).collect();
        let at = |x: usize| line[x % line.len()];
        (0..line.len()).map(|x| spread(at(x + line.len() - 1), line[x], at(x + 1))).collect()
    };
    let (mut above, mut here) = (lines(0), lines(0));
    for y in 0..height {
        let below = lines((y + 1).min(height - 1));
        for row in covered(y, height, rows) {
            let to = &mut to[row as usize * columns as usize..][..columns as usize];
            for x in 0..width {
                let i = x as usize;
                let weight = spread(above[i], here[i], below[i]);
                for column in covered(x, width, columns) {
                    to[column as usize] += weight;
                }
            }
        }
        (above, here) = (here, below);
    }
    // Cells have the sums of their texels so far.
    let texels = (f64::from(width) / f64::from(columns)) * (f64::from(height) / f64::from(rows));
    for weight in &mut to {
        *weight = (f64::from(*weight) / texels) as f32;
    }
    (columns, rows, to)
}

/// Returns the mean of a line that is interpolated between three texels, over the middle one.
fn spread(before: f32, here: f32, after: f32) -> f32 {
    here * 0.75 + (before + after) * 0.125
}

/// Returns the cells, of `to`, that share a part with texel `i` of `of`.
fn covered(i: u32, of: u32, to: u32) -> std::ops::RangeInclusive<u32> {
    let cell = |edge: u64| (edge * u64::from(to) / u64::from(of)) as u32;
    let last = (u64::from(i) + 1) * u64::from(to) - 1;
    cell(u64::from(i))..=(last / u64::from(of)) as u32
}

/// Appends where to begin the search among sums for each of several intervals of equal length: the
/// last index whose sum is not above the interval's lower end, and the same for its upper end, 1.
fn push_starts(sums: &[f32], to: &mut Vec<u16>) {
    let count = starts(sums.len());
    let mut at = 0;
    for number in 0..=count {
        let low = number as f32 / count as f32;
        while at + 2 < sums.len() && sums[at + 1] <= low {
            at += 1;
        }
        to.push(at as u16);
    }
}

/// The number of intervals for so many sums: a power of two, so that their ends are exact.
#[inline(always)]
fn starts(sums: usize) -> usize {
    ((sums - 1) / SUMS_PER_START).next_power_of_two()
}

/// Returns the last index whose sum is not above `u`, and where `u` lies between this sum and the
/// next. `sums` begins with 0 and ends with 1; `starts` says where to search.
#[inline(always)]
fn find(sums: &[f32], starts: &[u16], u: f32) -> (usize, f32) {
    let count = starts.len() - 1;
    let interval = ((u * count as f32) as usize).min(count - 1);
    let mut at = starts[interval] as usize;
    // It is one of so many from `at` on: the next sum is above `u`, or the last.
    let mut count = starts[interval + 1] as usize + 1 - at;
    while count > 1 {
        let half = count / 2;
        // No jump: none could be foreseen.
        at = select(sums[at + half] <= u, at + half, at);
        count -= half;
    }
    (at, (u - sums[at]) / (sums[at + 1] - sums[at]))
}

/// A sampled cell, and a place in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) row: usize,
    pub(super) column: usize,
    /// Versine of the angle from +z, in the lower half from -z.
    pub(super) versine: f32,
    /// Distance from the left edge, in cells.
    pub(super) right: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableSample {
    /// The unit direction.
    pub(super) way: Vec3,
    /// Where the image shows it.
    pub(super) uv: [f32; 2],
    /// Its `pdf_solid_angle`.
    pub(super) density: f32,
}

impl TableView<'_> {
    /// Returns the luminance of the mean radiance that rays are to find.
    pub(super) fn mean(&self) -> f32 {
        self.table.mean
    }

    #[inline(always)]
    fn cells(&self, row: usize) -> &[f32] {
        let stride = self.table.columns as usize + 1;
        &self.table.cell_sums[row * stride..][..stride]
    }

    #[inline(always)]
    fn starts(&self, row: usize) -> &[u16] {
        let stride = starts(self.table.columns as usize + 1) + 1;
        &self.table.cell_starts[row * stride..][..stride]
    }

    /// Returns the number of rows and of columns.
    pub(super) fn size(&self) -> (u32, u32) {
        (self.table.rows, self.table.columns)
    }

    /// Samples a cell, and a place in it, by a point `u` of the unit square.
    #[inline(always)]
    pub(super) fn find(&self, u: [f32; 2]) -> Cell {
        let table = self.table;
        let (row, below) = find(&table.row_sums, &table.row_starts, u[1]);
        let (column, right) = find(self.cells(row), self.starts(row), u[0]);
        let [start, height] = table.edges[row];
        let versine = (start + height * below.clamp(0.0, 1.0)).clamp(0.0, 2.0);
        Cell { row, column, versine, right: right.clamp(0.0, 1.0) }
    }

    /// Returns the unit direction of a place in a cell, and where the image shows it.
    #[inline(always)]
    pub(super) fn way(
        is_upper: bool,
        column: u32,
        columns: u32,
        versine: f32,
        right: f32,
    ) -> (Vec3, [f32; 2]) {
        let sine = (versine * (2.0 - versine)).sqrt();
        let z = if is_upper { 1.0 - versine } else { versine - 1.0 };
        let across = (column as f32 + right) / columns as f32;
        let (s, c) = sin_cos_turns(0.5 - across);
        (Vec3::new(sine * c, sine * s, z), [across, elevation_v(z, sine)])
    }

    /// Samples a direction by a point `u` of the unit square.
    #[inline(always)]
    pub(super) fn sample(&self, u: [f32; 2]) -> TableSample {
        let Cell { row, column, versine, right } = self.find(u);
        let (rows, columns) = self.size();
        let is_upper = 2 * (row as u32) < rows;
        let (way, uv) = Self::way(is_upper, column as u32, columns, versine, right);
        TableSample { way, uv, density: self.density_in(row, column) }
    }

    /// Returns the row and the column of the cell that the image shows at `(u, v)`.
    #[inline(always)]
    pub(super) fn cell(&self, [u, v]: [f32; 2]) -> [usize; 2] {
        let cell = |x: f32, count: u32| ((x * count as f32) as usize).min(count as usize - 1);
        [cell(1.0 - v, self.table.rows), cell(u, self.table.columns)]
    }

    /// Returns the `pdf_solid_angle` of the direction that the image shows at `(u, v)`.
    #[inline(always)]
    pub(super) fn density(&self, uv: [f32; 2]) -> f32 {
        let [row, column] = self.cell(uv);
        self.density_in(row, column)
    }

    /// Returns the `pdf_solid_angle` of the directions in a cell.
    #[inline(always)]
    pub(super) fn density_in(&self, row: usize, column: usize) -> f32 {
        let table = self.table;
        let cells = self.cells(row);
        let chance =
            (table.row_sums[row + 1] - table.row_sums[row]) * (cells[column + 1] - cells[column]);
        let [_, height] = table.edges[row];
        chance * table.columns as f32 / (TAU * height.abs())
    }
}
