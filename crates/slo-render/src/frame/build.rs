//! Builds a FrameScene from a SceneDescription and a frame number.

use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};

use super::compositing::Compositing;
use super::emitters::{add_emitters, light_groups};
use super::error::FrameError;
use super::kept::{Aids, structure};
use super::lists::{crowd, not_placed};
use super::looks::{Look, Looks};
use super::needs;
use super::parts::{Parts, Seen};
use super::sampled_camera::SampledCamera;
use super::scene::FrameScene;
use super::shared::Shared;
use super::sharp::sharp_objects;
use super::shown::Shown;
use super::texels::LightMaps;
use super::world::World;
use crate::camera::Camera;
use crate::photons::{Emission, Everywhere, PhotonLamps, targets};
use crate::sampling::Sampler;
use crate::shading::light::{EvenSky, LightBounds, LightTree, Poses, Skies, SkyShare, Techniques};
use crate::shading::material::{self, Kind};
use crate::shading::{Light, Lights, MaterialTable};
use slo_accel::Isa;
use slo_scene::animation::Clock;
use slo_scene::{
    CamSegment, Integrator, LightSampling, PhotonSeed, SceneDescription, Settings, ShadowMode,
};

/// Step, in units of the scene, by which the origin of render space follows the camera along each
/// axis. Within half a step of the origin, an f32 resolves 2^-14 units or better. Structures of
/// still objects are rebuilt whenever the origin moves, so it must not move in every frame.
const ORIGIN_STEP: f64 = 1024.0;

/// Name of the random numbers of pilot paths.
const PILOT: u32 = 0x7069_6c6f;

impl FrameScene {
    /// Builds frame `number` of a scene, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Fails if the frame's time lies in no camera segment, if nothing can be seen from the
    /// camera's view, or if an object's key frames do not form a path.
    pub fn build(scene: &SceneDescription, number: i64, isa: Isa) -> Result<Self, FrameError> {
        Self::build_with(scene, number, isa, Aids::default())
    }

