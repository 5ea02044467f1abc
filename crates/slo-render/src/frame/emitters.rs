//! Objects that emit light, as lights that rays are sent toward.

use glam::Vec3;

use super::parts::Parts;
use super::shapes::Geometry;
use crate::shading::Light;
use crate::shading::light::Triangle;
use slo_scene::material::Principled;
use slo_scene::{MaterialKind, Object, SceneDescription};

/// Returns the radiance of a material that emits the same light everywhere on its surface and in
/// all directions.
fn even_radiance(scene: &SceneDescription, object: &Object) -> Option<Vec3> {
    let MaterialKind::Principled(of) = &scene.materials[object.material.0 as usize].kind else {
        return None;
    };
    let Principled { emission_color, emission_strength, coat, sheen, alpha, .. } = of;
    let is_even = [emission_strength, coat, sheen, alpha].iter().all(|of| of.image.is_none())
        && emission_color.image.is_none()
        && coat.value == 0.0
        && sheen.value == 0.0
        && alpha.value == 1.0;
    let radiance = Vec3::from(emission_color.value) * emission_strength.value;
    (is_even && radiance != Vec3::ZERO).then_some(radiance)
}

/// Adds the triangles of still objects that emit light to the lights of a frame.
///
/// The light of other emitters is found by rays that hit them.
pub(super) fn add_emitters(scene: &SceneDescription, parts: &mut Parts, lights: &mut Vec<Light>) {
    for (number, object) in scene.objects.iter().enumerate() {
        let Some(radiance) = even_radiance(scene, object).filter(|_| object.sampled) else {
            continue;
        };
        let Some(triangles) = parts.still_triangles(number) else { continue };
        let first_light = lights.len() as u32;
        let light = |corners: &[Vec3; 3]| Light::Triangle(Triangle::new(*corners, radiance));
        lights.extend(triangles.iter().map(light));
        parts.objects[number].first_light = Some(first_light);
    }
}

/// Finds the groups of all objects, and returns those of all lights, as numbers: 0 for the light
/// without a group, and one more than the place among the names of the scene's groups for others.
pub(super) fn light_groups(scene: &SceneDescription, parts: &mut Parts, lights: usize) -> Vec<u32> {
    let groups = scene.light_groups();
    let number = |name: Option<&str>| groups.index(name).map_or(0, |index| index as u32 + 1);
    let mut all: Vec<u32> =
        scene.lights.iter().map(|light| number(light.group.as_deref())).collect();
    all.resize(lights, 0);
    for (object, to) in scene.objects.iter().zip(&mut parts.objects) {
        to.light_group = number(object.light_group.as_deref());
        if let (Some(first), Geometry::Mesh(mesh, _)) = (to.first_light, &to.geometry) {
            all[first as usize..][..mesh.faces.len()].fill(to.light_group);
        }
    }
    all
}
