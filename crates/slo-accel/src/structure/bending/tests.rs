//! Bending triangles against brute force over the triangles at each ray's time, bit by bit, on every
//! instruction set of this CPU.

use glam::Vec3;
use rand::RngExt;

use super::super::bvh::is_never_hit;
use super::*;
use crate::primitives::triangle::{self, ShearedRay};
use crate::rays::NO_HIT;
use crate::structure::testing::Random;

/// Times of rays: any, and now and then those of the shapes, or one beyond.
fn times(random: &mut Random, rays: usize, of_shapes: &[f32]) -> Vec<f32> {
    let (first, last) = (of_shapes[0], of_shapes[of_shapes.len() - 1]);
    let time = |i: usize| match i % 9 {
        0 => of_shapes[i / 9 % of_shapes.len()],
        1 => last + 0.5,
        2 => first - 1.0,
        _ => random.0.random_range(first..last),
    };
    (0..rays).map(time).collect()
}

/// The first hit of a ray: t, u, v, and the id.
fn brute(shapes: &[Vec<Triangle>], ray: (Vec3, Vec3, f32), at: Moment) -> ([f32; 3], u32) {
    let (starts, ends) = (&shapes[at.shape], &shapes[at.shape + 1]);
    let (origin, direction, mut t_max) = ray;
    let sheared = ShearedRay::new(origin, direction);
    let mut best = ([f32::INFINITY, 0.0, 0.0], NO_HIT);
    for (id, (start, end)) in (0..).zip(starts.iter().zip(ends)) {
        if is_never_hit(start, end) {
            continue;
        }
        let corner = |i: usize| start[i] + (end[i] - start[i]) * at.part;
        let moved = [corner(0), corner(1), corner(2)];
        if let Some(hit) = triangle::intersect(&sheared, &moved, t_max) {
            best = ([hit.t, hit.u, hit.v], id);
            t_max = hit.t;
        }
    }
    best
}

/// Asks for the same hits as brute force, of what was built and of what was fitted from the reverse;
/// returns how many there are.
fn check(shapes: &[Vec<Triangle>], of_shapes: &[f32], rays: &Rays, times: &[f32]) -> usize {
    let any = Bending::build(shapes, of_shapes, Isa::Portable);
    let expected: Vec<_> = (0..rays.len())
        .map(|i| {
            let ray = (rays.origin(i), rays.direction(i), rays.t_max[i]);
            brute(shapes, ray, any.moment(times[i]))
        })
        .collect();
    let mut scratch = Scratch::default();
    let (mut hits, mut blocked) = (Hits::default(), vec![]);
    let reverse: Vec<_> = shapes.iter().rev().cloned().collect();
    let ways = Isa::available().into_iter().map(|isa| (isa, false)).chain([(Isa::best(), true)]);
    for (isa, fits) in ways {
        let mut bending = if fits {
            let before = Bending::build(&reverse, of_shapes, isa);
            Bending::build_like(&before, f64::INFINITY, shapes, of_shapes, isa)
        } else {
            Bending::build(shapes, of_shapes, isa)
        };
        for (coherence, is_far) in [
            (Coherence::Coherent, false),
            (Coherence::Incoherent, false),
            (Coherence::Coherent, true),
        ] {
            bending.pieces.iter_mut().for_each(|piece| piece.is_far = is_far);
            bending.intersect(rays, times, coherence, &mut hits, &mut scratch);
            bending.occluded(rays, times, coherence, &mut blocked, &mut scratch);
            for (i, &(hit, id)) in expected.iter().enumerate() {
                let found = [hits.t[i], hits.u[i], hits.v[i]];
                let name = || format!("{isa} {fits} {coherence:?} ray {i} at {}", times[i]);
                assert_eq!(hits.primitive[i], id, "{}", name());
                assert_eq!(found.map(f32::to_bits), hit.map(f32::to_bits), "{}", name());
                assert_eq!(blocked[i], id != NO_HIT, "{}", name());
            }
        }
    }
    expected.iter().filter(|(_, id)| *id != NO_HIT).count()
}

