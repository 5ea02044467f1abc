use rand::{RngExt, SeedableRng, rngs::StdRng};

use super::*;
use crate::shading::light::{EvenSky, Light, Triangle, WithLamp};
use crate::shading::{Lamp, light::tests as lamps};

/// A random number generator with what the tests draw.
struct Random(StdRng);

impl Random {
    fn number(&mut self) -> f32 {
        self.0.random_range(0.0..1.0)
    }

    fn vector(&mut self, scale: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| (self.number() * 2.0 - 1.0) * scale))
    }

    fn direction(&mut self) -> Vec3 {
        self.vector(1.0).try_normalize().unwrap_or(Vec3::Z)
    }

    fn normal(&mut self) -> u32 {
        if self.number() < 0.1 { receiver::ANY } else { receiver::pack(self.direction()) }
    }

    /// Lights of all kinds in random places.
    fn lights(&mut self, count: usize) -> Vec<Light> {
        (0..count).map(|i| self.light(i)).collect()
    }

    fn light(&mut self, i: usize) -> Light {
        let place = self.vector(10.0).as_dvec3();
        let direction = self.direction().as_dvec3();
        let size = f64::from(self.number()) + 0.01;
        let across = direction.any_orthonormal_vector();
        let corners = [place, place + across * size, place + across * size + direction * 2.0];
        match i % 9 {
            0 => lamps::sphere(place, 0.0),
            1 => lamps::sphere(place, size * 0.3),
            2 => lamps::spot_at(place, direction, 0.0, 30.0),
            3 => lamps::spot_at(place, direction, 0.05, 100.0),
            4 if i < 40 => lamps::sun(direction, 0.0),
            5 if i < 40 => lamps::sun(direction, 20.0),
            6 => lamps::rectangle(corners, i.is_multiple_of(2)),
            7 => lamps::disc(place, direction, size),
            8 if i < 10 => lamps::sky(16, 8, 0.0),
            8 if i < 40 => lamps::of_thesis(corners, i.is_multiple_of(2)),
            _ => {
                let corners = corners.map(|c| c.as_vec3());
                Light::Triangle(Triangle::new(corners, Vec3::splat(self.number())))
            }
        }
    }
}

fn tree(lights: &[Light]) -> LightTree {
    let bounds: Vec<_> = lights.iter().map(Light::bounds).collect();
    LightTree::new(&bounds)
}

const COUNTS: [usize; 7] = [1, 2, 9, 16, 17, 100, 3000];

#[test]
fn chances_sum_to_1_where_any_light_may_arrive() {
    let mut random = Random(StdRng::seed_from_u64(1));
    for count in COUNTS {
        let tree = tree(&random.lights(count));
        assert_eq!(tree.len(), count);
        let mut dark = 0;
        for _ in 0..50 {
            let (from, normal) = (random.vector(15.0), random.normal());
            let chances =
                (0..count as u32).map(|light| f64::from(tree.chance(light, from, normal)));
            let sum: f64 = chances.sum();
            let chosen = tree.choose(from, normal, random.number());
            if chosen.light == NO_LIGHT {
                assert_eq!(sum, 0.0);
                dark += 1;
            } else {
                assert!((sum - 1.0).abs() < 1e-5, "{count} lights: {sum}");
            }
        }
        assert!(dark == 0 || count < 9, "{count}: {dark}");
    }
    let none = LightTree::new(&[]).choose(Vec3::ZERO, receiver::ANY, 0.5);
    assert_eq!((none.light, none.chance), (NO_LIGHT, 0.0));
    assert_eq!(LightTree::new(&[]).chance(0, Vec3::ZERO, receiver::ANY), 0.0);
}

