//! A scene during one shutter.

use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

use glam::Vec3;

use super::affine::Affine;
use super::compositing::Compositing;
use super::costs::RayCounting;
use super::instance::Instance;
use super::looks::Looks;
use super::shapes::Geometry;
use super::texels::{Baked, LightMaps};
use super::world::{STILL, World, WorldHits};
use crate::camera::Camera;
use crate::guiding::Field;
use crate::photons::{Emission, PhotonLamps, PhotonLight};
use crate::sampling::Sampler;
use crate::shading::light::{LightTree, Techniques};
use crate::shading::{Lights, Material, MaterialTable};
use slo_accel::math::columns::Column;
use slo_accel::{Isa, Structure};
use slo_scene::animation::DAffine;
use slo_scene::{Integrator, Settings, ShadowMode, Texture};

/// A scene during one shutter.
///
/// It is in *render space*: scene space in f32, translated such that its origin lies near the
/// camera.
#[derive(Debug)]
pub struct FrameScene {
    pub(crate) camera: Camera,
    pub(crate) world: World,
    pub(crate) materials: Vec<Material>,
    /// The materials in columns.
    pub(crate) material_table: MaterialTable,
    pub(crate) lights: Lights,
    /// Chooses one of the lights from [`first_chosen`](Self::first_chosen) on.
    pub(crate) light_tree: LightTree,
    /// The first light that hits ask by choice. They ask each of those before it.
    pub(crate) first_chosen: u32,
    /// For each light, whether camera rays pass through it; empty if none does.
    pub(crate) hidden: Vec<bool>,
    /// For each light, whether all rays pass through it; empty if none does.
    pub(crate) passable: Vec<bool>,
    /// For each light, the number of its group; 0: none.
    pub(crate) light_groups: Vec<u32>,
    /// Indices of the lights that are infinitely far away.
    pub(crate) skies: Vec<u32>,
    /// How the light of lamps is shared between techniques, for physical shading.
    pub(crate) techniques: Techniques,
    /// Index of the first of the lights that are shaded where rays to them arrive; see
    /// [`Lamp::IS_SHADED`](crate::shading::Lamp::IS_SHADED).
    pub(crate) first_shaded: u32,
    /// Where photons start; `None` if the frame has none.
    pub(crate) emission: Option<Emission>,
    /// Where the light paths of `PHOTON_MAP` start; `None` under another integrator.
    pub(crate) photon_lamps: Option<PhotonLamps>,
    pub(crate) sampler: Sampler,
    /// Sampler of pilot paths, from which the field is learned.
    pub(crate) pilot_sampler: Sampler,
    /// Sampler of photons.
    pub(crate) photon_sampler: Sampler,
    pub(crate) settings: Settings,
    /// How rays are counted, if they are.
    pub(crate) counting: Option<RayCounting>,
    /// The field that guides rays, once it is known.
    pub(crate) field: OnceLock<Field>,
    /// The light map whose texels are the pixels, instead of what the camera sees.
    pub(crate) baked: Option<Baked>,
    /// Light maps that `PHOTON_MAP` reads at the ends of rays.
    pub(crate) light_maps: LightMaps,
    /// The light that photons brought, if the next frame needs it too.
    pub(crate) known_light: OnceLock<PhotonLight>,
    /// Instruction set of all vectorized code.
    pub(crate) isa: Isa,
    /// Whether variance is reduced by more than good sample points; see [`plain`](Self::plain).
    pub(crate) clever: bool,
    /// Whether the scene says anything that the thesis's integrator does not know.
    pub(crate) is_physical: bool,
    /// Whether light may arrive above the triangles of smooth meshes: whether any has a physical
    /// material.
    pub(crate) softens: bool,
    /// Whether vertex normals may have any length.
    pub(super) stretches: bool,
    /// Whether any object has a tint.
    pub(super) tints: bool,
    pub(super) textures: Vec<Arc<Texture>>,
    pub(super) objects: Vec<FrameObject>,
    pub(super) looks: Looks,
    pub(super) compositing: Compositing,
    /// Index and place of each still object: what the still structure was built from.
    pub(super) still_places: Arc<Vec<(u32, DAffine)>>,
    /// For each primitive of the still structure, the index of its object in `objects`.
    pub(super) still_objects: Vec<u32>,
}

