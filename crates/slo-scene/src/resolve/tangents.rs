//! Which meshes need tangents.

use std::collections::HashMap;
use std::sync::Arc;

use crate::description::Object;
use crate::diagnostics::Span;
use crate::material::Whole;
use crate::mesh::Mesh;
use crate::shape::Shape;

/// Computes the tangents of the meshes whose normals an image bends. Objects that shared a mesh
/// share it again; if nothing else holds the mesh, it is not copied.
pub(super) fn add_tangents(objects: &mut [(Object, Span)], materials: &[Whole]) {
    let mut users: HashMap<*const Mesh, Vec<usize>> = HashMap::new();
    for (i, (object, _)) in objects.iter().enumerate() {
        if let Shape::Mesh(surface) = &object.shape {
            users.entry(Arc::as_ptr(&surface.mesh)).or_default().push(i);
        }
    }
    let bends = |object: &Object| {
        materials.get(object.material.0 as usize).is_some_and(|material| material.bends_normals)
    };
    users.retain(|_, users| users.iter().any(|i| bends(&objects[*i].0)));
    for users in users.into_values() {
        let mut whole = Arc::default();
        for i in &users {
            if let Shape::Mesh(surface) = &mut objects[*i].0.shape {
                whole = std::mem::take(&mut surface.mesh);
            }
        }
        Arc::make_mut(&mut whole).add_tangents();
        for i in users {
            if let Shape::Mesh(surface) = &mut objects[i].0.shape {
                surface.mesh = Arc::clone(&whole);
            }
        }
    }
}
