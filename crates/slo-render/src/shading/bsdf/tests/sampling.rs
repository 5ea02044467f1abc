//! Sampling against density, weights against values, reciprocity, and robustness.

use glam::Vec3;
use slo_accel::Isa;
use slo_accel::math::columns::{BATCH, Vec3s};

use super::hits::{Hits, color, direction, material, point};
use crate::shading::bsdf::{At, Bsdf, Lobe, Sampled, WithLobe, principled};
use crate::shading::material::principled::Parameters;

/// A material that has one lobe, or glossy lobes over others, and whether it is seen from outside.
struct Case(&'static str, Box<Parameters>, bool);

fn cases() -> Vec<Case> {
    let white = |change: &dyn Fn(&mut Parameters)| {
        material(|p| {
            color(&mut p.base_color, [1.0; 3]);
            change(p);
        })
    };
    let case = |name, change: &dyn Fn(&mut Parameters)| Case(name, white(change), true);
    let glass = |p: &mut Parameters, roughness: f32, ior: f32| {
        p.transmission = [1.0; BATCH];
        p.roughness = [roughness; BATCH];
        p.ior = [ior; BATCH];
    };
    vec![
        case("diffuse and gloss", &|_| ()),
        case("rough diffuse", &|p| {
            p.diffuse_roughness = [0.8; BATCH];
            p.ior = [1.0; BATCH];
        }),
        case("metal", &|p| p.metallic = [1.0; BATCH]),
        case("rough metal", &|p| {
            p.metallic = [1.0; BATCH];
            p.roughness = [1.0; BATCH];
        }),
        case("anisotropic metal", &|p| {
            p.metallic = [1.0; BATCH];
            p.roughness = [0.6; BATCH];
            p.anisotropic = [0.8; BATCH];
            p.anisotropic_rotation = [0.15; BATCH];
        }),
        case("coat and sheen", &|p| {
            p.coat = [1.0; BATCH];
            p.coat_roughness = [0.4; BATCH];
            p.sheen = [1.0; BATCH];
            p.sheen_roughness = [0.4; BATCH];
        }),
        case("glass", &|p| glass(p, 0.5, 1.5)),
        case("rough glass", &|p| glass(p, 1.0, 1.33)),
        Case("glass from inside", white(&|p| glass(p, 0.5, 1.5)), false),
        Case("rough glass from inside", white(&|p| glass(p, 1.0, 1.5)), false),
        case("pane", &|p| {
            glass(p, 0.4, 1.5);
            p.thin = [1.0; BATCH];
        }),
    ]
}

fn eyes() -> [Vec3; 3] {
    [direction(0.0, 0.0), direction(50.0, 0.3), direction(78.0, 0.8)]
}

/// A number of 0 to 1 for each index and purpose.
fn random(index: u32, purpose: u32) -> f32 {
    let mut x = u64::from(index) << 32 | u64::from(purpose.wrapping_mul(0x9e37_79b9));
    for _ in 0..2 {
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    }
    (x >> 40) as f32 / (1u32 << 24) as f32
}

/// Calls a function with each lobe, the hit, and its directions.
struct Each<'a, F>(&'a Hits, F);

impl<F: FnMut(usize, &At, &dyn Whole)> WithLobe for Each<'_, F> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        for (i, at) in self.0.at.iter().enumerate() {
            if lobe.share().chance[i] > 0.0 {
                (self.1)(i, at, &Held(lobe));
            }
        }
    }
}

/// A lobe as an object.
trait Whole {
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> (Vec3, f32);
    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled;
    fn weight(&self, i: usize) -> Vec3;
}

struct Held<'a, L>(&'a L);

