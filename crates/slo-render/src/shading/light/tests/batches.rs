//! Samples of whole batches are those of single hits.

use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Column, Vec3s};

use super::super::{Lamp, Light, Samples, WithLamp};
use super::{disc, sky, sun};

struct Compare<'a>(Isa, &'a Vec3s, [&'a Column<f32>; 2]);

impl WithLamp for Compare<'_> {
    type Output = ();

    fn run<L: Lamp>(self, lamp: L) {
        let (Self(isa, hits, [u, v]), len) = (self, BATCH - 5);
        let mut samples = Samples::default();
        samples.density[7] = -1.0;
        lamp.sample_each(isa, (hits, len), [u, v], |i| i != 7, &mut samples);
        assert_eq!(samples.density[7], -1.0, "not asked");
        for i in (0..len).filter(|i| *i != 7) {
            let (one, found) = (lamp.sample(hits.get(i), [u[i], v[i]]), samples.get(i));
            assert_eq!(
                (one.way, one.radiance, one.density),
                (found.way, found.radiance, found.density),
                "{isa}, {i}"
            );
        }
        samples.way.set(7, Vec3::Z);
        lamp.found_each(isa, hits, len, &mut samples);
        for i in 0..len {
            let (found, one) = (samples.get(i), lamp.found(hits.get(i), samples.way.get(i)));
            assert_eq!((found.radiance, found.density), one, "{isa}, {i}");
        }
    }
}

#[test]
fn batches_find_what_single_hits_find() {
    let mut rng = StdRng::seed_from_u64(3);
    let (mut hits, mut u, mut v) = (Vec3s::default(), [0.0; BATCH], [0.0; BATCH]);
    for i in 0..BATCH {
        let mut number = || rng.random_range(0.0..1.0f32);
        hits.set(i, Vec3::new(number(), number(), number()));
        (u[i], v[i]) = (number(), number());
    }
    let lights: [Light; 4] = [
        sky(16, 8, 0.0),
        sky(300, 150, 77.0),
        sun(DVec3::NEG_Z, 3.0),
        disc(DVec3::Z * 4.0, DVec3::NEG_Z, 0.5),
    ];
    for light in &lights {
        for isa in Isa::available() {
            light.with(Compare(isa, &hits, [&u, &v]));
        }
    }
}