    /// Like [`build`](Self::build), but starts from what is there: [what another frame
    /// left](Self::remains), if it fits this frame too (structures of objects that move in both
    /// frames, and the structure of all still objects if they lie in the same places), and structures
    /// in a cache. The picture is the same.
    ///
    /// # Errors
    /// Fails in the same cases as [`build`](Self::build).
    pub fn build_with(
        scene: &SceneDescription,
        number: i64,
        isa: Isa,
        aids: impl Into<Aids>,
    ) -> Result<Self, FrameError> {
        let Aids { before, cache, parameters, stays, apart } = aids.into();
        let shutter = Clock::new(&scene.camera).shutter(number).map_err(FrameError::NoSegment)?;
        let segment = &scene.camera.segments[shutter.segment];
        let film = &scene.camera.film;
        let per_ms = scene.settings.transform_samples_per_ms;
        let path = SampledCamera::new(segment, &shutter, film, per_ms);
        let origin = match &before {
            Some(before) if stays && is_near(&path, before.origin) => before.origin,
            _ => origin(segment, &path),
        };
        let camera = Camera::new(path.views(), origin, film.width, film.height)
            .map_err(|reason| FrameError::View { segment: segment.name.clone(), reason })?;

        let shown = Shown::of(scene)?;
        // What the frame before left is not made again.
        if before.is_none() {
            needs::check(scene, &shown)?;
        }
        let spaces = &shown.spaces;
        let seen = Seen { shutter: &shutter, camera: &path, per_ms, origin, spaces };
        let cast =
            |&(object, _, count): &(u32, _, u64)| (&scene.objects[object as usize].shape, count);
        let shapes = shown.objects.iter().map(|shown| (&shown.object.shape, 1));
        let shared = Shared::new(shapes.chain(shown.casts.iter().map(cast)));
        let before =
            before.filter(|of| of.made.as_ref().is_none_or(|made| made.is_by(&scene.settings)));
        let left = before.as_ref();
        let mut parts = Parts {
            before: left.map(|before| before.moving.clone()).unwrap_or_default(),
            bending: left.map(|before| before.bending.clone()).unwrap_or_default(),
            made: left.and_then(|before| before.made.clone()),
            apart,
            cache,
            parameters,
            shared,
            ..Parts::default()
        };
        for object in &shown.objects {
            parts.add(object, scene, &seen, isa)?;
        }
        let share = match scene.settings.integrator {
            Integrator::Path => SkyShare::AboveMean,
            // Photons start where the sky is sampled.
            Integrator::Distributed | Integrator::PhotonMap => SkyShare::All,
        };
        let skies_before = before.as_ref().map_or(&[][..], |before| &before.skies);
        let sampled = Skies { share, before: skies_before };
        let (mut lights, mut poses) = (Vec::new(), Poses::default());
        let (mut hidden, mut passable) = (Vec::new(), Vec::new());
        for shown in &shown.lights {
            let (light, look) = (shown.light, Look::Light(lights.len() as u32));
            let (ready, path) = parts.add_light(shown, look, scene, &seen, isa, sampled)?;
            lights.push(ready);
            poses.add(1, path);
            hidden.push(!light.camera_visible);
            passable.push(!light.solid);
        }
        let mut settings = scene.settings.clone();
        let background = Vec3::from(settings.background);
        if settings.integrator == Integrator::PhotonMap && background != Vec3::ZERO {
            // As a sky, it sends photons.
            lights.push(Light::EvenSky(EvenSky::new(background)));
            poses.add(1, Vec::new());
            hidden.push(false);
            passable.push(false);
            settings.background = [0.0; 3];
        }
        // Glowing objects may have any number of triangles, so these are always chosen from.
        let first_chosen = match scene.settings.light_sampling() {
            LightSampling::All => lights.len(),
            LightSampling::One => 0,
        };
        let first_shaded = add_emitters(scene, &shown.objects, &mut parts, &mut lights, &mut poses);
        let resting = before.as_ref().filter(|of| of.made.is_none() && of.origin == origin);
        let resting = resting.and_then(|before| before.crowd.as_ref());
        let crowd = crowd(&shown, &mut parts, scene, &seen, isa, resting)?;
        let light_groups = light_groups(scene, &shown, &mut parts, lights.len());
        for flags in [&mut hidden, &mut passable] {
            if !flags.contains(&true) {
                flags.clear();
            }
        }
        let softens = softens(scene, &parts);
        let uses_photons =
            scene.settings.photons > 0.0 && scene.settings.integrator == Integrator::Path;
        let is_photon_map = scene.settings.integrator == Integrator::PhotonMap;
        let sends = uses_photons || is_photon_map;
        let targets = sends.then(|| targets(&sharp_objects(scene, &shown.objects, &parts)));
        let still = match before {
            Some(before) if *before.places == parts.places && parts.still_is_as_before() => {
                before.still
            }
            // Free the old structure before building the new one.
            other => {
                drop(other);
                Arc::new(structure(
                    parts.still(),
                    &scene.settings,
                    isa,
                    (parts.cache.as_deref(), parameters),
                )?)
            }
        };
        let still_objects = parts.still_objects();
        let times = (number, &shutter);
        let compositing = Compositing::new(scene, &shown, times, origin, &parts.looks)?;
        let looks = Looks::new(
            parts.looks.into_iter(),
            parts.instances.iter().map(|instance| instance.object),
        );
        let materials: Vec<_> = scene.materials.iter().map(material::row).collect();
        let world = World::new(still, parts.instances, crowd, isa).map_err(|error| {
            // There is no error without a crowd.
            let first = shown.crowds.first().copied().unwrap_or(0);
            not_placed(error, &scene.copies[first as usize])
        })?;
        let bounds = light_bounds(&lights, &poses);
        let light_tree = LightTree::new(&bounds[first_chosen..]);
        let skies = skies(&lights);
        let lights = lights.into_iter().collect::<Lights>().with_poses(poses);
        let is_physical = is_physical(scene) || lights.move_about();
        let all = Everywhere::new(&lights, &bounds, world.bounds()).filter(|_| is_photon_map);
        let emission = targets.and_then(|targets| {
            Emission::new(&lights, &bounds, targets, world.bounds(), camera.position())
        });
        let (emission, photon_lamps) = match all {
            Some(all) => (None, Some(PhotonLamps { all, aimed: emission })),
            None => (emission.filter(|_| uses_photons), None),
        };
        if emission.is_some() {
            needs::check_pass(scene)?;
        }
        let photon_frame = match scene.settings.photon_seed {
            PhotonSeed::Frame => number,
            PhotonSeed::Fixed => 0,
        };
        let sampler = |frame| Sampler::new(scene.settings.generator, scene.settings.seed, frame);
        let tints =
            world.crowd.tints() || parts.objects.iter().any(|object| object.tint != Vec3::ONE);
        let frame = Self {
            camera,
            world,
            material_table: MaterialTable::new(&scene.materials, &materials),
            materials,
            light_tree,
            first_chosen: first_chosen as u32,
            skies,
            hidden,
            passable,
            light_groups,
            techniques: techniques(&scene.settings),
            lights,
            first_shaded,
            emission,
            photon_lamps,
            is_physical,
            softens,
            stretches: parts.stretches,
            tints,
            sampler: sampler(number),
            photon_sampler: sampler(photon_frame),
            pilot_sampler: sampler(number).renamed(PILOT),
            field: OnceLock::new(),
            baked: None,
            light_maps: LightMaps::default(),
            known_light: OnceLock::new(),
            counting: None,
            settings,
            isa,
            clever: true,
            textures: scene.textures.clone(),
            objects: parts.objects,
            looks,
            compositing,
            still_places: Arc::new(parts.places),
            still_objects,
        };
        Ok(Self { light_maps: frame.light_maps_of(scene), ..frame })
    }
}

