//! Fetches data from tables for each hit, one hit at a time, since access to memory is random
//! there.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::columns::Surfaces;
use super::tangents::{Tangent, tangent};
use crate::frame::bend::normal_at;
use crate::frame::instance::Body;
use crate::frame::looks::Look;
use crate::frame::scene::{FrameObject, FrameScene};
use crate::frame::shapes::Geometry;
use crate::frame::world::{STILL, WorldHits};
use crate::shading::material::Kind;
use crate::shading::material::principled::Parameters;
use crate::shading::texture::sample_bilinear;
use slo_accel::curved::Part;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};
use slo_accel::{Curved, Lanewise, Moment, NO_HIT, Rays, Structure, Triangle};
use slo_scene::{Integrator, Mesh, ShadowMode};

/// The data from which the points of hits are computed.
#[derive(Debug)]
pub(super) struct Gathered {
    /// Corners of the triangles, in the space of their structure.
    pub(super) corners: [Vec3s; 3],
    /// Normals at the corners, in the same space; 0 if they are not interpolated.
    pub(super) normals: [Vec3s; 3],
    /// Weights of the second and third corners.
    pub(super) u: Column<f32>,
    pub(super) v: Column<f32>,
    /// Indices of hits on curved primitives.
    pub(super) curved: Vec<u16>,
    /// Indices of hits on moving objects.
    pub(super) moving: Vec<u16>,
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            corners: Default::default(),
            normals: Default::default(),
            u: [0.0; BATCH],
            v: [0.0; BATCH],
            curved: Vec::new(),
            moving: Vec::new(),
        }
    }
}

/// One hit, as reported by the structures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Index of the ray in its batch.
    ray: usize,
    /// Distance along the ray.
    t: f32,
    /// u and v as in [`Hits`](slo_accel::Hits).
    uv: [f32; 2],
    /// Primitive id in its structure.
    primitive: u32,
    /// Instance number or [`STILL`].
    instance: u32,
}

impl Hit {
    #[inline(always)]
    fn new(found: &WorldHits, ray: usize) -> Self {
        let hits = &found.hits;
        Self {
            ray,
            t: hits.t[ray],
            uv: [hits.u[ray], hits.v[ray]],
            primitive: hits.primitive[ray],
            instance: found.instance[ray],
        }
    }

    /// Returns 0 if a ray hits the same primitive of the same instance.
    #[inline(always)]
    fn differs(&self, found: &WorldHits, ray: usize) -> u32 {
        (self.primitive ^ found.hits.primitive[ray]) | (self.instance ^ found.instance[ray])
    }
}

/// Number of hits that are processed together: neighbours often hit the same triangle.
const GROUP: usize = 16;

/// The triangle that was fetched last.
struct Corners {
    /// Its primitive and its instance.
    of: (u32, u32),
    corners: Triangle,
    normals: [Vec3; 3],
}

impl Default for Corners {
    /// A placeholder for a hit without a triangle.
    fn default() -> Self {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        Self { of: (NO_HIT, STILL), corners, normals: [Vec3::ZERO; 3] }
    }
}

impl Gathered {
    #[inline(always)]
    fn set(&mut self, i: usize, from: &Corners) {
        for k in 0..3 {
            self.corners[k].set(i, from.corners[k]);
            self.normals[k].set(i, from.normals[k]);
        }
    }

    /// Sets all hits of the group that begins at `start`.
    #[inline(always)]
    fn fill(&mut self, start: usize, from: &Corners) {
        for k in 0..3 {
            self.corners[k].fill::<GROUP>(start, from.corners[k]);
            self.normals[k].fill::<GROUP>(start, from.normals[k]);
        }
    }
}

