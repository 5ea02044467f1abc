//! The order in which the rays of a batch are prepared, so that sixteen of them go the same way.

#[cfg(target_arch = "aarch64")]
pub(crate) mod neon;
#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;

use crate::rays::{LANES, Rays};
use crate::simd::lanes_of;

/// What ordering and choosing rays is made of, for one instruction set; here in plain Rust.
pub(crate) trait Choosing {
    /// The set of those of sixteen values that equal `value`.
    ///
    /// # Safety
    /// The CPU has the instruction set.
    #[inline(always)]
    unsafe fn lanes_with(values: &[u8; LANES], value: u8) -> u32 {
        let mut set = 0;
        for (lane, &other) in values.iter().enumerate() {
            set |= u32::from(other == value) << lane;
        }
        set
    }

    /// Writes `first + lane` for each lane of a set, in order.
    ///
    /// # Safety
    /// The CPU has the instruction set; `to` is writable for sixteen values.
    #[inline(always)]
    unsafe fn compress_lanes(first: u32, set: u32, to: *mut u32) {
        for (i, lane) in lanes_of(set).enumerate() {
            // SAFETY: a set has at most sixteen lanes.
            unsafe { *to.add(i) = first + lane as u32 };
        }
    }

    /// Writes the numbers of a set, of sixteen, in their order.
    ///
    /// # Safety
    /// The CPU has the instruction set; `to` is writable for sixteen values.
    #[inline(always)]
    unsafe fn compress(from: &[f32; LANES], set: u32, to: *mut f32) {
        for (i, lane) in lanes_of(set).enumerate() {
            // SAFETY: a set has at most sixteen lanes.
            unsafe { *to.add(i) = from[lane] };
        }
    }
}

/// Plain Rust.
pub(crate) struct Portable;

impl Choosing for Portable {}

/// Sixteens of a batch's rays.
#[derive(Debug, Default)]
pub(crate) struct Order {
    sixteens: Vec<Place>,
    ways: Vec<u8>,
    bins: Bins,
}

/// Rays that do not go the same way as their neighbours, binned by way.
#[derive(Debug, Default)]
struct Bins {
    /// Entries for each way: as many as the batch has rays, and [`LANES`] more.
    room: usize,
    /// Indices of the rays in the batch, by way.
    indices: Vec<u32>,
    /// The rays as columns of [`Numbers`], by way.
    numbers: Vec<f32>,
}

/// Sixteen rays: x, y, and z of their origins, of their directions, and their ends.
pub(crate) type Numbers<'a> = [&'a [f32; LANES]; NUMBERS];
const NUMBERS: usize = 7;

impl Bins {
    /// Makes room for a batch of `rays` rays, a multiple of [`LANES`]. Columns are an odd multiple
    /// of a cache line long, so that they do not share the sets of a cache.
    fn make_room(&mut self, rays: usize) {
        self.room = ((rays / LANES + 1) | 1) * LANES;
        if self.indices.len() < WAYS * self.room {
            // Most ways stay empty, and their memory untouched.
            self.indices = vec![0; WAYS * self.room];
            self.numbers = vec![0.0; WAYS * NUMBERS * self.room];
        }
    }

    /// Repeats the last of the `len` rays of a bin until there are whole sixteens.
    fn fill_up(&mut self, way: usize, len: usize) {
        let end = len.next_multiple_of(LANES);
        let bin = &mut self.indices[way * self.room..][..end];
        let last = bin[len - 1];
        bin[len..].fill(last);
        for k in 0..NUMBERS {
            let column = &mut self.numbers[(way * NUMBERS + k) * self.room..][..end];
            let last = column[len - 1];
            column[len..].fill(last);
        }
    }

    /// The sixteen from a place in the bins on.
    #[inline(always)]
    fn get(&self, start: usize) -> Sixteen<'_> {
        let (way, first) = (start / self.room, start % self.room);
        let numbers = &self.numbers[way * NUMBERS * self.room + first..];
        let column = |k: usize| numbers[k * self.room..][..LANES].try_into().expect("sixteen");
        let numbers = [column(0), column(1), column(2), column(3), column(4), column(5), column(6)];
        let indices = self.indices[start..start + LANES].try_into().expect("sixteen");
        Sixteen::Chosen(indices, numbers)
    }
}

/// Up to sixteen rays of a batch.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The first ray if they are neighbours, or else where they begin in the bins.
    start: u32,
    count: u8,
    are_neighbours: bool,
}

/// Up to sixteen rays of a batch.
pub(crate) enum Sixteen<'a> {
    /// Neighbours, from this ray on.
    Neighbours(usize),
    /// Any rays: their indices in the batch, and the rays; all sixteen can be read.
    Chosen(&'a [u32; LANES], Numbers<'a>),
}

/// Ways to go: signs of a direction and its largest axis.
const WAYS: usize = 32;

impl Order {
    /// Keeps the rays of a batch in their order.
    pub(crate) fn keep(&mut self, rays: &Rays) {
        let n = rays.len();
        let place = |start: usize| Place {
            start: start as u32,
            count: (n - start).min(LANES) as u8,
            are_neighbours: true,
        };
        self.sixteens.clear();
        self.sixteens.extend((0..n).step_by(LANES).map(place));
    }

