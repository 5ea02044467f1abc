//! A map of photons: finds those near a point.
//!
//! The photons of a slab of time are sorted along a Morton curve. Sixteen neighbours are a leaf,
//! sixteen leaves a node, and so on, so there are no pointers, and the boxes of a node's children
//! are one vector. The tree fits queries of every radius, unlike a grid.

use glam::Vec3;
use slo_accel::math::Bounds;

use super::counts::PhotonCounts;

/// Children of a node, and photons of a leaf.
const WIDE: usize = 16;

/// Most levels: 16^8 photons have as many numbers.
const MOST_LEVELS: usize = 8;

/// A photon where it ended: light that came from a lamp through sharp lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where it is, in render space.
    pub position: Vec3,
    /// Its power, W, if its slab had one light path.
    pub power: Vec3,
    /// Density of the light path where it left the lamp, per area and projected solid angle;
    /// infinite for lamps that no ray can hit.
    pub density: f32,
    /// Packed unit direction toward where it came from; see
    /// [`receiver`](crate::shading::light::receiver).
    pub toward: u32,
    /// Packed geometric normal of the surface that it is on.
    pub normal: u32,
    /// Index of the lamp.
    pub light: u32,
    /// Number of sharp surfaces on its way.
    pub bounces: u32,
}

/// Where the photons of a leaf are. Those that a leaf lacks are nowhere.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Leaf([[f32; WIDE]; 3]);

/// The boxes of children. Children that a node lacks are empty.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    min: [[f32; WIDE]; 3],
    max: [[f32; WIDE]; 3],
}

/// The photons of one slab of time.
#[derive(Clone, Debug, Default)]
pub struct Slab {
    /// In the order of the curve.
    photons: Vec<Photon>,
    leaves: Vec<Leaf>,
    /// The nodes above the leaves, then those above them, up to one.
    levels: Vec<Vec<Node>>,
}

impl Slab {
    /// Sorts photons. The result depends on their order only where two lie at the same place.
    pub fn new(photons: &[Photon]) -> Self {
        let bounds = Bounds::of_points(photons.iter().map(|photon| photon.position));
        let mut order: Vec<(u64, u32)> =
            photons.iter().map(|photon| morton(photon.position, bounds)).zip(0..).collect();
        order.sort_unstable();
        let photons: Vec<Photon> = order.iter().map(|(_, i)| photons[*i as usize]).collect();
        let leaves: Vec<Leaf> = photons.chunks(WIDE).map(leaf).collect();
        let boxes = photons
            .chunks(WIDE)
            .map(|leaf| Bounds::of_points(leaf.iter().map(|photon| photon.position)));
        let mut boxes: Vec<Bounds> = boxes.collect();
        let mut levels = Vec::new();
        while !boxes.is_empty() {
            levels.push(boxes.chunks(WIDE).map(node).collect());
            let about = |boxes: &[Bounds]| boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
            boxes = boxes.chunks(WIDE).map(about).collect();
            if boxes.len() == 1 {
                break;
            }
        }
        Self { photons, leaves, levels }
    }

    /// The photons.
    pub fn photons(&self) -> &[Photon] {
        &self.photons
    }

    /// Calls `found` with each photon less than `radius` away from a point, in the same order for
    /// all instruction sets.
    #[inline(always)]
    pub fn near(&self, point: Vec3, radius: f32, mut found: impl FnMut(&Photon)) {
        let square = radius * radius;
        let Some(top) = self.levels.len().checked_sub(1) else { return };
        let mut stack = [(0u32, 0u32); WIDE * MOST_LEVELS];
        let mut waiting = 1;
        stack[0] = (top as u32, 0);
        while waiting > 0 {
            waiting -= 1;
            let (level, index) = stack[waiting];
            let mut children = self.levels[level as usize][index as usize].near(point, square);
            while children != 0 {
                let child = index * WIDE as u32 + children.trailing_zeros();
                children &= children - 1;
                if level > 0 {
                    stack[waiting] = (level - 1, child);
                    waiting += 1;
                    continue;
                }
                let mut photons = self.leaves[child as usize].near(point, square);
                while photons != 0 {
                    let photon = child * WIDE as u32 + photons.trailing_zeros();
                    photons &= photons - 1;
                    found(&self.photons[photon as usize]);
                }
            }
        }
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        let nodes: usize = self.levels.iter().map(Vec::len).sum();
        size_of_val(&self.photons[..]) + size_of_val(&self.leaves[..]) + nodes * size_of::<Node>()
    }
}