impl<L: Lobe> Whole for Held<'_, L> {
    fn evaluate(&self, i: usize, at: &At, toward: Vec3) -> (Vec3, f32) {
        let scattered = self.0.evaluate(i, at, toward);
        (scattered.value, scattered.density)
    }

    fn sample(&self, i: usize, at: &At, u: [f32; 3]) -> Sampled {
        self.0.sample(i, at, u)
    }

    fn weight(&self, i: usize) -> Vec3 {
        self.0.share().weight.get(i)
    }
}

fn each(hits: &Hits, work: impl FnMut(usize, &At, &dyn Whole)) {
    hits.bsdf.for_each(&mut Each(hits, work));
}

const RINGS: usize = 16;
const SECTORS: usize = 24;

fn cell(w: Vec3) -> usize {
    let turn = libm::atan2f(w.y, w.x) / std::f32::consts::TAU + 0.5;
    let ring = (libm::acosf(w.z.clamp(-1.0, 1.0)) / std::f32::consts::PI * RINGS as f32) as usize;
    ring.min(RINGS - 1) * SECTORS + ((turn * SECTORS as f32) as usize).min(SECTORS - 1)
}

/// How many standard deviations chi-square of `counts` against `expected` lies above what it should
/// be, by Wilson and Hilferty's approximation. Cells with less than 5 are taken together.
fn deviation(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut chi, mut cells, mut few) = (0.0, 0.0, [0.0; 2]);
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            few = [few[0] + count, few[1] + expected];
        } else {
            chi += (count - expected) * (count - expected) / expected;
            cells += 1.0;
        }
    }
    if few[1] > 1.0 {
        chi += (few[0] - few[1]) * (few[0] - few[1]) / few[1];
        cells += 1.0;
    }
    let freedom: f64 = cells - 1.0;
    let variance = 2.0 / (9.0 * freedom);
    (libm::cbrt(chi / freedom) - (1.0 - variance)) / variance.sqrt()
}

#[test]
fn samples_have_their_density() {
    const SAMPLES: u32 = 50_000;
    // Parts of a ring and of a sector. Refracted lobes end abruptly at a ring.
    const FINE: [usize; 2] = [96, 6];
    // Of about 45 tests, the worst exceeds this by chance in one of a hundred runs.
    const LIMIT: f64 = 3.5;
    let mut tests = 0;
    for Case(name, parameters, outside) in cases() {
        let hits = Hits::new(&parameters, &eyes(), outside);
        each(&hits, |i, at, lobe| {
            tests += 1;
            // The last cell counts samples that failed.
            let mut counts = vec![0.0; RINGS * SECTORS + 1];
            let mut expected = vec![0.0; RINGS * SECTORS + 1];
            for k in 0..SAMPLES {
                let u = [0, 1, 2].map(|d| random(k, 3 * i as u32 + d + 17 * tests));
                let Sampled { direction, weight, .. } = lobe.sample(i, at, u);
                let failed = weight == Vec3::ZERO;
                counts[if failed { RINGS * SECTORS } else { cell(direction) }] += 1.0;
            }
            let steps = [RINGS * FINE[0], SECTORS * FINE[1]];
            let angles = [0.5, 1.0].map(|turns| turns * std::f64::consts::TAU);
            for ring in 0..steps[0] {
                let theta = (ring as f64 + 0.5) / steps[0] as f64 * angles[0];
                let area = libm::sin(theta) * angles[0] * angles[1] / (steps[0] * steps[1]) as f64;
                for sector in 0..steps[1] {
                    let turn = (sector as f64 + 0.5) / steps[1] as f64;
                    let w = direction(theta.to_degrees(), turn - 0.5);
                    let (_, density) = lobe.evaluate(i, at, w);
                    expected[ring / FINE[0] * SECTORS + sector / FINE[1]] +=
                        f64::from(density) * area * f64::from(SAMPLES);
                }
            }
            let sum = expected.iter().sum::<f64>();
            assert!(sum < 1.003 * f64::from(SAMPLES), "{name} {i}: {sum}");
            expected[RINGS * SECTORS] = (f64::from(SAMPLES) - sum).max(0.0);
            let found = deviation(&counts, &expected);
            assert!(found < LIMIT, "{name}, eye {i}, test {tests}: {found}");
        });
    }
    assert!(tests > 40, "{tests}");
}

