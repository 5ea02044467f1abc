//! Hierarchies with spatial splits: what is in them, and that rays find all of it.

use glam::{DVec3, Vec3};
use rand::RngExt;

use super::cut::cut;
use super::planes::BINS;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::triangle::POSITION_ERROR;
use crate::primitives::{Primitives, Triangle};
use crate::rays::Rays;
use crate::structure::BuildOptions;
use crate::structure::bvh::hierarchy::Bvh;
use crate::structure::bvh::layout::{Child, Node, WIDTH, stack_size};
use crate::structure::bvh::tests::{assert_same, check, of_triangles};
use crate::structure::interface::{Geometry, SpatialIndex};
use crate::structure::testing::Random;

fn build(primitives: Primitives) -> Bvh {
    Bvh::build(primitives, BuildOptions::new(Isa::best()).with_spatial_splits(true))
}

/// Triangles that are a thousand times as long as wide.
fn needles(random: &mut Random, n: usize, length: f32) -> Vec<Triangle> {
    (0..n)
        .map(|_| {
            let (p, along) = (random.vector(1.0), random.vector(length));
            let across = random.vector(1e-3 * length);
            [p, p + along, p + 0.5 * along + across]
        })
        .collect()
}

/// Small triangles, and a needle to every ten of them.
fn mixture(random: &mut Random, n: usize) -> Vec<Triangle> {
    [needles(random, n / 11, 1.0), random.triangles(n - n / 11, 0.02)].concat()
}

/// The blocks of triangles, by first slot and length.
fn blocks(bvh: &Bvh) -> impl Iterator<Item = (usize, usize)> {
    let children = bvh.nodes.iter().flat_map(|node| node.children);
    children.filter(|child| child.is_block()).map(|child| (child.index(), child.block_len()))
}

/// How many boxes a ray through everything is expected to meet, leaves and nodes alike.
fn expected_boxes(bvh: &Bvh) -> f32 {
    let half_area = |planes: &[[f32; WIDTH]; 6], i: usize| {
        let d = [0, 1, 2].map(|axis| planes[2 * axis + 1][i] - planes[2 * axis][i]);
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    };
    let node_area = |node: &Node| -> f32 {
        let used = (0..WIDTH).filter(|&i| node.children[i] != Child::DONE);
        used.map(|i| half_area(&node.planes, i)).sum()
    };
    bvh.nodes.iter().map(node_area).sum::<f32>() / (bvh.bounds.area() * 0.5)
}

#[test]
fn long_triangles_are_cut_and_cost_less() {
    let triangles = mixture(&mut Random::new(1), 4_400);
    let plain = Bvh::build(of_triangles(triangles.clone()), Isa::best().into());
    let bvh = build(of_triangles(triangles));
    let slots = bvh.corners.slots();
    assert!((4_800..=5_500).contains(&slots), "{slots}");
    let ratio = expected_boxes(&bvh) / expected_boxes(&plain);
    assert!(ratio < 0.85, "{ratio}");
}

