//! The order in which the rays of a batch are made ready, so that sixteen of them go the same way.

use crate::accel::{LANES, Rays};

/// Sixteens of a batch's rays.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// First rays of sixteen neighbours that are taken as they are.
    whole: Vec<u32>,
    /// The other rays, sorted by the way they go; a multiple of sixteen.
    mixed: Vec<u32>,
    /// How many of them are not there to fill up.
    mixed_len: usize,
    ways: Vec<u8>,
    /// First rays of neighbours that go different ways.
    split: Vec<u32>,
}

/// Up to sixteen rays of a batch.
pub(super) enum Sixteen<'a> {
    /// Neighbours, from this ray on.
    Neighbours(usize),
    /// Any; all of these can be read.
    Chosen(&'a [u32; LANES]),
}

/// Ways to go: signs of a direction and its largest axis.
const WAYS: usize = 32;

impl Order {
    /// Takes the rays of a batch as they come.
    pub(super) fn keep(&mut self, rays: &Rays) {
        self.whole.clear();
        self.whole.extend((0..rays.len() as u32).step_by(LANES));
        self.mixed_len = 0;
    }

    /// Orders the rays of a batch so that sixteen go the same way where that can be: neighbours
    /// stay together if they do, and all others are sorted, those of one way in the order of
    /// neighbours.
    #[inline(always)]
    pub(super) fn sort(&mut self, rays: &Rays) {
        let n = rays.len();
        let Self { whole, mixed, mixed_len, ways, split } = self;
        let [x, y, z] = &rays.direction;
        ways.clear();
        ways.extend(x[..n].iter().zip(&y[..n]).zip(&z[..n]).map(|((&x, &y), &z)| way(x, y, z)));
        whole.clear();
        split.clear();
        let mut places = [0u32; WAYS];
        for (sixteen, first) in ways.chunks(LANES).zip((0..).step_by(LANES)) {
            if *sixteen == [sixteen[0]; LANES] {
                whole.push(first);
            } else {
                split.push(first);
                sixteen.iter().for_each(|&way| places[usize::from(way) % WAYS] += 1);
            }
        }
        let mut len = 0;
        for place in &mut places {
            len += std::mem::replace(place, len);
        }
        *mixed_len = len as usize;
        mixed.clear();
        mixed.resize(mixed_len.next_multiple_of(LANES), split.last().copied().unwrap_or(0));
        for &first in &*split {
            let last = n.min(first as usize + LANES) as u32;
            for (&way, i) in ways[first as usize..last as usize].iter().zip(first..last) {
                let place = &mut places[usize::from(way) % WAYS];
                mixed[*place as usize] = i;
                *place += 1;
            }
        }
    }

    /// The n-th sixteen, and how many of them are rays to be traced; `None` behind the last.
    #[inline(always)]
    pub(super) fn get(&self, n: usize, rays: &Rays) -> Option<(Sixteen<'_>, usize)> {
        if let Some(&first) = self.whole.get(n) {
            let first = first as usize;
            return Some((Sixteen::Neighbours(first), (rays.len() - first).min(LANES)));
        }
        let start = (n - self.whole.len()) * LANES;
        let left = self.mixed_len.checked_sub(start).filter(|&left| left > 0)?;
        let chosen = self.mixed[start..start + LANES].try_into().expect("as many as lanes");
        Some((Sixteen::Chosen(chosen), left.min(LANES)))
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
            order.sort(&rays);
            let (mut taken, mut alike) = (vec![], 0);
            for i in 0.. {
                let Some((sixteen, len)) = order.get(i, &rays) else { break };
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
                assert!(ways.is_sorted());
                alike += usize::from(ways == [ways[0]; LANES]);
            }
            taken.sort_unstable();
            assert_eq!(taken, (0..n).collect::<Vec<_>>());
            assert!(alike >= n / 32, "{alike} of {n}");
        }
    }
}
