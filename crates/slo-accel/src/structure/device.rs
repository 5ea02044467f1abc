//! Devices beside the CPU that traverse structures, and what is done so that they cannot change a hit.
//!
//! A device answers with the primitive that a ray hits and says whether it is certain. The CPU then
//! repeats the test of that one primitive, whose bits count. It traces a ray by itself if the device is
//! not certain of it, or if the test contradicts the device, and all rays from then on if the device
//! fails. What is left to trust is that a device that is certain has missed nothing nearer.

use std::fmt::Debug;

use super::study::{Answer, Layout};
use crate::primitives::Triangle;
use crate::rays::Rays;

/// A device that traverses structures.
pub trait Device: Debug + Send + Sync {
    /// Takes a structure and the triangles that it is built over, one for each object. A triangle whose
    /// corners are all the same is never hit.
    ///
    /// # Errors
    /// Why the device cannot take them, in words for the user.
    fn upload(
        &self,
        layout: &Layout<'_>,
        triangles: &[Triangle],
    ) -> Result<Box<dyn Uploaded>, String>;
}

/// A structure on a device.
pub trait Uploaded: Debug + Send + Sync {
    /// Writes an answer for each ray, and drops what `answers` held before: the first hit, or any hit if
    /// `any` is enough. May be called from several threads at a time.
    ///
    /// # Errors
    /// If the device fails: why, in words for the user. It is not asked again.
    fn trace(&self, rays: &Rays, any: bool, answers: &mut Vec<Answer>) -> Result<(), String>;

    /// Bytes held on the device.
    fn bytes(&self) -> usize;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::Isa;
    use crate::primitives::{Primitives, triangle};
    use crate::rays::{Coherence, Hits, NO_HIT};
    use crate::structure::study::Counts;
    use crate::structure::testing::Random;
    use crate::structure::{Accelerator, Scratch, Structure};

    /// How a device behaves.
    #[derive(Clone, Copy, Debug)]
    enum Manner {
        Good,
        Doubts,
        NamesOthers,
        NamesNone,
        Fails,
        AnswersFew,
    }

    #[derive(Debug)]
    struct Fake {
        manner: Manner,
        triangles: Vec<Triangle>,
    }

    impl Device for Manner {
        fn upload(&self, _: &Layout<'_>, all: &[Triangle]) -> Result<Box<dyn Uploaded>, String> {
            Ok(Box::new(Fake { manner: *self, triangles: all.to_vec() }))
        }
    }

    impl Uploaded for Fake {
        fn trace(&self, rays: &Rays, _: bool, answers: &mut Vec<Answer>) -> Result<(), String> {
            answers.clear();
            for i in 0..rays.len() {
                let ray = triangle::ShearedRay::new(rays.origin(i), rays.direction(i));
                let (mut object, mut t_max) = (NO_HIT, rays.t_max[i]);
                for (number, one) in (0..).zip(&self.triangles) {
                    // No other triangle has all corners at one point.
                    let is_solid = one[0] != one[1];
                    let hit = triangle::intersect(&ray, one, t_max).filter(|_| is_solid);
                    if let Some(hit) = hit {
                        (object, t_max) = (number, hit.t);
                    }
                }
                let certain = Answer { object, t: t_max, u: 0.0, v: 0.0, ..NOTHING };
                answers.push(match self.manner {
                    Manner::Good => certain,
                    Manner::Doubts => Answer { object: i as u32, is_certain: false, ..certain },
                    Manner::NamesOthers if object == NO_HIT => Answer { object: 3, ..certain },
                    Manner::NamesNone => Answer { object: NO_HIT - 1, ..certain },
                    _ => certain,
                });
            }
            match self.manner {
                Manner::Fails => Err("it is lost".to_owned()),
                Manner::AnswersFew => {
                    answers.truncate(1);
                    Ok(())
                }
                _ => Ok(()),
            }
        }

        fn bytes(&self) -> usize {
            1
        }
    }

    const NOTHING: Answer = Answer {
        object: NO_HIT,
        t: 0.0,
        u: 0.0,
        v: 0.0,
        counts: Counts {
            steps: 0,
            boxes: 0,
            tests: 0,
            leaves: 0,
            empty_leaves: 0,
            mailbox_hits: 0,
            restarts: 0,
        },
        is_certain: true,
    };

    fn bits(structure: &Structure, rays: &Rays) -> Vec<([u32; 4], bool)> {
        let (mut hits, mut blocked) = (Hits::default(), vec![]);
        let mut scratch = Scratch::default();
        structure.intersect(rays, Coherence::Incoherent, &mut hits, &mut scratch);
        structure.occluded(rays, Coherence::Incoherent, &mut blocked, &mut scratch);
        let of = |i: usize| {
            let [t, u, v] = [hits.t[i], hits.u[i], hits.v[i]].map(f32::to_bits);
            ([t, u, v, hits.primitive[i]], blocked[i])
        };
        (0..rays.len()).map(of).collect()
    }

    #[test]
    fn no_device_changes_a_hit() {
        let mut random = Random::new(41);
        let mut triangles = random.triangles(300, 0.4);
        triangles.extend_from_within(..20);
        triangles.push([triangles[0][0]; 3]);
        let rays = random.rays(1500, 1.0);
        for curved in [vec![], random.curved(30, 0.2)] {
            let primitives = Primitives { triangles: triangles.clone(), curved };
            let none = Structure::build(Accelerator::None, primitives.clone(), Isa::best());
            let expected = bits(&none, &rays);
            for manner in [
                Manner::Good,
                Manner::Doubts,
                Manner::NamesOthers,
                Manner::NamesNone,
                Manner::Fails,
                Manner::AnswersFew,
            ] {
                for accelerator in [Accelerator::Grid, Accelerator::Kd, Accelerator::Binary] {
                    let primitives = primitives.clone();
                    let built =
                        Structure::build_on(&manner, accelerator, primitives, Isa::best()).unwrap();
                    assert!(bits(&built, &rays) == expected, "{manner:?} {accelerator}");
                }
            }
        }
    }

    #[test]
    fn not_all_structures_can_be_given_to_a_device() {
        let triangles = Random::new(42).triangles(10, 0.4);
        for accelerator in [Accelerator::Bvh, Accelerator::Octree, Accelerator::None] {
            let built =
                Structure::build_on(&Manner::Good, accelerator, triangles.clone(), Isa::best());
            assert!(built.unwrap_err().contains("device"), "{accelerator}");
        }
        let options = crate::BuildOptions::new(Isa::best());
        let options = options.with_parameters("mailbox=1".parse().unwrap());
        let built = Structure::build_on(&Manner::Good, Accelerator::Kd, triangles, options);
        assert!(built.unwrap_err().contains("without mailboxes"));
    }
}