#[test]
fn the_chance_of_a_light_is_that_of_its_choice_on_all_instruction_sets() {
    let mut random = Random(StdRng::seed_from_u64(2));
    let mut sets = COUNTS.map(|count| random.lights(count)).to_vec();
    // A few of each kind, with suns and skies among them.
    for few in [0..3, 1..5, 4..6, 3..6, 5..9, 7..9] {
        sets.push(few.map(|i| random.light(i)).collect());
    }
    for lights in sets {
        let tree = tree(&lights);
        let (mut from, mut normal, mut u) = (Vec3s::default(), [0; BATCH], [0.0; BATCH]);
        for i in 0..BATCH {
            from.set(i, random.vector(15.0));
            (normal[i], u[i]) = (random.normal(), random.number());
        }
        let len = BATCH - 3;
        for isa in Isa::available() {
            let (mut choices, mut chances) = (Choices::default(), [0.0; BATCH]);
            tree.choose_all(isa, len, &from, &normal, &u, &mut choices);
            tree.chance_all(isa, len, &choices.light, &from, &normal, &mut chances);
            for i in 0..len {
                let one = tree.choose(from.get(i), normal[i], u[i]);
                let all =
                    [choices.light[i], choices.chance[i].to_bits(), choices.rest[i].to_bits()];
                assert_eq!(all, [one.light, one.chance.to_bits(), one.rest.to_bits()], "{isa}");
                assert_eq!(chances[i].to_bits(), one.chance.to_bits(), "{isa}");
                assert!((0.0..1.0).contains(&one.rest));
            }
        }
    }
}

/// The light of a sample of a lamp on a surface.
struct Received(Vec3, Vec3, [f32; 2]);

impl WithLamp for Received {
    type Output = f64;

    fn run<L: Lamp>(self, lamp: L) -> f64 {
        let Self(from, normal, u) = self;
        let way = lamp.way(from, u);
        let cos = way.dot(normal) / way.length();
        let cos = if normal == Vec3::ZERO { 1.0 } else { cos.max(0.0) };
        let density = if L::IS_DELTA || L::IS_OF_THESIS { 1.0 } else { lamp.density(from, way) };
        f64::from(lamp.radiance(way).x * cos / density)
    }
}

/// The mean light of all lights, and by samples of chosen lights: both are the same, and nothing
/// that brings light is never chosen.
#[test]
fn no_light_is_lost() {
    let mut random = Random(StdRng::seed_from_u64(3));
    for count in [9, 100, 700] {
        let lights = random.lights(count);
        let tree = tree(&lights);
        for _ in 0..12 {
            let (from, packed) = (random.vector(12.0), random.normal());
            let normal = receiver::unpack(packed);
            let mut all = 0.0;
            for (number, light) in lights.iter().enumerate() {
                let samples: Vec<f64> =
                    lamps::points(256).map(|u| light.with(Received(from, normal, u))).collect();
                let mean = samples.iter().sum::<f64>() / 256.0;
                all += mean;
                let chance = tree.chance(number as u32, from, packed);
                assert!(mean == 0.0 || chance > 0.0, "{light:?} from {from}, {normal}");
            }
            let samples = 1 << 16;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..samples {
                let chosen = tree.choose(from, packed, random.number());
                let Some(light) = lights.get(chosen.light as usize) else { continue };
                let u = [random.number(), random.number()];
                let one = light.with(Received(from, normal, u)) / f64::from(chosen.chance);
                sum += one;
                squares += one * one;
            }
            let samples = f64::from(samples);
            let mean = sum / samples;
            let error = ((squares / samples - mean * mean) / samples).sqrt();
            assert!(
                (mean - all).abs() < 6.0 * error + 0.01 * all,
                "{mean} is not {all} by {error}"
            );
        }
    }
}

#[test]
fn what_lies_behind_a_surface_is_not_chosen() {
    let mut random = Random(StdRng::seed_from_u64(4));
    let up = receiver::pack(Vec3::Z);
    let height = |random: &mut Random| f64::from(random.number()) * 5.0 + 0.01;
    let lights: Vec<_> = (0..200)
        .map(|i| {
            let mut place = random.vector(10.0).as_dvec3();
            place.z = height(&mut random) * if i % 2 == 0 { 1.0 } else { -1.0 };
            lamps::sphere(place, 0.0)
        })
        .collect();
    let tree = tree(&lights);
    for i in 0..1000 {
        let from = random.vector(10.0) * Vec3::new(1.0, 1.0, 0.0);
        assert_eq!(tree.choose(from, up, random.number()).light % 2, 0);
        assert_eq!(tree.chance(2 * (i % 100) + 1, from, up), 0.0);
    }
    let below = Vec3::new(0.0, 0.0, -100.0);
    let chosen = tree.choose(below, receiver::pack(Vec3::NEG_Z), 0.5);
    assert_eq!((chosen.light, chosen.chance), (NO_LIGHT, 0.0));
    assert_ne!(tree.choose(below, receiver::ANY, 0.5).light, NO_LIGHT);
}

