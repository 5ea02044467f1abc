//! Meshes in a cache: parsed, with their normals, as they come out of [`load`](super::load()).

use bytemuck::{cast_slice, cast_vec};
use glam::DVec3;
use rayon::prelude::*;

use super::data::{LoadedMesh, Mesh};
use super::finish::MAX_COORDINATE;
use crate::cache::{Cache, Entry, Key};

/// Version of the readers of mesh files and of the sections here: to be raised whenever a file may
/// come out as another mesh.
const LAYOUT: u32 = 1;

/// Smaller files are read again as fast.
pub(crate) const LEAST_BYTES: u64 = 1 << 20;

/// Sections.
const POSITIONS: usize = 0;
const FACES: usize = 1;
const NORMALS: usize = 2;
const UVS: usize = 3;
const FACE_UVS: usize = 4;
const WARNINGS: usize = 5;

/// The key of the mesh that is made of a file of a hash.
pub(crate) fn key(file: &blake3::Hash, extension: &str, smooth: bool, scale: f64) -> Key {
    let scale = scale.to_bits().to_le_bytes();
    let parts: [&[u8]; 4] = [file.as_bytes(), extension.as_bytes(), &[smooth.into()], &scale];
    Key::new("mesh", LAYOUT, &parts)
}

/// Keeps a mesh.
pub(crate) fn put(cache: &Cache, key: &Key, LoadedMesh { mesh, warnings }: &LoadedMesh) {
    let Mesh { positions, faces, normals, uvs, face_uvs, tangents } = mesh;
    if !tangents.is_empty() || cfg!(target_endian = "big") {
        return;
    }
    let warnings = warnings.join("\n");
    cache.put(
        key,
        &[
            cast_slice(positions),
            cast_slice(faces),
            cast_slice(normals),
            cast_slice(uvs),
            cast_slice(face_uvs),
            warnings.as_bytes(),
        ],
    );
}

/// Returns the mesh of a key, if it was kept.
pub(crate) fn get(cache: &Cache, key: &Key, smooth: bool) -> Option<LoadedMesh> {
    if cfg!(target_endian = "big") {
        return None;
    }
    cache.get(key, |entry| read(entry, smooth))
}

/// Reads a mesh. `None` if it is none that a reader of mesh files could have made.
fn read(entry: &Entry, smooth: bool) -> Option<LoadedMesh> {
    let positions: Vec<[f64; 3]> = entry.values(POSITIONS)?;
    let mesh = Mesh {
        positions: cast_vec::<[f64; 3], DVec3>(positions),
        faces: entry.values(FACES)?,
        normals: entry.values(NORMALS)?,
        uvs: entry.values(UVS)?,
        face_uvs: entry.values(FACE_UVS)?,
        tangents: Vec::new(),
    };
    let warnings = String::from_utf8(entry.values(WARNINGS)?).ok()?;
    let warnings = warnings.lines().map(str::to_owned).collect();
    let is_near = |p: &DVec3| p.abs().cmple(DVec3::splat(MAX_COORDINATE)).all();
    // A vertex of no face has no normal.
    let is_short = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>() < 1.02;
    let is_sound = !mesh.faces.is_empty()
        && mesh.is_consistent(smooth)
        && mesh.positions.par_iter().all(is_near)
        && mesh.normals.par_iter().all(is_short)
        && mesh.uvs.par_iter().all(|uv| uv.iter().all(|x| x.is_finite()));
    is_sound.then_some(LoadedMesh { mesh, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt 1 1\nvt 1 0\n\
        f 1/1 2/2 3/3\nf 1/1 1/1 2/2\n";

    fn loaded(smooth: bool) -> LoadedMesh {
        super::super::load("a.obj", &mut OBJ.as_bytes(), smooth, 2.0).expect("a mesh")
    }

    fn check(change: impl FnOnce(&mut Mesh)) -> Option<LoadedMesh> {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = Cache::new(folder.path(), 1 << 20, |_| {});
        let key = key(&blake3::hash(OBJ.as_bytes()), "obj", true, 2.0);
        let mut mesh = loaded(true);
        change(&mut mesh.mesh);
        put(&cache, &key, &mesh);
        get(&cache, &key, true)
    }

    #[test]
    fn a_mesh_comes_back_with_its_warnings() {
        let loaded = loaded(true);
        assert_eq!((loaded.warnings.len(), loaded.mesh.normals.len()), (1, 3));
        assert_eq!(check(|_| {}), Some(loaded));
    }

    #[test]
    fn what_no_file_says_is_not_believed() {
        assert_eq!(check(|mesh| mesh.faces[0][1] = 3), None);
        assert_eq!(check(|mesh| mesh.face_uvs[0][2] = 3), None);
        assert_eq!(check(|mesh| mesh.faces.clear()), None);
        assert_eq!(check(|mesh| mesh.face_uvs.push([0; 3])), None);
        assert_eq!(check(|mesh| mesh.normals.truncate(2)), None);
        assert_eq!(check(|mesh| mesh.normals.clear()), None);
        assert_eq!(check(|mesh| mesh.normals[1] = [f32::NAN; 3]), None);
        assert_eq!(check(|mesh| mesh.positions[1].x = f64::NAN), None);
        assert_eq!(check(|mesh| mesh.positions[1].x = 1e300), None);
        assert_eq!(check(|mesh| mesh.uvs[1][0] = f32::INFINITY), None);
    }
}
