//! A frame whose rays are counted.

use slo_accel::study::{Counts, Ray};
use slo_accel::{Rays, Structure};

use super::costs::{CostMap, RayCounting};
use super::error::FrameError;
use super::instance::Body;
use super::needs;
use super::scene::FrameScene;
use super::world::{World, WorldScratch, push_local};

/// What one of a frame's structures is made of.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CountedStructure {
    /// Number of primitives.
    pub primitives: usize,
    /// Bytes held, primitives included.
    pub memory: usize,
    /// What is known of it.
    pub statistics: Option<slo_accel::study::Statistics>,
}

impl FrameScene {
    /// Begins to count what rays take in the structures, and, with `by_pixel`, how much each pixel's do.
    /// Pictures stay the same, and take several times as long.
    ///
    /// # Errors
    /// [`FrameError::Uncounted`], or [`FrameError::Memory`] if there is not enough for so many pixels.
    pub fn count(&mut self, by_pixel: bool) -> Result<(), FrameError> {
        let uncounted = |reason| FrameError::Uncounted { reason };
        self.world.can_count().map_err(uncounted)?;
        let map = if by_pixel {
            let (width, height) = (self.camera.width(), self.camera.height());
            needs::check_costs(width, height)?;
            let no_memory = "there is no memory for the costs of so many pixels";
            Some(CostMap::new(width, height).ok_or(uncounted(no_memory))?)
        } else {
            None
        };
        let boxes = self.world.instances.iter().map(|instance| instance.bounds()).collect();
        self.counting = Some(RayCounting { boxes, map });
        Ok(())
    }

    /// The steps and the tests of the rays of each pixel so far, row by row; empty unless they are
    /// [counted](Self::count) by pixel.
    pub fn costs(&self) -> Vec<[u64; 2]> {
        let map = self.counting.as_ref().and_then(|counting| counting.map.as_ref());
        map.map_or_else(Vec::new, CostMap::costs)
    }

    /// What the structures are made of: first the one of all that is still, then those of the others, each
    /// once.
    pub fn counted_structures(&self) -> Vec<CountedStructure> {
        let of = |structure: &Structure| CountedStructure {
            primitives: structure.triangle_count() + structure.curved().len(),
            memory: structure.memory(),
            statistics: structure.statistics(),
        };
        self.world.structures().map(|structure| of(structure)).collect()
    }
}

impl World {
    /// Whether [`count`](Self::count) counts.
    fn can_count(&self) -> Result<(), &'static str> {
        if !self.crowd.is_empty() {
            Err(
                "copies, and many objects of one mesh, are traced by a hierarchy that does not count",
            )
        } else if self.bending().next().is_some() {
            Err("meshes that change shape are traced by a hierarchy that does not count")
        } else if !self.structures().all(|structure| structure.can_count()) {
            Err("CWBVH does not count")
        } else {
            Ok(())
        }
    }

    /// Traces one ray of a batch by itself, at its time, and adds what it takes. Each object that moves is
    /// a step and a test of its box, and then what its own structure takes. Returns the t of the first hit,
    /// or of any if that is enough; infinite if there is none.
    pub(crate) fn count(
        &self,
        (rays, time): (&Rays, f32),
        i: usize,
        (any, counting): (bool, &RayCounting),
        scratch: &mut WorldScratch,
        counts: &mut Counts,
    ) -> f32 {
        let mut t = self.still.count(rays, i, any, &mut scratch.accel, counts);
        for (instance, bounds) in self.instances.iter().zip(&counting.boxes) {
            if any && t < f32::INFINITY {
                break;
            }
            let t_max = t.min(rays.t_max[i]);
            let (origin, direction) = (rays.origin(i), rays.direction(i));
            counts.boxes += 1;
            if !(Ray { origin, direction, t_max }).enters(bounds) {
                continue;
            }
            counts.steps += 1;
            let local = &mut scratch.local;
            local.set_len(0);
            push_local(local, rays, instance.pose(time), i, t_max);
            if let Body::Still(structure) = &instance.body {
                t = t.min(structure.count(local, 0, any, &mut scratch.accel, counts));
            }
        }
        t
    }
}
