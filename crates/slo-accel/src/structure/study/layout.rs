//! How a structure lies in memory, for devices that traverse it by programs of their own.

use crate::math::Bounds;

/// A node of a hierarchy of boxes: its box, and its children or its objects, which are neighbours.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct BoxNode {
    /// The smallest box about all objects below.
    pub bounds: Bounds,
    /// Number of the first child, or of the first reference of a leaf.
    pub start: u32,
    /// Number of children, or of references.
    pub count: u32,
    /// Whether the node is a leaf.
    pub is_leaf: bool,
}

/// A node of a kd-tree.
#[derive(Clone, Copy, Debug)]
pub enum KdNode {
    /// A plane across a cell.
    Interior {
        /// The axis that the plane crosses.
        axis: u8,
        /// Where it crosses the axis.
        plane: f32,
        /// The child below the plane; the one above is the next node.
        first: u32,
    },
    /// A cell with objects.
    Leaf {
        /// The first of its references.
        start: u32,
        /// Number of its references.
        count: u32,
    },
}

/// The arrays of a structure. What they mean is told by the file of each structure; a traversal that
/// follows that file step by step visits the same nodes, cells and objects.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Layout<'a> {
    /// A uniform grid.
    Grid {
        /// The least and the greatest corner.
        ends: [[f64; 3]; 2],
        /// Lengths of the sides of a cell. Plane `i` of an axis is at `ends[0] + i side`, the last one
        /// at `ends[1]`.
        side: [f64; 3],
        /// Numbers of cells along x, y and z.
        cells: [u32; 3],
        /// Where the references of each cell start, x first, and where those of the last end.
        starts: &'a [u32],
        /// Numbers of objects.
        references: &'a [u32],
    },
    /// A kd-tree. The root is node 0; there is none if there are no objects.
    Kd {
        /// The least and the greatest corner.
        ends: [[f64; 3]; 2],
        /// The nodes.
        nodes: &'a [KdNode],
        /// Numbers of objects.
        references: &'a [u32],
        /// Entries of the stack: as many as are needed, or a few, or none.
        stack: Option<usize>,
        /// Whether a ray starts again at the deepest node that holds all that is left, not at the root.
        pushes_down: bool,
    },
    /// A hierarchy of boxes. The root is node 0; there is none if there are no objects.
    Hierarchy {
        /// The nodes.
        nodes: &'a [BoxNode],
        /// Numbers of objects.
        references: &'a [u32],
    },
}
