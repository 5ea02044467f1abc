//! Where the texels of light maps lie, in render space.

use std::f32::consts::PI;

use glam::Vec3;

use super::instance::{Body, Instance};
use super::scene::FrameScene;
use super::texels::{LightMaps, Map, TexelPoint, Texels};
use super::world::{STILL, WorldHits};
use slo_accel::curved::Part;
use slo_accel::math::elementary::sin_cos_turns;
use slo_scene::light_map::{Layout, LightMap, Place, Unwrapped};
use slo_scene::{Integrator, Object, SceneDescription, Shape};

impl FrameScene {
    /// Returns the texels of the light map of an object, the one with the index `number` in the scene.
    /// `None` if the frame does not show the object, or if it has no texture coordinates.
    pub(crate) fn texels(
        &self,
        scene: &SceneDescription,
        number: usize,
        LightMap { side, inside }: LightMap,
    ) -> Option<Texels> {
        let is_shown = |of: &&Object| !of.hidden && !scene.hides(of.parent);
        let shape = &scene.objects.get(number).filter(is_shown)?.shape;
        let object = scene.objects[..number].iter().filter(is_shown).count() as u32;
        let map = match shape.unwrapped().ok()? {
            Unwrapped::Faces(faces) => Map::Faces(Layout::new(&faces, side)?),
            Unwrapped::Sphere => {
                let Shape::Sphere(sphere) = shape else { return None };
                Map::Sphere { center: sphere.center.as_vec3(), radius: sphere.radius as f32 }
            }
        };
        let is_it = |of: &Instance| of.object == object;
        let instance = self.world.instances.iter().position(is_it);
        let first = match instance {
            Some(_) => 0,
            None => self.still_objects.iter().position(|&of| of == object)? as u32,
        };
        let instance = instance.map_or(STILL, |number| number as u32);
        Some(Texels { side, object, instance, first, inside, map })
    }

    /// Returns a point of a texel at a time of the shutter; `within` is from 0 to 1 rightward and
    /// downward. `None` if there is no surface.
    pub(crate) fn texel_point(
        &self,
        texels: &Texels,
        [x, y]: [u32; 2],
        within: [f32; 2],
        time: f32,
    ) -> Option<TexelPoint> {
        let Texels { side, instance, first, inside, .. } = *texels;
        let found = match &texels.map {
            Map::Faces(layout) => {
                let Place { face, weights, area } = layout.place(x, y, within)?;
                let [a, b, c] = self.corners(texels, face, time);
                let [u, v] = weights;
                let double = (b - a).as_dvec3().cross((c - a).as_dvec3());
                TexelPoint {
                    primitive: first + face,
                    instance,
                    uv: weights,
                    point: a * (1.0 - u - v) + b * u + c * v,
                    normal: double.try_normalize()?.as_vec3(),
                    width: (0.5 * double.length() / f64::from(area)).sqrt() as f32,
                }
            }
            &Map::Sphere { center, radius } => {
                let scale = 1.0 / side as f32;
                let turn = (x as f32 + within[0]) * scale;
                let rise = 0.5 - (y as f32 + within[1]) * scale;
                let ((s, c), (up, out)) = (sin_cos_turns(turn), sin_cos_turns(0.5 * rise));
                let axis = Vec3::new(out * c, out * s, up);
                let [middle, point, normal] = self.on_ball(texels, center, axis * radius, time);
                TexelPoint {
                    primitive: first,
                    instance,
                    uv: [Part::Side.to_u(), 0.0],
                    point,
                    normal,
                    width: (point - middle).length() * PI * scale,
                }
            }
        };
        let normal = if inside { -found.normal } else { found.normal };
        let is_sound = found.point.is_finite() && found.width > 0.0 && found.width.is_finite();
        is_sound.then_some(TexelPoint { normal, ..found })
    }

    /// Returns the corners of a face, in render space.
    fn corners(&self, texels: &Texels, face: u32, time: f32) -> [Vec3; 3] {
        let id = texels.first + face;
        let Some(instance) = self.world.instances.get(texels.instance as usize) else {
            return self.world.still.triangle(id);
        };
        let local = match &instance.body {
            Body::Bending(bending) => bending.triangle(id, time),
            Body::Still(structure) => structure.triangle(id),
        };
        let pose = instance.pose(time);
        local.map(|corner| pose.point(corner))
    }

    /// Returns the middle of a ball, a point of it, and the unit normal there, in render space.
    fn on_ball(&self, texels: &Texels, center: Vec3, way: Vec3, time: f32) -> [Vec3; 3] {
        let (place, shift) = match self.world.instances.get(texels.instance as usize) {
            Some(instance) => (instance.pose(time), instance.center),
            None => (&self.objects[texels.object as usize].place, Vec3::ZERO),
        };
        let middle = center - shift;
        [place.point(middle), place.point(middle + way), place.normal(way).normalize_or_zero()]
    }

    /// Returns the light maps of all objects that have one, if the frame gathers light.
    pub(super) fn light_maps_of(&self, scene: &SceneDescription) -> LightMaps {
        if self.settings.integrator != Integrator::PhotonMap || !self.settings.gather {
            return LightMaps::default();
        }
        let texels =
            |(number, object): (usize, &Object)| self.texels(scene, number, object.light_map?);
        let all = scene.objects.iter().enumerate().filter_map(texels).collect();
        LightMaps::new(all, self.objects.len())
    }

    /// Returns the points in the middle of all texels of a light map, row by row, with their normals, in
    /// the middle of the shutter.
    pub(crate) fn texel_middles(&self, texels: &Texels) -> Vec<Option<[Vec3; 2]>> {
        let side = texels.side();
        let point = |place| {
            let found = self.texel_point(texels, place, [0.5; 2], 0.5)?;
            Some([found.point, found.normal])
        };
        (0..side).flat_map(|y| (0..side).map(move |x| [x, y])).map(point).collect()
    }

    /// Returns the light map of the object that a ray hit, and the index of its texel, if there is one on
    /// that side of the surface. The hit is at a point, at a time of the shutter.
    pub(crate) fn texel_of(
        &self,
        found: &WorldHits,
        ray: usize,
        (point, time, from_outside): (Vec3, f32, bool),
    ) -> Option<(usize, usize)> {
        let object = self.object_of(found.hits.primitive[ray], found.instance[ray]);
        let map = *self.light_maps.of_objects.get(object as usize)?;
        let texels = self.light_maps.all.get(map as usize)?;
        Some((map as usize, texels.at(self.uv_of(found, ray, point, time), from_outside)?))
    }
}
