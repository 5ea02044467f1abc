//! The tree against the oracle that tests every primitive.

use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng, rngs::StdRng};

use super::tree::MAX_DEPTH;
use super::treelet::{Child, Stand};
use super::*;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Curved, Triangle};
use crate::structure::brute::Brute;
use crate::structure::testing::Answers;

/// Checks that tree and oracle agree to the last bit, for every instruction set, both kinds of
/// query and both hints, and as if the tree were far away.
fn check(name: &str, primitives: Primitives, rays: &Rays) {
    let oracle = Brute::build(primitives.clone(), Isa::Portable.into());
    let expected = Answers::of(&oracle, rays, Coherence::Incoherent);
    for isa in Isa::available() {
        let mut tree = KdTree::build(primitives.clone(), isa.into());
        for (coherence, is_far) in [
            (Coherence::Coherent, false),
            (Coherence::Incoherent, false),
            (Coherence::Coherent, true),
            (Coherence::Incoherent, true),
        ] {
            tree.is_far = is_far;
            let answers = Answers::of(&tree, rays, coherence);
            for i in 0..rays.len() {
                let told = [&expected, &answers].map(|a| (a.bits(i), a.hits.t[i]));
                let ray = (rays.origin(i), rays.direction(i), rays.t_max[i]);
                assert_eq!(told[0], told[1], "{name}, {isa:?}, {coherence:?}, ray {i} {ray:?}");
            }
        }
    }
}

/// What streams of each instruction set remember of tracing rays.
#[cfg(target_arch = "x86_64")]
fn streams(
    primitives: &Primitives,
    rays: &Rays,
    coherence: Coherence,
) -> impl Iterator<Item = Box<stream::Stream>> {
    Isa::available().into_iter().filter(|&isa| isa != Isa::Portable).map(move |isa| {
        let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
        hits.reset(rays.len());
        let tree = KdTree::build(primitives.clone(), isa.into());
        tree.intersect(rays, coherence, &mut hits, &mut scratch);
        scratch.stream.unwrap_or_default()
    })
}

fn point(rng: &mut impl Rng) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

/// A direction that often has components that are 0 or alike.
fn direction(rng: &mut impl Rng) -> Vec3 {
    loop {
        let d = match rng.random_range(0..4) {
            0 => point(rng).map(|x| (2.0 * x).trunc()),
            1 => point(rng).map(|x| if x.abs() < 0.5 { 0.0f32.copysign(x) } else { x }),
            _ => point(rng),
        };
        if d != Vec3::ZERO {
            return d;
        }
    }
}

/// Rays from about the scene: from anywhere, from corners, along triangles and toward corners.
fn rays_about(primitives: &Primitives, count: usize, seed: u64) -> Rays {
    let rng = &mut StdRng::seed_from_u64(seed);
    let ids = 0..primitives.len() as u32;
    let bounds = ids.fold(Bounds::EMPTY, |b, id| b.union(primitives.bounds(id)));
    let (center, half) = match bounds.is_empty() {
        true => (Vec3::ZERO, Vec3::ONE),
        false => (0.5 * bounds.min + 0.5 * bounds.max, 0.5 * bounds.max - 0.5 * bounds.min),
    };
    let corner = |rng: &mut StdRng| match primitives.triangles.len() {
        0 => center + half * point(rng).signum(),
        n => primitives.triangles[rng.random_range(0..n)][rng.random_range(0..3)],
    };
    let mut rays = Rays::with_capacity(count);
    for i in 0..count {
        let reach = if i % 3 == 0 { 3.0 } else { 1.0 };
        let origin = if i % 5 == 0 { corner(rng) } else { center + half * reach * point(rng) };
        let toward = match i % 4 {
            0 => corner(rng) - origin,
            1 => center + half * point(rng) - origin,
            _ => direction(rng) * if i % 8 == 3 { half } else { Vec3::ONE },
        };
        let toward = if toward == Vec3::ZERO { Vec3::X } else { toward };
        let t_max = match i % 3 {
            0 => rng.random_range(0.0f32..2.0).max(f32::MIN_POSITIVE),
            _ => f32::INFINITY,
        };
        rays.push(origin, toward, t_max);
    }
    rays
}

