//! Objects with sharp lobes: where photons are sent.

use slo_accel::math::Bounds;
use slo_scene::material::Principled;
use slo_scene::{MaterialKind, SceneDescription};

use super::parts::Parts;
use crate::photons::Sharp;
use crate::shading::bsdf::{SHARP, SHARP_INVERSE};
use crate::shading::material;

/// Returns the objects of a frame that have sharp lobes.
pub(super) fn sharp_objects(scene: &SceneDescription, parts: &Parts) -> Vec<Sharp> {
    let shares: Vec<f32> =
        (0..scene.materials.len()).map(|number| share(scene, number as u32)).collect();
    let mut bounds = vec![Bounds::EMPTY; scene.objects.len()];
    let mut add = |object: u32, more: Bounds| {
        // Surfaces of lamps come after all objects.
        if let Some(bounds) = bounds.get_mut(object as usize) {
            *bounds = bounds.union(more);
        }
    };
    for (triangle, &object) in parts.still.triangles.iter().zip(&parts.triangle_objects) {
        add(object, Bounds::of_points(*triangle));
    }
    for (curved, &object) in parts.still.curved.iter().zip(&parts.curved_objects) {
        add(object, curved.bounds());
    }
    for instance in &parts.instances {
        add(instance.object, instance.bounds());
    }
    let sharp = |(object, bounds): (&slo_scene::Object, Bounds)| {
        let share = shares[object.material.0 as usize];
        (share > 0.0 && !bounds.is_empty()).then_some(Sharp { bounds, share })
    };
    scene.objects.iter().zip(bounds).filter_map(sharp).collect()
}

/// Estimates the share of light that the sharp lobes of a material scatter; 0 if it has none.
fn share(scene: &SceneDescription, number: u32) -> f32 {
    let material = &scene.materials[number as usize];
    match &material.kind {
        MaterialKind::Phong(_) => {
            let row = material::row(material);
            let if_sharp = |share, inverse| if inverse < SHARP_INVERSE { share } else { 0.0f32 };
            if_sharp(row.reflectance, row.reflection_lobe)
                + if_sharp(row.refraction, row.refraction_lobe)
        }
        MaterialKind::Principled(of) => of_principled(of),
        MaterialKind::Mix(mix) => share(scene, mix.first.0).max(share(scene, mix.second.0)),
    }
}

fn of_principled(of: &Principled) -> f32 {
    let Principled { roughness, coat, coat_roughness, metallic, transmission, .. } = of;
    // An image may darken a roughness to 0.
    let is_sharp = |roughness: &slo_scene::material::Varying<f32>| {
        roughness.image.is_some() || roughness.value * roughness.value < SHARP
    };
    let root = (of.ior.value - 1.0) / (of.ior.value + 1.0).max(f32::MIN_POSITIVE);
    let gloss = (root * root * 2.0 * of.specular_ior_level.value).min(1.0);
    let below = transmission.value + (1.0 - transmission.value) * gloss;
    let base = metallic.value + (1.0 - metallic.value) * below;
    let coated = if is_sharp(coat_roughness) { coat.value * 0.04 } else { 0.0 };
    coated + if is_sharp(roughness) { base } else { 0.0 }
}