impl FrameScene {
    /// Fetches corners and normals, and lists the hits that need more: those on curved primitives
    /// and on moving objects.
    pub(super) fn gather(
        &self,
        found: &WorldHits,
        time: &Column<f32>,
        (rays, len): (&Column<u32>, usize),
        to: &mut Gathered,
    ) {
        to.curved.clear();
        to.moving.clear();
        let mut last = Corners::default();
        for (group, rays) in rays[..len].chunks(GROUP).enumerate() {
            let start = group * GROUP;
            let (first, u_v) = (Hit::new(found, rays[0] as usize), |ray| Hit::new(found, ray).uv);
            let differs = rays.iter().fold(0, |all, &ray| all | first.differs(found, ray as usize));
            let differs = differs | u32::from(self.bends(first.instance));
            if differs == 0 {
                self.find_corners(&first, time, start..start + rays.len(), &mut last, to);
                to.fill(start, &last);
            }
            for (i, &ray) in (start..).zip(rays) {
                [to.u[i], to.v[i]] = u_v(ray as usize);
                if differs != 0 {
                    let hit = Hit::new(found, ray as usize);
                    self.find_corners(&hit, time, i..i + 1, &mut last, to);
                    to.set(i, &last);
                }
            }
        }
    }

    /// Fetches corners and normals of the triangle that contains `hits`, unless `last` is that
    /// triangle, and lists the hits that need more.
    #[inline(always)]
    fn find_corners(
        &self,
        hit: &Hit,
        time: &Column<f32>,
        hits: Range<usize>,
        last: &mut Corners,
        to: &mut Gathered,
    ) {
        let numbers = hits.start as u16..hits.end as u16;
        let (structure, object) = if hit.instance == STILL {
            (&self.world.still, self.still_objects[hit.primitive as usize])
        } else {
            to.moving.extend(numbers.clone());
            match self.world.body(hit.instance) {
                (Body::Still(structure), _, object) => (structure, object),
                (Body::Bending(bending), _, object) => {
                    let (time, object) = (time[hit.ray], &self.objects[object as usize]);
                    *last = Corners {
                        of: (NO_HIT, STILL),
                        corners: bending.triangle(hit.primitive, time),
                        normals: object.bent_normals(hit.primitive, bending.moment(time)),
                    };
                    return;
                }
            }
        };
        if (hit.primitive as usize) >= structure.triangle_count() {
            to.curved.extend(numbers);
        } else if (hit.primitive, hit.instance) != last.of {
            *last = Corners {
                of: (hit.primitive, hit.instance),
                corners: structure.triangle(hit.primitive),
                normals: self.objects[object as usize].corner_normals(hit.primitive),
            };
        }
    }

    /// Whether the corners of an instance depend on the ray's time.
    fn bends(&self, instance: u32) -> bool {
        let instance = self.world.instances.get(instance as usize);
        instance.is_some_and(|instance| matches!(instance.body, Body::Bending(_)))
    }

    /// Computes points and normals of curved surfaces, in the space of their structure.
    pub(super) fn place_curved(
        &self,
        rays: &Rays,
        time: &Column<f32>,
        found: &WorldHits,
        gathered: &Gathered,
        to: &mut Surfaces,
    ) {
        for &i in &gathered.curved {
            let i = usize::from(i);
            let hit = Hit::new(found, to.ray[i] as usize);
            let (origin, direction) = (rays.origin(hit.ray), rays.direction(hit.ray));
            let local = if hit.instance == STILL {
                on_curved(&self.world.still, &hit, origin, direction)
            } else {
                // Only what does not bend has curved surfaces.
                let (Body::Still(structure), ..) = self.world.body(hit.instance) else { continue };
                let pose = self.world.pose(hit.instance, time[hit.ray]);
                let (origin, direction) =
                    (pose.inverse_point(origin), pose.inverse_vector(direction));
                on_curved(structure, &hit, origin, direction)
            };
            to.point.set(i, local.point);
            to.n_geo.set(i, local.normal);
            to.n_shade.set(i, Vec3::ZERO);
            to.magnitude.set(i, local.magnitude);
        }
    }

