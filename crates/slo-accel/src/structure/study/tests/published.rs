//! Counts that others have published.
//!
//! Source: Havran, Sixta, *Comparison of Hierarchical Grids*, Ray Tracing News 12(1), 1999: objects
//! are referred to by their boxes.

use super::scenes::{balls, lattice, tetra};
use crate::math::Bounds;
use crate::structure::study::{Grid, Octree, Parameters, Planes, Statistics, Study};

fn grid(boxes: &[Bounds], cells: [u32; 3]) -> Statistics {
    Grid::build(boxes, &Parameters { cells: Some(cells), ..Parameters::default() }).statistics()
}

fn octree(boxes: &[Bounds], depth: u32) -> Statistics {
    Octree::build(boxes, &Parameters { depth: Some(depth), ..Parameters::default() }).statistics()
}

#[test]
fn scenes_have_their_numbers_of_objects() {
    assert_eq!([balls().len(), lattice(false).len(), tetra().len()], [7382, 8281, 4096]);
}

#[test]
fn grids_have_the_cells_and_references_of_havran_and_sixta() {
    let of = |boxes: &[Bounds], cells| {
        let of = grid(boxes, cells);
        assert_eq!(of.leaves, cells.iter().map(|&n| u64::from(n)).product::<u64>());
        (of.empty_leaves, of.references)
    };
    assert_eq!(of(&tetra(), [16; 3]), (3104, 12_556));
    assert_eq!(of(&tetra(), [35; 3]), (37_311, 35_936));
    assert_eq!(of(&lattice(true), [20; 3]), (0, 32_152));
    assert_eq!(of(&lattice(true), [44; 3]), (38_016, 90_368));
    assert_eq!(of(&lattice(false), [20; 3]), (0, 32_152));
    // Published: 10 240 references; the scene's coordinates were rounded to six digits.
    let (empty, references) = of(&balls(), [46, 46, 3]);
    assert!(empty == 4208 && references.abs_diff(10_240) < 30, "{empty}, {references}");
    let (empty, references) = of(&balls(), [103, 103, 7]);
    assert!(
        empty.abs_diff(63_393) < 4 && references.abs_diff(19_966) < 120,
        "{empty}, {references}"
    );
}

#[test]
fn octrees_are_those_of_havran_and_sixta() {
    let of = |boxes: &[Bounds], depth| {
        let of = octree(boxes, depth);
        assert_eq!(of.leaves, 7 * of.interior + 1);
        assert!(of.deepest == depth && of.mean_depth < f64::from(depth) + 1e-9);
        (of.interior, of.empty_leaves, of.references)
    };
    let tetra = tetra();
    assert_eq!(of(&tetra, 4), (305, 1072, 13_312));
    assert_eq!(of(&tetra, 5), (1369, 4764, 32_768));
    assert_eq!(of(&tetra, 6), (6189, 21_100, 110_592));
    assert_eq!(of(&tetra, 7), (28_413, 80_444, 512_000));
    let lattice = lattice(false);
    assert_eq!(of(&lattice, 4), (585, 0, 22_112));
    assert_eq!(of(&lattice, 5), (4681, 7744, 49_600));
    // Published: 28 732 empty leaves and 147 494 references. Faces of boxes lie next to planes here, so
    // that rounding decides.
    let (interior, empty, references) = of(&lattice, 6);
    assert!(interior == 17_993 && empty.abs_diff(28_732) < 1500, "{empty}");
    assert!(references.abs_diff(147_494) < 6200, "{references}");
    // The published numbers of references and of some leaves differ by the rounding of coordinates.
    let (interior, empty, references) = of(&balls(), 4);
    assert!((interior, empty) == (57, 300) && references.abs_diff(9171) < 280, "{references}");
}

/// The published scenes were rounded to six digits, and their median is not described.
#[test]
fn octrees_with_planes_by_cost_have_about_the_nodes_of_havran_and_sixta() {
    for (boxes, within, published) in [
        (tetra(), 0.03, [325, 1485, 6449, 30_617]),
        (balls(), 0.05, [131, 661, 3077, 15_283]),
        (lattice(false), 0.015, [585, 4681, 18_218, 45_496]),
    ] {
        for (depth, published) in (4..).zip(published) {
            let parameters =
                Parameters { depth: Some(depth), planes: Planes::Cost, ..Parameters::default() };
            let interior = Octree::build(&boxes, &parameters).statistics().interior;
            let off = interior as f64 / f64::from(published) - 1.0;
            assert!(off.abs() < within, "depth {depth}: {interior} instead of {published}");
        }
    }
}

#[test]
fn a_grid_has_as_many_cells_as_its_density_asks_for() {
    for (boxes, density, cells) in [
        (tetra(), 1.0, [16; 3]),
        (lattice(false), 1.0, [20; 3]),
        (lattice(false), 10.0, [44; 3]),
        (balls(), 1.0, [51, 51, 3]),
    ] {
        let parameters = Parameters { density: Some(density), ..Parameters::default() };
        assert_eq!(Grid::build(&boxes, &parameters).statistics().cells, Some(cells));
    }
    // 4 times the fourth root of 4096 on the shortest side.
    let parameters = Parameters { shortest: Some(4.0), ..Parameters::default() };
    assert_eq!(Grid::build(&tetra(), &parameters).statistics().cells, Some([32; 3]));
}
