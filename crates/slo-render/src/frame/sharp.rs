//! Objects with sharp lobes: where photons are sent.

use glam::Vec3;
use slo_accel::math::Bounds;
use slo_accel::{Curved, Primitives};
use slo_scene::SceneDescription;

use super::parts::Parts;
use super::sharpness::shares;
use super::shown::ShownObject;
use crate::photons::Sharp;

/// Returns the objects of a frame that have sharp lobes.
pub(super) fn sharp_objects(
    scene: &SceneDescription,
    objects: &[ShownObject<'_>],
    parts: &Parts,
) -> Vec<Sharp> {
    let shares = shares(&scene.materials);
    let (still, still_objects) = (parts.still(), parts.still_objects());
    let mut bounds = vec![Bounds::EMPTY; objects.len()];
    let mut add = |object: u32, more: Bounds| {
        // Surfaces of lamps come after all objects.
        if let Some(bounds) = bounds.get_mut(object as usize) {
            *bounds = bounds.union(more);
        }
    };
    for (triangle, &object) in still.triangles.iter().zip(&still_objects) {
        add(object, Bounds::of_points(*triangle));
    }
    for (curved, &object) in still.curved.iter().zip(&parts.curved_objects) {
        add(object, curved.bounds());
    }
    for instance in &parts.instances {
        add(instance.object, instance.bounds());
    }
    let reaches = reaches(parts, (&still, &still_objects), &bounds);
    let sharp = |((object, bounds), reach): ((&ShownObject<'_>, Bounds), f32)| {
        let share = shares[object.material.0 as usize];
        (share > 0.0 && !bounds.is_empty()).then_some(Sharp { bounds, reach, share })
    };
    objects.iter().zip(bounds).zip(reaches).filter_map(sharp).collect()
}

/// Returns the greatest distance of any point of each object from the middle of its bounds.
fn reaches(
    parts: &Parts,
    (still, still_objects): (&Primitives, &[u32]),
    bounds: &[Bounds],
) -> Vec<f32> {
    let mut reaches = vec![0.0f32; bounds.len()];
    let mut add = |object: u32, of: &dyn Fn(Vec3) -> f32| {
        if let Some(bounds) = bounds.get(object as usize) {
            let reach = &mut reaches[object as usize];
            *reach = reach.max(of((bounds.min + bounds.max) * 0.5));
        }
    };
    for (triangle, &object) in still.triangles.iter().zip(still_objects) {
        add(object, &|middle| triangle.iter().fold(0.0, |most, v| most.max((v - middle).length())));
    }
    for (curved, &object) in still.curved.iter().zip(&parts.curved_objects) {
        add(object, &|middle| match *curved {
            Curved::Sphere { center, radius } => (center - middle).length() + radius,
            _ => curved.bounds().size().length() * 0.5,
        });
    }
    for instance in &parts.instances {
        add(instance.object, &|_| instance.bounds().size().length() * 0.5);
    }
    reaches
}
