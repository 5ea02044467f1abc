//! Builds a FrameScene from a SceneDescription and a frame number.

use std::fmt;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::emitters::{add_emitters, light_groups};
use super::looks::{Look, Looks};
use super::rigid::Rigid;
use super::sampled_camera::SampledCamera;
use super::sampled_motion::{ObjectBox, SampledMotion};
use super::scene::{FrameObject, FrameScene};
use super::shapes::{Geometry, geometry, lamp_geometry};
use super::world::{Instance, World};
use crate::camera::{Camera, DegenerateView};
use crate::sampling::Sampler;
use crate::shading::light::{LightTree, Pose, Techniques};
use crate::shading::material::Kind;
use crate::shading::{Light, Lights, Material, MaterialTable};
use slo_accel::{Accelerator, BuildOptions, Isa, Primitives, Structure, Triangle};
use slo_scene::animation::{Clock, DRigid, KeyFrameError, KeyFrames, NoSegment, Shutter};
use slo_scene::{CamSegment, Integrator, Object, SceneDescription, Settings, ShadowMode};

/// Step, in units of the scene, by which the origin of render space follows the camera along each
/// axis. Within half a step of the origin, an f32 resolves 2^-14 units or better. Structures of
/// still objects are rebuilt whenever the origin moves, so it must not move in every frame.
const ORIGIN_STEP: f64 = 1024.0;

/// Why a frame of a scene cannot be built.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// The frame's time lies in no camera segment.
    NoSegment(NoSegment),
    /// Nothing can be seen from the camera's view in this frame.
    View {
        /// Name of the camera segment.
        segment: String,
        /// What is wrong.
        reason: DegenerateView,
    },
    /// An object's key frames do not form a path.
    Path {
        /// Name of the object.
        object: String,
        /// What is wrong.
        reason: KeyFrameError,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSegment(error) => error.fmt(f),
            Self::View { segment, reason } => {
                write!(f, "the camera of segment `{segment}` can't see in this frame: ")?;
                f.write_str(match reason {
                    DegenerateView::NoDirection => "its position and its target are the same point",
                    DegenerateView::SkyAlongView => {
                        "its sky is zero or parallel to its direction of view"
                    }
                })
            }
            Self::Path { object, reason: KeyFrameError::NoOrientation(key) } => {
                write!(f, "key frame {} of `{object}`: up is parallel to right", key + 1)
            }
            Self::Path { object, reason: KeyFrameError::OutOfOrder(key) } => {
                write!(f, "key frame {} of `{object}` is earlier than the one before it", key + 1)
            }
        }
    }
}

impl std::error::Error for FrameError {}

impl FrameScene {
    /// Builds frame `number` of a scene, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Fails if the frame's time lies in no camera segment, if nothing can be seen from the
    /// camera's view, or if an object's key frames do not form a path.
    pub fn build(scene: &SceneDescription, number: i64, isa: Isa) -> Result<Self, FrameError> {
        Self::build_after(scene, number, isa, None)
    }