/// The weight of a sample is its value over its density, and its density is that of its direction.
#[test]
fn weights_are_values_over_densities() {
    let straight = cases().into_iter().map(|case| (case, Vec3::Z));
    let bent = cases().into_iter().map(|case| (case, direction(35.0, 0.6)));
    for (Case(name, parameters, outside), n) in straight.chain(bent) {
        let at = |eye| At {
            eye,
            n,
            n_geo: Vec3::Z,
            floor: Vec3::Z,
            is_bent: n != Vec3::Z,
            tangent: Vec3::X,
        };
        let hits = Hits::of(&parameters, eyes().map(at).to_vec(), outside);
        each(&hits, |i, at, lobe| {
            for k in 0..2000 {
                let sampled = lobe.sample(i, at, point(k, 2000));
                assert!((sampled.direction.length() - 1.0).abs() < 1e-5);
                let (value, density) = lobe.evaluate(i, at, sampled.direction);
                if sampled.weight == Vec3::ZERO || sampled.direction.z.abs() < 0.01 {
                    continue;
                }
                let weight = value / density;
                let off = (weight - sampled.weight).abs().max_element();
                assert!(off < 0.003 * (0.1 + weight.max_element()), "{name} {i}: {off}");
                let off = (density / sampled.density - 1.0).abs();
                assert!(off < 0.01, "{name} {i} {sampled:?}: {density}");
            }
        });
    }
}

/// Without the factors of layers and of lost light, which depend on the eye.
#[test]
fn lobes_are_reciprocal() {
    for Case(name, parameters, outside) in cases() {
        if name.contains("sheen") {
            continue;
        }
        for k in 0..200 {
            let [a, b] = [0, 1]
                .map(|j| direction(85.0 * f64::from(random(k, j)), f64::from(random(k, 2 + j))));
            let passes = parameters.transmission[0] > 0.0 && k % 2 == 0;
            let b = if passes { b * Vec3::new(1.0, 1.0, -1.0) } else { b };
            let n = if passes { -Vec3::Z } else { Vec3::Z };
            let up = At {
                eye: a,
                n: Vec3::Z,
                n_geo: Vec3::Z,
                floor: Vec3::Z,
                is_bent: false,
                tangent: Vec3::X,
            };
            let down = At { eye: b, n, n_geo: n, floor: n, is_bent: false, tangent: Vec3::X };
            let there = Hits::of(&parameters, vec![up], outside);
            let back = Hits::of(&parameters, vec![down], outside != passes);
            let values = |hits: &Hits, toward: Vec3| {
                let mut values = Vec::new();
                each(hits, |i, at, lobe| {
                    let scale = lobe.weight(i) * toward.z.abs();
                    values.push((lobe.evaluate(i, at, toward).0 / scale).x);
                });
                values
            };
            let ior = parameters.ior[0];
            let body = passes && parameters.thin[0] == 0.0;
            let from = if outside { ior * ior } else { 1.0 / (ior * ior) };
            for (f, g) in values(&there, b).into_iter().zip(values(&back, a)) {
                let f = if body { f * from } else { f };
                assert!((f - g).abs() <= 2e-3 * (f + g) + 1e-4, "{name} {a} {b}: {f} is not {g}");
            }
        }
    }
}

