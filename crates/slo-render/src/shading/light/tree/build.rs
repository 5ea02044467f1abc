//! Builds the tree from the top: a node begins with all its lights in one range, and divides ranges
//! until it has 16.

use std::ops::Range;

use glam::Vec3;

use super::super::bounds::LightBounds;
use super::LightTree;
use super::node::Node;
use super::sums::WIDTH;

/// Levels from which on ranges are halved, so that no way down is longer than 16 nodes.
const HALVING_LEVEL: u32 = 8;

/// Intervals of an axis that a division is chosen from.
const BINS: usize = 16;

/// Lights of a range from which on only the longest axis is divided.
const MANY: usize = 4096;

/// Builds the tree of lights.
pub(super) fn build(lights: &[LightBounds]) -> LightTree {
    if lights.is_empty() {
        return LightTree::default();
    }
    let mut order: Vec<u32> = (0..lights.len() as u32).collect();
    // Lights of different classes never come into one range; see `Class`.
    order.sort_by_key(|&light| class(&lights[light as usize]));
    let mut builder = Builder {
        lights,
        tree: LightTree { nodes: Vec::new(), paths: vec![0; lights.len()] },
        spare: Vec::new(),
    };
    let classes = order.chunk_by(|&a, &b| class(&lights[a as usize]) == class(&lights[b as usize]));
    let mut start = 0;
    let mut ranges = Vec::new();
    for lights in classes {
        ranges.push(start..start + lights.len());
        start += lights.len();
    }
    builder.node(&mut order, ranges, 0, 0);
    builder.tree
}

/// Lights whose estimates have different formulas: distant lights, and whether light falls off.
fn class(light: &LightBounds) -> (bool, bool) {
    (light.is_distant, light.falls_off)
}

struct Builder<'a> {
    lights: &'a [LightBounds],
    tree: LightTree,
    /// Working memory.
    spare: Vec<u32>,
}