/// Shapes that differ by up to `reach` in each corner.
fn shapes(random: &mut Random, first: &[Triangle], count: usize, reach: f32) -> Vec<Vec<Triangle>> {
    let mut shapes = vec![first.to_vec()];
    for i in 1..count {
        let moved = |t: &Triangle| t.map(|p| p + random.vector(reach));
        let next = shapes[i - 1].iter().map(moved).collect();
        shapes.push(next);
    }
    shapes
}

#[test]
fn many_rays_and_few_triangles() {
    let mut random = Random::new(1);
    let first = random.triangles(100, 0.4);
    let shapes = shapes(&mut random, &first, 2, 0.3);
    for rays in [random.rays(20_000, 1.0), random.bundles(20_000, 1.0)] {
        let times = times(&mut random, rays.len(), &[0.0, 1.0]);
        assert!(check(&shapes, &[0.0, 1.0], &rays, &times) > 5_000);
    }
}

#[test]
fn many_triangles_and_few_rays() {
    let mut random = Random::new(2);
    let first = random.triangles(5_000, 0.05);
    let shapes = shapes(&mut random, &first, 2, 0.1);
    let rays = random.bundles(1_500, 1.0);
    let times = times(&mut random, rays.len(), &[0.0, 1.0]);
    assert!(check(&shapes, &[0.0, 1.0], &rays, &times) > 300);
}

#[test]
fn several_pieces_of_any_length() {
    let mut random = Random::new(3);
    let first = random.triangles(300, 0.2);
    for of_shapes in [&[-0.5, 2.0][..], &[0.0, 0.3, 1.0], &[0.0, 0.25, 0.5, 0.75, 1.0]] {
        let shapes = shapes(&mut random, &first, of_shapes.len(), 0.2);
        let rays = random.rays(2_000, 1.0);
        let times = times(&mut random, rays.len(), of_shapes);
        assert!(check(&shapes, of_shapes, &rays, &times) > 300);
    }
}

#[test]
fn nothing_and_one() {
    let mut random = Random::new(4);
    let rays = random.rays(500, 1.0);
    let times = times(&mut random, rays.len(), &[0.0, 1.0]);
    assert_eq!(check(&[vec![], vec![]], &[0.0, 1.0], &rays, &times), 0);
    for n in 1..20 {
        let first = random.triangles(n, 1.0);
        let shapes = shapes(&mut random, &first, 2, 1.0);
        assert!(check(&shapes, &[0.0, 1.0], &rays, &times) > 5);
    }
    let first = random.triangles(9, 1.0);
    assert_eq!(check(&[first.clone(), first], &[0.0, 1.0], &Rays::default(), &[]), 0);
}