/// Runs of rays that go nearly the same way, as packets are made of; some of each go another way.
fn bundles(count: usize, seed: u64) -> Rays {
    let rng = &mut StdRng::seed_from_u64(seed);
    let mut rays = Rays::with_capacity(count);
    while rays.len() < count {
        let (origin, target) = (1.5 * point(rng), 0.7 * point(rng));
        let spread = [0.0, 1e-3, 0.1][rays.len() / 16 % 3];
        let lens = [0.0, 0.05][rays.len() / 48 % 2];
        for i in 0..rng.random_range(9..17) {
            let from = origin + lens * point(rng);
            let to = if i == 7 { point(rng) } else { target + spread * point(rng) };
            let t_max = if i % 5 == 3 { rng.random_range(0.1..1.5) } else { f32::INFINITY };
            rays.push(from, to - from, t_max);
        }
    }
    rays
}

fn check_about(name: &str, triangles: Vec<Triangle>, curved: Vec<Curved>, count: usize) {
    let primitives = Primitives { triangles, curved };
    let rays = rays_about(&primitives, count, 1);
    check(name, primitives, &rays);
}

fn soup(n: usize, size: f32, seed: u64) -> Vec<Triangle> {
    let rng = &mut StdRng::seed_from_u64(seed);
    (0..n)
        .map(|_| {
            let p = point(rng);
            [p, p + size * point(rng), p + size * point(rng)]
        })
        .collect()
}

/// A closed ball of `4 n^2` triangles.
fn ball(n: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let (a, b) = (i as f32 / n as f32, j as f32 / n as f32);
        let (polar, around) = (a * std::f32::consts::PI, b * std::f32::consts::PI);
        let sine = if i == n { 0.0 } else { libm::sinf(polar) };
        let around = if j == 2 * n { 0.0 } else { around };
        Vec3::new(sine * libm::cosf(around), sine * libm::sinf(around), libm::cosf(polar))
    };
    let quads = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
    quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// A flat grid of `2 n^2` triangles in the plane z = 0.