    /// Transforms hits on moving objects from the space of their structure to render space, each at
    /// its own time.
    pub(super) fn place_moving(
        &self,
        time: &Column<f32>,
        found: &WorldHits,
        gathered: &Gathered,
        to: &mut Surfaces,
    ) {
        let turns = self.material_table.images.any_needs_tangent();
        for &i in &gathered.moving {
            let i = usize::from(i);
            let ray = to.ray[i] as usize;
            let (instance, time) = (found.instance[ray], time[ray]);
            let pose = self.world.pose(instance, time);
            to.point.set(i, pose.point(to.point.get(i)));
            to.n_geo.set(i, pose.normal(to.n_geo.get(i)).normalize());
            to.n_shade.set(i, pose.normal(to.n_shade.get(i)));
            if turns {
                to.tangent.set(i, pose.direction(to.tangent.get(i)));
            }
            to.magnitude.set(i, self.world.magnitude(instance, time, to.magnitude.get(i)));
        }
    }

    /// Looks up the colours of images. `to.point` must still be in the space of the structures.
    pub(super) fn look_up_images(&self, found: &WorldHits, to: &mut Surfaces) {
        self.isa.run(Images { frame: self, found, to });
        let images = &self.material_table.images;
        if !images.any_needs_uv() {
            return;
        }
        let turns = images.any_needs_tangent();
        for i in 0..to.len.min(BATCH) {
            let material = to.material[i];
            let hit = Hit::new(found, to.ray[i] as usize);
            if images.needs_uv(material) {
                [to.uv[0][i], to.uv[1][i]] = self.uv(&hit, to.point.get(i));
            }
            if images.needs_tangent(material) {
                let normal = to.n_shade.get(i);
                let length = normal.length();
                let (normal, length) =
                    if length > 1e-3 { (normal / length, length) } else { (to.n_geo.get(i), 1.0) };
                let Tangent { along, side } = self.tangent(&hit, to.point.get(i), normal);
                // In proportion to the interpolated normal, which will have length 1.
                to.tangent.set(i, along / length);
                to.bitangent[i] = side * length;
            } else if turns {
                to.tangent.set(i, Vec3::ZERO);
            }
        }
    }

    /// Returns the tangent at a hit, in the space of its structure, as are `point` and `normal`.
    fn tangent(&self, hit: &Hit, point: Vec3, normal: Vec3) -> Tangent {
        if hit.instance == STILL {
            let object = &self.objects[self.still_objects[hit.primitive as usize] as usize];
            let (face, place) = (hit.primitive.wrapping_sub(object.first_triangle), &object.place);
            let (point, normal) = (place.inverse_point(point), place.inverse_normal(normal));
            let found = tangent(&object.geometry, face, hit.uv, point, normal);
            Tangent { along: place.direction(found.along), ..found }
        } else {
            let (_, center, object) = self.world.body(hit.instance);
            let geometry = &self.objects[object as usize].geometry;
            tangent(geometry, hit.primitive, hit.uv, point + center, normal)
        }
    }

    /// Returns the texture coordinates of a hit at `point`, in render space.
    pub(crate) fn uv_of(&self, found: &WorldHits, ray: usize, point: Vec3, time: f32) -> [f32; 2] {
        let hit = Hit::new(found, ray);
        if hit.instance == STILL {
            return self.uv(&hit, point);
        }
        self.uv(&hit, self.world.pose(hit.instance, time).inverse_point(point))
    }

    /// Returns the texture coordinates of a hit. `point` is in the space of its structure.
    fn uv(&self, hit: &Hit, point: Vec3) -> [f32; 2] {
        let (object, object_point, place) = if hit.instance == STILL {
            let object = &self.objects[self.still_objects[hit.primitive as usize] as usize];
            (object, None, object.place)
        } else {
            let (_, center, object) = self.world.body(hit.instance);
            let object = &self.objects[object as usize];
            (object, Some(point + center), object.place)
        };
        match object.geometry {
            Geometry::Mesh(ref mesh, _) => {
                interpolated_uv(mesh, hit.primitive - object.first_triangle, hit.uv)
            }
            Geometry::Curved(ref shape) => {
                let point = object_point.unwrap_or_else(|| place.inverse_point(point));
                shape.uv_at(point, Part::from_u(hit.uv[0]))
            }
        }
    }

