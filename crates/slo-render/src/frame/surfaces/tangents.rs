//! Tangents at hits, and normals that images bend.

use glam::{Vec2, Vec3};

use super::columns::Surfaces;
use crate::frame::scene::FrameScene;
use crate::frame::shapes::{Geometry, tangent_about};
use crate::shading::material::principled::Parameters;
use slo_accel::curved::Part;
use slo_accel::math::columns::BATCH;
use slo_scene::Mesh;

/// How a texture lies on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent {
    /// Where u grows.
    pub(super) along: Vec3,
    /// v grows along so many times the cross product of normal and tangent: 1, or -1 if the texture
    /// is mirrored.
    pub(super) side: f32,
}

/// Returns the tangent at a hit, in the space of the object. `point` and the unit outward `normal`
/// are in the same space; a `face` belongs to a mesh.
pub(super) fn tangent(
    geometry: &Geometry,
    face: u32,
    uv: [f32; 2],
    point: Vec3,
    normal: Vec3,
) -> Tangent {
    match geometry {
        Geometry::Mesh(mesh, _) => of_mesh(mesh, face, uv).unwrap_or_else(|| {
            // About the z axis, as Blender does without texture coordinates.
            let about = Vec3::Z.cross(point);
            let along = about - normal * about.dot(normal);
            Tangent { along: along.try_normalize().unwrap_or_else(|| any_along(normal)), side: 1.0 }
        }),
        Geometry::Curved(shape) => {
            let part = Part::from_u(uv[0]);
            let along = tangent_about(shape.axis(), point, part);
            // Seen from below, the image on the base is mirrored.
            Tangent { along, side: if part == Part::Base { -1.0 } else { 1.0 } }
        }
    }
}

/// Returns a unit vector that is perpendicular to a unit vector.
fn any_along(normal: Vec3) -> Vec3 {
    let about = Vec3::Z.cross(normal);
    about.try_normalize().unwrap_or(Vec3::X)
}

/// Returns the tangent of a face of a mesh that has texture coordinates.
fn of_mesh(mesh: &Mesh, face: u32, [u, v]: [f32; 2]) -> Option<Tangent> {
    let face = face as usize;
    if let Some(corners) = mesh.tangents.get(face) {
        let [a, b, c] = corners.map(|tangent| tangent.unpacked());
        let mix = |k: usize| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v;
        // Interpolated, and not of unit length: so MikkTSpace wants it.
        return Some(Tangent { along: Vec3::new(mix(0), mix(1), mix(2)), side: a[3] });
    }
    let [a, b, c] = mesh.face_uvs.get(face)?.map(|i| Vec2::from(mesh.uvs[i as usize]));
    let [p, q, r] = mesh.faces[face].map(|i| mesh.positions[i as usize]);
    let (ab, ac) = (b - a, c - a);
    let (pq, pr) = ((q - p).as_vec3(), (r - p).as_vec3());
    let area = ab.x * ac.y - ab.y * ac.x;
    let along = (pq * ac.y - pr * ab.y) * area.signum();
    along.try_normalize().map(|along| Tangent { along, side: area.signum() })
}

impl FrameScene {
    /// Bends the shading normals of hits whose materials have an image of normals.
    pub(crate) fn bend_normals(&self, parameters: &Parameters, to: &mut Surfaces) {
        let images = &self.material_table.images;
        to.any_is_bent = images.any_bends();
        if !to.any_is_bent {
            return;
        }
        for i in 0..to.len.min(BATCH) {
            let image = images.normals(to.material[i]);
            to.is_bent[i] = u32::from(image.is_some());
            let Some(image) = image else { continue };
            let n = to.n_shade.get(i);
            let facing = if to.from_outside[i] == 1 { 1.0 } else { -1.0 };
            // The side of the surface that the image is meant for.
            let outward = n * facing;
            let tangent = to.tangent.get(i);
            let bitangent = outward.cross(tangent) * to.bitangent[i];
            let map = image.color(&self.textures, to.uv(i)) * 2.0 - Vec3::ONE;
            let strength = parameters.normal_strength[i];
            let z = 1.0 + (map.z - 1.0) * strength.clamp(0.0, 1.0);
            let bent = tangent * (map.x * strength) + bitangent * (map.y * strength) + outward * z;
            let bent = (bent * facing).try_normalize().unwrap_or(n);
            // On the side from which light arrives.
            let floor = to.floor.get(i);
            let below = bent.dot(floor);
            let bent = if below < 0.0 { bent - 2.0 * below * floor } else { bent };
            to.n_shade.set(i, bent);
        }
    }
}
