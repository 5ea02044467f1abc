//! Parts of a frame, collected object by object.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use super::affine::Affine;
use super::bend::{Bent, Shaped};
use super::crowd::Cast;
use super::error::FrameError;
use super::instance::{Body, Instance};
use super::kept::{most_growth, structure_like};
use super::lamps::carried;
use super::looks::Look;
use super::remains::Made;
use super::sampled_camera::SampledCamera;
use super::sampled_motion::{ObjectBox, SampledMotion};
use super::scene::FrameObject;
use super::shapes::{Geometry, geometry, lamp_geometry};
use super::shared::Shared;
use super::shown::{ShownLight, ShownObject, Whereabouts};
use crate::shading::Light;
use crate::shading::light::{Pose, Skies};
use slo_accel::study::Parameters;
use slo_accel::{Bending, Isa, Primitives, Structure};
use slo_scene::animation::{DAffine, Path, Shutter, Spaces};
use slo_scene::cache::Cache;
use slo_scene::shape::MeshSurface;
use slo_scene::{MaterialId, Object, SceneDescription, Shape};

/// Least number of vertices or faces that a thread takes at a time.
const AT_ONCE: usize = 1 << 14;

/// What the objects' motion is sampled for.
pub(super) struct Seen<'a> {
    pub(super) shutter: &'a Shutter,
    pub(super) camera: &'a SampledCamera,
    /// Least number of sampled transforms per millisecond.
    pub(super) per_ms: f64,
    /// Origin of render space.
    pub(super) origin: DVec3,
    /// What objects and lights hang in.
    pub(super) spaces: &'a Spaces,
}

impl Seen<'_> {
    pub(super) fn path(
        &self,
        name: &str,
        Whereabouts { key_frames, repeat, parent }: Whereabouts<'_>,
    ) -> Result<Path, FrameError> {
        self.spaces
            .path(key_frames, repeat, parent)
            .map_err(|reason| FrameError::Path { object: name.to_owned(), reason })
    }

    /// Returns where something is over the shutter: one pose if it does not move. `about` are bounds
    /// of it in its own space.
    pub(super) fn poses(
        &self,
        name: &str,
        path: &Path,
        about: &ObjectBox,
    ) -> Result<Vec<DAffine>, FrameError> {
        let poses = if path.moves(self.shutter.scene_interval()) {
            let motion = SampledMotion::new(path, self.shutter, about, self.camera, self.per_ms);
            motion.into_poses()
        } else {
            vec![path.pose(self.shutter.scene_time(0.0))]
        };
        if poses.iter().all(|pose| pose.is_rigid() || fits(pose, about)) {
            Ok(poses)
        } else {
            Err(FrameError::Extent { object: name.to_owned() })
        }
    }
}

/// Whether f32 can hold a stretched object.
pub(super) fn fits(pose: &DAffine, about: &ObjectBox) -> bool {
    const MOST_GROWTH: f64 = 1e12;
    const FARTHEST: f64 = 1e10;
    let most = |m: DMat3| m.to_cols_array().into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    let is_bounded = |m: DMat3| m.is_finite() && most(m) <= MOST_GROWTH;
    let is_near = |corner: DVec3| pose.point(corner).abs().max_element() <= FARTHEST;
    is_bounded(pose.linear)
        && is_bounded(pose.linear.inverse())
        && about.corners().into_iter().all(is_near)
}

/// Parts of a frame, collected object by object.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) objects: Vec<FrameObject>,
    /// Look of each object.
    pub(super) looks: Vec<Look>,
    /// Index and place of each still object.
    pub(super) places: Vec<(u32, DAffine)>,
    /// Whether normals of any still object may have any length.
    pub(super) stretches: bool,
    /// Existing structures of instances, by the index of the object.
    pub(super) before: HashMap<u32, Arc<Structure>>,
    /// Existing structures of meshes that have changed their shape, by the index of the object.
    pub(super) reshaped: HashMap<u32, Arc<Structure>>,
    /// Existing structures of meshes that bend, by the index of the object.
    pub(super) bending: HashMap<u32, Arc<Bending>>,
    /// What they, and the structure of all still objects, were made of, if the scene may be another one.
    pub(super) made: Option<Arc<Made>>,
    /// Name of the thing that has a structure of its own.
    pub(super) apart: Option<String>,
    /// Where structures may be found.
    pub(super) cache: Option<Arc<Cache>>,
    /// Parameters of structures to study.
    pub(super) parameters: Parameters,
    /// What objects of one mesh share.
    pub(super) shared: Shared,
    /// Number of triangles of all still objects.
    pub(super) still_triangles: usize,
    /// Index of the object of each still curved surface.
    pub(super) curved_objects: Vec<u32>,
    pub(super) instances: Vec<Instance>,
}