fn grid(n: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| Vec3::new(i as f32, j as f32, 0.0);
    let quads = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

fn moved(triangles: &[Triangle], scale: f32, by: Vec3) -> Vec<Triangle> {
    triangles.iter().map(|t| t.map(|p| scale * p + by)).collect()
}

fn shapes(n: usize, seed: u64) -> Vec<Curved> {
    let rng = &mut StdRng::seed_from_u64(seed);
    (0..n)
        .map(|i| {
            let (base, other) = (point(rng), point(rng));
            let radius = 0.3 * other.x.abs() + 0.01;
            match i % 3 {
                0 => Curved::Sphere { center: base, radius },
                1 => Curved::Cylinder { base, top: base + 0.3 * other, radius },
                _ => Curved::Cone { base, apex: base + 0.3 * other, radius },
            }
        })
        .collect()
}

#[test]
fn nothing_and_single_primitives() {
    check_about("empty", vec![], vec![], 1000);
    check_about("one triangle", soup(1, 1.0, 1), vec![], 20_000);
    check_about("one sphere", vec![], shapes(1, 1), 20_000);
    let flat = vec![[Vec3::ZERO; 3], [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X]];
    check_about("degenerate only", flat, vec![], 1000);
}

#[test]
fn random_triangles() {
    check_about("soup of small", soup(200, 0.2, 2), vec![], 100_000);
    check_about("soup of large", soup(100, 2.0, 3), vec![], 100_000);
    let mut mixed = soup(120, 0.1, 4);
    mixed.extend(soup(30, 3.0, 5));
    mixed.extend([[Vec3::ONE; 3], [Vec3::ZERO, Vec3::X, Vec3::X]]);
    check_about("mixed sizes", mixed, vec![], 100_000);
}

#[test]
fn bundles_of_rays() {
    let triangles = [soup(3000, 0.1, 13), soup(20, 2.0, 14)].concat();
    check("bundles", Primitives { triangles, curved: shapes(20, 15) }, &bundles(20_000, 16));
    let floor = [-9.0, 9.0]
        .map(|x| [Vec3::new(x, x, 0.0), Vec3::new(9.0, -9.0, 0.0), Vec3::new(-9.0, 9.0, 0.0)]);
    let triangles = [&floor[..], &ball(12), &soup(200, 0.3, 17)].concat();
    check("bundles over a floor", Primitives { triangles, curved: vec![] }, &bundles(20_000, 18));
    for scale in [1e-15, 1e-40, 1e15] {
        let triangles = moved(&ball(6), scale, Vec3::ZERO);
        let mut rays = bundles(5_000, 19);
        for axis in 0..3 {
            rays.origin[axis].iter_mut().for_each(|x| *x *= scale);
        }
        check("bundles of all sizes", Primitives { triangles, curved: vec![] }, &rays);
    }
    for length in [1e-28, 1e-20, 1e20, 1e37] {
        let triangles = ball(12);
        let mut rays = bundles(5_000, 25);
        for axis in 0..3 {
            rays.direction[axis].iter_mut().for_each(|x| *x *= length);
        }
        check("directions of all lengths", Primitives { triangles, curved: vec![] }, &rays);
    }
}

/// Rays that go the same way, to triangles that are much smaller than the gaps between them.
#[test]
fn rays_that_leave_packets() {
    let rng = &mut StdRng::seed_from_u64(21);
    let hill = |p: Vec3| Vec3::new(p.x, p.y, libm::sinf(1.7 * p.x) * libm::cosf(1.3 * p.y));
    let triangles: Vec<Triangle> = grid(64).into_iter().map(|t| t.map(hill)).collect();
    let mut rays = Rays::with_capacity(2048);
    for i in 0..2048 {
        let (block, place) = (i / 16, i % 16);
        let corner = Vec3::new((block % 8 * 8) as f32, (block / 8 % 8 * 8) as f32, 0.0);
        let target = corner + Vec3::new((place % 4 * 4) as f32, (place / 4 * 4) as f32, 0.0);
        let origin = Vec3::new(100.0, 90.0, 6.0);
        rays.push(origin, target + point(rng) - origin, f32::INFINITY);
    }
    let primitives = Primitives { triangles, curved: shapes(20, 22) };
    check("hills", primitives.clone(), &rays);
    #[cfg(target_arch = "x86_64")]
    for stream in streams(&primitives, &rays, Coherence::Coherent) {
        assert!(stream.took_over);
    }
}

/// Rays in all directions from places that sixteen of them have nearly in common, often right
/// beside where planes are.
#[test]
fn rays_that_start_together() {
    let rng = &mut StdRng::seed_from_u64(23);
    let step = |p: Vec3| Vec3::new(p.x, p.y, (p.x * p.y) % 3.0);
    let triangles: Vec<Triangle> = grid(12).into_iter().map(|t| t.map(step)).collect();
    let mut rays = Rays::with_capacity(16_384);
    while rays.len() < 16_384 {
        let mut place = 6.0 + 6.0 * point(rng);
        place.z /= 4.0;
        let spread = [0.0, 1e-6, 1e-3][rays.len() / 16 % 3];
        let is_beside = (rays.len() / 48).is_multiple_of(2);
        for i in 0..16 {
            let mut origin = if is_beside { place.round() } else { place } + spread * point(rng);
            if is_beside && i % 2 == 0 {
                origin = origin.map(f32::next_up);
            }
            let direction = if i % 3 == 0 { direction(rng) } else { point(rng) };
            let t_max = if i % 5 == 3 { rng.random_range(0.1..5.0) } else { f32::INFINITY };
            rays.push(origin, direction, t_max);
        }
    }
    let primitives = Primitives { triangles, curved: shapes(20, 24) };
    check("steps", primitives.clone(), &rays);
    #[cfg(target_arch = "x86_64")]
    for stream in streams(&primitives, &rays, Coherence::Incoherent) {
        assert!(stream.path.brought_down > 4000);
    }
}

/// What has one ray for each length of a batch: no lane is traced that holds none.
#[test]
fn batches_of_any_length() {
    let primitives = Primitives { triangles: ball(8), curved: vec![] };
    let all = bundles(70, 20);
    for count in 0..70 {
        let mut rays = Rays::with_capacity(count);
        (0..count).for_each(|i| rays.push(all.origin(i), all.direction(i), all.t_max[i]));
        check("batch", primitives.clone(), &rays);
    }
}

#[test]
fn meshes() {
    check_about("ball", ball(8), vec![], 100_000);
    check_about("grid", grid(10), vec![], 100_000);
    let box_of_grids = (0..3).flat_map(|axis| {
        grid(6)
            .into_iter()
            .map(move |t| t.map(|p| Vec3::from_array(std::array::from_fn(|i| p[(i + axis) % 3]))))
    });
    check_about("three walls", box_of_grids.collect(), vec![], 100_000);
}

#[test]
fn coincident_triangles() {
    check_about("same triangle", vec![soup(1, 1.0, 6)[0]; 100], vec![], 20_000);
    check_about("three balls in one", [ball(5), ball(5), ball(5)].concat(), vec![], 20_000);
}

#[test]
fn huge_tiny_and_far() {
    check_about("huge", moved(&ball(6), 1e15, Vec3::ZERO), vec![], 20_000);
    check_about("beyond products", moved(&ball(6), 1e30, Vec3::ZERO), vec![], 10_000);
    check_about("largest", moved(&ball(6), f32::MAX, Vec3::ZERO), vec![], 10_000);
    check_about("tiny", moved(&ball(6), 1e-15, Vec3::ZERO), vec![], 20_000);
    check_about("denormal", moved(&ball(6), 1e-40, Vec3::ZERO), vec![], 10_000);
    check_about("far", moved(&ball(6), 1.0, Vec3::new(1e4, -3e4, 2e5)), vec![], 20_000);
    let needles = soup(100, 1.0, 7).into_iter().map(|[a, b, _]| [a, b, b + Vec3::splat(1e-6)]);
    check_about("needles", needles.collect(), vec![], 100_000);
}

#[test]
fn curved_primitives() {
    check_about("shapes", vec![], shapes(60, 8), 100_000);
    check_about("shapes and triangles", soup(100, 0.2, 9), shapes(30, 10), 100_000);
    let wide = Curved::Sphere { center: Vec3::ZERO, radius: 1.0 };
    check_about("same sphere", ball(5), vec![wide; 5], 20_000);
}

#[test]
fn threads_do_not_change_the_tree() {
    let triangles = [ball(40), soup(3000, 0.1, 11)].concat();
    let built = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let primitives = Primitives { triangles: triangles.clone(), curved: vec![] };
        pool.install(|| KdTree::build(primitives, Isa::Portable.into()))
    });
    for tree in &built[1..] {
        assert_eq!(tree.words(), built[0].words());
    }
}

