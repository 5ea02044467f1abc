//! The GPU's traversals against the CPU's, ray by ray: hits, and what they took.
//!
//! Without an adapter the tests say so and pass; with `SLO_REQUIRE_GPU=1` they fail. On software all bits
//! and all counters must be equal; on hardware see `Verdict`.

mod compare;
mod scenes;

use compare::{Compared, gpu};
use scenes::{Random, ball, hills};
use slo_accel::Triangle;
use slo_accel::study::{BinaryTree, Grid, Kd, MedianTree, Parameters};

/// Compares all structures about the same triangles and rays.
fn compare_all(name: &str, triangles: &[Triangle], rays: &slo_accel::Rays) {
    let Some(gpu) = gpu() else { return };
    let parameters = |text: &str| text.parse::<Parameters>().expect("parameters");
    for any in [false, true] {
        let compared = Compared { name, triangles, rays, any };
        compared.check::<Grid>(&gpu, parameters(""));
        compared.check::<Grid>(&gpu, parameters("density=0.1"));
        for stack in ["", "traversal=short-stack", "traversal=push-down", "traversal=restart"] {
            compared.check::<Kd>(&gpu, parameters(stack));
        }
        compared.check::<Kd>(&gpu, parameters("traversal=short-stack,stack=1"));
        compared.check::<BinaryTree>(&gpu, parameters(""));
        compared.check::<MedianTree>(&gpu, parameters("leaf=3"));
    }
}

#[test]
fn random_triangles() {
    let mut random = Random::new(1);
    for (n, size) in [(1, 1.0), (37, 0.8), (900, 0.2), (5000, 0.05)] {
        let triangles = random.triangles(n, size);
        let rays = random.rays(4000, 1.0);
        compare_all(&format!("{n} random triangles"), &triangles, &rays);
    }
}

#[test]
fn doubled_and_degenerate_triangles() {
    let mut random = Random::new(2);
    let mut triangles = random.triangles(300, 0.4);
    triangles.extend_from_within(..100);
    let flat: Vec<Triangle> = triangles[..50].iter().map(|t| [t[0], t[1], t[0]]).collect();
    triangles.extend(flat);
    triangles.push([triangles[0][0]; 3]);
    triangles.push([triangles[0][0] * f32::NAN; 3]);
    compare_all("doubled and degenerate triangles", &triangles, &random.rays(4000, 1.0));
}

#[test]
fn small_whole_coordinates() {
    // Rays run along edges, diagonals and planes of cells.
    let mut random = Random::new(3);
    compare_all("hills on a raster", &hills(12), &random.raster_rays(4000, 12));
}

#[test]
fn a_closed_mesh_from_near_and_far() {
    let mut random = Random::new(4);
    let triangles = ball(40, 1.0);
    compare_all("a ball", &triangles, &random.rays(4000, 1.0));
    for scale in [1e-6, 1e6] {
        let triangles = ball(20, scale);
        compare_all(&format!("a ball of {scale}"), &triangles, &random.rays(2000, scale));
    }
}

#[test]
fn rays_that_start_on_surfaces() {
    let mut random = Random::new(5);
    for (name, triangles) in [("a ball", ball(30, 1.0)), ("hills", hills(20))] {
        compare_all(name, &triangles, &random.rays_from(&triangles, 4000));
    }
}

#[test]
fn nothing_at_all() {
    compare_all("no triangle", &[], &Random::new(6).rays(100, 1.0));
}
