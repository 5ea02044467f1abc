//! A field while it is learned: integer sums of what pilot paths find.

use glam::Vec3;
use rayon::prelude::*;
use slo_accel::math::Bounds;
use slo_accel::math::elementary::log2;
use slo_picture::film::{Fixed, SignedFixed};

use super::field::{Field, Guide, NOWHERE};
use super::places::{Grid, Node};
use super::quads::Tally;

/// Records of a leaf above which it is divided.
const MOST_RECORDS: u64 = 2000;

/// Most leaves.
const MOST_LEAVES: usize = 1 << 20;

/// Records of earlier stages count half as much, 2 to the power of this, as those of the next.
const FORGOTTEN: u32 = 1;

/// Chances, of 256, that directions may be taken from the field with.
const SHARES: [u8; 6] = [0, 64, 128, 176, 216, 240];

/// What a pilot path found where it left a rough lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Where.
    pub place: Vec3,
    /// [Packed](super::pack) direction that the light came from.
    pub toward: u32,
    /// The light that the lobe made of it, over the density of the direction.
    pub value: f32,
    /// Densities of the direction, per solid angle: of the lobe,
    pub own: f32,
    /// of the field that the path was guided by; 0 if there was none,
    pub field: f32,
    /// and of both together.
    pub mixed: f32,
    /// Whether the lobe is diffuse.
    pub is_diffuse: bool,
}

/// Learns a field from the records of stage after stage.
#[derive(Clone, Debug, Default)]
pub struct Learning {
    grid: Option<Grid>,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

#[derive(Clone, Debug, Default)]
struct Leaf {
    count: u64,
    tally: Tally,
    fits: [Fit; 2],
}

/// How well each of the [`SHARES`] fits the light, the larger the better.
#[derive(Clone, Copy, Debug, Default)]
struct Fit([i64; SHARES.len()]);

impl Learning {
    /// Learns from the records of a stage. Changes their order. The result does not depend on the order
    /// that they come in.
    pub fn learn(&mut self, records: &mut [Record]) {
        if records.is_empty() && self.grid.is_none() {
            return;
        }
        let bounds = || Bounds::of_points(records.iter().map(|record| record.place));
        let grid = *self.grid.get_or_insert_with(|| Grid::new(bounds()));
        if self.nodes.is_empty() {
            self.nodes.push(Node::leaf(0));
            self.leaves.push(Leaf::default());
        }
        for leaf in &mut self.leaves {
            leaf.weaken(FORGOTTEN);
        }
        let mut parts = vec![Part { node: 0, records }];
        let mut done = Vec::new();
        while let Some(Part { node, records }) = parts.pop() {
            if self.nodes[node].axis() == 3 {
                self.divide(grid, node, records);
            }
            let Node { split, .. } = self.nodes[node];
            let (axis, number) = (self.nodes[node].axis(), self.nodes[node].number());
            if axis == 3 {
                done.push((number, records));
                continue;
            }
            let first = partition(records, |record| grid.steps(record.place)[axis] < split);
            let (first, second) = records.split_at_mut(first);
            parts.push(Part { node: number as usize, records: first });
            parts.push(Part { node: number as usize + 1, records: second });
        }
        done.sort_unstable_by_key(|(number, _)| *number);
        self.leaves.par_iter_mut().zip(done).for_each(|(leaf, (_, records))| leaf.add(records));
    }

    /// Divides a leaf where the records of the new stage, and those of earlier ones, are too many.
    fn divide(&mut self, grid: Grid, node: usize, records: &[Record]) {
        let number = self.nodes[node].number() as usize;
        let count = self.leaves[number].count + records.len() as u64;
        if count <= MOST_RECORDS || self.leaves.len() >= MOST_LEAVES {
            return;
        }
        let Some((axis, split)) = longest(grid, records) else { return };
        let leaf = &mut self.leaves[number];
        leaf.count /= 2;
        leaf.weaken(1);
        let second = leaf.clone();
        let first = self.nodes.len() as u32;
        self.nodes[node] = Node::divided(axis, split, first);
        self.nodes.push(Node::leaf(number as u32));
        self.nodes.push(Node::leaf(self.leaves.len() as u32));
        self.leaves.push(second);
    }

