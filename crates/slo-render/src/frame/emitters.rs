//! Objects that emit light, as lights that rays are sent toward.
//!
//! Where a surface emits the same light everywhere and in all directions, a ray to it carries this
//! light. Toward other surfaces, rays are sent that are shaded where they arrive: their lights are
//! the last of a frame, from [`FrameScene::first_shaded`](super::scene::FrameScene) on.

use glam::{Mat3, Vec2, Vec3};

use super::affine::Affine;
use super::glow::Glow;
use super::parts::Parts;
use super::shapes::Geometry;
use super::shown::{Shown, ShownObject};
use crate::shading::Light;
use crate::shading::light::{MOST_SHADED, Pose, Poses, Shaded, SphereLamp, Triangle};
use slo_accel::Curved;
use slo_scene::material::Principled;
use slo_scene::{MaterialId, MaterialKind, SceneDescription};

/// Places of images that are looked up for all triangles of an object together, about.
const LOOK_UPS: u32 = 1 << 18;

/// Fewest and most places that are looked up for one triangle.
const LOOK_UPS_OF_ONE: [u32; 2] = [16, 4096];

/// Whether a surface emits the same light everywhere and in all directions.
fn is_even(scene: &SceneDescription, material: MaterialId) -> bool {
    let MaterialKind::Principled(of) = &scene.materials[material.0 as usize].kind else {
        return false;
    };
    let Principled { emission_color, emission_strength, coat, sheen, alpha, .. } = of;
    [emission_strength, coat, sheen, alpha].iter().all(|of| of.image.is_none())
        && emission_color.image.is_none()
        && coat.value == 0.0
        && sheen.value == 0.0
        && alpha.value == 1.0
}

/// What an object is made of, in the space in which it rests, with the poses of this space.
struct Body {
    primitives: Primitives,
    poses: Vec<Pose>,
}

enum Primitives {
    Triangles(Vec<[Vec3; 3]>),
    Sphere(Vec3, f32),
}

impl Body {
    /// Returns what an object is made of; `None` if rays are not sent toward such a shape.
    fn of(parts: &Parts, object: usize) -> Option<Self> {
        let geometry = &parts.objects[object].geometry;
        // Lists are in the order of objects.
        let number = object as u32;
        let instances = &parts.instances;
        if let Ok(place) = instances.binary_search_by_key(&number, |of| of.object) {
            let instance = &instances[place];
            let structure = instance.body.structure()?;
            let primitives = match (geometry, structure.curved()) {
                (Geometry::Curved(_), [Curved::Sphere { center, radius }]) => {
                    Primitives::Sphere(*center, *radius)
                }
                (Geometry::Curved(_), _) => return None,
                (Geometry::Mesh(..), _) => {
                    let ids = 0..structure.triangle_count() as u32;
                    Primitives::Triangles(ids.map(|id| structure.triangle(id)).collect())
                }
            };
            return Self { primitives, poses: Vec::new() }.moving(&instance.poses);
        }
        let slo_accel::Primitives { triangles, curved, .. } = parts.still_object(object)?;
        let primitives = match (geometry, &curved[..]) {
            (Geometry::Mesh(..), _) => Primitives::Triangles(triangles),
            (Geometry::Curved(_), [Curved::Sphere { center, radius }]) => {
                Primitives::Sphere(*center, *radius)
            }
            (Geometry::Curved(_), _) => return None,
        };
        Some(Self { primitives, poses: Vec::new() })
    }

    /// Returns the same body in these poses; `None` if its size or its shape changes over them, or if
    /// a sphere would not be round.
    fn moving(mut self, poses: &[Affine]) -> Option<Self> {
        let Some(first) = poses.iter().find(|pose| !pose.is_rigid) else {
            let pose = |at: &Affine| Pose { rotation: at.linear, translation: at.translation };
            self.poses = poses.iter().map(pose).collect();
            return Some(self);
        };
        let Affine { linear, .. } = *first;
        match &mut self.primitives {
            Primitives::Triangles(triangles) => {
                triangles.iter_mut().for_each(|corners| *corners = corners.map(|c| linear * c));
            }
            Primitives::Sphere(center, radius) => {
                rotation(linear * (1.0 / linear.x_axis.length()))?;
                *radius *= linear.x_axis.length();
                *center = linear * *center;
            }
        }
        let back = linear.inverse();
        let pose = |at: &Affine| {
            Some(Pose { rotation: rotation(at.linear * back)?, translation: at.translation })
        };
        self.poses = poses.iter().map(pose).collect::<Option<_>>()?;
        Some(self)
    }

    fn count(&self) -> usize {
        match &self.primitives {
            Primitives::Triangles(triangles) => triangles.len(),
            Primitives::Sphere(..) => 1,
        }
    }
}