    /// Chooses materials of mixes for the hits of a batch, by a random number `u` for each, which is
    /// rescaled to be uniform again.
    pub(crate) fn choose_materials(&self, u: &mut Column<f32>, to: &mut Surfaces) {
        let table = &self.material_table;
        for (i, u) in u.iter_mut().enumerate().take(to.len) {
            let mixed = to.material[i];
            if table.kinds[mixed as usize] != Kind::Mix {
                continue;
            }
            let (material, rest) = table.images.choose(mixed, &self.textures, to.uv(i), *u);
            (to.material[i], *u) = (material, rest);
            if let Some(texture) = self.materials[material as usize].texture {
                let image = &self.textures[texture.texture.0 as usize];
                let [scale_u, scale_v] = texture.scale;
                let uv = to.uv(i);
                let color = Vec3::from(sample_bilinear(image, uv.x * scale_u, uv.y * scale_v));
                to.tint.set(i, if self.tints { to.tint.get(i) * color } else { color });
            }
        }
    }

    /// Whether [`multiply_images`](Self::multiply_images) changes anything.
    pub(crate) fn multiplies(&self) -> bool {
        self.tints || self.material_table.images.any_needs_uv()
    }

    /// Multiplies the numbers of physical materials by what images hold at the hits of a batch, and
    /// by tints.
    pub(crate) fn multiply_images(&self, surfaces: &Surfaces, to: &mut Parameters) {
        let images = &self.material_table.images;
        if images.any_needs_uv() {
            for i in 0..surfaces.len.min(BATCH) {
                let material = surfaces.material[i];
                images.multiply(material, &self.textures, surfaces.uv(i), i, to);
            }
        }
        if self.tints {
            for i in 0..surfaces.len.min(BATCH) {
                to.base_color.set(i, to.base_color.get(i) * surfaces.tint.get(i));
            }
        }
    }

    /// Whether light may pass through hits on a material or light, unbent: the look of a hit.
    pub(crate) fn may_pass(&self, look: Look) -> bool {
        match look {
            Look::Material(material) => self.material_table.images.passes(material),
            Look::Light(light) => self.is_passable(light),
            Look::Nothing => false,
        }
    }

    /// Returns the share of light that passes through hit `i` of a batch unbent.
    pub(crate) fn share_passing(&self, surfaces: &Surfaces, i: usize) -> f32 {
        let (images, material) = (&self.material_table.images, surfaces.material[i]);
        1.0 - images.opacity(material, &self.textures, surfaces.uv(i))
    }

    /// Returns the number of the object that a primitive belongs to.
    pub(crate) fn object_of(&self, primitive: u32, instance: u32) -> u32 {
        if instance == STILL {
            self.still_objects[primitive as usize]
        } else {
            self.world.object_of(instance)
        }
    }

    /// Returns the factor of the material's colours at a hit.
    fn tint_of(&self, hit: &Hit) -> Vec3 {
        let of_object = || self.objects[self.object_of(hit.primitive, hit.instance) as usize].tint;
        self.world.tint(hit.instance).unwrap_or_else(of_object)
    }

    /// Returns the look of a primitive.
    pub(crate) fn look_of(&self, primitive: u32, instance: u32) -> Look {
        self.looks.of(self.object_of(primitive, instance))
    }

    /// Returns the share of light that passes a primitive on its way to another one, for
    /// transparent shadows; `None` if the primitive blocks it.
    ///
    /// A closed object lets the share `refraction` through in all, so each of its surfaces lets the
    /// square root of it through.
    pub(crate) fn light_passed(&self, primitive: u32, instance: u32) -> Option<f32> {
        // Under PATH, rays that follow lobes bring this light.
        let is_path = self.settings.integrator != Integrator::Distributed;
        if is_path || self.settings.shadow == ShadowMode::Opaque {
            return None;
        }
        let number = self.object_of(primitive, instance);
        let Look::Material(material) = self.looks.of(number) else { return None };
        let refraction = self.materials[material as usize].refraction;
        let geometry = &self.objects[number as usize].geometry;
        let open = matches!(geometry, Geometry::Mesh(mesh, _) if mesh.faces.len() <= 2);
        (refraction > 0.0).then(|| if open { refraction } else { refraction.sqrt() })
    }
}

