//! The order in which the rays of a batch are made ready, so that sixteen of them go the same way.

#[cfg(target_arch = "x86_64")]
pub(in crate::accel) mod x86;

use super::simd::lanes_of;
use super::{LANES, Rays};

/// What ordering and choosing rays is made of, for one instruction set; here in plain Rust.
pub(in crate::accel) trait Choosing {
    /// Sixteen elements of an array.
    ///
    /// # Safety
    /// The CPU has the instruction set; there are such elements.
    #[inline(always)]
    unsafe fn gather(array: *const f32, indices: &[u32; LANES]) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        for (value, &index) in values.iter_mut().zip(indices) {
            // SAFETY: the caller's.
            *value = unsafe { *array.add(index as usize) };
        }
        values
    }

    /// Which of sixteen values equal one.
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
    unsafe fn compress(first: u32, set: u32, to: *mut u32) {
        for (i, lane) in lanes_of(set).enumerate() {
            // SAFETY: a set has at most sixteen lanes.
            unsafe { *to.add(i) = first + lane as u32 };
        }
    }
}

/// Plain Rust.
pub(in crate::accel) struct Portable;

impl Choosing for Portable {}

/// Sixteens of a batch's rays.
#[derive(Debug, Default)]
pub(in crate::accel) struct Order {
    sixteens: Vec<Place>,
    ways: Vec<u8>,
    /// Rays that do not go the way of their neighbours, by the way they go: for each way as much
    /// room as the batch has rays, and [`LANES`] more.
    bins: Vec<u32>,
}

/// Up to sixteen rays of a batch.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The first of neighbours, or where they begin in the bins.
    start: u32,
    count: u8,
    are_neighbours: bool,
}

/// Up to sixteen rays of a batch.
pub(in crate::accel) enum Sixteen<'a> {
    /// Neighbours, from this ray on.
    Neighbours(usize),
    /// Any; all of these can be read.
    Chosen(&'a [u32; LANES]),
}

/// Ways to go: signs of a direction and its largest axis.
const WAYS: usize = 32;

impl Order {
    /// Takes the rays of a batch as they come.
    pub(in crate::accel) fn keep(&mut self, rays: &Rays) {
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
    pub(in crate::accel) unsafe fn sort<S: Choosing>(&mut self, rays: &Rays) {
        self.keep(rays);
        let Self { sixteens, ways, bins } = self;
        let n = sixteens.len() * LANES;
        let [x, y, z] = &rays.direction;
        ways.clear();
        ways.extend(x[..n].iter().zip(&y[..n]).zip(&z[..n]).map(|((&x, &y), &z)| way(x, y, z)));
        let room = n + LANES;
        if bins.len() < WAYS * room {
            bins.resize(WAYS * room, 0);
        }
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
                    let len = &mut lens[usize::from(way) % WAYS];
                    let bin = bins.as_mut_ptr().add(usize::from(way) % WAYS * room + *len);
                    S::compress(place.start, alike, bin);
                    *len += alike.count_ones() as usize;
                }
            }
        }
        sixteens.truncate(whole);
        for (way, &len) in lens.iter().enumerate().filter(|&(_, &len)| len > 0) {
            let bin = way * room;
            let last = bins[bin + len - 1];
            bins[bin + len..bin + len.next_multiple_of(LANES)].fill(last);
            let place = |start: usize| Place {
                start: (bin + start) as u32,
                count: (len - start).min(LANES) as u8,
                are_neighbours: false,
            };
            sixteens.extend((0..len).step_by(LANES).map(place));
        }
    }

    /// The n-th sixteen, and how many of them are rays to be traced; `None` behind the last.
    #[inline(always)]
    pub(in crate::accel) fn get(&self, n: usize) -> Option<(Sixteen<'_>, usize)> {
        let &Place { start, count, are_neighbours } = self.sixteens.get(n)?;
        let start = start as usize;
        let sixteen = if are_neighbours {
            Sixteen::Neighbours(start)
        } else {
            Sixteen::Chosen(self.bins[start..start + LANES].try_into().expect("as many as lanes"))
        };
        Some((sixteen, usize::from(count)))
    }
}

/// Signs of a direction and its largest axis; nothing depends on how equals are told apart.
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

    #[test]
    fn every_ray_is_taken_once_and_neighbours_of_one_way_stay_together() {
        let mut rng = StdRng::seed_from_u64(1);
        let mut order = Order::default();
        for n in [0, 1, 15, 16, 17, 100, 1024] {
            let mut rays = Rays::default();
            for i in 0..n {
                let mut number = || rng.random_range(-1.0..1.0f32);
                let any = Vec3::new(number(), number(), number());
                let direction = if i % 64 < 32 { Vec3::new(0.5, -0.5, 2.0) } else { any };
                rays.push(Vec3::ZERO, direction, 1.0);
            }
            // SAFETY: plain Rust runs everywhere.
            unsafe { order.sort::<Portable>(&rays) };
            let (mut taken, mut alike) = (vec![], 0);
            for i in 0.. {
                let Some((sixteen, len)) = order.get(i) else { break };
                match sixteen {
                    Sixteen::Neighbours(first) => taken.extend(first..first + len),
                    Sixteen::Chosen(chosen) => {
                        taken.extend(chosen[..len].iter().map(|&i| i as usize))
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
