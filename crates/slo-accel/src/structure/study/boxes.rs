//! Lone boxes: a ray is tested against the box of each object, one after the other, and against the
//! objects whose boxes it enters.
//!
//! Source: Weghorst, Hooper, Greenberg, *Improved Computational Methods for Ray Tracing*, ACM TOG
//! 1984, without the hierarchy that they build next. It shows what boxes alone are worth: no more
//! than the ratio of the costs of both tests.

use super::Study;
use super::counting::Counting;
use super::memory::Memory;
use super::parameters::Parameters;
use super::ray::{Cell, Line, Ray, solid};
use super::statistics::Statistics;
use crate::math::Bounds;

/// The boxes of all objects, in their order.
#[derive(Debug)]
pub struct Boxes {
    bounds: Cell,
    objects: usize,
    ids: Vec<u32>,
    boxes: Vec<Bounds>,
}

impl Study for Boxes {
    fn build(objects: &[Bounds], _: &Parameters) -> Self {
        let (ids, bounds) = solid(objects);
        let boxes = ids.iter().map(|&id| objects[id as usize]).collect();
        Self { bounds, objects: objects.len(), ids, boxes }
    }

    fn walk<C: Counting, V: FnMut(u32, f32) -> f32>(
        &self,
        ray: &Ray,
        memory: &mut Memory,
        counting: &mut C,
        visit: V,
    ) -> f32 {
        let (_, mut tests) = memory.begin(self.objects, false, ray.t_max, counting, visit);
        let line = Line::new(ray, &self.bounds);
        for (id, bounds) in self.ids.iter().zip(&self.boxes) {
            if tests.t_max < 0.0 {
                break;
            }
            tests.counting.boxes(1);
            let [near, far] = line.span(&Cell::of(bounds), tests.t_max);
            if near <= far {
                tests.counting.step();
                tests.leaf(std::slice::from_ref(id));
            }
        }
        tests.t_max
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::new(self.objects);
        for bounds in &self.boxes {
            statistics.add_leaf(1, 0, Cell::of(bounds).area());
        }
        statistics.finish(self.bounds.area(), self.bytes(), 0)
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.ids) + size_of_val(&*self.boxes)
    }
}