/// Looks up the colours of images.
struct Images<'a> {
    frame: &'a FrameScene,
    found: &'a WorldHits,
    to: &'a mut Surfaces,
}

impl Lanewise for Images<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { frame, found, to } = self;
        if frame.textures.is_empty() && !frame.tints {
            let Vec3s { x, y, z } = &mut to.tint;
            [x, y, z].into_iter().for_each(|column| column[lanes(to.len)].fill(1.0));
            return;
        }
        for i in 0..to.len.min(BATCH) {
            let material = frame.materials.get(to.material[i] as usize);
            let hit = Hit::new(found, to.ray[i] as usize);
            let tint = if frame.tints { frame.tint_of(&hit) } else { Vec3::ONE };
            let Some(texture) = material.and_then(|material| material.texture) else {
                to.tint.set(i, tint);
                continue;
            };
            let [u, v] = frame.uv(&hit, to.point.get(i));
            let image = &frame.textures[texture.texture.0 as usize];
            let color = sample_bilinear(image, u * texture.scale[0], v * texture.scale[1]);
            let color = Vec3::from(color);
            to.tint.set(i, if frame.tints { tint * color } else { color });
        }
    }
}

impl FrameObject {
    /// Returns the normals at the corners of a triangle; 0 if they are not interpolated.
    #[inline]
    fn corner_normals(&self, primitive: u32) -> [Vec3; 3] {
        match self.geometry {
            Geometry::Mesh(ref mesh, _) if !self.normals.is_empty() => {
                let face = mesh.faces[(primitive - self.first_triangle) as usize];
                face.map(|vertex| self.normals[vertex as usize])
            }
            _ => [Vec3::ZERO; 3],
        }
    }
}

impl FrameObject {
    /// Returns the normals at the corners of a triangle of a mesh that bends; 0 if they are not
    /// interpolated.
    fn bent_normals(&self, primitive: u32, at: Moment) -> [Vec3; 3] {
        match self.geometry {
            Geometry::Mesh(ref mesh, _) if !self.normals.is_empty() => {
                let (face, count) = (mesh.faces[primitive as usize], mesh.positions.len());
                face.map(|vertex| normal_at(&self.normals, count, vertex, at))
            }
            _ => [Vec3::ZERO; 3],
        }
    }
}

/// A point of a primitive, in the space of its structure.
struct Local {
    point: Vec3,
    /// Unit outward normal.
    normal: Vec3,
    /// Bounds of the absolute coordinates from which the point was computed.
    magnitude: Vec3,
}

fn on_curved(structure: &Structure, hit: &Hit, origin: Vec3, direction: Vec3) -> Local {
    let curved: &Curved = &structure.curved()[hit.primitive as usize - structure.triangle_count()];
    let part = Part::from_u(hit.uv[0]);
    let along = origin.as_dvec3() + f64::from(hit.t) * direction.as_dvec3();
    let normal = curved.normal_at(along.as_vec3(), part);
    // The error of t grows with the distance, so the point is moved back onto the surface.
    let point: DVec3 = along - normal.as_dvec3() * curved.signed_distance(along, part);
    let bounds = curved.bounds();
    Local {
        point: point.as_vec3(),
        normal: curved.normal_at(point.as_vec3(), part),
        magnitude: bounds.min.abs().max(bounds.max.abs()),
    }
}

/// Returns the texture coordinates of a point of a face; 0 if the mesh has none.
fn interpolated_uv(mesh: &Mesh, face: u32, [u, v]: [f32; 2]) -> [f32; 2] {
    let Some(corners) = mesh.face_uvs.get(face as usize) else { return [0.0; 2] };
    let [a, b, c] = corners.map(|i| mesh.uvs[i as usize]);
    [0, 1].map(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v)
}
