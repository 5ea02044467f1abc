//! Meshes with moved vertices, which are no files yet.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use slo_scene::Mesh;
use slo_scene::mesh::slo::write_slo;

/// Bytes that a moved vertex takes, about.
const BYTES_OF_VERTEX: usize = 48;

/// A mesh and its moved vertices, in the units and axes of its file.
#[derive(Clone, Debug)]
pub(crate) struct Sculpted {
    mesh: Arc<Mesh>,
    moved: Arc<BTreeMap<u32, DVec3>>,
    /// Another number for every state.
    version: u64,
}

impl Sculpted {
    /// A mesh as a scene shows it, `scale` times as large as in a file; `is_y_up`: y is up in the file.
    pub(crate) fn new(shown: &Mesh, scale: f64, is_y_up: bool) -> Self {
        let in_file = |p: DVec3| if is_y_up { DVec3::new(p.x, p.z, -p.y) } else { p };
        let normal = |[x, y, z]: [f32; 3]| if is_y_up { [x, z, -y] } else { [x, y, z] };
        let mesh = Mesh {
            positions: shown.positions.iter().map(|p| in_file(*p / scale)).collect(),
            normals: shown.normals.iter().copied().map(normal).collect(),
            tangents: Vec::new(),
            ..shown.clone()
        };
        Self { mesh: Arc::new(mesh), moved: Arc::default(), version: next() }
    }

    /// Where a vertex is.
    pub(crate) fn position(&self, vertex: u32) -> Option<DVec3> {
        let moved = self.moved.get(&vertex).copied();
        moved.or_else(|| self.mesh.positions.get(vertex as usize).copied())
    }

    /// The mesh after vertices were moved.
    pub(crate) fn with(&self, places: impl IntoIterator<Item = (u32, DVec3)>) -> Self {
        let mut moved = (*self.moved).clone();
        moved.extend(places);
        Self { mesh: self.mesh.clone(), moved: Arc::new(moved), version: next() }
    }

    /// Another number for every state.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Memory that remembering it takes, beside the mesh.
    pub(crate) fn bytes(&self) -> usize {
        self.moved.len() * BYTES_OF_VERTEX
    }

    /// The content of its file.
    ///
    /// # Errors
    /// A coordinate is not finite.
    pub(crate) fn to_file(&self) -> io::Result<Vec<u8>> {
        let mut mesh = (*self.mesh).clone();
        for (vertex, to) in &*self.moved {
            if let Some(at) = mesh.positions.get_mut(*vertex as usize) {
                *at = *to;
            }
        }
        mesh.renew_normals(&self.moved.keys().copied().collect());
        let mut file = Vec::new();
        write_slo(&mesh, &mut file)?;
        Ok(file)
    }
}

fn next() -> u64 {
    static VERSIONS: AtomicU64 = AtomicU64::new(1);
    VERSIONS.fetch_add(1, Ordering::Relaxed)
}

/// Meshes that are no files yet, by the names of their files beside the scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sculptures(Arc<BTreeMap<String, Sculpted>>);

impl PartialEq for Sculptures {
    fn eq(&self, other: &Self) -> bool {
        let versions = |of: &Self| -> Vec<(String, u64)> {
            of.0.iter().map(|(name, mesh)| (name.clone(), mesh.version)).collect()
        };
        Arc::ptr_eq(&self.0, &other.0) || versions(self) == versions(other)
    }
}

impl Sculptures {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn get(&self, name: &str) -> Option<&Sculpted> {
        self.0.get(name)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &Sculpted)> {
        self.0.iter().map(|(name, mesh)| (&**name, mesh))
    }

    /// The same, with a mesh of a name.
    pub(crate) fn with(&self, name: &str, mesh: Sculpted) -> Self {
        let mut all = (*self.0).clone();
        all.insert(name.to_owned(), mesh);
        Self(Arc::new(all))
    }

    /// Memory that remembering them takes, beside the meshes.
    pub(crate) fn bytes(&self) -> usize {
        self.0.values().map(Sculpted::bytes).sum()
    }
}

#[cfg(test)]
mod tests {
    use slo_scene::mesh::load;

    use super::*;

    #[test]
    fn what_is_saved_is_what_was_shown_but_for_what_was_moved() {
        let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
        for (smooth, is_y_up) in [(false, false), (true, true)] {
            let read = |name: &str, bytes: &[u8], scale| {
                load(name, &mut &*bytes, smooth, scale).expect("a mesh").mesh
            };
            let mut shown = read("a.obj", obj.as_bytes(), 2.0);
            let turned = |p: DVec3| if is_y_up { DVec3::new(p.x, -p.z, p.y) } else { p };
            shown.positions.iter_mut().for_each(|p| *p = turned(*p));
            let sculpted = Sculpted::new(&shown, 2.0, is_y_up);
            assert_eq!(sculpted.position(1), Some(DVec3::X));
            let moved = sculpted.with([(2, DVec3::new(1.0, 2.0, 0.0))]);
            assert!(moved.version() != sculpted.version() && moved.bytes() > 0);
            let file = read("a.slo", &moved.to_file().unwrap(), 1.0);
            let original = read("a.obj", obj.as_bytes(), 1.0);
            let mut expected = original.clone();
            expected.positions[2].y = 2.0;
            assert_eq!((file.positions, file.faces), (expected.positions, expected.faces));
            assert_eq!((file.uvs, file.face_uvs), (original.uvs, original.face_uvs));
            assert_eq!(file.normals.len(), if smooth { 4 } else { 0 });
        }
    }

    #[test]
    fn what_is_not_finite_is_no_file() {
        let mesh =
            Mesh { positions: vec![DVec3::ZERO; 3], faces: vec![[0, 1, 2]], ..Mesh::default() };
        let sculpted = Sculpted::new(&mesh, 1.0, false);
        assert!(sculpted.with([(0, DVec3::NAN)]).to_file().is_err());
        let all = Sculptures::default().with("a.slo", sculpted.clone());
        assert!(all == all.clone() && all != all.with("a.slo", sculpted.with([])));
        assert_eq!(all.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["a.slo"]);
    }
}