/// An object with everything that shading needs.
#[derive(Debug)]
pub(super) struct FrameObject {
    pub(super) geometry: Geometry,
    /// `render_from_object` of a still object; the identity if it is an instance.
    pub(super) place: Affine,
    /// Id of its first triangle in its structure.
    pub(super) first_triangle: u32,
    /// Index of the light that its first triangle is, if the material emits light toward which rays
    /// are sent.
    pub(super) first_light: Option<u32>,
    /// Number of the group of the light that it emits; 0: none.
    pub(super) light_group: u32,
    /// Factor of the material's colours.
    pub(super) tint: Vec3,
    /// Normals of the vertices: in render space if the object is still, in object space if it is an
    /// instance. They are unit, except if `place` is a stretch. Empty if the object is not smooth.
    pub(super) normals: Arc<[Vec3]>,
}

impl FrameObject {
    /// An object of this geometry that is an instance.
    pub(super) fn placed(geometry: Geometry, normals: Arc<[Vec3]>) -> Self {
        Self {
            geometry,
            place: Affine::IDENTITY,
            first_triangle: 0,
            first_light: None,
            light_group: 0,
            tint: Vec3::ONE,
            normals,
        }
    }
}

impl FrameScene {
    /// Returns the same frame with every estimator in its plainest form. Lamps in glossy surfaces
    /// are found by rays of the lobe only, one light of many is chosen uniformly, and no ray is
    /// left out for its small weight. The expected picture is the same, but its noise is not.
    #[must_use]
    pub fn plain(self) -> Self {
        Self { clever: false, ..self }
    }

    /// Returns the same frame with another way to share the light of lamps between rays to them and
    /// rays that follow lobes, for physical shading. The expected picture is the same.
    #[must_use]
    pub fn with_techniques(self, techniques: Techniques) -> Self {
        Self { techniques, ..self }
    }

    /// Returns the same frame with a field that guides rays. The expected picture is the same for every
    /// field.
    #[must_use]
    pub fn with_field(self, field: Field) -> Self {
        Self { field: OnceLock::from(field), ..self }
    }

    /// Whether rays are guided by a field.
    pub fn is_guided(&self) -> bool {
        self.settings.guide && self.settings.integrator == Integrator::Path
    }

    /// Returns the field that guides rays, if it is known.
    pub fn field(&self) -> Option<&Field> {
        self.field.get()
    }

    /// Whether the light that glossy lobes receive from lamps is also sampled by rays to the lamps.
    ///
    /// This requires opaque shadows: rays to lights pass straight through transparent objects, rays
    /// of lobes do not.
    pub(crate) fn combines(&self) -> bool {
        self.clever && self.settings.shadow == ShadowMode::Opaque
    }

    /// Whether the caustics of a light are photons of `PHOTON_MAP`.
    pub(crate) fn sends_caustics(&self, light: u32) -> bool {
        let aimed = self.photon_lamps.as_ref().and_then(|lamps| lamps.aimed.as_ref());
        aimed.is_some_and(|aimed| aimed.sends(light))
    }

    /// Whether rays to lights behind a surface may add light.
    pub(crate) fn receives_through(&self) -> bool {
        let rough = |m: &Material| m.refraction > 0.0 && m.refraction_lobe > 0.0;
        self.combines() && self.materials.iter().any(rough)
    }

    /// Whether camera rays pass through a light.
    pub(crate) fn is_hidden(&self, light: u32) -> bool {
        self.hidden.get(light as usize).is_some_and(|hidden| *hidden)
    }

    /// Returns the number of the group of a light; 0 if it has none.
    pub(crate) fn group_of(&self, light: u32) -> u32 {
        self.light_groups.get(light as usize).copied().unwrap_or(0)
    }