impl Leaf {
    /// Returns which photons are nearer to a point than the root of `square`, as bits.
    #[inline(always)]
    fn near(&self, point: Vec3, square: f32) -> u32 {
        let [x, y, z] = &self.0;
        let mut is_near = [0u32; WIDE];
        for i in 0..WIDE {
            let [dx, dy, dz] = [x[i] - point.x, y[i] - point.y, z[i] - point.z];
            is_near[i] = u32::from(dx * dx + dy * dy + dz * dz < square);
        }
        bits(&is_near)
    }
}

impl Node {
    /// Returns which boxes come nearer to a point than the root of `square`, as bits.
    #[inline(always)]
    fn near(&self, point: Vec3, square: f32) -> u32 {
        let Self { min, max } = self;
        let mut is_near = [0u32; WIDE];
        for i in 0..WIDE {
            let mut distance = 0.0;
            for (axis, p) in [point.x, point.y, point.z].into_iter().enumerate() {
                let d = (min[axis][i] - p).max(p - max[axis][i]).max(0.0);
                distance += d * d;
            }
            is_near[i] = u32::from(distance < square);
        }
        bits(&is_near)
    }
}

#[inline(always)]
fn bits(flags: &[u32; WIDE]) -> u32 {
    let mut bits = 0;
    for (i, flag) in flags.iter().enumerate() {
        bits |= flag << i;
    }
    bits
}

fn leaf(photons: &[Photon]) -> Leaf {
    let at = |axis: usize, i: usize| photons.get(i).map_or(f32::INFINITY, |p| p.position[axis]);
    Leaf(std::array::from_fn(|axis| std::array::from_fn(|i| at(axis, i))))
}

fn node(boxes: &[Bounds]) -> Node {
    let of = |i: usize| boxes.get(i).copied().unwrap_or(Bounds::EMPTY);
    Node {
        min: std::array::from_fn(|axis| std::array::from_fn(|i| of(i).min[axis])),
        max: std::array::from_fn(|axis| std::array::from_fn(|i| of(i).max[axis])),
    }
}

/// Returns the place of a point within bounds on a Morton curve of 2^21 steps an axis.
fn morton(point: Vec3, bounds: Bounds) -> u64 {
    let step = |axis: usize| {
        let size = (bounds.max[axis] - bounds.min[axis]).max(f32::MIN_POSITIVE);
        let share = ((point[axis] - bounds.min[axis]) / size).clamp(0.0, 1.0);
        (f64::from(share) * f64::from((1 << 21) - 1)) as u64
    };
    spread(step(0)) | spread(step(1)) << 1 | spread(step(2)) << 2
}

/// Puts two zeros between the lowest 21 bits of a number.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// The photons of one pass.
#[derive(Clone, Debug)]
pub struct PhotonMap {
    slabs: Vec<Slab>,
    /// Number of light paths of each slab.
    paths: f32,
    /// Radius as a share of that of the first pass.
    radius: f32,
}

impl PhotonMap {
    /// A map of slabs that divide the shutter evenly; `paths` light paths were sent in each.
    pub fn new(slabs: Vec<Slab>, paths: f32, radius: f32) -> Self {
        Self { slabs, paths, radius }
    }

    /// Returns the photons of a time of the shutter, in `[0, 1]`.
    #[inline(always)]
    pub fn slab(&self, time: f32) -> &Slab {
        let slab = (time * self.slabs.len() as f32) as usize;
        &self.slabs[slab.min(self.slabs.len() - 1)]
    }

    /// Number of slabs.
    #[inline(always)]
    pub fn slabs(&self) -> u32 {
        self.slabs.len() as u32
    }

