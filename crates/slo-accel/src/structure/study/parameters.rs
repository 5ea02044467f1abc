//! How structures are built and traversed: one list of parameters for all of them.

/// Parameters of structures. Each structure reads those that it knows; what is not given has the
/// structure's own default. No parameter changes a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Parameters {
    /// `GRID`: cells per object.
    pub density: Option<f32>,
    /// `GRID`: cells along the shortest side, divided by the fourth root of the number of objects.
    pub shortest: Option<f32>,
    /// `GRID`: cells along x, y and z.
    pub cells: Option<[u32; 3]>,
    /// `GRID`, `OCTREE`, `KD`: whether an object is tested only once by a ray.
    pub mailbox: bool,
    /// Trees: the greatest depth of a leaf; that of the root is 0.
    pub depth: Option<u32>,
    /// Trees: nodes with as many objects, or fewer, are leaves.
    pub leaf: Option<u32>,
    /// `RTREE`: children of a node.
    pub capacity: Option<u32>,
    /// `KD`: what a ray does to reach the nodes that it has put off.
    pub traversal: Traversal,
    /// `KD`: entries of a short stack.
    pub stack: Option<u32>,
}

/// How a ray reaches the nodes of a kd-tree that it has put off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Traversal {
    /// They wait on a stack.
    #[default]
    Stack,
    /// It starts again at the root.
    Restart,
    /// It starts again at the deepest node that holds all that is left.
    PushDown,
    /// They wait on a stack of few entries, 4 if not given; as `PushDown` if it has lost some.
    ShortStack,
}
