//! All structures and instruction sets give the same hits, bit by bit, on any geometry.

use slo_accel::glam::Vec3;
use slo_accel::{Accelerator, Coherence, Curved, Hits, Isa, Primitives, Rays, Scratch, Structure};
use crate::pieces::Numbers;
use crate::within_limits;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let mut numbers = Numbers::of(data);
        let rays = rays(&mut numbers);
        let primitives = primitives(&mut numbers);
        let expected = answers(Accelerator::None, &primitives, Isa::Portable, &rays);
        for (name, accelerator) in Accelerator::NAMES {
            // That structure may miss hits.
            if *accelerator == Accelerator::Cwbvh {
                continue;
            }
            for isa in Isa::available() {
                let found = answers(*accelerator, &primitives, isa, &rays);
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    assert_eq!(found, expected, "{name}, {isa:?}, ray {i}: {primitives:?}");
                }
            }
        }
    });
}

fn vector(numbers: &mut Numbers<'_>) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| numbers.coordinate()))
}

fn rays(numbers: &mut Numbers<'_>) -> Rays {
    let count = 1 + usize::from(numbers.byte()) % 34;
    let mut rays = Rays::with_capacity(count);
    for _ in 0..count {
        let (origin, mut direction) = (vector(numbers), vector(numbers));
        if direction == Vec3::ZERO {
            direction = Vec3::X;
        }
        let end = numbers.coordinate();
        rays.push(origin, direction, if end > 0.0 { end } else { f32::INFINITY });
    }
    rays
}

fn primitives(numbers: &mut Numbers<'_>) -> Primitives {
    let mut primitives = Primitives::default();
    while !numbers.is_empty() && primitives.len() < 200 {
        let point = vector(numbers);
        let radius = || 0.25;
        match numbers.byte() % 8 {
            0 => primitives.curved.push(Curved::Sphere { center: point, radius: radius() }),
            1 => {
                let top = point + Vec3::Y;
                primitives.curved.push(Curved::Cylinder { base: point, top, radius: radius() });
            }
            2 => {
                let apex = point + Vec3::Z;
                primitives.curved.push(Curved::Cone { base: point, apex, radius: radius() });
            }
            // A second triangle beside the last one.
            3 => {
                let last = primitives.triangles.last().copied();
                let [_, b, c] = last.unwrap_or([Vec3::ZERO, Vec3::X, Vec3::Y]);
                primitives.triangles.push([b, c, point]);
            }
            _ => primitives.triangles.push([point, vector(numbers), vector(numbers)]),
        }
    }
    primitives
}

/// Bits of each hit, and whether the ray is blocked.
fn answers(
    accelerator: Accelerator,
    primitives: &Primitives,
    isa: Isa,
    rays: &Rays,
) -> Vec<([u32; 4], bool)> {
    let structure = Structure::build(accelerator, primitives.clone(), isa);
    let (mut hits, mut blocked) = (Hits::default(), Vec::new());
    let mut scratch = Scratch::default();
    structure.intersect(rays, Coherence::Incoherent, &mut hits, &mut scratch);
    structure.occluded(rays, Coherence::Coherent, &mut blocked, &mut scratch);
    let bits = |i: usize| {
        let Hits { t, u, v, primitive, .. } = &hits;
        ([t[i].to_bits(), u[i].to_bits(), v[i].to_bits(), primitive[i]], blocked[i])
    };
    (0..rays.len()).map(bits).collect()
}