/// Returns the rotation that a matrix is, up to rounding; `None` if it is none.
fn rotation(matrix: Mat3) -> Option<Mat3> {
    const ROUNDING: f32 = 1e-4;
    let rest = matrix.transpose() * matrix - Mat3::IDENTITY;
    let is_rotation = rest.to_cols_array().iter().all(|c| c.abs() <= ROUNDING);
    let x = matrix.x_axis.normalize_or(Vec3::X);
    let y = (matrix.y_axis - x * x.dot(matrix.y_axis)).normalize_or(Vec3::Y);
    is_rotation.then(|| Mat3::from_cols(x, y, x.cross(y)))
}

/// Adds objects that emit light to the lights of a frame: triangles and spheres. Returns the number
/// of the first light that is shaded where rays arrive.
///
/// The light of other shapes, and of objects whose size changes while the shutter is open, is found by
/// rays that hit them.
pub(super) fn add_emitters(
    scene: &SceneDescription,
    objects: &[ShownObject<'_>],
    parts: &mut Parts,
    lights: &mut Vec<Light>,
    poses: &mut Poses,
) -> u32 {
    let glows: Vec<Glow> =
        (0..scene.materials.len()).map(|number| Glow::of(scene, number as u32)).collect();
    let glow_of = |shown: &ShownObject<'_>| &glows[shown.material.0 as usize];
    let emits = |shown: &ShownObject<'_>| {
        let object = shown.object;
        object.sampled && !object.shape.changes() && !matches!(glow_of(shown), Glow::Dark)
    };
    let most = MOST_SHADED as usize;
    let mut first_shaded = lights.len();
    for is_plain in [true, false] {
        for (number, object) in objects.iter().enumerate() {
            if !emits(object) || is_even(scene, object.material) != is_plain {
                continue;
            }
            let Some(body) = Body::of(parts, number) else { continue };
            if !is_plain && lights.len() - first_shaded + body.count() > most {
                continue;
            }
            parts.objects[number].first_light = Some(lights.len() as u32);
            let geometry = &parts.objects[number].geometry;
            add(scene, glow_of(object), geometry, &body.primitives, is_plain, lights);
            poses.add(body.count(), body.poses);
        }
        if is_plain {
            first_shaded = lights.len();
        }
    }
    first_shaded as u32
}

/// Adds the lights of an object.
fn add(
    scene: &SceneDescription,
    glow: &Glow,
    geometry: &Geometry,
    primitives: &Primitives,
    is_plain: bool,
    lights: &mut Vec<Light>,
) {
    let textures = &scene.textures;
    let triangles = match primitives {
        Primitives::Triangles(triangles) => triangles,
        Primitives::Sphere(center, radius) => {
            let radiance = glow.mean(textures, LOOK_UPS_OF_ONE[1]);
            let sphere = SphereLamp::even(*center, *radius, radiance);
            lights.push(if is_plain {
                Light::SphereLamp(sphere)
            } else {
                Light::ShadedSphere(Shaded(sphere))
            });
            return;
        }
    };
    let [least, most] = LOOK_UPS_OF_ONE;
    let count = (LOOK_UPS / triangles.len().max(1) as u32).clamp(least, most);
    let uvs = |face: usize| match geometry {
        Geometry::Mesh(mesh, _) => mesh.face_uvs.get(face).map_or([Vec2::ZERO; 3], |corners| {
            corners.map(|corner| Vec2::from(mesh.uvs[corner as usize]))
        }),
        Geometry::Curved(_) => [Vec2::ZERO; 3],
    };
    lights.extend(triangles.iter().enumerate().map(|(face, corners)| {
        let radiance = glow.mean_in(textures, uvs(face), count);
        let triangle = Triangle::new(*corners, radiance);
        if is_plain { Light::Triangle(triangle) } else { Light::ShadedTriangle(Shaded(triangle)) }
    }));
}

/// Finds the groups of all objects, and returns those of all lights, as numbers: 0 for the light
/// without a group, and one more than the place among the names of the scene's groups for others.
pub(super) fn light_groups(
    scene: &SceneDescription,
    shown: &Shown<'_>,
    parts: &mut Parts,
    lights: usize,
) -> Vec<u32> {
    let groups = scene.light_groups();
    let number = |name: Option<&str>| groups.index(name).map_or(0, |index| index as u32 + 1);
    let mut all: Vec<u32> =
        shown.lights.iter().map(|of| number(of.light.group.as_deref())).collect();
    all.resize(lights, 0);
    let first_cast = parts.objects.len() - shown.casts.len();
    for ((object, ..), to) in shown.casts.iter().zip(&mut parts.objects[first_cast..]) {
        to.light_group = number(scene.objects[*object as usize].light_group.as_deref());
    }
    for (shown, to) in shown.objects.iter().zip(&mut parts.objects) {
        to.light_group = number(shown.object.light_group.as_deref());
        if let Some(first) = to.first_light {
            let count = match &to.geometry {
                Geometry::Mesh(mesh, _) => mesh.faces.len(),
                Geometry::Curved(_) => 1,
            };
            all[first as usize..][..count].fill(to.light_group);
        }
    }
    all
}
