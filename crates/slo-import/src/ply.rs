//! PLY: one mesh, read as slo-rt reads it.

use crate::corners::Corners;
use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Material, Model, Object, Shape};

/// Reads a file.
pub(crate) fn read(source: &Source) -> Result<Model, ImportError> {
    let loaded = slo_scene::mesh::load("mesh.ply", &mut source.bytes.as_slice(), true, 1.0)
        .map_err(|error| source.bad(error.to_string()))?;
    let (mesh, mut model) = (loaded.mesh, Model::default());
    for warning in loaded.warnings {
        model.notes.leave_out(warning);
    }
    let mut corners = Corners::default();
    for (i, face) in mesh.faces.iter().enumerate() {
        let uvs = mesh.face_uvs.get(i);
        let corner = |k: usize| (face[k], Some(face[k]), uvs.map(|uvs| uvs[k]));
        corners.add(&[corner(0), corner(1), corner(2)]);
    }
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    model.meshes.push(corners.mesh(source.stem(), &positions, &mesh.normals, &mesh.uvs));
    model.materials.push(Material { name: "plain".into(), ..Material::default() });
    let name = source.stem();
    model.objects.push(Object {
        name,
        space: None,
        material: 0,
        shape: Shape::Mesh(0),
        is_hidden: false,
    });
    Ok(model)
}