/// A sheet of small triangles, whose neighbours touch.
#[test]
fn where_nothing_overlaps_the_tree_is_the_plain_one() {
    let corner = |x: u32, y: u32| {
        let (x, y) = (x as f32 * 0.01, y as f32 * 0.01);
        Vec3::new(x, y, 0.1 * libm::sinf(9.0 * x) * libm::sinf(7.0 * y))
    };
    let mut triangles = vec![];
    for (x, y) in (0..100 * 100).map(|i| (i % 100, i / 100)) {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let primitives = of_triangles(triangles);
    assert_same(&build(primitives.clone()), &Bvh::build(primitives, Isa::best().into()));
}

#[test]
fn a_leaf_holds_a_triangle_once_and_places_are_first_slots() {
    let mut random = Random::new(2);
    let mut triangles = mixture(&mut random, 3_000);
    triangles[17] = [Vec3::ONE; 3];
    let primitives = Primitives { triangles, curved: random.curved(50, 0.2) };
    let bvh = build(primitives.clone());
    assert!(bvh.corners.slots() > bvh.places.len());
    for (slot, len) in blocks(&bvh) {
        let ids: Vec<_> = (0..len).map(|lane| bvh.corners.id(slot, len, lane)).collect();
        assert!(ids.is_sorted_by(|a, b| a < b), "{slot} {len}");
    }
    assert_eq!(blocks(&bvh).map(|(_, len)| len).sum::<usize>() + 1, bvh.corners.slots());
    assert_eq!(bvh.triangle_count(), 3_000);
    for (id, triangle) in (0..).zip(&primitives.triangles) {
        let place = bvh.places[id as usize];
        let is_first = |&(slot, len): &(usize, usize)| {
            (0..len).any(|lane| bvh.corners.id(slot, len, lane) == id)
        };
        let first = blocks(&bvh).filter(is_first).map(|(slot, _)| slot).min();
        assert!(first.is_none_or(|first| first == place.slot()));
        assert_eq!(bvh.corners.id(place.slot(), place.count(), place.lane()), id);
        assert_eq!(bvh.triangle(id), *triangle);
    }
    assert_eq!(bvh.curved(), primitives.curved);
    assert_eq!(bvh.all_bounds(), primitives.all_bounds());
}

/// So many that bins are filled in parallel.
#[test]
fn any_number_of_threads_and_any_instruction_set_build_the_same() {
    let mut random = Random::new(3);
    let triangles = [needles(&mut random, 30_000, 0.7), random.triangles(50_000, 0.02)].concat();
    let primitives = Primitives { triangles, curved: random.curved(100, 0.1) };
    let build = |threads, isa| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = BuildOptions::new(isa).with_spatial_splits(true);
        pool.install(|| Bvh::build(primitives.clone(), options))
    };
    let one = build(1, Isa::Portable);
    assert!(one.corners.slots() > 90_000);
    let others = Isa::available().into_iter().map(|isa| build(1, isa));
    for other in others.chain([build(3, Isa::Portable)]) {
        assert_same(&one, &other);
    }
}

#[test]
fn weighs_at_most_80_bytes_a_triangle() {
    for n in [3_000, 30_000] {
        let bvh = build(of_triangles(mixture(&mut Random::new(4), n)));
        assert!(bvh.corners.slots() > n * 11 / 10, "{}", bvh.corners.slots());
        assert!(bvh.bytes() <= 80 * n, "{}", bvh.bytes() / n);
    }
}

/// Sizes that shrink geometrically, long ones among short ones.
#[test]
fn depth_is_bounded() {
    let triangles: Vec<_> = (0..3_000)
        .map(|i| {
            let s = libm::powf(0.97, (i % 2_500) as f32);
            match i % 9 {
                0 => [Vec3::new(-s, -s, -s), Vec3::new(s, 0.9 * s, s), Vec3::new(s, s, s)],
                _ => [Vec3::ZERO, Vec3::new(s, 0.0, s * 0.1), Vec3::new(0.0, 0.1 * s, s)],
            }
        })
        .collect();
    let bvh = build(of_triangles(triangles));
    assert!(bvh.corners.slots() > 3_000);
    assert!(bvh.stack <= stack_size(48 + 13));
}

#[test]
fn needles_in_any_light() {
    let mut random = Random::new(5);
    let triangles = [needles(&mut random, 300, 2.0), random.triangles(300, 0.05)].concat();
    let primitives = Primitives { triangles, curved: random.curved(9, 0.2) };
    assert!(build(primitives.clone()).corners.slots() > 700);
    assert!(check(primitives.clone(), &random.rays(6_000, 1.0)) > 1_000);
    assert!(check(primitives, &random.bundles(4_000, 1.0)) > 500);
}

/// Rays that run in the planes that space may be cut by, at the root and in its boxes.
#[test]
fn rays_in_the_planes_of_cuts() {
    let mut random = Random::new(6);
    for shift in [Vec3::ZERO, Vec3::new(30.0, -7.0, 100.0)] {
        let mut triangles = needles(&mut random, 100, 2.0);
        triangles.extend(random.triangles(300, 0.1));
        triangles.iter_mut().flatten().for_each(|p| *p += shift);
        let bvh = build(of_triangles(triangles.clone()));
        assert!(bvh.corners.slots() > 430, "{}", bvh.corners.slots());
        let mut rays = Rays::with_capacity(9_000);
        for i in 0..9_000 {
            let axis = i % 3;
            let plane = if i % 2 == 0 {
                let width = bvh.bounds.size()[axis] / BINS as f32;
                bvh.bounds.min[axis] + random.0.random_range(1..BINS) as f32 * width
            } else {
                let planes = &bvh.nodes[random.0.random_range(0..bvh.nodes.len())].planes;
                planes[2 * axis + i % 2][random.0.random_range(0..2)]
            };
            let (mut origin, mut target) = (random.vector(1.5) + shift, random.vector(0.7) + shift);
            (origin[axis], target[axis]) = (plane, plane);
            rays.push(origin, target - origin, f32::INFINITY);
        }
        let count = check(of_triangles(triangles), &rays);
        assert!(count > 400, "{count}");
    }
}