impl Builder<'_> {
    /// Adds a node over ranges of `order`, `level` nodes below the root, at the end of `path`.
    /// Returns its number.
    fn node(&mut self, order: &mut [u32], ranges: Vec<Range<usize>>, level: u32, path: u64) -> u32 {
        let number = self.tree.nodes.len() as u32;
        let mut node = Node::empty();
        self.tree.nodes.push(Node::empty());
        let ranges = self.divide(order, ranges, level);
        let count = ranges.len();
        for (k, range) in ranges.into_iter().enumerate() {
            let path = path | (k as u64) << (4 * level);
            let lights = &mut order[range];
            node.set(k, &self.about(lights));
            if let [light] = *lights {
                node.set_light(k, light);
                self.tree.paths[light as usize] = path;
            } else {
                let all = 0..lights.len();
                let child = self.node(lights, vec![all], level + 1, path);
                node.set_node(k, child);
            }
        }
        node.count_classes(count);
        self.tree.nodes[number as usize] = node;
        number
    }

    /// Returns the bounds of several lights.
    fn about(&self, lights: &[u32]) -> LightBounds {
        let mut all = lights.iter().map(|&light| self.lights[light as usize]);
        match lights {
            [light] => self.lights[*light as usize],
            _ => LightBounds::about(&mut all).unwrap_or(self.lights[0]),
        }
    }

    /// Divides ranges until there are [`WIDTH`], or each has one light.
    fn divide(
        &mut self,
        order: &mut [u32],
        ranges: Vec<Range<usize>>,
        level: u32,
    ) -> Vec<Range<usize>> {
        if order.len() <= WIDTH {
            return (0..order.len()).map(|i| i..i + 1).collect();
        }
        let weight = |builder: &Self, order: &[u32], range: &Range<usize>| {
            let count = range.len() as f64;
            let lights = &order[range.clone()];
            if level < HALVING_LEVEL {
                builder.spread(lights) * (1.0 + 1e-3 * count)
            } else {
                count
            }
        };
        let mut ranges: Vec<_> = ranges.into_iter().map(|r| (weight(self, order, &r), r)).collect();
        while ranges.len() < WIDTH {
            let divisible = ranges.iter().enumerate().filter(|(_, (_, r))| r.len() > 1);
            let heaviest = divisible
                .max_by(|(_, (a, r)), (_, (b, s))| a.total_cmp(b).then(r.len().cmp(&s.len())));
            let Some(i) = heaviest.map(|(i, _)| i) else { break };
            let range = ranges[i].1.clone();
            let lights = &mut order[range.clone()];
            let middle = if level < HALVING_LEVEL { self.best_division(lights) } else { None };
            let middle = range.start + middle.unwrap_or_else(|| self.halve(lights));
            let parts = [range.start..middle, middle..range.end];
            let parts = parts.map(|part| (weight(self, order, &part), part));
            ranges.splice(i..=i, parts);
        }
        ranges.into_iter().map(|(_, range)| range).collect()
    }

    /// Returns how much is gained if these lights are told apart: their energy times the square of
    /// the diagonal of their box.
    fn spread(&self, lights: &[u32]) -> f64 {
        let mut all = Bin::EMPTY;
        for &light in lights {
            all.add(&self.lights[light as usize]);
        }
        all.cost()
    }

    /// Sorts lights by the middle of their boxes along the longest axis, and returns half their
    /// number.
    fn halve(&self, lights: &mut [u32]) -> usize {
        let (min, max) = self.middles(lights);
        let axis = longest(max - min);
        let key = |light: &u32| middle(&self.lights[*light as usize])[axis];
        let half = lights.len() / 2;
        lights.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        half
    }

    /// Returns the box about the middles of the boxes of lights.
    fn middles(&self, lights: &[u32]) -> (Vec3, Vec3) {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &light in lights {
            let middle = middle(&self.lights[light as usize]);
            (min, max) = (min.min(middle), max.max(middle));
        }
        (min, max)
    }

    /// Divides lights where the sum of the costs of the two parts is least, and returns the number
    /// of the first part; `None` if all lie in one place.
    fn best_division(&mut self, lights: &mut [u32]) -> Option<usize> {
        let (min, max) = self.middles(lights);
        let size = max - min;
        let mut best: Option<(f64, usize, usize)> = None;
        for axis in 0..3 {
            let is_tried = lights.len() < MANY || axis == longest(size);
            if !is_tried || size[axis].partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
                continue;
            }
            let mut bins = [Bin::EMPTY; BINS];
            for &light in lights.iter() {
                let light = &self.lights[light as usize];
                bins[bin(light, axis, min, size)].add(light);
            }
            let mut after = [Bin::EMPTY; BINS];
            for i in (0..BINS - 1).rev() {
                after[i] = after[i + 1].and(&bins[i + 1]);
            }
            let mut before = Bin::EMPTY;
            for i in 0..BINS - 1 {
                before = before.and(&bins[i]);
                if before.count == 0.0 || after[i].count == 0.0 {
                    continue;
                }
                let cost = before.cost() + after[i].cost();
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, i));
                }
            }
        }
        let (_, axis, last) = best?;
        self.spare.clear();
        let mut first = 0;
        for i in 0..lights.len() {
            let light = lights[i];
            if bin(&self.lights[light as usize], axis, min, size) <= last {
                lights[first] = light;
                first += 1;
            } else {
                self.spare.push(light);
            }
        }
        lights[first..].copy_from_slice(&self.spare);
        Some(first)
    }
}

/// Returns the middle of a light's box.
fn middle(light: &LightBounds) -> Vec3 {
    (light.min + light.max) * 0.5
}

/// Returns the number of the longest axis of a box.
fn longest(size: Vec3) -> usize {
    size.max_position()
}

/// Returns the number of the interval of an axis in which a light lies.
fn bin(light: &LightBounds, axis: usize, min: Vec3, size: Vec3) -> usize {
    let share = (middle(light)[axis] - min[axis]) / size[axis];
    ((share * BINS as f32) as usize).min(BINS - 1)
}

/// Sums over lights.
#[derive(Clone, Copy)]
struct Bin {
    count: f64,
    energy: f64,
    min: Vec3,
    max: Vec3,
    /// Sum of the axes of lights that do not shine all round, turned upward if they are two-sided.
    axes: Vec3,
}

impl Bin {
    const EMPTY: Self = Self {
        count: 0.0,
        energy: 0.0,
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        axes: Vec3::ZERO,
    };

    fn add(&mut self, light: &LightBounds) {
        self.count += 1.0;
        self.energy += f64::from(light.energy);
        self.min = self.min.min(light.min);
        self.max = self.max.max(light.max);
        let axis = if light.two_sided && light.axis.z < 0.0 { -light.axis } else { light.axis };
        self.axes += if light.spread < std::f32::consts::PI { axis } else { Vec3::ZERO };
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            energy: self.energy + other.energy,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            axes: self.axes + other.axes,
        }
    }

    /// The energy, times the square of the diagonal of the box, times the solid angle into which
    /// the lights shine, roughly: as it grows from a half of all directions to all of them.
    fn cost(&self) -> f64 {
        let scattered = 1.0 - f64::from(self.axes.length()) / self.count;
        self.energy * (1.0 + scattered) * f64::from((self.max - self.min).length_squared())
    }
}
