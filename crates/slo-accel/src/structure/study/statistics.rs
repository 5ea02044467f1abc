//! What a structure is made of.

/// Cost of a step, in tests of objects, in [`Statistics::sah`]. Source: Aila, Karras, Laine, *On
/// Quality Metrics of Bounding Volume Hierarchies*, HPG 2013.
pub const COST_OF_STEP: f64 = 1.2;

/// Cost of a test of an object, in [`Statistics::sah`].
pub const COST_OF_TEST: f64 = 1.0;

/// What a structure is made of: the same on every machine.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// Number of objects.
    pub objects: u64,
    /// Interior nodes; 0 for a grid.
    pub interior: u64,
    /// Leaves, or cells of a grid.
    pub leaves: u64,
    /// Empty ones among them.
    pub empty_leaves: u64,
    /// References to objects in all leaves.
    pub references: u64,
    /// The greatest depth of a leaf; that of the root is 0.
    pub deepest: u32,
    /// Mean depth of the leaves.
    pub mean_depth: f64,
    /// Mean depth of the leaves, weighted by the surface areas of their boxes.
    pub mean_depth_by_area: f64,
    /// Number of leaves by their number of objects: the last entry counts all that have more.
    pub leaf_sizes: Vec<u64>,
    /// The greatest number of objects in a leaf.
    pub largest_leaf: u64,
    /// Cells of a grid along x, y and z.
    pub cells: Option<[u32; 3]>,
    /// Bytes of the structure, without the objects.
    pub bytes: u64,
    /// Bytes of all arrays of the builder when they were the most, without the objects.
    pub bytes_of_building: u64,
    /// Expected cost of a random line that meets the box of all objects, after the surface area
    /// heuristic: the areas of interior nodes times [`COST_OF_STEP`] and of leaves times their
    /// number of objects and [`COST_OF_TEST`], divided by the root's area. A cell of a grid counts
    /// as a step and a leaf.
    pub sah: f64,
    /// [End-point overlap](super::Study::end_point_overlap), of hierarchies of boxes over triangles, where
    /// the triangles are known.
    pub epo: Option<f64>,
    depths: f64,
    depths_by_area: f64,
    area_of_leaves: f64,
    cost: f64,
}

impl Statistics {
    /// Entries of [`leaf_sizes`](Self::leaf_sizes).
    const SIZES: usize = 33;

    pub(crate) fn new(objects: usize) -> Self {
        let leaf_sizes = vec![0; Self::SIZES];
        Self { objects: objects as u64, leaf_sizes, ..Self::default() }
    }

    /// Adds an interior node.
    pub(crate) fn add_interior(&mut self, area: f64) {
        self.interior += 1;
        self.cost += COST_OF_STEP * area;
    }

    /// Adds a leaf.
    pub(crate) fn add_leaf(&mut self, objects: usize, depth: u32, area: f64) {
        self.leaves += 1;
        self.empty_leaves += u64::from(objects == 0);
        self.references += objects as u64;
        self.largest_leaf = self.largest_leaf.max(objects as u64);
        self.leaf_sizes[objects.min(Self::SIZES - 1)] += 1;
        self.deepest = self.deepest.max(depth);
        self.depths += f64::from(depth);
        self.depths_by_area += f64::from(depth) * area;
        self.area_of_leaves += area;
        self.cost += COST_OF_TEST * objects as f64 * area;
    }

    /// Adds a cell of a grid.
    pub(super) fn add_cell(&mut self, objects: usize, area: f64) {
        self.add_leaf(objects, 0, area);
        self.cost += COST_OF_STEP * area;
    }

    /// Derives what depends on all leaves.
    pub(crate) fn finish(mut self, area: f64, bytes: usize, bytes_of_building: usize) -> Self {
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        self.mean_depth = ratio(self.depths, self.leaves as f64);
        self.mean_depth_by_area = ratio(self.depths_by_area, self.area_of_leaves);
        self.sah = ratio(self.cost, area);
        self.bytes = bytes as u64;
        self.bytes_of_building = bytes_of_building.max(bytes) as u64;
        self
    }

    /// References per object: 1 if no object is in several leaves.
    pub fn duplication(&self) -> f64 {
        if self.objects == 0 { 0.0 } else { self.references as f64 / self.objects as f64 }
    }

    /// Mean number of objects in a leaf.
    pub fn mean_leaf(&self) -> f64 {
        if self.leaves == 0 { 0.0 } else { self.references as f64 / self.leaves as f64 }
    }
}

/// Bytes that a builder holds, and their highest number.
#[derive(Debug, Default)]
pub(super) struct Meter {
    now: usize,
    highest: usize,
}

impl Meter {
    pub(super) fn take(&mut self, bytes: usize) {
        self.now += bytes;
        self.highest = self.highest.max(self.now);
    }

    pub(super) fn give_back(&mut self, bytes: usize) {
        self.now -= bytes;
    }

    pub(super) fn highest(&self) -> usize {
        self.highest
    }
}