    /// Returns the field as it is known now.
    pub fn field(&self) -> Field {
        let mut quads = Vec::new();
        let guide = |leaf: &Leaf| {
            let share = leaf.fits.map(Fit::share);
            if leaf.tally.total() == 0 || share == [0; 2] {
                return Guide { root: NOWHERE, share: [0; 2] };
            }
            let root = quads.len() as u32;
            leaf.tally.freeze(&mut quads);
            Guide { root, share }
        };
        let guides = self.leaves.iter().map(guide).collect();
        let grid = self.grid.unwrap_or(Grid { least: Vec3::ZERO, scale: Vec3::ONE });
        Field { grid, nodes: self.nodes.clone(), guides, quads }
    }
}

/// Records of a node.
struct Part<'a> {
    node: usize,
    records: &'a mut [Record],
}

/// Puts the records for which `is_first` holds before the others, and returns their number.
fn partition(records: &mut [Record], is_first: impl Fn(&Record) -> bool) -> usize {
    let mut first = 0;
    for i in 0..records.len() {
        if is_first(&records[i]) {
            records.swap(first, i);
            first += 1;
        }
    }
    first
}

/// Returns the axis along which records are spread most, and where their middle is: the step at which
/// the second half begins. `None` if all are in one place.
fn longest(grid: Grid, records: &[Record]) -> Option<(usize, u32)> {
    let (mut sum, mut squares) = ([0u64; 3], [0u128; 3]);
    for record in records {
        let steps = grid.steps(record.place);
        for axis in 0..3 {
            sum[axis] += u64::from(steps[axis]);
            squares[axis] += u128::from(steps[axis]).pow(2);
        }
    }
    let count = records.len() as u128;
    // The variance of all lengths, not of steps, times the square of their number.
    let spread = |axis: usize| {
        let variance = count * squares[axis] - u128::from(sum[axis]).pow(2);
        variance as f64 / (f64::from(grid.scale[axis]) * f64::from(grid.scale[axis]))
    };
    let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b)))?;
    let split = (u128::from(sum[axis]).div_ceil(count.max(1))) as u32;
    let is_apart = |steps: u32| steps >= split;
    let second = records.iter().filter(|r| is_apart(grid.steps(r.place)[axis])).count();
    (second > 0 && second < records.len()).then_some((axis, split))
}

impl Leaf {
    fn weaken(&mut self, bits: u32) {
        self.tally.weaken(bits);
        for fit in &mut self.fits {
            fit.0 = fit.0.map(|fit| fit >> bits);
        }
    }

    fn add(&mut self, records: &[Record]) {
        self.count += records.len() as u64;
        for record in records {
            self.tally.add(record.toward, Fixed::clamped(record.value).units());
            self.fits[usize::from(record.is_diffuse)].add(record);
        }
        self.tally.refine();
    }
}

impl Fit {
    /// Adds a record: the logarithm of each share's density, weighted with its light. Its sum is largest
    /// where the density is nearest to the light (Müller, "Practical Path Guiding in Production", 2019).
    fn add(&mut self, record: &Record) {
        if record.field == 0.0 {
            return;
        }
        let value = record.value.min(MOST_VALUE);
        for (fit, share) in self.0.iter_mut().zip(SHARES) {
            let share = f32::from(share) * (1.0 / 256.0);
            let mixed = record.own + share * (record.field - record.own);
            let gain = log2((mixed / record.mixed).max(f32::MIN_POSITIVE));
            *fit = fit.saturating_add(SignedFixed::clamped(value * gain).units());
        }
    }

