//! Working memory of a traversal, and the tests of the objects in a leaf.

use super::answer::Answer;
use super::counting::Counting;

/// Working memory of traversals, one for each thread. It holds nothing between calls, so any
/// structure may use it next.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    pub(super) stack: Vec<Visit>,
    boxes: Mailboxes,
    /// What a device has answered.
    pub(super) answers: Vec<Answer>,
}

/// A node that is still to be visited, and the span in which the ray may find hits in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    pub(super) node: u32,
    pub(super) near: f64,
    pub(super) far: f64,
}

/// Mailboxes: the number of the last ray that met an object. Source: Arnaldi, Priol, Bouatouch, *A
/// New Space Subdivision Method for Ray Tracing CSG Modelled Scenes*, The Visual Computer 1987.
#[derive(Clone, Debug, Default)]
struct Mailboxes {
    rays: Vec<u32>,
    ray: u32,
}

impl Mailboxes {
    fn begin(&mut self, objects: usize) {
        if self.rays.len() < objects {
            self.rays.resize(objects, 0);
        }
        self.ray = self.ray.checked_add(1).unwrap_or_else(|| {
            self.rays.fill(0);
            1
        });
    }
}

/// Tests of a ray with the objects of the leaves that it enters.
pub(super) struct Tests<'a, C, V> {
    /// The largest t that still counts.
    pub(super) t_max: f32,
    pub(super) counting: &'a mut C,
    visit: V,
    boxes: Option<&'a mut Mailboxes>,
}

impl Memory {
    /// Begins a traversal among `objects` objects, with mailboxes or without.
    pub(super) fn begin<'a, C: Counting, V: FnMut(u32, f32) -> f32>(
        &'a mut self,
        objects: usize,
        mailbox: bool,
        t_max: f32,
        counting: &'a mut C,
        visit: V,
    ) -> (&'a mut Vec<Visit>, Tests<'a, C, V>) {
        let Self { stack, boxes, .. } = self;
        stack.clear();
        let boxes = mailbox.then(|| {
            boxes.begin(objects);
            boxes
        });
        (stack, Tests { t_max, counting, visit, boxes })
    }
}

impl<C: Counting, V: FnMut(u32, f32) -> f32> Tests<'_, C, V> {
    /// Tests the objects of a leaf.
    #[inline]
    pub(super) fn leaf(&mut self, objects: &[u32]) {
        self.counting.leaf(objects.len());
        for &object in objects {
            if let Some(boxes) = &mut self.boxes {
                let last = &mut boxes.rays[object as usize];
                if std::mem::replace(last, boxes.ray) == boxes.ray {
                    self.counting.mailbox_hit();
                    continue;
                }
            }
            self.counting.test();
            self.t_max = (self.visit)(object, self.t_max);
            if self.t_max < 0.0 {
                return;
            }
        }
    }

    /// Whether hits from a time on still count.
    #[inline]
    pub(super) fn reaches(&self, t: f64) -> bool {
        t.max(0.0) <= f64::from(self.t_max)
    }
}
