//! The hierarchy against brute force, bit by bit, on every instruction set of this CPU.

use glam::Vec3;

use super::layout::stack_size;
use super::*;
use crate::primitives::{Curved, Triangle};
use crate::rays::NO_HIT;
use crate::structure::brute::Brute;
use crate::structure::interface::Geometry;
use crate::structure::testing::{Answers, Random};

/// Asks for the same hits as brute force, with spatial splits and without; returns how many there
/// are.
pub(crate) fn check(primitives: Primitives, rays: &Rays) -> usize {
    let oracle = Brute::build(primitives.clone(), Isa::Portable.into());
    let expected = Answers::of(&oracle, rays, Coherence::Incoherent);
    // The same triangles elsewhere.
    let mirrored = |p: Vec3| Vec3::new(p.y, -0.5 * p.z, p.x);
    let elsewhere = primitives.triangles.iter().map(|t| t.map(mirrored)).collect();
    let elsewhere = Primitives { triangles: elsewhere, curved: primitives.curved.clone() };
    let ways = Isa::available().into_iter().flat_map(|isa| {
        [false, true].map(|splits| (BuildOptions::new(isa).with_spatial_splits(splits), false))
    });
    let ways = ways.chain([(BuildOptions::new(Isa::best()), true)]);
    for (options, fits) in ways {
        let mut bvh = match fits {
            true => match Bvh::build(elsewhere.clone(), options).refitted(
                &primitives,
                f64::INFINITY,
                options,
            ) {
                Some(fitted) => fitted,
                None => continue,
            },
            false => Bvh::build(primitives.clone(), options),
        };
        for (coherence, is_far) in [
            (Coherence::Coherent, false),
            (Coherence::Incoherent, false),
            (Coherence::Incoherent, true),
        ] {
            bvh.is_far = is_far;
            let answers = Answers::of(&bvh, rays, coherence);
            for i in 0..rays.len() {
                let (o, d) = (rays.origin(i), rays.direction(i));
                assert_eq!(
                    answers.bits(i),
                    expected.bits(i),
                    "{options:?} {fits} {coherence:?} {o} {d}"
                );
            }
        }
    }
    (0..rays.len()).filter(|&i| expected.hits.primitive[i] != NO_HIT).count()
}

pub(crate) fn of_triangles(triangles: Vec<Triangle>) -> Primitives {
    Primitives { triangles, curved: vec![] }
}

#[test]
fn a_hundred_thousand_random_rays() {
    let mut random = Random::new(1);
    let (triangles, curved) = (random.triangles(100, 0.4), random.curved(9, 0.2));
    let rays = random.rays(100_000, 1.0);
    assert!(check(Primitives { triangles, curved }, &rays) > 30_000);
}

#[test]
fn bundles_of_rays() {
    let mut random = Random::new(8);
    let (triangles, curved) = (random.triangles(3_000, 0.1), random.curved(20, 0.1));
    let rays = random.bundles(8_000, 1.0);
    assert!(check(Primitives { triangles, curved }, &rays) > 2_000);
    let floor = [-9.0, 9.0]
        .map(|x| [Vec3::new(x, x, 0.0), Vec3::new(9.0, -9.0, 0.0), Vec3::new(-9.0, 9.0, 0.0)]);
    let triangles = [&floor[..], &random.triangles(200, 0.3)].concat();
    assert!(check(of_triangles(triangles), &random.bundles(8_000, 1.0)) > 4_000);
}

#[test]
fn many_small_triangles() {
    let mut random = Random::new(2);
    let triangles = random.triangles(5_000, 0.05);
    assert!(check(of_triangles(triangles), &random.rays(1_500, 1.0)) > 300);
}

#[test]
fn nothing_and_one() {
    let mut random = Random::new(3);
    let rays = random.rays(200, 1.0);
    assert_eq!(check(Primitives::default(), &rays), 0);
    assert!(check(of_triangles(random.triangles(1, 3.0)), &rays) > 10);
    let curved = vec![Curved::Sphere { center: Vec3::ZERO, radius: 0.5 }];
    assert!(check(Primitives { triangles: vec![], curved }, &rays) > 10);
    for n in 2..20 {
        check(of_triangles(random.triangles(n, 1.0)), &rays);
    }
    assert_eq!(check(of_triangles(random.triangles(9, 1.0)), &Rays::default()), 0);
}

#[test]
fn many_curved() {
    let mut random = Random::new(4);
    let curved = random.curved(300, 0.1);
    assert!(check(Primitives { triangles: vec![], curved }, &random.rays(3_000, 1.0)) > 500);
    let (triangles, curved) = (random.triangles(50, 0.3), random.curved(50, 0.2));
    assert!(check(Primitives { triangles, curved }, &random.rays(3_000, 1.0)) > 500);
}