    /// Returns the share that fits best; half if nothing is known.
    fn share(self) -> u8 {
        if self.0 == [0; SHARES.len()] {
            return 128;
        }
        let best = (0..SHARES.len()).max_by_key(|&i| (self.0[i], std::cmp::Reverse(i)));
        SHARES[best.unwrap_or(0)]
    }
}

/// Most light of a record where shares are compared, so that products stay in range.
const MOST_VALUE: f32 = 512.0;

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::super::direction::{direction, pack};
    use super::*;

    /// Places on two walls; light on each comes from a spot of its own.
    fn records(seed: u64, count: usize, field: Option<&Field>) -> Vec<Record> {
        let mut rng = StdRng::seed_from_u64(seed);
        let uniform = 0.25 * std::f32::consts::FRAC_1_PI;
        let mut record = || {
            let wall = f32::from(rng.random_bool(0.5));
            let place = Vec3::new(wall * 4.0, rng.random_range(-3.0..3.0), rng.random());
            let toward = pack(direction([rng.random(), rng.random()]));
            let is_lit = (toward >> 28) as f32 == 3.0 + 8.0 * wall;
            let found = field.map_or(0.0, |field| field.density(field.guide(place).word(), toward));
            Record {
                place,
                toward,
                value: if is_lit { 2.0 } else { 0.01 },
                own: uniform,
                field: found,
                mixed: uniform,
                is_diffuse: rng.random(),
            }
        };
        (0..count).map(|_| record()).collect()
    }

    #[test]
    fn light_is_found_again_where_it_was() {
        let mut learning = Learning::default();
        for stage in 0..6 {
            let field = learning.field();
            let mut records = records(stage, 4000 << stage, (stage > 0).then_some(&field));
            learning.learn(&mut records);
        }
        let field = learning.field();
        assert!(field.sizes()[0] > 30, "{:?}", field.sizes());
        for wall in [0.0, 1.0] {
            let guide = field.guide(Vec3::new(4.0 * wall, 0.1, 0.6));
            let lit = direction([(3.5 + 8.0 * wall) / 16.0, 0.3]);
            let dark = direction([0.5, 0.3]);
            let [lit, dark] = [lit, dark].map(|d| field.density(guide.word(), pack(d)));
            assert!(lit > 20.0 * dark, "{wall}: {lit} {dark}");
            assert!(guide.share(true) > 0.6, "{}", guide.share(true));
        }
    }

    #[test]
    fn the_order_of_records_does_not_matter() {
        let mut fields = [false, true].map(|is_reversed| {
            let mut learning = Learning::default();
            for stage in 0..4 {
                let field = learning.field();
                let mut records = records(stage, 5000 << stage, (stage > 0).then_some(&field));
                if is_reversed {
                    records.reverse();
                }
                learning.learn(&mut records);
            }
            learning.field()
        });
        let [first, second] = &mut fields;
        assert_eq!(first, second);
    }

    #[test]
    fn records_in_one_place_end() {
        let mut learning = Learning::default();
        let one = Record {
            place: Vec3::ONE,
            toward: 7,
            value: 1.0,
            own: 1.0,
            field: 0.0,
            mixed: 1.0,
            is_diffuse: true,
        };
        learning.learn(&mut [one; 10_000]);
        learning.learn(&mut []);
        assert_eq!(learning.field().sizes()[0], 1);
    }

    #[test]
    fn rays_are_not_guided_where_light_comes_from_everywhere() {
        let mut learning = Learning::default();
        for stage in 0..4 {
            let field = learning.field();
            let mut records = records(stage, 8000 << stage, (stage > 0).then_some(&field));
            for record in &mut records {
                // A lobe that fits the light already.
                let is_lit = record.value == 2.0;
                record.own = if is_lit { 1.0 } else { 0.005 };
            }
            learning.learn(&mut records);
        }
        assert!(learning.field().guided()[1] < 0.4, "{:?}", learning.field().guided());
    }
}