/// The interval of a light is in one piece, as long as its chance, and the rest is the place in it.
#[test]
fn numbers_that_are_stratified_give_stratified_choices() {
    let mut random = Random(StdRng::seed_from_u64(5));
    let lights = random.lights(50);
    let tree = tree(&lights);
    for _ in 0..10 {
        let (from, normal) = (random.vector(12.0), random.normal());
        let steps = 1 << 16;
        let mut counts = vec![0u32; lights.len()];
        let mut last = Chosen { light: NO_LIGHT, chance: 0.0, rest: 0.0 };
        for i in 0..steps {
            let chosen = tree.choose(from, normal, i as f32 / steps as f32);
            if chosen.light == last.light {
                assert!(chosen.rest >= last.rest);
            } else {
                assert_eq!(counts[chosen.light as usize], 0, "in two pieces");
            }
            counts[chosen.light as usize] += 1;
            last = chosen;
        }
        for (light, count) in counts.iter().enumerate() {
            let chance = tree.chance(light as u32, from, normal) * steps as f32;
            assert!((chance - *count as f32).abs() < 2.0, "{light}: {count} of {chance}");
        }
    }
}

/// A thousand lights that are equal and lie in one place, and lights whose sizes and energies
/// differ by the whole range of f32.
#[test]
fn odd_collections_of_lights_make_trees() {
    let same = LightBounds::all_round([Vec3::ONE; 2], 1.0);
    let equal = LightTree::new(&vec![same; 1000]);
    let chances: f32 = (0..1000).map(|i| equal.chance(i, Vec3::ZERO, receiver::ANY)).sum();
    assert!((chances - 1.0).abs() < 1e-4);
    let scale = |i: i32| libm::exp2f((i % 240 - 120) as f32);
    let wild: Vec<_> = (0..20_000)
        .map(|i| LightBounds::all_round([Vec3::X * scale(i * 7); 2], scale(i * 13)))
        .collect();
    let wild = LightTree::new(&wild);
    let chances: f64 =
        (0..20_000).map(|i| f64::from(wild.chance(i, Vec3::ZERO, receiver::ANY))).sum();
    assert!((chances - 1.0).abs() < 1e-4, "{chances}");
    let dark = LightTree::new(&[LightBounds { energy: 0.0, ..same }; 2]);
    assert_eq!(dark.choose(Vec3::ZERO, receiver::ANY, 0.5).light, NO_LIGHT);
}

/// Near lights are chosen more often than far ones, and lights that face a hit more often than
/// lights that do not.
#[test]
fn choices_follow_the_light() {
    let near = |x: f32| LightBounds::all_round([Vec3::X * x; 2], 1.0);
    let two = LightTree::new(&[near(1.0), near(-3.0)]);
    let chance = two.chance(0, Vec3::ZERO, receiver::ANY);
    assert!((chance - 0.9).abs() < 1e-5, "{chance}");
    let distant = LightBounds { is_distant: true, falls_off: false, ..near(1.0) };
    let three = LightTree::new(&[near(1.0), near(-3.0), distant]);
    let far_away = Vec3::Y * 1e5;
    // Half of the choice goes to the two classes alike.
    let chance = three.chance(2, far_away, receiver::ANY);
    assert!((chance - 0.75).abs() < 1e-3, "{chance}");
}

#[test]
fn a_sky_alone_is_always_chosen() {
    let tree = LightTree::new(&[Light::EvenSky(EvenSky::new(Vec3::ONE)).bounds()]);
    for z in [-9.0, -2.5, -2.0, -1.5, -1.0, -0.1, 0.0, 0.3, 1.5, 7.0] {
        for n in [Vec3::Z, Vec3::X, -Vec3::Z] {
            let from = Vec3::new(0.1, -0.2, z);
            let chosen = tree.choose(from, receiver::pack(n), 0.4);
            assert_eq!((chosen.light, chosen.chance), (0, 1.0), "{from}, {n}");
            let mut choices = Choices::default();
            let (mut points, mut u) = (Vec3s::default(), [0.4; BATCH]);
            u[3] = 0.7;
            (0..BATCH).for_each(|i| points.set(i, from));
            let normals = [receiver::pack(n); BATCH];
            for isa in Isa::available() {
                tree.choose_all(isa, BATCH, &points, &normals, &u, &mut choices);
                assert!(choices.light.iter().all(|light| *light == 0), "{isa}, {from}, {n}");
                assert!(choices.chance.iter().all(|chance| *chance == 1.0), "{isa}, {from}, {n}");
            }
        }
    }
}
