//! A camera and light for files that have none.

use glam::DVec3;

use crate::model::{Camera, Lamp, LampKind, Material, Model, Shape, View};

/// Width and height of pictures of files that do not say.
pub(crate) const SIZE: [u32; 2] = [1280, 720];

/// Gives the model a camera that sees all of it, and light, if it has none.
pub(crate) fn complete(model: &mut Model) {
    if model.camera.is_none() {
        let [least, most] = model.bounds().unwrap_or([DVec3::splat(-1.0), DVec3::ONE]);
        model.camera = Some(camera_of(least, most));
        model.notes.made_up.push("a camera that sees everything".into());
    }
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