    /// Like [`build`](Self::build), but reuses structures of another frame of the same scene if
    /// they fit this frame too: the structures of objects that move in both frames, and the
    /// structure of all still objects if they lie in the same places.
    ///
    /// # Errors
    /// Fails in the same cases as [`build`](Self::build).
    pub fn build_after(
        scene: &SceneDescription,
        number: i64,
        isa: Isa,
        before: Option<Self>,
    ) -> Result<Self, FrameError> {
        let shutter = Clock::new(&scene.camera).shutter(number).map_err(FrameError::NoSegment)?;
        let segment = &scene.camera.segments[shutter.segment];
        let film = &scene.camera.film;
        let per_ms = scene.settings.transform_samples_per_ms;
        let path = SampledCamera::new(segment, &shutter, film, per_ms);
        let origin = origin(segment, &path);
        let camera = Camera::new(path.views(), origin, film.width, film.height)
            .map_err(|reason| FrameError::View { segment: segment.name.clone(), reason })?;

        let seen = Seen { shutter: &shutter, camera: &path, per_ms, origin };
        let before = before.map(Before::from);
        let moving = before.as_ref().map(|before| before.moving.clone()).unwrap_or_default();
        let mut parts = Parts { before: moving, ..Parts::default() };
        for object in &scene.objects {
            parts.add(object, scene, &seen, isa)?;
        }
        let lights_before = before.as_ref().map(|before| &before.lights);
        let (mut lights, mut poses) = (Vec::new(), Vec::new());
        let (mut hidden, mut passable) = (Vec::new(), Vec::new());
        for light in &scene.lights {
            let look = Look::Light(lights.len() as u32);
            let (ready, path) = parts.add_light(light, look, scene, &seen, isa, lights_before)?;
            lights.push(ready);
            poses.push(path);
            hidden.push(!light.camera_visible);
            passable.push(!light.solid);
        }
        add_emitters(scene, &mut parts, &mut lights);
        let light_groups = light_groups(scene, &mut parts, lights.len());
        for flags in [&mut hidden, &mut passable] {
            if !flags.contains(&true) {
                flags.clear();
            }
        }
        let still = match before {
            Some(before) if before.places == parts.places => before.still,
            // Free the old structure before building the new one.
            other => {
                drop(other);
                Arc::new(structure(parts.still, &scene.settings, isa))
            }
        };
        let looks = Looks::new(
            parts.looks.into_iter(),
            parts.instances.iter().map(|instance| instance.object),
        );
        let materials: Vec<_> = scene.materials.iter().map(Material::new).collect();
        Ok(Self {
            camera,
            world: World::new(still, parts.instances, isa),
            material_table: MaterialTable::new(&scene.materials, &materials),
            materials,
            light_tree: light_tree(&lights, &poses),
            skies: skies(&lights),
            hidden,
            passable,
            light_groups,
            techniques: techniques(&scene.settings),
            lights: lights.into_iter().collect::<Lights>().with_poses(poses),
            is_physical: is_physical(scene),
            sampler: Sampler::new(scene.settings.generator, scene.settings.seed, number),
            settings: scene.settings.clone(),
            isa,
            clever: true,
            textures: scene.textures.clone(),
            objects: parts.objects,
            looks,
            still_places: parts.places,
            still_objects: [parts.triangle_objects, parts.curved_objects].concat(),
        })
    }
}

/// Returns the indices of lights that are infinitely far away and seen by rays that hit nothing.
fn skies(lights: &[Light]) -> Vec<u32> {
    let is_sky = |light: &Light| light.is_distant() && !light.is_delta();
    (0..).zip(lights).filter(|(_, light)| is_sky(light)).map(|(number, _)| number).collect()
}

/// Builds the tree that chooses among lights, wherever they are during the shutter.
fn light_tree(lights: &[Light], poses: &[Vec<Pose>]) -> LightTree {
    let none = Vec::new();
    let bounds = lights.iter().enumerate().map(|(number, light)| {
        let poses = poses.get(number).unwrap_or(&none).iter();
        light.bounds().in_poses(poses.map(|pose| (pose.rotation, pose.translation)))
    });
    LightTree::new(&bounds.collect::<Vec<_>>())
}

/// Chooses how the light of lamps is shared. Rays to lamps pass straight through transparent objects if
/// the settings say so, and rays of lobes do not.
fn techniques(settings: &Settings) -> Techniques {
    match (settings.integrator, settings.shadow) {
        (Integrator::Distributed, ShadowMode::Transparent) => Techniques::Separate,
        (Integrator::Distributed, ShadowMode::Opaque) | (Integrator::Path, _) => {
            Techniques::Combined
        }
    }
}

/// Whether a scene says anything that the thesis's integrator does not know.
fn is_physical(scene: &SceneDescription) -> bool {
    scene.settings.integrator == Integrator::Path
        || scene.lights.iter().any(|light| !light.kind.is_of_thesis())
        || scene.materials.iter().any(|material| Kind::of(material) != Kind::Phong)
}

/// Structures of another frame, to be reused.
struct Before {
    still: Arc<Structure>,
    places: Vec<(u32, DRigid)>,
    /// Structures of moving objects, with the index of the object.
    moving: Vec<(u32, Arc<Structure>)>,
    /// Lights, for tables of images.
    lights: Lights,
}

impl From<FrameScene> for Before {
    fn from(frame: FrameScene) -> Self {
        let World { still, instances, .. } = frame.world;
        let moving = instances.into_iter().map(|i| (i.object, i.structure)).collect();
        Self { still, places: frame.still_places, moving, lights: frame.lights }
    }
}