/// Triangles that reach far beyond what rays see of them: a hit's error is that of the whole
/// triangle, the boxes of its pieces are small and near the origin.
#[test]
fn huge_triangles_grazed_near_the_origin() {
    let mut random = Random::new(7);
    for reach in [1e2, 1e3, 3e4] {
        let mut triangles = random.triangles(400, 0.1);
        for i in 0..60 {
            // Half of them nearly along axes: their pieces have the thinnest boxes.
            let tilt = [1.0, 1e-5][i % 2];
            let beside = |axis: usize, off: Vec3| Vec3::AXES[axis % 3] + off;
            let along = beside(i, random.vector(tilt)).normalize() * reach;
            let across = beside(i + 1, random.vector(tilt)).normalize() * reach * 1e-3;
            let p = random.vector(0.8);
            triangles.push([p - along, p + along - across, p + 0.8 * along + across]);
        }
        let huge = triangles[400..].to_vec();
        let mut rays = random.rays(2_000, 1.0);
        for i in 0..8_000 {
            // Nearly in the plane of one, through a point of it near the origin.
            let [a, b, c] = huge[i % 60];
            let (u, v) = (0.5 + random.vector(1e-3).x / reach, random.vector(1e-3).y);
            let on = a + (b - a) * u + (c - a) * v * v;
            let along = (b - a).normalize() + random.vector([1e-4, 1e-6][i / 120 % 2]);
            let aside = random.vector([1e-6, 1e-8][i / 60 % 2] * reach);
            rays.push(on - 2.0 * along + aside, along, f32::INFINITY);
        }
        let primitives = of_triangles(triangles);
        let bvh = build(primitives.clone());
        assert!(bvh.corners.slots() > 460, "{reach} {}", bvh.corners.slots());
        assert!(check(primitives, &rays) > 2_000, "{reach}");
    }
}

/// However often a triangle is cut, each point of it lies deep enough in the box of a piece.
#[test]
fn pieces_hold_all_of_a_triangle() {
    let mut random = Random::new(8);
    for round in 0..400 {
        let size = [0.1, 1.0, 1e3, 1e6][round % 4];
        let p = random.vector(1.0);
        let triangle = [p, p + random.vector(size), p + random.vector(size)];
        let mut pieces = vec![Bounds::of_points(triangle)];
        for axis in (0..3).cycle().take(6) {
            pieces = pieces
                .into_iter()
                .flat_map(|piece| {
                    let at = piece.min[axis] + 0.3 * piece.size()[axis];
                    let parts = cut(&triangle, piece, axis, at);
                    assert!(parts.iter().any(Option::is_some));
                    parts.into_iter().flatten()
                })
                .collect();
        }
        assert!(pieces.len() >= 8);
        let largest = triangle.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let deep = f64::from(POSITION_ERROR * largest);
        let [a, b, c] = triangle.map(Vec3::as_dvec3);
        for _ in 0..200 {
            let (u, v) = (random.0.random::<f64>(), random.0.random::<f64>());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = a + (b - a) * u + (c - a) * v;
            let holds = |piece: &Bounds| {
                (piece.min.as_dvec3() + DVec3::splat(deep)).cmple(point).all()
                    && (piece.max.as_dvec3() - DVec3::splat(deep)).cmpge(point).all()
            };
            assert!(pieces.iter().any(holds), "{triangle:?} {point}");
        }
    }
}

#[test]
fn a_flat_cut_leaves_boxes_of_the_parts() {
    let triangle = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
    let [left, right] = cut(&triangle, Bounds::of_points(triangle), 0, 3.0).map(Option::unwrap);
    let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-4;
    assert!(near(left.max, Vec3::new(3.0, 4.0, 0.0)) && near(left.min, Vec3::ZERO), "{left:?}");
    assert!(near(right.min, Vec3::new(3.0, 0.0, 0.0)), "{right:?}");
    assert!(near(right.max, Vec3::new(4.0, 1.0, 0.0)), "{right:?}");
}