impl Parts {
    /// Returns the primitives of all still objects, in render space.
    pub(super) fn still(&self) -> Primitives {
        let mut still = Primitives::default();
        still.triangles.reserve_exact(self.still_triangles);
        for (number, place) in &self.places {
            add_primitives(&mut still, &self.objects[*number as usize].geometry, place);
        }
        still
    }

    /// Whether the still objects have the shapes that they had in the frame before.
    pub(super) fn still_is_as_before(&self) -> bool {
        let is_same = |made: &Arc<Made>| {
            let mut still = self.places.iter().map(|(number, _)| *number);
            still.all(|number| made.is(number, &self.objects[number as usize].geometry))
        };
        self.made.as_ref().is_none_or(is_same)
    }

    /// Returns the primitives of an object, in render space, if it is still.
    pub(super) fn still_object(&self, object: usize) -> Option<Primitives> {
        let place =
            self.places.binary_search_by_key(&(object as u32), |(number, _)| *number).ok()?;
        let mut primitives = Primitives::default();
        add_primitives(&mut primitives, &self.objects[object].geometry, &self.places[place].1);
        Some(primitives)
    }

    /// Returns the index of the object of each still triangle, then of each still curved surface.
    pub(super) fn still_objects(&self) -> Vec<u32> {
        let faces = |number: u32| match &self.objects[number as usize].geometry {
            Geometry::Mesh(mesh, _) => mesh.faces.len(),
            Geometry::Curved(_) => 0,
        };
        let count: usize = self.places.iter().map(|(number, _)| faces(*number)).sum();
        let mut all = Vec::with_capacity(count + self.curved_objects.len());
        for (number, _) in &self.places {
            all.extend(std::iter::repeat_n(*number, faces(*number)));
        }
        all.extend(&self.curved_objects);
        all
    }

    pub(super) fn add(
        &mut self,
        shown: &ShownObject<'_>,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Result<(), FrameError> {
        let object = shown.object;
        let path = seen.path(&object.name, shown.at)?;
        let look = Look::Material(shown.material.0);
        if let Shape::Mesh(MeshSurface { mesh, smooth, shapes: Some(shapes) }) = &object.shape {
            // What another frame knows of this object is about another shape.
            let number = self.objects.len() as u32;
            self.reshaped.extend(self.before.remove(&number).map(|before| (number, before)));
            let shaped = Shaped::new(mesh, shapes, seen.shutter)
                .map_err(|reason| FrameError::Shape { object: object.name.clone(), reason })?;
            match shaped {
                Shaped::Bends(bent) => {
                    let poses = seen.poses(&object.name, &path, &bent.about())?;
                    self.add_bent(look, bent, *smooth, &poses, (scene, seen), isa);
                }
                // It has a structure of its own, so that those of other objects fit the next frame.
                Shaped::AtRest(mesh) => {
                    let geometry = Geometry::Mesh(mesh, *smooth);
                    let poses = seen.poses(&object.name, &path, &self.shared.about(&geometry))?;
                    self.add_instance(look, geometry, &poses, scene, seen, isa)?;
                }
            }
        } else {
            let geometry = geometry(&object.shape);
            let about = self.shared.about(&geometry);
            let poses = seen.poses(&object.name, &path, &about)?;
            if self.apart.as_ref() == Some(&object.name) {
                self.add_instance(look, geometry, &poses, scene, seen, isa)?;
            } else {
                self.add_surface(look, geometry, &poses, scene, seen, isa)?;
            }
        }
        if let Some(added) = self.objects.last_mut() {
            added.tint = shown.tint.into();
        }
        Ok(())
    }

