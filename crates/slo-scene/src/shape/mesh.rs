//! `mesh`

use std::sync::Arc;

use glam::DVec3;

use super::shapes::{ADD_SHAPE, SHAPES, Written, written_shapes};
use super::surface::{Surface, WrittenShape};
use crate::assets::{Assets, Standing};
use crate::attributes::Fields;
use crate::attributes::schema::{block, choice, number, single, word};
use crate::diagnostics::Diagnostic;
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;
use crate::mesh::Mesh;
use crate::mesh_shapes::MeshShapes;

/// The triangles of one or more files.
#[derive(Clone, Debug)]
pub struct MeshSurface {
    /// The triangles; of the first shape, if there are several.
    pub mesh: Arc<Mesh>,
    /// Whether the vertex normals are interpolated.
    pub smooth: bool,
    /// The shapes that the mesh has at scene times, if it changes its shape.
    pub shapes: Option<Arc<MeshShapes>>,
}

impl MeshSurface {
    /// A mesh that keeps its shape.
    pub fn new(mesh: impl Into<Arc<Mesh>>, smooth: bool) -> Self {
        Self { mesh: mesh.into(), smooth, shapes: None }
    }
}

impl WrittenShape for MeshSurface {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "mesh",
        attributes: &[
            word("filename", "PATH").repeated(),
            number("smooth_normals"),
            choice("axes"),
            single("fit", "size"),
            block(&ADD_SHAPE).repeated(),
            block(&SHAPES),
        ],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, assets: &mut Assets<'_>) -> Option<Self> {
        let smooth = fields.count("smooth_normals", 0, 1);
        let axes = fields.one_of("axes").unwrap_or_default();
        let size = fields.length_in_braces("fit").map(|size| size.value);
        let paths = fields.words("filename")?;
        let smooth = smooth.is_some_and(|s| s.value == 1);
        let standing = Standing { smooth, axes, size };
        let Some(written) = written_shapes(fields) else {
            if paths.is_empty() {
                report_no_file(fields);
                return None;
            }
            let mesh = assets.mesh(&paths, standing, fields.scale, fields.diagnostics)?;
            return Some(Self { mesh, smooth, shapes: None });
        };
        let Written { keys, places } = written?;
        if let [first, ..] = paths[..] {
            let message = format!("{} has `filename` and shapes", fields.element.title());
            let error = Diagnostic::error(message).at(first.span, "one of the two is too much");
            fields.diagnostics.push(error.help("shapes name the files of the mesh"));
            return None;
        }
        if let Some(fit) = fields.get("fit") {
            let message = format!("{} has `fit` and shapes", fields.element.title());
            let error = Diagnostic::error(message).at(fit.keyword.span, "this is for one file");
            fields.diagnostics.push(error.help("a key frame with `scale` makes all shapes larger"));
            return None;
        }
        let first = keys[0].1.clone();
        let scale = fields.scale;
        let mesh = assets.first_shape((&first, places[0]), standing, scale, fields.diagnostics)?;
        let mut others = keys.iter().zip(&places).skip(1);
        let are_there =
            others.all(|((_, path), place)| assets.is_there((path, *place), fields.diagnostics));
        let keys = keys.into_iter().zip(&places);
        let keys = keys.map(|((time, path), place)| (time, assets.full_path((&path, *place))));
        let shapes = MeshShapes::new(assets.files(), keys.collect(), standing, scale, first);
        are_there.then(|| Self { mesh, smooth, shapes: Some(Arc::new(shapes)) })
    }
}

fn report_no_file(fields: &mut Fields<'_, '_, '_>) {
    if fields.element.damaged || fields.has_strangers() {
        return;
    }
    let message = format!("{} has no `filename`", fields.element.title());
    let error =
        Diagnostic::error(message).at(fields.element.head(), "expected `filename PATH` in this");
    fields.diagnostics.push(error);
}

impl Surface for MeshSurface {
    fn triangle_count(&self) -> usize {
        self.mesh.faces.len()
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn unwrapped(&self) -> Result<Unwrapped, &'static str> {
        let Mesh { uvs, face_uvs, .. } = &*self.mesh;
        if face_uvs.is_empty() {
            return Err("its file has no texture coordinates");
        }
        let corners = |face: &[u32; 3]| face.map(|corner| uvs[corner as usize]);
        Ok(Unwrapped::Faces(face_uvs.iter().map(corners).collect()))
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        if self.shapes.is_some() {
            return;
        }
        for face in &self.mesh.faces {
            if !put(&face.map(|i| self.mesh.positions[i as usize])) {
                return;
            }
        }
    }

    fn is_consistent(&self) -> bool {
        self.mesh.is_consistent(self.smooth)
    }
}
