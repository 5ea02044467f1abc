//! Meshes that change their shape: where their vertices are while the shutter is open.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::sampled_motion::ObjectBox;
use slo_accel::{Bending, Isa, Moment, Triangle};
use slo_scene::animation::Shutter;
use slo_scene::{Mesh, MeshShapes, ShapeAt, ShapeError};

/// Knots that lie closer together are one.
const LEAST_GAP: f64 = 1e-6;

/// A mesh during one shutter, in object space.
pub(super) enum Shaped {
    /// It keeps the shape that it has.
    AtRest(Arc<Mesh>),
    /// It bends.
    Bends(Bent),
}

/// A mesh that bends during one shutter: vertices move straight and evenly from knot to knot.
pub(super) struct Bent {
    /// The mesh when the shutter opens.
    pub(super) mesh: Arc<Mesh>,
    /// Shutter times, from 0 to 1.
    times: Vec<f32>,
    /// Positions of the vertices at each of them.
    positions: Vec<Vec<DVec3>>,
    /// Unit normals of the vertices, knot by knot; empty if the mesh has none.
    pub(super) normals: Vec<Vec3>,
}

impl Shaped {
    /// Finds the shape of `mesh` during a shutter. Reads the files that it needs.
    pub(super) fn new(
        mesh: &Mesh,
        shapes: &MeshShapes,
        shutter: &Shutter,
    ) -> Result<Self, ShapeError> {
        let keys = shapes.within(shutter.scene_interval(), mesh)?;
        let opened = Arc::new(mesh_at(mesh, &keys, shutter.scene_time(0.0)));
        let stands = shutter.scene_time(0.0) == shutter.scene_time(1.0);
        if keys.len() == 1 || stands {
            return Ok(Self::AtRest(opened));
        }
        let times = knots(&keys, shutter);
        let vertices: Vec<_> = times.iter().map(|&s| at(&keys, shutter.scene_time(s))).collect();
        let (positions, normals): (Vec<_>, Vec<_>) = vertices.into_iter().unzip();
        let times = times.into_iter().map(|s| s as f32).collect();
        Ok(Self::Bends(Bent { mesh: opened, times, positions, normals: normals.concat() }))
    }
}

impl Bent {
    /// Returns a box about all vertices at all times.
    pub(super) fn about(&self) -> ObjectBox {
        ObjectBox::about(self.positions.iter().flatten().copied())
    }

    /// Builds the structure over the triangles, translated by `-center`. It starts from the structure
    /// of another frame, if there is one, and lets rays cost so much more.
    pub(super) fn structure(
        &self,
        center: DVec3,
        isa: Isa,
        like: Option<(&Bending, f64)>,
    ) -> Bending {
        let shape = |positions: &Vec<DVec3>| -> Vec<Triangle> {
            let local: Vec<Vec3> = positions.iter().map(|&p| (p - center).as_vec3()).collect();
            let triangle = |face: &[u32; 3]| face.map(|vertex| local[vertex as usize]);
            self.mesh.faces.iter().map(triangle).collect()
        };
        let shapes: Vec<_> = self.positions.iter().map(shape).collect();
        match like {
            Some((before, growth)) => {
                Bending::build_like(before, growth, &shapes, &self.times, isa)
            }
            None => Bending::build(&shapes, &self.times, isa),
        }
    }
}

/// Returns the normal of a vertex of `count` at a moment, from normals knot by knot.
#[inline]
pub(super) fn normal_at(normals: &[Vec3], count: usize, vertex: u32, at: Moment) -> Vec3 {
    let place = at.shape * count + vertex as usize;
    normals[place].lerp(normals[place + count], at.part)
}

/// Returns the shutter times between which all vertices move evenly, from 0 to 1: those of shapes,
/// and the one at which scene time stops, where the shutter outlasts it.
fn knots(keys: &[ShapeAt], shutter: &Shutter) -> Vec<f64> {
    let stops = shutter.scene_time(1.0);
    let times = keys.iter().map(|key| key.time).chain([stops]);
    let inner = times.filter_map(|time| shutter.shutter_time_of(time));
    let mut inner: Vec<f64> = inner.filter(|s| (LEAST_GAP..=1.0 - LEAST_GAP).contains(s)).collect();
    inner.sort_by(f64::total_cmp);
    inner.dedup_by(|b, a| *b - *a < LEAST_GAP);
    [&[0.0][..], &inner, &[1.0]].concat()
}

/// Returns the mesh at a scene time.
fn mesh_at(mesh: &Mesh, keys: &[ShapeAt], time: f64) -> Mesh {
    let (positions, normals) = at(keys, time);
    let mut mesh = Mesh {
        positions,
        normals: normals.iter().map(Vec3::to_array).collect(),
        faces: mesh.faces.clone(),
        uvs: mesh.uvs.clone(),
        face_uvs: mesh.face_uvs.clone(),
        tangents: mesh.tangents.clone(),
    };
    if !mesh.tangents.is_empty() {
        mesh.add_tangents();
    }
    mesh
}

/// Returns the positions and normals of all vertices at a scene time.
fn at(keys: &[ShapeAt], time: f64) -> (Vec<DVec3>, Vec<Vec3>) {
    let after = keys.partition_point(|key| key.time <= time).clamp(1, keys.len().max(2) - 1);
    let (a, b) = (&keys[after - 1], keys.get(after).unwrap_or(&keys[after - 1]));
    let length = b.time - a.time;
    let part = if length > 0.0 { ((time - a.time) / length).clamp(0.0, 1.0) } else { 0.0 };
    let positions = a.mesh.positions.iter().zip(&b.mesh.positions);
    let normals = a.mesh.normals.iter().zip(&b.mesh.normals).map(|(&a, &b)| {
        let (a, b) = (Vec3::from(a), Vec3::from(b));
        a.lerp(b, part as f32).try_normalize().unwrap_or(a)
    });
    (positions.map(|(&a, &b)| a + (b - a) * part).collect(), normals.collect())
}