/// Tiles of a floor: every box is flat, rays run in its plane and hit edges.
#[test]
fn flat() {
    let mut random = Random::new(5);
    for axis in 0..3 {
        let corner = |x: i32, y: i32| {
            let mut p = Vec3::ZERO;
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (x as f32 * 0.25, y as f32 * 0.25);
            p
        };
        let mut triangles = vec![];
        for x in -4..4 {
            for y in -4..4 {
                let [a, b] = [corner(x, y), corner(x + 1, y)];
                let [c, d] = [corner(x + 1, y + 1), corner(x, y + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        assert!(check(of_triangles(triangles), &random.rays(4_000, 1.0)) > 1_000);
    }
}

#[test]
fn coincident() {
    let mut random = Random::new(6);
    let some = random.triangles(7, 0.8);
    let triangles = (0..200).map(|i| some[i * i % 7]).collect();
    let sphere = Curved::Sphere { center: Vec3::ZERO, radius: 0.3 };
    let primitives = Primitives { triangles, curved: vec![sphere; 40] };
    assert!(check(primitives, &random.rays(4_000, 1.0)) > 500);
}

#[test]
fn huge_tiny_and_both() {
    let mut random = Random::new(7);
    for scale in [1e-30, 1e-11, 1e-4, 1e4, 1e9, 1e11, 1e25] {
        let triangles: Vec<_> =
            random.triangles(60, 0.5).iter().map(|t| t.map(|p| p * scale)).collect();
        let count = check(of_triangles(triangles), &random.rays(1_000, scale));
        // Beyond these the test of a triangle leaves the range of f32.
        assert!(count > 50 || !(1e-11..1e12).contains(&scale), "{scale}");
    }
    let mut triangles = random.triangles(60, 0.5);
    triangles.extend(random.triangles(30, 0.5).iter().map(|t| t.map(|p| p * 1e6)));
    triangles.extend(random.triangles(30, 0.5).iter().map(|t| t.map(|p| p * 1e-4)));
    let primitives = of_triangles(triangles);
    for scale in [1e-4, 1.0, 1e6] {
        assert!(check(primitives.clone(), &random.rays(1_000, scale)) > 50, "{scale}");
    }
}

#[test]
fn far_from_the_origin() {
    let mut random = Random::new(8);
    let shift = Vec3::new(3e5, -1e4, 7e3);
    let triangles: Vec<_> =
        random.triangles(200, 0.5).iter().map(|t| t.map(|p| p + shift)).collect();
    let mut rays = random.rays(3_000, 1.0);
    for axis in 0..3 {
        rays.origin[axis].iter_mut().for_each(|o| *o += shift[axis]);
    }
    assert!(check(of_triangles(triangles), &rays) > 1_000);
}

/// Needles, points, and numbers that are none.
#[test]
fn degenerate() {
    let mut random = Random::new(9);
    let mut triangles = random.triangles(30, 0.5);
    for i in 0..60 {
        let [a, b, c] = triangles[i % 30];
        triangles.push(match i % 6 {
            0 => [a, a, b],
            1 => [a, b, a + 0.5 * (b - a)],
            2 => [a, b, a + 0.5 * (b - a) + 1e-7 * c],
            3 => [a, Vec3::splat(f32::NAN), c],
            4 => [a, b, Vec3::splat(f32::INFINITY)],
            _ => [a; 3],
        });
    }
    let curved = vec![
        Curved::Sphere { center: Vec3::splat(f32::NAN), radius: 1.0 },
        Curved::Cylinder { base: Vec3::ZERO, top: Vec3::ZERO, radius: 0.5 },
        Curved::Sphere { center: Vec3::ZERO, radius: 1e-30 },
    ];
    assert!(check(Primitives { triangles, curved }, &random.rays(3_000, 1.0)) > 300);
}

/// Directions of every length, and ends of rays that leave nothing.
#[test]
fn odd_rays() {
    let mut random = Random::new(10);
    let primitives = of_triangles(random.triangles(100, 0.5));
    let mut rays = random.rays(4_000, 1.0);
    for i in 0..rays.len() {
        let scale = [1e-42, 1e-30, 1e-12, 1e-3, 1e5, 1e12, 1e30, 3e37][i % 8];
        rays.direction.iter_mut().for_each(|d| d[i] *= scale);
        rays.t_max[i] = [f32::INFINITY, 1.0 / scale, 0.0, -1.0, f32::NAN, f32::MAX][i / 8 % 6];
        if i % 50 == 0 {
            rays.origin[i % 3][i] *= 1e30;
        }
    }
    assert!(check(primitives, &rays) > 300);
}

/// A ray that ends exactly where a triangle is does not hit it; one ulp longer and it does.
#[test]
fn the_end_of_a_ray_is_not_hit() {
    let floor = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let mut rays = Rays::default();
    for t_max in [2.0, 2.0f32.next_up(), 2.0f32.next_down()] {
        rays.push(Vec3::new(0.0, 0.0, 2.0), Vec3::NEG_Z, t_max);
    }
    assert_eq!(check(of_triangles(vec![floor; 9]), &rays), 1);
}

#[test]
fn triangles_come_back_as_they_were() {
    let mut random = Random::new(11);
    let mut triangles = random.triangles(1_000, 0.3);
    triangles[17] = [Vec3::ONE; 3];
    let primitives = Primitives { triangles, curved: random.curved(5, 0.1) };
    let bvh = Bvh::build(primitives.clone(), Isa::Portable.into());
    assert_eq!(bvh.triangle_count(), 1_000);
    for (id, triangle) in (0..).zip(&primitives.triangles) {
        assert_eq!(bvh.triangle(id), *triangle);
    }
    assert_eq!(bvh.curved(), primitives.curved);
    assert_eq!(bvh.all_bounds(), primitives.all_bounds());
}

/// Every thread count and every instruction set: the builder's kernels are twins too.
#[test]
fn any_number_of_threads_and_any_instruction_set_build_the_same() {
    let mut random = Random::new(12);
    let mut triangles = random.triangles(80_000, 0.01);
    triangles.extend([[Vec3::ONE; 3]; 5]);
    triangles.extend([[Vec3::ZERO, Vec3::X, Vec3::Y]; 50]);
    let primitives = Primitives { triangles, curved: random.curved(100, 0.1) };
    let build = |threads, isa: Isa| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::build(primitives.clone(), isa.into()))
    };
    let one = build(1, Isa::Portable);
    let others = Isa::available().into_iter().map(|isa| build(1, isa));
    for other in others.chain([build(3, Isa::Portable)]) {
        assert_same(&one, &other);
    }
}

/// Asks for two hierarchies that are the same, bit by bit.
pub(crate) fn assert_same(one: &Bvh, other: &Bvh) {
    assert!(one.places.iter().zip(&other.places).all(|(a, b)| a.0 == b.0));
    assert_eq!(one.corners.rows(), other.corners.rows());
    assert_eq!(one.nodes.len(), other.nodes.len());
    assert!(
        one.nodes.iter().zip(&*other.nodes).all(|(a, b)| {
            a.planes == b.planes && a.children == b.children && a.order == b.order
        })
    );
}

/// Sizes that shrink geometrically tempt the heuristic to peel off one triangle at a time.
#[test]
fn depth_is_bounded() {
    let triangles: Vec<_> = (0..3_000)
        .map(|i| {
            let s = libm::powf(0.97, (i % 2_500) as f32);
            [Vec3::ZERO, Vec3::new(s, 0.0, s * 0.1), Vec3::new(0.0, s, s)]
        })
        .collect();
    let bvh = Bvh::build(of_triangles(triangles.clone()), Isa::Portable.into());
    assert!(bvh.stack <= stack_size(48 + 12));
    check(of_triangles(triangles), &Random::new(13).rays(500, 1.0));
}

#[test]
fn weighs_at_most_80_bytes_a_triangle() {
    let n = 50_000;
    let bvh = Bvh::build(of_triangles(Random::new(14).triangles(n, 0.01)), Isa::Portable.into());
    assert!(bvh.bytes() <= 80 * n, "{}", bvh.bytes() / n);
}

#[test]
fn what_has_moved_keeps_its_hierarchy() {
    let mut random = Random::new(31);
    let mut triangles = random.triangles(3_000, 0.05);
    triangles[5] = [triangles[5][0]; 3];
    let isa = Isa::best();
    let build = |triangles: &[Triangle], splits| {
        let options = BuildOptions::new(isa).with_spatial_splits(splits);
        Bvh::build(of_triangles(triangles.to_vec()), options)
    };
    let fit = |bvh: &Bvh, triangles: &[Triangle], growth| {
        bvh.refitted(&of_triangles(triangles.to_vec()), growth, isa.into())
    };
    let built = build(&triangles, false);
    let again = fit(&built, &triangles, 1.0).expect("nothing moved");
    assert_same(&again, &built);
    let moved: Vec<Triangle> = triangles.iter().map(|t| t.map(|p| p * 1.5 + Vec3::X)).collect();
    let fitted = fit(&built, &moved, 1.001).expect("it has grown evenly");
    assert_eq!(fitted.bounds, build(&moved, false).bounds);
    let shuffled: Vec<Triangle> = triangles.iter().rev().copied().collect();
    assert!(fit(&built, &shuffled, 1.5).is_none(), "it would be slow");
    let curved = Primitives { triangles: moved.clone(), curved: random.curved(1, 0.1) };
    assert!(built.refitted(&curved, f64::INFINITY, isa.into()).is_none());
}