/// Sampled light lies on the surface's side that the lobe serves, whatever the shading normal.
#[test]
fn shading_normals_send_nothing_through_the_surface() {
    for Case(name, parameters, outside) in cases() {
        if parameters.transmission[0] > 0.0 {
            continue;
        }
        let n = direction(40.0, 0.6);
        let at = |eye| At {
            eye,
            n,
            n_geo: Vec3::Z,
            floor: Vec3::Z,
            is_bent: false,
            tangent: Vec3::ZERO,
        };
        let hits = Hits::of(&parameters, eyes().map(at).to_vec(), outside);
        each(&hits, |i, at, lobe| {
            for k in 0..500 {
                let sampled = lobe.sample(i, at, point(k, 500));
                let is_above = sampled.direction.z > 0.0;
                assert!(is_above || sampled.weight == Vec3::ZERO, "{name}: {sampled:?}");
                let below = sampled.direction * Vec3::new(1.0, 1.0, -1.0);
                if is_above {
                    assert_eq!(lobe.evaluate(i, at, below), (Vec3::ZERO, 0.0), "{name}");
                }
            }
        });
    }
}

/// Diffuse light fades out toward the surface that an image bends, and not elsewhere.
#[test]
fn bent_normals_end_softly() {
    let parameters = material(|p| p.specular_ior_level = [0.0; BATCH]);
    let n = direction(40.0, 0.0);
    let [plain, bent] = [false, true].map(|is_bent| {
        let at = At { eye: Vec3::Z, n, n_geo: Vec3::Z, floor: Vec3::Z, is_bent, tangent: Vec3::X };
        let hits = Hits::of(&parameters, vec![at], true);
        move |degrees: f64| {
            let toward =
                if degrees < 0.0 { direction(-degrees, 0.5) } else { direction(degrees, 0.0) };
            let mut value = 0.0;
            each(&hits, |i, at, lobe| value += lobe.evaluate(i, at, toward).0.x);
            value
        }
    });
    // The image's normal faces these directions, so the surface would end suddenly.
    assert!(plain(89.9) > 0.1 && bent(89.9) < 0.01 * plain(89.9));
    assert!(bent(80.0) > 0.3 * plain(80.0) && bent(80.0) < 0.9 * plain(80.0));
    for degrees in [0.0, -30.0, -49.0] {
        assert_eq!(bent(degrees), plain(degrees), "{degrees}");
    }
}