/// Long thin triangles crossing each other: references must not grow without bound.
#[test]
fn memory_is_bounded() {
    let rng = &mut StdRng::seed_from_u64(12);
    let n = 2000;
    let triangles: Vec<Triangle> = (0..n)
        .map(|_| [point(rng), point(rng), point(rng)].map(|p| 10.0 * p.normalize()))
        .collect();
    let tree = KdTree::build(Primitives { triangles, curved: vec![] }, Isa::Portable.into());
    assert!(tree.bytes() < 700 * n, "{}", tree.bytes() / n);
    assert!(planes(&tree, tree.root()) <= MAX_DEPTH);
    assert_eq!(treelets(&tree, Child::ROOT), tree.depth);
}

/// How many planes lie on the longest way down.
fn planes(tree: &KdTree, Stand { at, plane }: Stand) -> usize {
    if !at.is_treelet() {
        return 0;
    }
    let sides = (0..2).filter(|&side| !tree.treelet(at).is_empty(plane, side));
    let below = sides.map(|side| planes(tree, tree.treelet(at).beyond(at, plane, side)));
    1 + below.max().unwrap_or(0)
}

/// How many treelets lie on the longest way down.
fn treelets(tree: &KdTree, at: Child) -> usize {
    let children = tree.treelet(at).children.into_iter();
    let below = children.filter(|&child| child != Child::EMPTY && child.is_treelet());
    1 + below.map(|child| treelets(tree, child)).max().unwrap_or(0)
}
