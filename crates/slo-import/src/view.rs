//! A camera and light for files that have none.

use glam::DVec3;

use crate::model::{Camera, Lamp, LampKind, Material, Model, Shape, View};

/// Sine of the angle to its up vector below which a camera has no upright.
const LEAST_SINE: f64 = 1e-6;

/// Width and height of pictures of files that do not say.
pub(crate) const SIZE: [u32; 2] = [1280, 720];

/// Gives the model a camera that sees all of it, and light, if it has none.
pub(crate) fn complete(model: &mut Model) {
    if model.camera.is_none() {
        let [least, most] = model.bounds().unwrap_or([DVec3::splat(-1.0), DVec3::ONE]);
        model.camera = Some(camera_of(least, most));
        model.notes.made_up.push("a camera that sees everything".into());
    }
    set_upright(model);
    let glows = |material: &Material| {
        material.numbers.iter().any(|(input, value)| *input == "emission_strength" && *value > 0.0)
    };
    let is_lit = !model.lamps.is_empty()
        || model.background.is_some() && !model.is_classical
        || model.objects.iter().any(|object| glows(&model.materials[object.material]));
    if !is_lit {
        if model.is_classical {
            model.notes.made_up.push("a light at the camera".into());
            let position =
                model.camera.as_ref().map_or(DVec3::Z, |camera| camera.views[0].position);
            let kind = LampKind::Classical { color: [1.0; 3], position };
            model.lamps.push(Lamp { name: "light".into(), space: None, kind });
        } else {
            model.notes.made_up.push("a white sky".into());
            model.background = Some([1.0; 3]);
        }
    }
}

/// Gives cameras that look along their up vector another one, and all of them a target that is away
/// from where they are.
fn set_upright(model: &mut Model) {
    let Some(camera) = &mut model.camera else { return };
    let mut is_told = false;
    for view in &mut camera.views {
        let way = view.target - view.position;
        let direction = way.normalize_or(DVec3::NEG_Z);
        let size = view.position.abs().max_element().max(1.0);
        if way.length() < 1e-3 * size {
            // Numbers of the scene are rounded.
            view.target = view.position + direction * size;
        }
        if view.up.normalize_or_zero().cross(direction).length() < LEAST_SINE {
            view.up = if direction.z.abs() < 0.9 { DVec3::Z } else { DVec3::Y };
            is_told = true;
        }
    }
    if is_told {
        model.notes.made_up.push("which way is up, as the camera looks along its up vector".into());
    }
}

/// A camera that looks down at a box from the front and a little from the right.
fn camera_of(least: DVec3, most: DVec3) -> Camera {
    let (middle, radius) = ((least + most) / 2.0, (most - least).length() / 2.0);
    let radius = radius.max(1e-6);
    let fov = 0.35;
    let away = DVec3::new(0.45, -1.0, 0.5).normalize();
    // The ball around the box touches the edges of the view.
    let distance = radius * libm::sqrt(1.0 + fov * fov) / fov;
    let view = View { position: middle + away * distance, target: middle, up: DVec3::Z };
    Camera { size: SIZE, fov, views: vec![view] }
}

/// Number of triangles and of other shapes.
pub(crate) fn counts(model: &Model) -> (usize, usize) {
    let (mut triangles, mut others) = (0, 0);
    for object in &model.objects {
        match &object.shape {
            Shape::Mesh(mesh) => triangles += model.meshes[*mesh].triangles(),
            Shape::Changing { first, .. } => triangles += model.meshes[*first].triangles(),
            Shape::Sphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Cone { .. }
            | Shape::Box { .. } => others += 1,
        }
    }
    (triangles, others)
}