/// Numbers of all sizes give finite results, and the same on every instruction set.
#[test]
fn all_numbers_give_finite_results_and_the_same_everywhere() {
    let mut p = Box::<Parameters>::default();
    for i in 0..BATCH {
        let number = |purpose: u32| {
            let x = random(i as u32, purpose);
            if x < 0.1 {
                0.0
            } else if x > 0.9 {
                1.0
            } else {
                x
            }
        };
        for (k, to) in
            [&mut p.base_color, &mut p.specular_tint, &mut p.coat_tint, &mut p.sheen_tint]
                .into_iter()
                .enumerate()
        {
            to.set(i, Vec3::new(number(k as u32), number(k as u32 + 50), number(k as u32 + 90)));
        }
        p.metallic[i] = number(10);
        p.roughness[i] = number(11) * number(12);
        p.diffuse_roughness[i] = number(13);
        p.ior[i] = if i % 3 == 0 { 1.0 + 1e-4 * number(14) } else { 0.5 + 2.0 * number(14) };
        p.specular_ior_level[i] = number(15);
        p.anisotropic[i] = number(16);
        p.anisotropic_rotation[i] = number(17);
        p.transmission[i] = number(18);
        p.coat[i] = number(19);
        p.coat_roughness[i] = number(20);
        p.coat_ior[i] = 1.0 + number(21);
        p.sheen[i] = number(22);
        p.sheen_roughness[i] = number(23);
        p.thin[i] = if number(24) > 0.7 { 1.0 } else { 0.0 };
    }
    let at = |i: usize| {
        let (i, half) = (i as u32, |x: f32| if x < 0.1 { 89.999 } else { 90.0 * f64::from(x) });
        let n_geo = direction(180.0 * f64::from(random(i, 31)), f64::from(random(i, 32)));
        let eye = direction(half(random(i, 33)), f64::from(random(i, 34)));
        let eye = if eye.dot(n_geo) < 0.0 { -eye } else { eye };
        let n = direction(180.0 * f64::from(random(i, 35)), f64::from(random(i, 36)));
        let n = if n.dot(n_geo) < 0.0 { -n } else { n };
        At {
            eye,
            n,
            n_geo,
            floor: n_geo,
            is_bent: i % 3 == 0,
            tangent: if i % 5 == 0 { Vec3::ZERO } else { n.cross(eye) },
        }
    };
    let from_outside = std::array::from_fn(|i| u32::from(i % 4 != 0));
    struct All<'a>(&'a dyn Fn(usize) -> At, Vec<u32>);
    impl WithLobe for All<'_> {
        fn run<L: Lobe>(&mut self, lobe: &L) {
            for i in 0..BATCH {
                let at = (self.0)(i);
                let u = [41, 42, 43].map(|d| random(i as u32, d));
                let sampled = lobe.sample(i, &at, u);
                let toward = direction(180.0 * f64::from(u[0]), f64::from(u[1]));
                for toward in [toward, sampled.direction, -at.eye, at.eye] {
                    let found = lobe.evaluate(i, &at, toward);
                    assert!(found.value.is_finite() && found.density.is_finite(), "{i} {at:?}");
                    assert!(found.value.min_element() >= 0.0 && found.density >= 0.0, "{i}");
                    self.1.extend(found.value.to_array().map(f32::to_bits));
                }
                assert!(sampled.weight.is_finite() && sampled.density.is_finite(), "{i} {at:?}");
                assert!(sampled.weight.min_element() >= 0.0, "{i} {sampled:?}");
                assert!(lobe.share().chance[i].is_finite() && lobe.share().chance[i] >= 0.0);
                self.1.extend(sampled.direction.to_array().map(f32::to_bits));
            }
        }
    }
    let mut first: Option<Vec<u32>> = None;
    for isa in Isa::available() {
        let (mut bsdf, mut emitted) = (Box::<Bsdf>::default(), Box::<Vec3s>::default());
        principled(&p, at, &from_outside, |_| true, BATCH, isa, &mut bsdf, &mut emitted);
        let mut all = All(&at, Vec::new());
        bsdf.for_each(&mut all);
        assert!(*first.get_or_insert_with(|| all.1.clone()) == all.1, "{isa}");
    }
}

/// Hits of other kinds keep the lobe that kinds share, and have no other.
#[test]
fn other_materials_keep_their_lobes() {
    let mut bsdf = Box::<Bsdf>::default();
    bsdf.clear();
    let share = bsdf.diffuse.share_mut();
    share.is_present = true;
    share.weight.set(1, Vec3::new(0.1, 0.2, 0.3));
    share.chance[1] = 0.2;
    let p = material(|p| p.coat = [1.0; BATCH]);
    let at = |_| At {
        eye: Vec3::Z,
        n: Vec3::Z,
        n_geo: Vec3::Z,
        floor: Vec3::Z,
        is_bent: false,
        tangent: Vec3::ZERO,
    };
    let mut emitted = Box::<Vec3s>::default();
    let isa = Isa::best();
    principled(&p, at, &[1; BATCH], |i| i != 1, 3, isa, &mut bsdf, &mut emitted);
    assert_eq!(bsdf.diffuse.share().weight.get(1), Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(bsdf.diffuse.share().chance[1], 0.2);
    assert!(bsdf.diffuse.share().weight.x[2] > 0.5);
    assert_eq!(bsdf.coat.share().weight.get(1), Vec3::ZERO);
    assert!(bsdf.coat.share().weight.x[0] > 0.9);
    // The coat reflects 4 %.
    assert!((emitted.x[0] - 0.96).abs() < 1e-3, "{}", emitted.x[0]);
    assert!(!bsdf.metal.share().is_present && !bsdf.glass.share().is_present);
}
