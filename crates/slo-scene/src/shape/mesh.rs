//! `mesh`

use std::sync::Arc;

use glam::DVec3;

use super::surface::{Surface, WrittenShape};
use crate::assets::{Assets, Standing};
use crate::attributes::Fields;
use crate::attributes::schema::{choice, number, single, word};
use crate::kinds::Keyword;
use crate::mesh::Mesh;

/// The triangles of one or more files.
#[derive(Clone, Debug)]
pub struct MeshSurface {
    /// The triangles.
    pub mesh: Arc<Mesh>,
    /// Whether the vertex normals are interpolated.
    pub smooth: bool,
}

impl WrittenShape for MeshSurface {
    const KEYWORDS: &'static [Keyword] = &[Keyword {
        keyword: "mesh",
        attributes: &[
            word("filename", "PATH").required().repeated(),
            number("smooth_normals"),
            choice("axes"),
            single("fit", "size"),
        ],
    }];

    fn read(fields: &mut Fields<'_, '_, '_>, assets: &mut Assets<'_>) -> Option<Self> {
        let smooth = fields.count("smooth_normals", 0, 1);
        let axes = fields.one_of("axes").unwrap_or_default();
        let size = fields.length_in_braces("fit").map(|size| size.value);
        let paths = fields.words("filename")?;
        let smooth = smooth.is_some_and(|s| s.value == 1);
        let standing = Standing { smooth, axes, size };
        let mesh = assets.mesh(&paths, standing, fields.scale, fields.diagnostics)?;
        Some(Self { mesh, smooth })
    }
}

impl Surface for MeshSurface {
    fn triangle_count(&self) -> usize {
        self.mesh.faces.len()
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
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
