//! Structures as the programs expect them: arrays of words of 32 bits, and what holds for all rays.

use slo_accel::study::{BoxNode, KdNode, Layout};
use slo_accel::triangle::POSITION_ERROR;

use crate::program::Kind;

/// Stands for an infinite time. No ray takes as long: coordinates are below 2^128, directions 0 or above
/// 2^-150.
const FOREVER: f64 = 1e300;

/// Marks interior nodes of a hierarchy.
const INTERIOR: u32 = u32::MAX;

/// A structure for a program.
pub(crate) struct Packed {
    pub(crate) kind: Kind,
    /// Entries of the program's stack.
    pub(crate) stack: u32,
    /// Nodes, or where the references of each cell start.
    pub(crate) nodes: Vec<u32>,
    pub(crate) references: Vec<u32>,
    pub(crate) frame: Frame,
}

/// What is the same for all dispatches: most of the program's `Query`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    ends: [[f64; 3]; 2],
    side: [f64; 3],
    nodes: u32,
    cells: [u32; 3],
    entries: u32,
    pushes_down: bool,
}

impl Frame {
    /// The bytes of a `Query`, of which kernels/rays.wgsl tells the order.
    pub(crate) fn query(&self, rays: u32, any: bool, most_iterations: u32) -> Vec<u8> {
        let [low, high] = self.ends;
        // Times below the smallest f32 are rounded to it.
        let least_time = f64::from(f32::from_bits(4));
        let wide = [FOREVER, least_time, f64::from(POSITION_ERROR), 1.0];
        let wide = wide.into_iter().chain(low).chain(high).chain(self.side);
        let [x, y, z] = self.cells;
        let pushes_down = u32::from(self.pushes_down);
        let words =
            [most_iterations, rays, u32::from(any), self.nodes, x, y, z, self.entries, pushes_down];
        let words = words.into_iter().chain([0; 5]);
        wide.flat_map(f64::to_le_bytes).chain(words.flat_map(u32::to_le_bytes)).collect()
    }
}

impl Packed {
    /// Packs the arrays of a structure.
    pub(crate) fn new(layout: &Layout<'_>) -> Result<Self, String> {
        match *layout {
            Layout::Grid { ends, side, cells, starts, references } => {
                let nodes = references.len() as u32;
                Ok(Self {
                    kind: Kind::Grid,
                    stack: 0,
                    nodes: starts.to_vec(),
                    references: references.to_vec(),
                    frame: Frame { ends, side, nodes, cells, ..Frame::default() },
                })
            }
            Layout::Kd { ends, nodes, references, stack, pushes_down } => {
                let entries = match stack {
                    Some(entries) => entries.min(64) as u32,
                    // One entry for each level.
                    None => 64,
                };
                let count = nodes.len() as u32;
                Ok(Self {
                    kind: Kind::Kd,
                    stack: entries.next_power_of_two().max(4),
                    nodes: nodes.iter().flat_map(kd_node).collect(),
                    references: references.to_vec(),
                    frame: Frame { ends, nodes: count, entries, pushes_down, ..Frame::default() },
                })
            }
            Layout::Hierarchy { nodes, references } => hierarchy(nodes, references),
            _ => Err("no program traverses this structure".to_owned()),
        }
    }
}

fn kd_node(node: &KdNode) -> [u32; 2] {
    match *node {
        KdNode::Interior { axis, plane, first } => [plane.to_bits(), first << 2 | u32::from(axis)],
        KdNode::Leaf { start, count } => [start, count << 2 | 3],
    }
}

fn hierarchy(nodes: &[BoxNode], references: &[u32]) -> Result<Packed, String> {
    if nodes.iter().any(|node| !node.is_leaf && node.count != 2) {
        return Err("the program for hierarchies traverses binary ones only".to_owned());
    }
    let ends = nodes.first().map_or([[0.0; 3]; 2], |root| {
        [root.bounds.min, root.bounds.max].map(|end| end.to_array().map(f64::from))
    });
    // Each level leaves one node on the stack, and the last one two.
    let entries = depth(nodes) + 2;
    let words = |node: &BoxNode| {
        let [low, high] =
            [node.bounds.min, node.bounds.max].map(|end| end.to_array().map(f32::to_bits));
        let count = if node.is_leaf { node.count } else { INTERIOR };
        [low[0], low[1], low[2], node.start, high[0], high[1], high[2], count]
    };
    Ok(Packed {
        kind: Kind::Hierarchy,
        stack: entries.next_multiple_of(32),
        nodes: nodes.iter().flat_map(words).collect(),
        references: references.to_vec(),
        frame: Frame { ends, nodes: nodes.len() as u32, ..Frame::default() },
    })
}

/// The depth of the deepest node; children follow their parents.
fn depth(nodes: &[BoxNode]) -> u32 {
    let mut depths = vec![0u32; nodes.len()];
    for (number, node) in nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf) {
        let children = node.start as usize..(node.start + node.count) as usize;
        let below = depths[number] + 1;
        depths[children].fill(below);
    }
    depths.into_iter().max().unwrap_or(0)
}