/// A sheet that folds, with rays through its corners and edges at the ray's time: no gap, so a ray
/// that goes through the sheet's inside always hits.
#[test]
fn folding_sheet_has_no_gaps() {
    const N: usize = 12;
    let mut random = Random::new(5);
    let point = |x: usize, y: usize, lift: f32| {
        let (x, y) = (x as f32 / N as f32 - 0.5, y as f32 / N as f32 - 0.5);
        Vec3::new(x, y * (1.0 - 0.3 * lift), lift * 0.2 * libm::sinf(20.0 * x + 5.0 * y))
    };
    let sheet = |lift: f32| {
        let mut triangles = vec![];
        for x in 0..N {
            for y in 0..N {
                let [a, b] = [point(x, y, lift), point(x + 1, y, lift)];
                let [c, d] = [point(x + 1, y + 1, lift), point(x, y + 1, lift)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        triangles
    };
    let (start, end) = (sheet(0.0), sheet(1.0));
    let shapes = [start, end];
    let mut rays = Rays::default();
    let mut times = vec![];
    for i in 0..4_000 {
        let time = if i % 7 == 0 { 0.0 } else { random.0.random_range(0.0..1.0) };
        let (x, y) = (random.0.random_range(1..N), random.0.random_range(1..N));
        let at = |x, y| {
            let (a, b) = (point(x, y, 0.0), point(x, y, 1.0));
            a + (b - a) * time
        };
        let on_edge = at(x, y) + (at(x - 1, y) - at(x, y)) * random.0.random_range(0.0..1.0);
        let target = if i % 2 == 0 { at(x, y) } else { on_edge };
        let origin = target + Vec3::new(random.vector(0.5).x, random.vector(0.5).y, 2.0);
        rays.push(origin, target - origin, f32::INFINITY);
        times.push(time);
    }
    assert_eq!(check(&shapes, &[0.0, 1.0], &rays, &times), rays.len());
}

#[test]
fn huge_tiny_and_far_from_the_origin() {
    let mut random = Random::new(6);
    for (scale, shift) in [
        (1e-11, Vec3::ZERO),
        (1e-4, Vec3::ZERO),
        (1e9, Vec3::ZERO),
        (1e25, Vec3::ZERO),
        (1.0, Vec3::new(3e5, -1e4, 7e3)),
        (1.0, Vec3::new(1e6, 1e6, -1e6)),
    ] {
        let first = random.triangles(200, 0.5);
        let shapes: Vec<Vec<Triangle>> = shapes(&mut random, &first, 2, 0.5)
            .iter()
            .map(|shape| shape.iter().map(|t| t.map(|p| p * scale + shift)).collect())
            .collect();
        let mut rays = random.rays(2_000, scale);
        for axis in 0..3 {
            rays.origin[axis].iter_mut().for_each(|o| *o += shift[axis]);
        }
        let times = times(&mut random, rays.len(), &[0.0, 1.0]);
        let count = check(&shapes, &[0.0, 1.0], &rays, &times);
        assert!(count > 300 || scale > 1e12, "{scale} {shift}");
    }
}

/// Needles, points, numbers that are none, and triangles that have no area at some time only.
#[test]
fn degenerate() {
    let mut random = Random::new(7);
    let first = random.triangles(60, 0.5);
    let mut shapes = shapes(&mut random, &first, 2, 0.3);
    for i in 0..120 {
        let ([a, b, c], [d, e, f]) = (shapes[0][i % 60], shapes[1][i % 60]);
        let (start, end) = match i % 8 {
            0 => ([a, a, b], [d, d, e]),
            1 => ([a, b, c], [d, d, d]),
            2 => ([a; 3], [d, e, f]),
            3 => ([a, b, c], [d, Vec3::splat(f32::NAN), f]),
            4 => ([a, b, Vec3::splat(f32::INFINITY)], [d, e, f]),
            5 => ([a, b, Vec3::splat(f32::MAX)], [d, e, Vec3::splat(f32::MIN)]),
            6 => ([a, b, c], [b, a, c]),
            _ => ([a, b, a + 0.5 * (b - a)], [d, e, f]),
        };
        shapes[0].push(start);
        shapes[1].push(end);
    }
    let rays = random.rays(4_000, 1.0);
    let times = times(&mut random, rays.len(), &[0.0, 1.0]);
    assert!(check(&shapes, &[0.0, 1.0], &rays, &times) > 1_000);
}

/// At rest, the hits are those of a structure that does not move.
#[test]
fn at_rest_it_is_a_still_structure() {
    let mut random = Random::new(8);
    let triangles = random.triangles(2_000, 0.1);
    let rays = random.bundles(4_000, 1.0);
    let times = times(&mut random, rays.len(), &[0.0, 1.0]);
    let bending = Bending::build(&[triangles.clone(), triangles.clone()], &[0.0, 1.0], Isa::best());
    let still = super::super::Structure::build(Default::default(), triangles, Isa::best());
    assert_eq!(bending.bounds(), still.bounds());
    let mut scratch = Scratch::default();
    let (mut a, mut b) = (Hits::default(), Hits::default());
    bending.intersect(&rays, &times, Coherence::Coherent, &mut a, &mut scratch);
    still.intersect(&rays, Coherence::Coherent, &mut b, &mut scratch);
    assert_eq!((a.t, a.u, a.v, a.primitive), (b.t, b.u, b.v, b.primitive));
}

#[test]
fn triangles_are_where_their_shapes_say() {
    let mut random = Random::new(9);
    let first = random.triangles(100, 0.3);
    let shapes = shapes(&mut random, &first, 3, 0.3);
    let bending = Bending::build(&shapes, &[0.0, 0.5, 1.0], Isa::Portable);
    assert_eq!(bending.triangle_count(), 100);
    assert_eq!(bending.moment(0.75), Moment { shape: 1, part: 0.5 });
    let triangles = shapes[0].iter().zip(&shapes[1]).zip(&shapes[2]);
    for (id, ((&a, &b), &c)) in (0..100).zip(triangles) {
        assert_eq!(bending.triangle(id, 0.0), a);
        assert_eq!(bending.triangle(id, 0.5), b);
        let there = bending.triangle(id, 1.0);
        for corner in 0..3 {
            assert_eq!(there[corner], b[corner] + (c[corner] - b[corner]));
        }
        assert_eq!(bending.triangle(id, -1.0), a);
    }
}

#[test]
fn a_hierarchy_stays_as_long_as_rays_do_not_cost_too_much() {
    let mut random = Random::new(11);
    let first = random.triangles(3_000, 0.05);
    let isa = Isa::best();
    let moving = |by: f32| first.iter().map(|t| t.map(|p| p * (1.0 + by))).collect::<Vec<_>>();
    let built = Bending::build(&[first.clone(), moving(0.1)], &[0.0, 1.0], isa);
    let piece = &built.pieces[0];
    // What grows evenly costs the same: the hierarchy is that of the first shapes.
    let grown = piece.refitted_moving(&moving(0.1), &moving(0.21), 1.01, isa).expect("it fits");
    // Whatever is built anew over the same shapes has the boxes that it had.
    let again = piece.refitted_moving(&first, &moving(0.1), 1.0, isa).expect("nothing moved");
    super::super::bvh::tests::assert_same(&again, piece);
    // Chaos costs, and the cost is that of the hierarchy which was built, however often it is fitted.
    let mut shaken = grown;
    let mut fitted = 0;
    let mut shapes = [moving(0.1), moving(0.2)];
    loop {
        shapes = shapes.map(|shape| {
            shape
                .iter()
                .map(|t| {
                    let by = random.vector(0.1);
                    t.map(|p| p + by)
                })
                .collect()
        });
        match shaken.refitted_moving(&shapes[0], &shapes[1], 1.5, isa) {
            Some(next) => shaken = next,
            None => break,
        }
        fitted += 1;
        assert!(fitted < 50, "the cost grows without end");
    }
    assert!(fitted > 0);
    // Other triangles, or others without area, do not fit.
    let fewer = &first[1..];
    assert!(piece.refitted_moving(fewer, fewer, f64::INFINITY, isa).is_none());
    let mut flat = first.clone();
    flat[7] = [flat[7][0]; 3];
    assert!(piece.refitted_moving(&flat, &flat, f64::INFINITY, isa).is_none());
}

#[test]
fn any_number_of_threads_builds_the_same() {
    let mut random = Random::new(10);
    let first = random.triangles(50_000, 0.01);
    let shapes = shapes(&mut random, &first, 2, 0.05);
    let build = |threads, isa: Isa| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bending::build(&shapes, &[0.0, 1.0], isa))
    };
    let one = build(1, Isa::Portable);
    for other in [build(3, Isa::Portable), build(2, Isa::best())] {
        super::super::bvh::tests::assert_same(&one.pieces[0], &other.pieces[0]);
    }
}
