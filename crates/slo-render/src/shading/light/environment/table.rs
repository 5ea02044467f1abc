//! How an image of the sky is sampled: an even density in each cell of a grid.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use glam::Vec3;

use crate::shading::light::lamp::luminance;
use crate::shading::texture::{equirect_direction, equirect_uv, sample_equirect};
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

/// The least chance of a row, and of a cell in its row, in units. It keeps light from being lost
/// where the table says that it is dark.
const LEAST_UNITS: u32 = 16;

/// The density of an equirectangular image, by its luminance times its solid angle.
#[derive(Clone, Debug)]
pub struct SkyTable {
    columns: u32,
    rows: u32,
    /// Sum of the chances of the rows above each row, from the top, and 1.
    row_sums: Vec<f32>,
    /// For each row, the sum of the chances of the cells to the left of each cell, and 1.
    cell_sums: Vec<f32>,
    /// For each row, its upper edge and its lower edge minus this: versines of the angle from +z,
    /// in the lower half from -z.
    edges: Vec<[f32; 2]>,
    /// Luminance of the mean radiance.
    mean: f32,
}

/// A [`SkyTable`] as loops use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableView<'a> {
    table: &'a SkyTable,
}

impl SkyTable {
    /// Makes the table of an image.
    pub fn new(texture: &Texture) -> Self {
        let (columns, rows, weights) = weights(texture);
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
        let (mut cell_sums, mut row_weights) = (Vec::new(), Vec::new());
        for (row, cells) in weights.chunks_exact(columns as usize).enumerate() {
            let sum = push_sums(cells.iter().map(|w| f64::from(*w)), &mut cell_sums);
            row_weights.push(sum * edge(row as u32)[1].abs());
        }
        let mut row_sums = Vec::new();
        let sum = push_sums(row_weights.iter().copied(), &mut row_sums);
        let edges = (0..rows).map(|row| edge(row).map(|x| x as f32)).collect();
        let mean = (sum / (2.0 * f64::from(columns))) as f32;
        Self { columns, rows, row_sums, cell_sums, edges, mean }
    }

    pub(super) fn view(&self) -> TableView<'_> {
        TableView { table: self }
    }

    /// Returns the bytes that it takes.
    pub fn memory(&self) -> usize {
        (self.row_sums.len() + self.cell_sums.len()) * 4 + self.edges.len() * 8
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

/// Returns the last index whose sum is not above `u`, and where `u` lies between this sum and the
/// next. `sums` begins with 0 and ends with 1.
#[inline(always)]
fn find(sums: &[f32], u: f32) -> (usize, f32) {
    let last = sums.len() - 2;
    let mut at = 0;
    let mut step = sums.len().next_power_of_two() / 2;
    while step > 0 {
        let next = (at + step).min(last);
        at = if sums[next] <= u { next } else { at };
        step /= 2;
    }
    (at, (u - sums[at]) / (sums[at + 1] - sums[at]))
}

impl TableView<'_> {
    /// Returns the luminance of the mean radiance.
    pub(super) fn mean(&self) -> f32 {
        self.table.mean
    }

    #[inline(always)]
    fn cells(&self, row: usize) -> &[f32] {
        let stride = self.table.columns as usize + 1;
        &self.table.cell_sums[row * stride..][..stride]
    }

    /// Samples a direction by a point `u` of the unit square.
    #[inline(always)]
    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3 {
        let table = self.table;
        let (row, below) = find(&table.row_sums, u[1]);
        let (column, right) = find(self.cells(row), u[0]);
        let [start, height] = table.edges[row];
        let versine = (start + height * below.clamp(0.0, 1.0)).clamp(0.0, 2.0);
        let sine = (versine * (2.0 - versine)).sqrt();
        let z = if 2 * row < table.rows as usize { 1.0 - versine } else { versine - 1.0 };
        let across = (column as f32 + right.clamp(0.0, 1.0)) / table.columns as f32;
        let (s, c) = sin_cos_turns(0.5 - across);
        Vec3::new(sine * c, sine * s, z)
    }

    /// Returns the `pdf_solid_angle` of a direction.
    #[inline(always)]
    pub(super) fn density(&self, way: Vec3) -> f32 {
        let [u, v] = equirect_uv(way.to_array());
        let table = self.table;
        let cell = |x: f32, count: u32| ((x * count as f32) as usize).min(count as usize - 1);
        let (column, row) = (cell(u, table.columns), cell(1.0 - v, table.rows));
        let cells = self.cells(row);
        let chance =
            (table.row_sums[row + 1] - table.row_sums[row]) * (cells[column + 1] - cells[column]);
        let [_, height] = table.edges[row];
        chance * table.columns as f32 / (TAU * height.abs())
    }
}
