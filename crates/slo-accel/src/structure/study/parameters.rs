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
}