    /// Returns the number of the group of the object that a ray hit; 0 if it has none.
    pub(crate) fn group_of_object(&self, found: &WorldHits, ray: usize) -> u32 {
        let (primitive, instance) = (found.hits.primitive[ray], found.instance[ray]);
        self.objects[self.object_of(primitive, instance) as usize].light_group
    }

    /// Whether rays pass through a light.
    pub(crate) fn is_passable(&self, light: u32) -> bool {
        self.passable.get(light as usize).is_some_and(|passable| *passable)
    }

    /// Whether rays after `depth` bounces pass through any light.
    pub(crate) fn has_passable_lamps(&self, depth: u32) -> bool {
        !self.passable.is_empty() || (depth == 0 && !self.hidden.is_empty())
    }

    /// Whether rays to lamps may pass through anything.
    pub(crate) fn lets_light_pass(&self) -> bool {
        let is_path = self.settings.integrator != Integrator::Distributed;
        (self.settings.shadow == ShadowMode::Transparent && !is_path)
            || self.material_table.images.any_passes()
            || !self.passable.is_empty()
    }

    /// Whether any lights are shaded where rays to them arrive.
    pub(crate) fn has_shaded_lights(&self) -> bool {
        (self.first_shaded as usize) < self.lights.len()
    }

    /// Returns the light that the surface which a ray hit belongs to; `None` if no rays are sent
    /// toward it.
    pub(crate) fn emitter(&self, found: &WorldHits, ray: usize) -> Option<u32> {
        let (primitive, instance) = (found.hits.primitive[ray], found.instance[ray]);
        let object = &self.objects[self.object_of(primitive, instance) as usize];
        let place = match object.geometry {
            Geometry::Mesh(..) => primitive - object.first_triangle,
            Geometry::Curved(_) => 0,
        };
        object.first_light.map(|first| first + place)
    }

    /// Finds the looks of what the rays of a batch hit, as words.
    pub(crate) fn find_looks(&self, found: &WorldHits, to: &mut Column<u32>) {
        self.looks.find(self.isa, &self.still_objects, found, to);
        if self.world.crowd.is_empty() {
            return;
        }
        let first = self.world.instances.len() as u32;
        for (to, &instance) in to.iter_mut().zip(&found.instance) {
            if (first..STILL).contains(&instance) {
                *to = self.looks.word_of(self.world.object_of(instance));
            }
        }
    }

    /// Returns the memory, in bytes, of the structures and tables of this frame without meshes and
    /// textures.
    pub fn memory(&self) -> usize {
        let mut known = HashSet::new();
        let all = self.objects.iter().map(|object| &object.normals);
        let normals: usize =
            all.filter(|normals| known.insert(normals.as_ptr())).map(|normals| normals.len()).sum();
        self.world.memory()
            + self.still_objects.len() * size_of::<u32>()
            + normals * size_of::<Vec3>()
    }

    /// Returns where a point of a surface, which is there at one time of the shutter, is at another;
    /// `instance` is the instance that was hit.
    pub(crate) fn moved(&self, instance: u32, point: Vec3, [from, to]: [f32; 2]) -> Vec3 {
        if instance == STILL {
            return point;
        }
        let [from, to] = [from, to].map(|time| self.world.pose(instance, time));
        to.point(from.inverse_point(point))
    }

    /// Whether anything but the camera moves within the shutter.
    pub(crate) fn moves(&self) -> bool {
        self.world.moves() || self.lights.move_about()
    }

    /// Returns the number of objects that move within the shutter.
    pub fn moving_objects(&self) -> usize {
        let moves = |of: &&Instance| of.moves();
        self.world.instances.iter().filter(moves).count() + self.world.crowd.moving
    }