    /// Adds a light, and its surface if rays can hit it. Returns it, and its poses: none if its
    /// space is render space.
    pub(super) fn add_light(
        &mut self,
        shown: &ShownLight<'_>,
        look: Look,
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
        skies: Skies<'_>,
    ) -> Result<(Light, Vec<Pose>), FrameError> {
        let ready = |light: &slo_scene::Light, origin: DVec3| {
            Light::new(light, origin, &scene.textures, skies)
        };
        let light = shown.light;
        if shown.at.key_frames.is_empty() && shown.at.parent.is_none() {
            match lamp_geometry(&light.kind) {
                Some(surface) if self.apart.as_ref() == Some(&light.name) => {
                    self.add_instance(look, surface, &[DAffine::IDENTITY], scene, seen, isa)?;
                }
                Some(surface) => self.add_still(look, surface, &DAffine::IDENTITY, seen),
                None => {}
            }
            return Ok((ready(light, seen.origin), Vec::new()));
        }
        let path = seen.path(&light.name, shown.at)?;
        let box_of = |light: &Light| {
            let bounds = light.bounds();
            ObjectBox { min: bounds.min.as_dvec3(), max: bounds.max.as_dvec3() }
        };
        let surface = lamp_geometry(&light.kind);
        let about_zero = ready(light, DVec3::ZERO);
        let about = match &surface {
            Some(surface) => self.shared.about(surface),
            None => box_of(&about_zero),
        };
        let poses = seen.poses(&light.name, &path, &about)?;
        let (light, about_zero, surface, poses) = if poses.iter().all(DAffine::is_rigid) {
            (light.clone(), about_zero, surface, poses)
        } else {
            let fault = |reason| FrameError::Lamp { lamp: light.name.clone(), reason };
            let (light, poses) = carried(light, &poses).map_err(fault)?;
            let about_zero = ready(&light, DVec3::ZERO);
            let surface = lamp_geometry(&light.kind);
            (light, about_zero, surface, poses)
        };
        if let Some(surface) = surface {
            self.add_surface(look, surface, &poses, scene, seen, isa)?;
        }
        let is_distant = about_zero.is_distant();
        let center = if is_distant { DVec3::ZERO } else { box_of(&about_zero).center() };
        let pose = |pose: &DAffine| {
            let Affine { linear, translation, .. } =
                Affine::relative(&pose.about(center), seen.origin);
            Pose { rotation: linear, translation }
        };
        let ready = if is_distant { about_zero } else { ready(&light, center) };
        Ok((ready, poses.iter().map(pose).collect()))
    }