/// What the objects' motion is sampled for.
struct Seen<'a> {
    shutter: &'a Shutter,
    camera: &'a SampledCamera,
    /// Least number of sampled transforms per millisecond.
    per_ms: f64,
    /// Origin of render space.
    origin: DVec3,
}

/// Parts of a frame, collected object by object.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) objects: Vec<FrameObject>,
    /// Look of each object.
    looks: Vec<Look>,
    still: Primitives,
    /// Index and place of each still object.
    places: Vec<(u32, DRigid)>,
    /// Existing structures of moving objects, with the index of the object.
    before: Vec<(u32, Arc<Structure>)>,
    /// Index of the object of each still triangle, and of each still curved surface.
    triangle_objects: Vec<u32>,
    curved_objects: Vec<u32>,
    instances: Vec<Instance>,
}

impl Parts {
    /// Returns the triangles of an object, in render space, if it is still.
    pub(super) fn still_triangles(&self, object: usize) -> Option<&[Triangle]> {
        self.places.iter().find(|(number, _)| *number as usize == object)?;
        let Geometry::Mesh(mesh, _) = &self.objects[object].geometry else { return None };
        let first = self.objects[object].first_triangle as usize;
        self.still.triangles.get(first..first + mesh.faces.len())
    }

    fn add(
        &mut self,
        object: &Object,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Result<(), FrameError> {
        let path = KeyFrames::new(&object.key_frames)
            .map_err(|reason| FrameError::Path { object: object.name.clone(), reason })?;
        let look = Look::Material(object.material.0);
        let geometry = geometry(&object.shape);
        if !path.moves(seen.shutter.scene_interval()) {
            let place = path.pose(seen.shutter.scene_time(0.0));
            self.add_still(look, geometry, &place, seen);
            return Ok(());
        }
        self.add_moving(look, geometry, &path, scene, seen, isa);
        Ok(())
    }

    /// Adds a light, and its surface if rays can hit it. Returns it, and its poses: none if its
    /// space is render space.
    fn add_light(
        &mut self,
        light: &slo_scene::Light,
        look: Look,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
        before: Option<&Lights>,
    ) -> Result<(Light, Vec<Pose>), FrameError> {
        let ready = |origin: DVec3| Light::new(light, origin, &scene.textures, before);
        let surface = lamp_geometry(&light.kind);
        if light.key_frames.is_empty() {
            if let Some(surface) = surface {
                self.add_still(look, surface, &DRigid::IDENTITY, seen);
            }
            return Ok((ready(seen.origin), Vec::new()));
        }
        let path = KeyFrames::new(&light.key_frames)
            .map_err(|reason| FrameError::Path { object: light.name.clone(), reason })?;
        let about_zero = ready(DVec3::ZERO);
        let bounds = about_zero.bounds();
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let center = if bounds.is_distant { DVec3::ZERO } else { (min + max) * 0.5 };
        let pose = |pose: &DRigid| {
            let pose = DRigid { rotation: pose.rotation, translation: pose.point(center) };
            let Rigid { rotation, translation } = Rigid::relative(&pose, seen.origin);
            Pose { rotation, translation }
        };
        let poses = if !path.moves(seen.shutter.scene_interval()) {
            let place = path.pose(seen.shutter.scene_time(0.0));
            if let Some(surface) = surface {
                self.add_still(look, surface, &place, seen);
            }
            vec![place]
        } else if let Some(surface) = surface {
            self.add_moving(look, surface, &path, scene, seen, isa)
        } else {
            let about = ObjectBox { min, max };
            let motion = SampledMotion::new(&path, seen.shutter, &about, seen.camera, seen.per_ms);
            motion.poses().to_vec()
        };
        let ready = if bounds.is_distant { about_zero } else { ready(center) };
        Ok((ready, poses.iter().map(pose).collect()))
    }

    /// Adds something that moves during the shutter. Returns its poses.
    fn add_moving(
        &mut self,
        look: Look,
        geometry: Geometry,
        path: &KeyFrames,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Vec<DRigid> {
        let bounds = object_box(&geometry);
        let motion = SampledMotion::new(path, seen.shutter, &bounds, seen.camera, seen.per_ms);
        let center = (bounds.min + bounds.max) * 0.5;
        let number = self.objects.len() as u32;
        let there = self.before.iter().find(|(object, _)| *object == number);
        let structure = there.map(|(_, structure)| structure.clone()).unwrap_or_else(|| {
            let place = DRigid { translation: -center, ..DRigid::IDENTITY };
            let mut local = Primitives::default();
            add_primitives(&mut local, &geometry, &place);
            Arc::new(structure(local, &scene.settings, isa))
        });
        let poses = motion.poses().iter().map(|pose| {
            let pose = DRigid { rotation: pose.rotation, translation: pose.point(center) };
            Rigid::relative(&pose, seen.origin)
        });
        self.instances.push(Instance {
            structure,
            center: center.as_vec3(),
            poses: poses.collect(),
            object: number,
        });
        self.looks.push(look);
        self.objects.push(FrameObject {
            normals: vertex_normals(&geometry, &DRigid::IDENTITY),
            geometry,
            place: Rigid::IDENTITY,
            first_triangle: 0,
            first_light: None,
            light_group: 0,
        });
        motion.poses().to_vec()
    }

    fn add_still(&mut self, look: Look, geometry: Geometry, place: &DRigid, seen: &Seen<'_>) {
        let number = self.objects.len() as u32;
        let first_triangle = self.still.triangles.len() as u32;
        let placed = DRigid { translation: place.translation - seen.origin, ..*place };
        self.places.push((number, placed));
        add_primitives(&mut self.still, &geometry, &placed);
        self.triangle_objects.resize(self.still.triangles.len(), number);
        self.curved_objects.resize(self.still.curved.len(), number);
        let normals = vertex_normals(&geometry, place);
        let place = Rigid::relative(place, seen.origin);
        self.looks.push(look);
        self.objects.push(FrameObject {
            geometry,
            place,
            first_triangle,
            first_light: None,
            light_group: 0,
            normals,
        });
    }
}

/// Builds the structure that the settings ask for.
fn structure(primitives: Primitives, settings: &Settings, isa: Isa) -> Structure {
    let options = BuildOptions::new(isa).with_spatial_splits(settings.spatial_splits);
    Structure::build(accelerator(settings.accelerator), primitives, options)
}

/// Converts the scene's name of a structure.
fn accelerator(name: slo_scene::Accelerator) -> Accelerator {
    match name {
        slo_scene::Accelerator::KdTree => Accelerator::KdTree,
        slo_scene::Accelerator::Bvh => Accelerator::Bvh,
        slo_scene::Accelerator::Cwbvh => Accelerator::Cwbvh,
        slo_scene::Accelerator::None => Accelerator::None,
    }
}

/// Adds the primitives of a geometry, transformed by `place`.
fn add_primitives(primitives: &mut Primitives, geometry: &Geometry, place: &DRigid) {
    let point = |p: DVec3| place.point(p).as_vec3();
    match geometry {
        Geometry::Mesh(mesh, _) => {
            let positions: Vec<Vec3> = mesh.positions.iter().map(|&p| point(p)).collect();
            let triangle = |face: &[u32; 3]| face.map(|i| positions[i as usize]);
            primitives.triangles.extend(mesh.faces.iter().map(triangle));
        }
        Geometry::Curved(surface) => primitives.curved.push(surface.primitive(place)),
    }
}

/// Returns the vertex normals of a smooth mesh, rotated by `place`; empty if the geometry is not
/// smooth.
fn vertex_normals(geometry: &Geometry, place: &DRigid) -> Vec<Vec3> {
    let rotation = place.rotation.as_mat3();
    match geometry {
        Geometry::Mesh(mesh, true) => {
            mesh.normals.iter().map(|&n| rotation * Vec3::from(n)).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns the bounding box of a geometry in object space.
fn object_box(geometry: &Geometry) -> ObjectBox {
    match geometry {
        Geometry::Mesh(mesh, _) => ObjectBox::about(mesh.positions.iter().copied()),
        Geometry::Curved(surface) => surface.bounds(),
    }
}

/// Chooses the origin of render space, in scene space: near the camera, where precision matters. It
/// is the start of the camera's path, moved by whole steps as the camera gets farther away.
fn origin(segment: &CamSegment, path: &SampledCamera) -> DVec3 {
    let start = segment.positions[0];
    let steps = (path.views()[0].position - start) / ORIGIN_STEP;
    start + steps.round() * ORIGIN_STEP
}
