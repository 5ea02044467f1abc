//! From a hit to what shading needs: point, normals, colour of the image, rounding bound.

use glam::{DVec3, Mat3, Vec3};

use super::tessellate::Geometry;
use super::world::{Instance, STILL};
use super::{FrameObject, FrameScene, Look};
use crate::accel::curved::Part;
use crate::accel::{Curved, Structure, Triangle};
use crate::math::rounding::gamma;
use crate::scene::Mesh;
use crate::shading::texture::sample_bilinear;

/// One hit of a batch, as the structures tell it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Origin of the ray.
    pub(crate) origin: Vec3,
    /// Unit direction of the ray.
    pub(crate) direction: Vec3,
    /// Time of the ray in `[0, 1]`.
    pub(crate) time: f32,
    /// Distance.
    pub(crate) t: f32,
    /// As [`Hits`](crate::accel::Hits) tells them.
    pub(crate) uv: [f32; 2],
    /// Primitive id in its structure.
    pub(crate) primitive: u32,
    /// Instance number or [`STILL`].
    pub(crate) instance: u32,
}

/// What is at a hit. Render space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// The hit.
    pub(crate) point: Vec3,
    /// Bound of the rounding errors of `point`, and of those that a test of a ray from there
    /// makes, along the normal.
    offset: f32,
    /// Unit normal of the surface itself, on the side that the ray came from.
    pub(crate) n_geo: Vec3,
    /// Unit normal for shading, within 90 degrees of `n_geo`.
    pub(crate) n_shade: Vec3,
    /// Whether the ray came from outside.
    pub(crate) from_outside: bool,
    /// Colour of the material's image; white where it has none.
    pub(crate) tint: Vec3,
}

impl Surface {
    /// Where a ray toward `direction` starts, so that it can't hit the surface that it leaves.
    ///
    /// Source: Wächter and Binder (Ray Tracing Gems 6) for the problem; as in pbrt 3.9.5 the
    /// offset is the error bound of this very hit, not a constant.
    #[inline]
    pub(crate) fn leave(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.n_geo) < 0.0 { -self.n_geo } else { self.n_geo };
        let moved = self.point + side * self.offset;
        // The sum is rounded too: away from the surface.
        Vec3::new(away(moved.x, side.x), away(moved.y, side.y), away(moved.z, side.z))
    }
}

/// The next number after `p` on the side that `n` points to; `p` where `n` is 0.
#[inline(always)]
fn away(p: f32, n: f32) -> f32 {
    if p == 0.0 || !p.is_finite() || n == 0.0 {
        return if n > 0.0 {
            p.next_up()
        } else if n < 0.0 {
            p.next_down()
        } else {
            p
        };
    }
    // Without branches: the number's bits count up as its size does.
    let grows = (p > 0.0) == (n > 0.0);
    f32::from_bits(if grows { p.to_bits() + 1 } else { p.to_bits() - 1 })
}

/// A point of a primitive, in one space.
struct Local {
    point: Vec3,
    /// Unit, outward.
    normal: Vec3,
    /// Largest coordinates that the point was computed from.
    magnitude: Vec3,
}

/// A point of a primitive in all spaces that it is asked for in.
struct Found {
    render: Local,
    object_point: Vec3,
    /// From object to render space.
    rotation: Mat3,
    /// Id of the primitive within its object.
    primitive: u32,
}

impl FrameScene {
    /// What the object at a hit looks like.
    #[inline]
    pub(crate) fn look(&self, hit: &Hit) -> Look {
        self.objects[self.object_of(hit) as usize].look
    }

    #[inline]
    fn object_of(&self, hit: &Hit) -> u32 {
        if hit.instance == STILL {
            self.still_objects[hit.primitive as usize]
        } else {
            self.world.instances[hit.instance as usize].object
        }
    }

    /// The share of light that passes the surface at a hit on its way to another hit, where shadows
    /// are transparent; `None` where it blocks.
    ///
    /// A closed object lets `refraction` through in all: the square root at each of its surfaces.
    pub(crate) fn light_passed(&self, hit: &Hit) -> Option<f32> {
        let object = &self.objects[self.object_of(hit) as usize];
        let Look::Material(material) = object.look else { return None };
        let refraction = self.materials[material as usize].refraction;
        let open = matches!(object.geometry, Geometry::Mesh(ref mesh, _) if mesh.faces.len() <= 2);
        (refraction > 0.0).then(|| if open { refraction } else { refraction.sqrt() })
    }

    /// Everything about the point of a hit.
    pub(crate) fn surface(&self, hit: &Hit) -> Surface {
        let object = &self.objects[self.object_of(hit) as usize];
        let found = if hit.instance == STILL {
            self.on_still(hit, object)
        } else {
            on_instance(hit, &self.world.instances[hit.instance as usize])
        };
        let from_outside = hit.direction.dot(found.render.normal) < 0.0;
        let n_geo = if from_outside { found.render.normal } else { -found.render.normal };
        let n_shade = match object.geometry {
            Geometry::Mesh(ref mesh, true) => {
                let n = interpolated_normal(mesh, found.primitive, hit.uv);
                let n = found.rotation * n;
                // Opposite normals may cancel.
                let n = n.try_normalize().unwrap_or(n_geo);
                if n.dot(n_geo) < 0.0 { -n } else { n }
            }
            _ => n_geo,
        };
        Surface {
            // Roundings: 3 of a weighted sum, 5 of a transform there, 5 of one back, and those of
            // the next ray's own test of this surface.
            offset: n_geo.abs().dot(found.render.magnitude) * gamma(32),
            point: found.render.point,
            n_geo,
            n_shade,
            from_outside,
            tint: self.tint(hit, object, &found),
        }
    }