    /// Adds a surface in these poses over the shutter.
    fn add_surface(
        &mut self,
        look: Look,
        geometry: Geometry,
        poses: &[DAffine],
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Result<(), FrameError> {
        match (poses, &geometry) {
            // A curved surface is what it is in its own space only.
            ([place], Geometry::Curved(_)) if place.growth.is_none() => {}
            ([_], _) if self.shared.is_placed(&geometry) => {}
            ([place], _) => {
                self.add_still(look, geometry, place, seen);
                return Ok(());
            }
            _ => {}
        }
        self.add_instance(look, geometry, poses, scene, seen, isa)
    }

    /// Adds something that moves during the shutter, that is stretched, or of which there are many.
    fn add_instance(
        &mut self,
        look: Look,
        geometry: Geometry,
        poses: &[DAffine],
        scene: &SceneDescription,
        seen: &Seen<'_>,
        isa: Isa,
    ) -> Result<(), FrameError> {
        let center = self.shared.about(&geometry).center();
        let (structure, normals) = self.made_of(&geometry, center, scene, isa)?;
        let poses = poses.iter().map(|pose| Affine::relative(&pose.about(center), seen.origin));
        self.instances.push(Instance {
            body: Body::Still(structure),
            center: center.as_vec3(),
            poses: poses.collect(),
            object: self.objects.len() as u32,
        });
        self.looks.push(look);
        self.objects.push(FrameObject::placed(geometry, normals));
        Ok(())
    }

    /// Adds an object of a crowd. Returns what it is made of, and its box in object space.
    pub(super) fn add_cast(
        &mut self,
        object: &Object,
        material: MaterialId,
        scene: &SceneDescription,
        isa: Isa,
    ) -> Result<(Cast, ObjectBox), FrameError> {
        let geometry = geometry(&object.shape);
        let about = self.shared.about(&geometry);
        let (structure, normals) = self.made_of(&geometry, about.center(), scene, isa)?;
        self.looks.push(Look::Material(material.0));
        self.objects.push(FrameObject::placed(geometry, normals));
        Ok((Cast { body: Body::Still(structure), center: about.center().as_vec3() }, about))
    }

    /// Returns the structure of the next object, translated by `-center`, and the normals of its
    /// vertices. Both may be shared with others.
    fn made_of(
        &mut self,
        geometry: &Geometry,
        center: DVec3,
        scene: &SceneDescription,
        isa: Isa,
    ) -> Result<(Arc<Structure>, Arc<[Vec3]>), FrameError> {
        let number = self.objects.len() as u32;
        let is_same = self.made.as_ref().is_none_or(|made| made.is(number, geometry));
        let there = self.before.get(&number).filter(|_| is_same).cloned();
        let (cache, parameters) = (self.cache.clone(), self.parameters);
        let reshaped = self.reshaped.remove(&number);
        let get = || {
            if let Some(there) = there {
                return Ok(there);
            }
            let place = DAffine { translation: -center, ..DAffine::IDENTITY };
            let mut local = Primitives::default();
            add_primitives(&mut local, geometry, &place);
            let from = (cache.as_deref(), parameters);
            structure_like(reshaped.as_deref(), local, scene, isa, from).map(Arc::new)
        };
        let normals = || vertex_normals(geometry, &DAffine::IDENTITY).into();
        match self.shared.of(geometry) {
            Some(common) => {
                let structure = match &common.structure {
                    Some(structure) => structure.clone(),
                    None => common.structure.insert(get()?).clone(),
                };
                let is_smooth = matches!(geometry, Geometry::Mesh(_, true));
                let normals = match is_smooth {
                    true => common.normals.get_or_insert_with(normals).clone(),
                    false => Arc::default(),
                };
                Ok((structure, normals))
            }
            None => Ok((get()?, normals())),
        }
    }

    /// Adds a mesh that bends during the shutter.
    fn add_bent(
        &mut self,
        look: Look,
        bent: Bent,
        is_smooth: bool,
        poses: &[DAffine],
        (scene, seen): (&SceneDescription, &Seen<'_>),
        isa: Isa,
    ) {
        let center = bent.about().center();
        let before = self.bending.remove(&(self.objects.len() as u32));
        let growth = most_growth(scene, bent.mesh.faces.len());
        let like = before.as_deref().zip(growth);
        let poses = poses.iter().map(|pose| Affine::relative(&pose.about(center), seen.origin));
        self.instances.push(Instance {
            body: Body::Bending(Arc::new(bent.structure(center, isa, like))),
            center: center.as_vec3(),
            poses: poses.collect(),
            object: self.objects.len() as u32,
        });
        self.looks.push(look);
        let normals = if is_smooth { bent.normals.into() } else { Arc::default() };
        self.objects.push(FrameObject::placed(Geometry::Mesh(bent.mesh, is_smooth), normals));
    }

    fn add_still(&mut self, look: Look, geometry: Geometry, place: &DAffine, seen: &Seen<'_>) {
        let number = self.objects.len() as u32;
        let first_triangle = self.still_triangles;
        let placed = DAffine { translation: place.translation - seen.origin, ..*place };
        self.places.push((number, placed));
        match &geometry {
            Geometry::Mesh(mesh, _) => self.still_triangles += mesh.faces.len(),
            Geometry::Curved(_) => self.curved_objects.push(number),
        }
        let normals = vertex_normals(&geometry, place);
        self.stretches |= place.growth.is_none() && !normals.is_empty();
        let place = Affine::relative(place, seen.origin);
        self.looks.push(look);
        self.objects.push(FrameObject {
            geometry,
            place,
            first_triangle: first_triangle as u32,
            first_light: None,
            light_group: 0,
            tint: Vec3::ONE,
            normals: normals.into(),
        });
    }
}

/// Adds the primitives of a geometry, transformed by `place`.
fn add_primitives(primitives: &mut Primitives, geometry: &Geometry, place: &DAffine) {
    let point = |p: DVec3| place.point(p).as_vec3();
    match geometry {
        Geometry::Mesh(mesh, _) => {
            let positions: Vec<Vec3> =
                mesh.positions.par_iter().with_min_len(AT_ONCE).map(|&p| point(p)).collect();
            let triangle = |face: &[u32; 3]| face.map(|i| positions[i as usize]);
            let triangles = mesh.faces.par_iter().with_min_len(AT_ONCE).map(triangle);
            primitives.triangles.par_extend(triangles);
        }
        Geometry::Curved(surface) => primitives.curved.push(surface.primitive(place)),
    }
}

/// Returns the vertex normals of a smooth mesh, transformed by `place`; empty if the geometry is not
/// smooth. They are unit if `place` grows by the same factor in all directions.
fn vertex_normals(geometry: &Geometry, place: &DAffine) -> Vec<Vec3> {
    let transform = match place.growth {
        Some(1.0) => place.linear,
        Some(factor) => place.linear * (1.0 / factor),
        // Not of unit length, so that interpolated normals are those of an instance.
        None => {
            let growth = libm::cbrt(place.linear.determinant());
            place.linear.inverse().transpose() * growth
        }
    };
    let transform = transform.as_mat3();
    match geometry {
        Geometry::Mesh(mesh, true) => {
            let normals = mesh.normals.par_iter().with_min_len(AT_ONCE);
            normals.map(|&n| transform * Vec3::from(n)).collect()
        }
        _ => Vec::new(),
    }
}
