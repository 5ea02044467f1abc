//! Parts of a frame, collected object by object.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::error::FrameError;
use super::looks::Look;
use super::rigid::Rigid;
use super::sampled_camera::SampledCamera;
use super::sampled_motion::{ObjectBox, SampledMotion};
use super::scene::FrameObject;
use super::shapes::{Geometry, geometry, lamp_geometry};
use super::world::Instance;
use crate::shading::Light;
use crate::shading::light::{Pose, Skies};
use slo_accel::{Accelerator, BuildOptions, Isa, Primitives, Structure, Triangle};
use slo_scene::animation::{DRigid, KeyFrames, Shutter};
use slo_scene::{Object, SceneDescription, Settings};

/// What the objects' motion is sampled for.
pub(super) struct Seen<'a> {
    pub(super) shutter: &'a Shutter,
    pub(super) camera: &'a SampledCamera,
    /// Least number of sampled transforms per millisecond.
    pub(super) per_ms: f64,
    /// Origin of render space.
    pub(super) origin: DVec3,
}

/// Parts of a frame, collected object by object.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) objects: Vec<FrameObject>,
    /// Look of each object.
    pub(super) looks: Vec<Look>,
    pub(super) still: Primitives,
    /// Index and place of each still object.
    pub(super) places: Vec<(u32, DRigid)>,
    /// Existing structures of moving objects, with the index of the object.
    pub(super) before: Vec<(u32, Arc<Structure>)>,
    /// Index of the object of each still triangle, and of each still curved surface.
    pub(super) triangle_objects: Vec<u32>,
    pub(super) curved_objects: Vec<u32>,
    pub(super) instances: Vec<Instance>,
}

impl Parts {
    /// Returns the triangles of an object, in render space, if it is still.
    pub(super) fn still_triangles(&self, object: usize) -> Option<&[Triangle]> {
        self.places.iter().find(|(number, _)| *number as usize == object)?;
        let Geometry::Mesh(mesh, _) = &self.objects[object].geometry else { return None };
        let first = self.objects[object].first_triangle as usize;
        self.still.triangles.get(first..first + mesh.faces.len())
    }

    pub(super) fn add(
        &mut self,
        object: &Object,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Result<(), FrameError> {
        let path = KeyFrames::new(&object.key_frames)
            .map_err(|reason| FrameError::Path { object: object.name.clone(), reason })?
            .repeated(object.repeat);
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
    pub(super) fn add_light(
        &mut self,
        light: &slo_scene::Light,
        look: Look,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
        skies: Skies<'_>,
    ) -> Result<(Light, Vec<Pose>), FrameError> {
        let ready = |origin: DVec3| Light::new(light, origin, &scene.textures, skies);
        let surface = lamp_geometry(&light.kind);
        if light.key_frames.is_empty() {
            if let Some(surface) = surface {
                self.add_still(look, surface, &DRigid::IDENTITY, seen);
            }
            return Ok((ready(seen.origin), Vec::new()));
        }
        let path = KeyFrames::new(&light.key_frames)
            .map_err(|reason| FrameError::Path { object: light.name.clone(), reason })?
            .repeated(light.repeat);
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
    pub(super) fn add_moving(
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

    pub(super) fn add_still(
        &mut self,
        look: Look,
        geometry: Geometry,
        place: &DRigid,
        seen: &Seen<'_>,
    ) {
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
pub(super) fn structure(primitives: Primitives, settings: &Settings, isa: Isa) -> Structure {
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