/// Returns the indices of lights that are infinitely far away and seen by rays that hit nothing.
fn skies(lights: &[Light]) -> Vec<u32> {
    let is_sky = |light: &Light| light.is_distant() && !light.is_delta();
    (0..).zip(lights).filter(|(_, light)| is_sky(light)).map(|(number, _)| number).collect()
}

/// Returns the bounds of each light, wherever it is during the shutter.
fn light_bounds(lights: &[Light], poses: &Poses) -> Vec<LightBounds> {
    let bounds = (0..).zip(lights).map(|(number, light)| {
        let poses = poses.of(number).iter();
        light.bounds().in_poses(poses.map(|pose| (pose.rotation, pose.translation)))
    });
    bounds.collect()
}

/// Chooses how the light of lamps is shared. Rays to lamps pass straight through transparent objects if
/// the settings say so, and rays of lobes do not.
fn techniques(settings: &Settings) -> Techniques {
    match (settings.integrator, settings.shadow) {
        (Integrator::Distributed, ShadowMode::Transparent) => Techniques::Separate,
        (Integrator::Distributed, ShadowMode::Opaque)
        | (Integrator::Path | Integrator::PhotonMap, _) => Techniques::Combined,
    }
}

/// Whether a scene says anything that the thesis's integrator does not know, but for lights that move.
fn is_physical(scene: &SceneDescription) -> bool {
    scene.settings.integrator != Integrator::Distributed
        || scene.lights.iter().any(|light| !light.kind.is_of_thesis())
        || scene.materials.iter().any(|material| Kind::of(material) != Kind::Phong)
}

/// Whether any smooth mesh may have a physical material.
fn softens(scene: &SceneDescription, parts: &Parts) -> bool {
    parts.objects.iter().zip(&parts.looks).any(|(object, look)| {
        let is_physical = |index| Kind::of(&scene.materials[index as usize]) != Kind::Phong;
        !object.normals.is_empty() && look.material().is_some_and(is_physical)
    })
}

/// Whether the camera is not farther from the origin of render space than it may be.
pub(super) fn is_near(path: &SampledCamera, origin: DVec3) -> bool {
    (path.views()[0].position - origin).abs().max_element() <= ORIGIN_STEP
}

/// Chooses the origin of render space, in scene space: near the camera, where precision matters. It
/// is the start of the camera's path, moved by whole steps as the camera gets farther away.
fn origin(segment: &CamSegment, path: &SampledCamera) -> DVec3 {
    let start = segment.positions[0];
    let steps = (path.views()[0].position - start) / ORIGIN_STEP;
    start + steps.round() * ORIGIN_STEP
}
