//! Polygons of every shape, each against its own area.

use glam::{DMat3, DVec3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::super::normals::corners;
use super::Polygons;

/// Triangles of the polygon, and warnings about it.
fn cut(points: &[DVec3]) -> (Vec<[u32; 3]>, Vec<String>) {
    let len = points.len() as u32;
    let mut faces: Vec<_> = (2..len).map(|i| [0, i - 1, i]).collect();
    let mut polygons = Polygons::default();
    polygons.push(7, 0, points.len());
    let mut uvs: Vec<_> = faces.iter().map(|face| face.map(|i| i + 100)).collect();
    let warnings = polygons.cut(points, &mut faces, [&mut uvs, &mut []]);
    let uvs: Vec<_> = uvs.into_iter().map(|uvs| uvs.map(|i| i - 100)).collect();
    assert_eq!(uvs, faces, "what belongs to corners goes with them");
    (faces, warnings)
}

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

fn doubled_normal(points: &[DVec3], face: [u32; 3]) -> DVec3 {
    let [a, b, c] = corners(points, face);
    (b - a).cross(c - a)
}

/// No triangle is turned over, and their areas add up to that of the polygon: so they lie side by
/// side.
fn check_tiling(points: &[DVec3], faces: &[[u32; 3]], what: &str) {
    assert_eq!(faces.len(), points.len() - 2, "{what}");
    let len = points.len() as u32;
    let whole: DVec3 = (2..len).map(|i| doubled_normal(points, [0, i - 1, i])).sum();
    let normal = whole.normalize();
    let mut sum = 0.0;
    for &face in faces {
        let area = doubled_normal(points, face).dot(normal);
        assert!(area >= -1e-9 * whole.length(), "{what}: {face:?} is turned over");
        sum += area.abs();
    }
    assert!((sum / whole.length() - 1.0).abs() < 1e-9, "{what}: {sum} for {}", whole.length());
}

/// Wherever the polygon begins, whichever way it turns and faces.
fn check(points: &[[f64; 2]], what: &str) {
    let turned = DMat3::from_cols_array(&[0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6]);
    for first in 0..points.len() {
        let mut begun = flat(points);
        begun.rotate_left(first);
        for mirrored in [false, true] {
            if mirrored {
                begun.reverse();
            }
            let there: Vec<_> = begun.iter().map(|&p| turned * p + 3.0).collect();
            for points in [&begun, &there] {
                let (faces, warnings) = cut(points);
                assert_eq!(warnings, [""; 0], "{what} from {first}");
                check_tiling(points, &faces, what);
            }
        }
    }
}

const ELL: [[f64; 2]; 6] = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];

#[test]
fn polygons_with_inner_corners_are_covered_and_nothing_else() {
    check(&ELL, "an L");
    check(&[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]], "an arrow");
    let comb: Vec<_> =
        (0..20).map(|i| [f64::from(i), if i % 2 == 0 { 5.0 } else { 1.0 }]).collect();
    check(
        &[&[[19.0, 0.0], [0.0, 0.0]][..], &comb].concat().into_iter().rev().collect::<Vec<_>>(),
        "a comb",
    );
    let with_middles = [
        [0.0, 0.0],
        [1.5, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [1.0, 3.0],
        [0.0, 3.0],
        [0.0, 1.0],
    ];
    check(&with_middles, "an L with corners on its edges");
}

#[test]
fn a_frame_whose_hole_is_joined_by_a_bridge_stays_open() {
    let outside = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
    let hole = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]];
    let bridged = [&outside[..], &outside[..1], &hole, &hole[..1]].concat();
    // The order is that of a pen: around, over the bridge, around the hole, and back.
    let frame = [&bridged[..5], &bridged[5..]].concat();
    check(&frame, "a frame");
}

#[test]
fn convex_polygons_stay_fans() {
    let mut rng = StdRng::seed_from_u64(1);
    for corners in 4..40 {
        let step = std::f64::consts::TAU / f64::from(corners);
        let turn: f64 = rng.random();
        let angle = |i: u32| step * (f64::from(i) + turn);
        // Rounded to six digits, as files have it.
        let round = |x: f64| (x * 1e6).round() / 1e6;
        let points: Vec<_> = (0..corners)
            .map(|i| [round(libm::cos(angle(i))), round(libm::sin(angle(i)))])
            .collect();
        let fan: Vec<_> = (2..corners).map(|i| [0, i - 1, i]).collect();
        assert_eq!(cut(&flat(&points)), (fan, Vec::new()));
    }
    let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]];
    let bent = bent.map(DVec3::from_array);
    assert_eq!(cut(&bent).0, [[0, 1, 2], [0, 2, 3]]);
    let fan_that_fits = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
    assert_eq!(cut(&flat(&fan_that_fits)).0, [[0, 1, 2], [0, 2, 3]]);
}

/// Star-shaped polygons with random radii, which are simple.
#[test]
fn random_polygons_are_tiled() {
    let mut rng = StdRng::seed_from_u64(2);
    for corners in (4..60).chain([500, 5000]) {
        for _ in 0..if corners < 100 { 50 } else { 1 } {
            let step = std::f64::consts::TAU / f64::from(corners);
            let points: Vec<_> = (0..corners)
                .map(|i| {
                    let radius = rng.random_range(0.1..1.0);
                    let angle = step * f64::from(i);
                    [radius * libm::cos(angle), radius * libm::sin(angle)]
                })
                .collect();
            let points = flat(&points);
            let (faces, warnings) = cut(&points);
            assert_eq!(warnings, [""; 0]);
            check_tiling(&points, &faces, "a star");
        }
    }
}

#[test]
fn polygons_that_cross_themselves_get_a_warning() {
    let crossing = ["1 polygon crosses itself and may be cut into wrong triangles (face 7)"];
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert_eq!(cut(&flat(&bow)), (vec![[0, 1, 2], [0, 2, 3]], crossing.map(str::to_owned).into()));
    // Without an area nothing is wrong with it: its triangles are left out as all such are.
    let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]];
    assert_eq!(cut(&flat(&line)).1, [""; 0]);
    let spike = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [1.0, 4.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    assert_eq!(cut(&flat(&spike)).1, [""; 0]);
}

/// Polygons of nothing but inner corners of each other: effort is bounded, whatever they look like.
#[test]
fn effort_is_bounded() {
    let corners = 60_000;
    let mut rng = StdRng::seed_from_u64(3);
    let points: Vec<_> = (0..corners).map(|_| [rng.random(), rng.random()]).collect();
    let (faces, warnings) = cut(&flat(&points));
    assert_eq!(faces.len(), corners - 2);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}