    /// Orders the rays of a batch so that sixteen go the same way: neighbours stay together if
    /// they do, and the others are gathered by the way they go, in the order of neighbours.
    ///
    /// # Safety
    /// The CPU has the instruction set of `S`.
    #[inline(always)]
    pub(crate) unsafe fn sort<S: Choosing>(&mut self, rays: &Rays) {
        self.keep(rays);
        let Self { sixteens, ways, bins } = self;
        let n = sixteens.len() * LANES;
        let [x, y, z] = &rays.direction;
        ways.clear();
        ways.extend(x[..n].iter().zip(&y[..n]).zip(&z[..n]).map(|((&x, &y), &z)| way(x, y, z)));
        bins.make_room(n);
        let room = bins.room;
        let [ox, oy, oz] = &rays.origin;
        let columns: [_; NUMBERS] = [ox, oy, oz, x, y, z, &rays.t_max];
        let mut lens = [0; WAYS];
        let mut whole = 0;
        for i in 0..sixteens.len() {
            let place = sixteens[i];
            let ways: &[u8; LANES] = ways[i * LANES..][..LANES].try_into().expect("sixteen");
            let all = u32::MAX >> (32 - u32::from(place.count));
            let mut left = all;
            // SAFETY: each bin has room for all rays, and for sixteen more behind the last.
            unsafe {
                let alike = S::lanes_with(ways, ways[0]) & all;
                if alike == all {
                    sixteens[whole] = place;
                    whole += 1;
                    continue;
                }
                while left != 0 {
                    let way = ways[left.trailing_zeros() as usize % LANES];
                    let alike = S::lanes_with(ways, way) & left;
                    left &= !alike;
                    let way = usize::from(way) % WAYS;
                    let len = lens[way];
                    let indices = bins.indices.as_mut_ptr().add(way * room + len);
                    S::compress_lanes(place.start, alike, indices);
                    let numbers = bins.numbers.as_mut_ptr().add(way * NUMBERS * room + len);
                    for (k, column) in columns.iter().enumerate() {
                        let sixteen = column[i * LANES..][..LANES].try_into().expect("sixteen");
                        S::compress(sixteen, alike, numbers.add(k * room));
                    }
                    lens[way] += alike.count_ones() as usize;
                }
            }
        }
        sixteens.truncate(whole);
        for (way, &len) in lens.iter().enumerate().filter(|&(_, &len)| len > 0) {
            bins.fill_up(way, len);
            let place = |start: usize| Place {
                start: (way * room + start) as u32,
                count: (len - start).min(LANES) as u8,
                are_neighbours: false,
            };
            sixteens.extend((0..len).step_by(LANES).map(place));
        }
    }

    /// The n-th sixteen, and how many of them are rays to be traced; `None` after the last.
    #[inline(always)]
    pub(crate) fn get(&self, n: usize) -> Option<(Sixteen<'_>, usize)> {
        let &Place { start, count, are_neighbours } = self.sixteens.get(n)?;
        let start = start as usize;
        let sixteen =
            if are_neighbours { Sixteen::Neighbours(start) } else { self.bins.get(start) };
        Some((sixteen, usize::from(count)))
    }
}

/// Signs of a direction and its largest axis; any choice between equals will do.
#[inline(always)]
fn way(x: f32, y: f32, z: f32) -> u8 {
    let negative = |v: f32| (v.to_bits() >> 31) as u8;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let y_or_z = if ay < az { 2 } else { 1 };
    let largest = if ax >= ay && ax >= az { 0 } else { y_or_z };
    negative(x) | negative(y) << 1 | negative(z) << 2 | largest << 3
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;
    use crate::isa::Isa;

    #[test]
    fn every_ray_is_taken_once_and_neighbours_of_one_way_stay_together() {
        Isa::available().into_iter().for_each(check);
    }

    fn sort(isa: Isa, order: &mut Order, rays: &Rays) {
        // SAFETY: the CPU has that instruction set.
        unsafe {
            match isa {
                #[cfg(target_arch = "x86_64")]
                Isa::Avx512 => order.sort::<x86::Avx512>(rays),
                #[cfg(target_arch = "x86_64")]
                Isa::Avx2 => order.sort::<x86::Avx2>(rays),
                #[cfg(target_arch = "aarch64")]
                Isa::Neon => order.sort::<neon::Neon>(rays),
                _ => order.sort::<Portable>(rays),
            }
        }
    }

    fn check(isa: Isa) {
        let mut rng = StdRng::seed_from_u64(1);
        let mut order = Order::default();
        for n in [0, 1, 15, 16, 17, 100, 1024] {
            let mut rays = Rays::default();
            for i in 0..n {
                let mut number = || rng.random_range(-1.0..1.0f32);
                let any = Vec3::new(number(), number(), number());
                let direction = if i % 64 < 32 { Vec3::new(0.5, -0.5, 2.0) } else { any };
                let (origin, t_max) = (Vec3::new(number(), number(), number()), number());
                rays.push(origin, direction, t_max);
            }
            sort(isa, &mut order, &rays);
            let (mut taken, mut alike) = (vec![], 0);
            for i in 0.. {
                let Some((sixteen, len)) = order.get(i) else { break };
                match sixteen {
                    Sixteen::Neighbours(first) => taken.extend(first..first + len),
                    Sixteen::Chosen(chosen, numbers) => {
                        taken.extend(chosen[..len].iter().map(|&i| i as usize));
                        for lane in 0..LANES {
                            let i = chosen[lane] as usize;
                            let (o, d) = (rays.origin(i), rays.direction(i));
                            let told = [o.x, o.y, o.z, d.x, d.y, d.z, rays.t_max[i]];
                            assert_eq!(numbers.map(|column| column[lane]), told);
                        }
                    }
                }
                let way_of = |&i: &usize| {
                    let d = rays.direction(i);
                    way(d.x, d.y, d.z)
                };
                let ways: Vec<_> = taken[taken.len() - len..].iter().map(way_of).collect();
                assert!(ways.iter().all(|&way| way == ways[0]));
                alike += usize::from(len == LANES);
            }
            taken.sort_unstable();
            assert_eq!(taken, (0..n).collect::<Vec<_>>());
            assert!(alike >= n / 32, "{alike} of {n}");
        }
    }
}
