//! The finished hierarchy.

use super::layout::{Child, Corners, Node, Place, WIDTH};
use super::ray::Ray;
use crate::isa::Isa;
use crate::math::Bounds;
use crate::primitives::{Curved, Triangle};
use crate::rays::Rays;
use crate::structure::interface::Geometry;
use crate::structure::shared::pages::Array;
use crate::structure::study::Statistics;

/// Hierarchies of more bytes are far away: they are mostly outside the caches of a core.
pub(super) const FAR: usize = 48 << 20;

/// A hierarchy over primitives, which it holds itself.
#[derive(Debug)]
pub(crate) struct Bvh {
    pub(super) nodes: Array<Node>,
    pub(super) corners: Corners,
    /// Where each triangle is first, by id.
    pub(super) places: Vec<Place>,
    pub(super) curved: Vec<Curved>,
    pub(super) bounds: Bounds,
    /// Entries that a ray's stack needs.
    pub(super) stack: usize,
    pub(super) isa: Isa,
    /// Whether tame rays stay tame here.
    pub(super) is_tame: bool,
    /// Whether its nodes are far away, beyond [`FAR`].
    pub(in crate::structure) is_far: bool,
    /// Whether its triangles move: see [`Corners`] and [`nodes_per_node`](super::layout::nodes_per_node).
    pub(super) moves: bool,
    /// Expected cost of a ray in the hierarchy that was built, if this one was fitted to triangles
    /// that have moved since.
    pub(super) built_cost: Option<f64>,
}

impl Geometry for Bvh {
    #[inline]
    fn triangle_count(&self) -> usize {
        self.places.len()
    }

    #[inline]
    fn triangle(&self, id: u32) -> Triangle {
        let place = self.places[id as usize];
        self.corners.triangle(place.slot(), place.count(), place.lane())
    }

    #[inline]
    fn curved(&self) -> &[Curved] {
        &self.curved
    }

    fn all_bounds(&self) -> Bounds {
        self.bounds
    }

    fn memory(&self) -> usize {
        size_of_val(self.corners.rows())
            + size_of_val(self.places.as_slice())
            + size_of_val(self.curved.as_slice())
    }
}

impl Bvh {
    /// The triangle of an id, at a time from 0 to 1 if triangles move.
    #[inline]
    pub(in crate::structure) fn triangle_at(&self, id: u32, time: f32) -> Triangle {
        let place = self.places[id as usize];
        self.corners.triangle_at(place.slot(), place.count(), place.lane(), time)
    }

    /// Bytes of nodes and of all that they lead to.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + self.memory()
    }

    /// What the hierarchy is made of, which is not one whose boxes move. Blocks and curved surfaces are its
    /// leaves.
    pub(super) fn made_of(&self) -> Statistics {
        let mut statistics = Statistics::new(self.places.len() + self.curved.len());
        let mut stack = Vec::new();
        let mut area = 0.0;
        if let Some(root) = self.nodes.first() {
            area = f64::from(self.all_bounds().area());
            statistics.add_interior(area);
            stack.push((root, 0));
        }
        while let Some((node, depth)) = stack.pop() {
            for place in (0..WIDTH).filter(|&place| !node.is_closed(place)) {
                let side = |side: usize| [0, 1, 2].map(|axis| node.planes[2 * axis + side][place]);
                let bounds = Bounds { min: side(0).into(), max: side(1).into() };
                let (child, area) = (node.children[place], f64::from(bounds.area()));
                if child.is_leaf() {
                    let objects = if child.is_block() { child.block_len() } else { 1 };
                    statistics.add_leaf(objects, depth + 1, area);
                } else {
                    statistics.add_interior(area);
                    stack.push((&self.nodes[child.index()], depth + 1));
                }
            }
        }
        statistics.finish(area, size_of_val(&*self.nodes), 0)
    }

    /// Tests a curved surface.
    pub(super) fn test_curved(&self, rays: &Rays, child: Child, ray: &mut Ray) {
        let index = child.index();
        let i = ray.index as usize;
        let hit = self.curved[index].intersect(rays.origin(i), rays.direction(i), ray.t.next_up());
        if let Some((t, part)) = hit {
            ray.offer(t, part.to_u(), 0.0, (self.places.len() + index) as u32);
        }
    }
}