    /// Number of light paths that were sent at any time of the shutter.
    #[inline(always)]
    pub fn paths(&self) -> f32 {
        self.paths
    }

    /// Radius of queries, as a share of that of the first pass.
    #[inline(always)]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        self.slabs.iter().map(Slab::memory).sum()
    }

    /// Number of photons.
    pub fn len(&self) -> usize {
        self.slabs.iter().map(|slab| slab.photons.len()).sum()
    }

    /// Whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The maps of passes that follow each other.
#[derive(Clone, Debug, Default)]
pub struct PhotonMaps {
    /// The first pass.
    pub first: u32,
    /// The maps of that pass and the next ones.
    pub maps: Vec<PhotonMap>,
}

impl PhotonMaps {
    /// What these took.
    pub fn counts(&self) -> PhotonCounts {
        let of = |map: &PhotonMap| PhotonCounts {
            passes: 1,
            paths: (f64::from(map.paths) * map.slabs.len() as f64).round() as u64,
            photons: map.len() as u64,
            records: 0,
            memory: 0,
        };
        let memory = self.maps.iter().map(PhotonMap::memory).sum();
        let mut counts = PhotonCounts { memory, ..PhotonCounts::default() };
        self.maps.iter().for_each(|map| counts += of(map));
        counts
    }

    /// Returns the map of a pass, if it is one of these.
    #[inline(always)]
    pub fn get(&self, pass: u32) -> Option<&PhotonMap> {
        self.maps.get(pass.wrapping_sub(self.first) as usize)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use slo_accel::{Isa, Lanewise};

    use super::*;

    fn photon(position: Vec3, light: u32) -> Photon {
        Photon { position, power: Vec3::ONE, density: 1.0, toward: 0, normal: 0, light, bounces: 1 }
    }

    struct Count<'a>(&'a Slab, Vec3, f32);

    impl Lanewise for Count<'_> {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run(self) -> Vec<u32> {
            let mut all = Vec::new();
            self.0.near(self.1, self.2, |photon| all.push(photon.light));
            all
        }
    }

    #[test]
    fn queries_find_what_is_near_and_nothing_else() {
        let mut rng = StdRng::seed_from_u64(7);
        for count in [0, 1, 15, 16, 17, 255, 256, 257, 5000] {
            let place = |rng: &mut StdRng| {
                // Half of them in a small spot.
                let size = if rng.random_bool(0.5) { 0.02 } else { 1.0 };
                Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
            };
            let photons: Vec<Photon> = (0..count).map(|i| photon(place(&mut rng), i)).collect();
            let slab = Slab::new(&photons);
            assert_eq!(slab.photons().len(), count as usize);
            for radius in [0.0, 0.003, 0.1, 0.7, 10.0] {
                let point = place(&mut rng);
                let is_near = |p: &&Photon| (p.position - point).length_squared() < radius * radius;
                let mut expected: Vec<u32> =
                    photons.iter().filter(is_near).map(|p| p.light).collect();
                let found = Isa::Portable.run(Count(&slab, point, radius));
                for isa in Isa::available() {
                    assert_eq!(isa.run(Count(&slab, point, radius)), found, "{isa}");
                }
                let mut found = found;
                found.sort_unstable();
                expected.sort_unstable();
                assert_eq!(found, expected, "{count} photons, radius {radius}");
            }
        }
    }

    #[test]
    fn photons_at_one_place_are_all_found() {
        let photons: Vec<Photon> = (0..1000).map(|i| photon(Vec3::ONE, i)).collect();
        let slab = Slab::new(&photons);
        assert_eq!(Isa::best().run(Count(&slab, Vec3::ONE, 1e-3)).len(), 1000);
    }

    #[test]
    fn slabs_divide_the_shutter() {
        let slab = |light| Slab::new(&[photon(Vec3::ZERO, light)]);
        let map = PhotonMap::new((0..4).map(slab).collect(), 1.0, 1.0);
        let at = |time| map.slab(time).photons()[0].light;
        assert_eq!([0.0, 0.24, 0.26, 0.99, 1.0].map(at), [0, 0, 1, 3, 3]);
        assert_eq!(map.len(), 4);
    }
}