    fn on_still(&self, hit: &Hit, object: &FrameObject) -> Found {
        let structure = &self.world.still;
        let render = local(structure, hit, hit.origin, hit.direction);
        let is_triangle = (hit.primitive as usize) < structure.triangle_count();
        let first = if is_triangle { object.first_triangle } else { hit.primitive };
        Found {
            object_point: object.place.inverse_point(render.point),
            render,
            rotation: object.place.rotation,
            primitive: hit.primitive - first,
        }
    }

    /// The colour of the object's image at a hit.
    fn tint(&self, hit: &Hit, object: &FrameObject, found: &Found) -> Vec3 {
        let Look::Material(material) = object.look else { return Vec3::ONE };
        let Some(texture) = self.materials[material as usize].texture else { return Vec3::ONE };
        let [u, v] = match object.geometry {
            Geometry::Mesh(ref mesh, _) => interpolated_uv(mesh, found.primitive, hit.uv),
            Geometry::Curved(ref shape) => shape.uv_at(found.object_point, Part::from_u(hit.uv[0])),
        };
        let image = &self.textures[texture.texture.0 as usize];
        sample_bilinear(image, u * texture.scale[0], v * texture.scale[1]).into()
    }
}

fn on_instance(hit: &Hit, instance: &Instance) -> Found {
    let pose = instance.pose(hit.time);
    let origin = pose.inverse_point(hit.origin);
    let direction = pose.inverse_vector(hit.direction);
    let local = local(&instance.structure, hit, origin, direction);
    Found {
        object_point: local.point + instance.center,
        render: Local {
            point: pose.point(local.point),
            normal: pose.vector(local.normal).normalize(),
            magnitude: abs_product(&pose.rotation, local.magnitude) + pose.translation.abs(),
        },
        rotation: pose.rotation,
        primitive: hit.primitive,
    }
}

/// The point of a hit, by a ray that is given in the space of the structure.
fn local(structure: &Structure, hit: &Hit, origin: Vec3, direction: Vec3) -> Local {
    let triangles = structure.triangle_count();
    match (hit.primitive as usize).checked_sub(triangles) {
        None => on_triangle(&structure.triangle(hit.primitive), hit.uv),
        Some(curved) => {
            let curved = &structure.curved()[curved];
            on_curved(curved, Part::from_u(hit.uv[0]), origin, direction, hit.t)
        }
    }
}

fn on_triangle(&[a, b, c]: &Triangle, [u, v]: [f32; 2]) -> Local {
    // In f64: the squares of tiny edges would underflow.
    let (edge_b, edge_c) = ((b - a).as_dvec3(), (c - a).as_dvec3());
    Local {
        point: a * (1.0 - u - v) + b * u + c * v,
        normal: edge_b.cross(edge_c).normalize_or(DVec3::Z).as_vec3(),
        magnitude: a.abs().max(b.abs()).max(c.abs()),
    }
}

fn on_curved(curved: &Curved, part: Part, origin: Vec3, direction: Vec3, t: f32) -> Local {
    let along = origin.as_dvec3() + f64::from(t) * direction.as_dvec3();
    let normal = curved.normal_at(along.as_vec3(), part);
    // The error of t grows with the distance; the surface itself does not.
    let point = along - normal.as_dvec3() * curved.signed_distance(along, part);
    let bounds = curved.bounds();
    Local {
        point: point.as_vec3(),
        normal: curved.normal_at(point.as_vec3(), part),
        magnitude: bounds.min.abs().max(bounds.max.abs()),
    }
}

/// |m| v, by components.
fn abs_product(m: &Mat3, v: Vec3) -> Vec3 {
    m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z
}

/// N = (1 - u - v) N_a + u N_b + v N_c, in object space; need not be unit. Source: thesis 5.1.
fn interpolated_normal(mesh: &Mesh, face: u32, [u, v]: [f32; 2]) -> Vec3 {
    let [a, b, c] = mesh.faces[face as usize].map(|i| Vec3::from(mesh.normals[i as usize]));
    a * (1.0 - u - v) + b * u + c * v
}

/// Texture coordinates of a point of a face; 0 for a mesh that has none.
fn interpolated_uv(mesh: &Mesh, face: u32, [u, v]: [f32; 2]) -> [f32; 2] {
    let Some(corners) = mesh.face_uvs.get(face as usize) else { return [0.0; 2] };
    let [a, b, c] = corners.map(|i| mesh.uvs[i as usize]);
    [0, 1].map(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v)
}

#[cfg(test)]
mod tests {
    use super::away;

    #[test]
    fn away_is_the_next_number_on_that_side() {
        let numbers = [0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, f32::MAX, f32::MIN, f32::MIN_POSITIVE];
        for p in numbers.into_iter().chain((1..1000).map(|i| (i as f32 - 500.5) * 0.37)) {
            assert_eq!(away(p, 0.3).to_bits(), p.next_up().to_bits(), "{p}");
            assert_eq!(away(p, -1e-9).to_bits(), p.next_down().to_bits(), "{p}");
            assert_eq!(away(p, 0.0).to_bits(), p.to_bits(), "{p}");
        }
    }
}