    /// Returns the number of primitives in all structures. Objects that share a structure count
    /// once.
    pub fn primitives(&self) -> usize {
        let of = |s: &Structure| s.triangle_count() + s.curved().len();
        let bending: usize = self.world.bending().map(|of| of.triangle_count()).sum();
        self.world.structures().map(|structure| of(structure)).sum::<usize>() + bending
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::{Files, load};

    const SCENE: &str = "
        settings s {}
        Camera c {
            fps 25
            Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
            CamSegment only {
                videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
                addPosition { 0 -5 1 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart 0.4
            }
        }
        light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
        phong_info matte { diffuse { .7 .6 .5 } }
        material_phong matte { phong_info matte }
        mesh m { filename tetra.slo smooth_normals 1 material matte }";
    const TETRA: &[u8] = b"slo_mesh 1
        vertices { 0 0 0 1 0 0 0 1 0 0 0 1 }
        faces { 0 2 1 0 1 3 1 2 3 2 0 3 }";

    fn frame(text: &str, mesh: &'static [u8]) -> FrameScene {
        let files = Box::leak(Box::new([("tetra.slo", mesh)]));
        let loaded = load("scene.txt", text, &Files::built_in("", files));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        FrameScene::build(&scene, 0, Isa::best()).unwrap()
    }

    fn memory(text: &str) -> usize {
        frame(text, TETRA).memory()
    }

    /// The scene with `count` more objects of the mesh, each with what `keys` returns.
    fn with_copies(count: usize, keys: impl Fn(usize) -> String) -> String {
        let copy = |i| {
            format!(
                "mesh m{i} {{ filename tetra.slo smooth_normals 1 material matte {} }}",
                keys(i)
            )
        };
        SCENE.to_owned() + &(0..count).map(copy).collect::<String>()
    }

    #[test]
    fn normals_of_vertices_take_memory() {
        let flat = memory(&SCENE.replace("smooth_normals 1", "smooth_normals 0"));
        assert_eq!(memory(SCENE), flat + 4 * size_of::<Vec3>());
    }

    #[test]
    fn moving_objects_share_what_they_have_in_common() {
        let key =
            |x: usize, time| format!("addKframe {{ time {time} key {{ pivot {{ {x} 0 0 }} }} }}");
        let scene = with_copies(40, |i| key(i, 0) + &key(i + 1, 1))
            .replace("fovStart 0.4", "fovStart 0.4 blurDuration 1");
        let frame = frame(&scene, TETRA);
        // The first one is still.
        assert_eq!((frame.moving_objects(), frame.primitives()), (40, 4 + 4));
        let normals = |i: usize| frame.objects[i].normals.as_ptr();
        assert!(normals(1) == normals(40) && normals(0) != normals(1));
    }

    #[test]
    fn many_still_objects_of_a_large_mesh_are_stored_once() {
        const SIDE: usize = 32;
        let vertices: String = (0..=SIDE)
            .flat_map(|i| (0..=SIDE).map(move |j| format!("{i} {j} {} ", (i * j) % 3)))
            .collect();
        let corner = |i: usize, j: usize| i * (SIDE + 1) + j;
        let quad = |i: usize, j: usize| {
            let (a, b) = (corner(i, j), corner(i + 1, j));
            let (c, d) = (corner(i + 1, j + 1), corner(i, j + 1));
            format!("{a} {b} {c} {a} {c} {d} ")
        };
        let faces: String = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| quad(i, j))).collect();
        let mesh = format!("slo_mesh 1 vertices {{ {vertices} }} faces {{ {faces} }}");
        let place =
            |i: usize| format!("addKframe {{ time 0 key {{ pivot {{ {} 5 0 }} }} }}", 40 * i);
        let faces = 2 * SIDE * SIDE;
        let mesh: &[u8] = mesh.leak().as_bytes();
        let few = frame(&with_copies(3, place), mesh);
        assert_eq!((few.primitives(), few.world.instances.len()), (4 * faces, 0));
        let many = frame(&with_copies(600, place), mesh);
        assert_eq!((many.primitives(), many.world.instances.len()), (faces, 601));
        assert!(!many.moves() && many.moving_objects() == 0);
        assert!(many.memory() < 2 * few.memory());
    }
}
