//! End-point overlap: how much surface lies in boxes that it does not belong to.
//!
//! Source: Aila, Karras, Laine, *On Quality Metrics of Bounding Volume Hierarchies*, HPG 2013. Rays end
//! on surfaces; a ray that ends in a foreign box has visited it for nothing. Triangles are clipped to the
//! boxes exactly, on the way down the hierarchy.

use glam::DVec3;

use super::ray::Cell;
use super::statistics::{COST_OF_STEP, COST_OF_TEST};
use crate::primitives::Triangle;

/// A node as it matters here.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) cell: Cell,
    /// Its children, or objects if it is a leaf.
    pub(super) start: u32,
    pub(super) count: u32,
    pub(super) is_leaf: bool,
    /// Which references are in it and below it.
    pub(super) first: u32,
    pub(super) end: u32,
}

/// Sum over all nodes of their cost times the share of all surface that lies in their box and does not
/// belong to them. Each
/// triangle comes with the place of its object among the references.
pub(super) fn end_point_overlap(nodes: &[Part], surfaces: &[(u32, Triangle)]) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for &(place, triangle) in surfaces {
        let polygon = triangle.map(|corner| corner.as_dvec3()).to_vec();
        area += area_of(&polygon);
        let mut stack = vec![(0, polygon)];
        while let Some((node, polygon)) = stack.pop() {
            let Some(node) = nodes.get(node) else { break };
            let inside = clipped(polygon, &node.cell);
            if inside.len() < 3 {
                continue;
            }
            let own = (node.first..node.end).contains(&place);
            if !own {
                let tests = COST_OF_TEST * f64::from(node.count);
                sum += area_of(&inside) * if node.is_leaf { tests } else { COST_OF_STEP };
            }
            if !node.is_leaf {
                let children = node.start as usize..(node.start + node.count) as usize;
                stack.extend(children.map(|child| (child, inside.clone())));
            }
        }
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

fn area_of(polygon: &[DVec3]) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else { return 0.0 };
    let cross = rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first));
    0.5 * cross.fold(DVec3::ZERO, |sum, cross| sum + cross).length()
}

/// The part of a polygon in a box.
///
/// Source: Sutherland, Hodgman, *Reentrant Polygon Clipping*, CACM 1974.
fn clipped(mut polygon: Vec<DVec3>, cell: &Cell) -> Vec<DVec3> {
    for axis in 0..3 {
        for (side, plane) in [(-1.0, cell.min[axis]), (1.0, cell.max[axis])] {
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (i, &p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                let [from, to] = [p, q].map(|corner| side * (corner[axis] - plane));
                if from <= 0.0 {
                    kept.push(p);
                }
                if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
                    kept.push(p + (q - p) * (from / (from - to)));
                }
            }
            polygon = kept;
        }
    }
    polygon
}
