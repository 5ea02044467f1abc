//! What layers for compositors need of a frame: where things are in the frames before and after, and the
//! ids of their names.

use glam::{DMat3, DVec3};

use super::error::FrameError;
use super::looks::Look;
use super::shown::{Shown, ShownLight, ShownObject, Whereabouts};
use slo_picture::film::mask_id;
use slo_scene::animation::{Clock, DAffine, Shutter, Spaces, View, axes, view_at};
use slo_scene::{Layer, SceneDescription};

/// What layers for compositors need of a frame.
#[derive(Debug)]
pub(super) struct Compositing {
    /// Origin of render space, in scene space.
    pub(super) origin: DVec3,
    /// The camera when the shutter opens, and when it opens in the frames before and after. `None` if
    /// there is no such frame; only in frames with [`Layer::Motion`].
    eyes: Option<[Option<Eye>; 3]>,
    /// Of each object: where its points are in the frames before and after. `None` if it stands still.
    /// Empty if all do.
    moves: Vec<Option<[Move; 2]>>,
    /// Ids of the names of all objects; empty without [`Layer::CryptoObject`].
    pub(super) objects: Vec<u32>,
    /// Ids of the names of the objects' materials, 0 for lamps; empty without
    /// [`Layer::CryptoMaterial`].
    pub(super) materials: Vec<u32>,
}

impl Compositing {
    /// Of a frame without layers.
    pub(super) fn without_layers(origin: DVec3) -> Self {
        let (moves, objects, materials) = (Vec::new(), Vec::new(), Vec::new());
        Self { origin, eyes: None, moves, objects, materials }
    }

    /// Of frame `number` of a scene, with its shutter. `looks` are those of the objects.
    pub(super) fn new(
        scene: &SceneDescription,
        shown: &Shown<'_>,
        (number, shutter): (i64, &Shutter),
        origin: DVec3,
        looks: &[Look],
    ) -> Result<Self, FrameError> {
        let has = |layer| scene.camera.film.layers.contains(&layer);
        let mut all = Self::without_layers(origin);
        let things = || (0..looks.len()).map(|number| Thing::of(scene, shown, number, looks));
        if has(Layer::CryptoObject) {
            all.objects = things().map(|thing| mask_id(thing.name)).collect();
        }
        if has(Layer::CryptoMaterial) {
            all.materials = things().map(|thing| thing.material.map_or(0, mask_id)).collect();
        }
        if has(Layer::Motion) {
            let clock = Clock::new(&scene.camera);
            let other = |number: Option<i64>| clock.shutter(number?).ok();
            let others = [other(number.checked_sub(1)), other(number.checked_add(1))];
            let eye = |shutter: &Shutter| Eye::of(scene, shutter);
            let [before, after] = others.each_ref().map(|other| other.as_ref().and_then(eye));
            all.eyes = Some([eye(shutter), before, after]);
            let time = |shutter: &Shutter| shutter.scene_time(0.0);
            let now = time(shutter);
            let times = others.map(|other| other.map_or(now, |other| time(&other)));
            for thing in things() {
                all.moves.push(moves(&thing, &shown.spaces, now, times)?);
            }
        }
        Ok(all)
    }

    /// Returns the motion, in pixels, of a point of an object that is there, in scene space, when the
    /// shutter opens.
    pub(super) fn motion(&self, object: u32, point: DVec3) -> [f64; 4] {
        let Some([Some(now), before, after]) = &self.eyes else { return [0.0; 4] };
        let Some([x, y]) = now.project(point) else { return [0.0; 4] };
        let moves = self.moves.get(object as usize).and_then(Option::as_ref);
        let there = |k: usize| moves.map_or(point, |moves| moves[k].point(point));
        let way = |eye: &Option<Eye>, k: usize| {
            let seen = eye.as_ref().and_then(|eye| eye.project(there(k)));
            seen.map_or([0.0; 2], |[to_x, to_y]| [to_x - x, to_y - y])
        };
        let ([before_x, before_y], [after_x, after_y]) = (way(before, 0), way(after, 1));
        [before_x, before_y, -after_x, -after_y]
    }
}

/// What an object of the frame is in the scene: an object, or a lamp that rays can hit.
struct Thing<'a> {
    name: &'a str,
    at: Whereabouts<'a>,
    /// Name of the material; `None` for lamps.
    material: Option<&'a str>,
}

impl<'a> Thing<'a> {
    fn of(scene: &'a SceneDescription, shown: &Shown<'a>, number: usize, looks: &[Look]) -> Self {
        let at_rest = Whereabouts { key_frames: &[], repeat: None, parent: None };
        match looks[number] {
            Look::Light(light) => {
                let ShownLight { light, at } = shown.lights[light as usize];
                Self { name: &light.name, at, material: None }
            }
            Look::Material(material) => {
                let (object, at) = match shown.objects.get(number) {
                    Some(ShownObject { object, at, .. }) => (*object, *at),
                    None => {
                        // Crowds come last. They rest, if anybody asks for motion.
                        let (object, ..) = shown.casts[number - (looks.len() - shown.casts.len())];
                        (&scene.objects[object as usize], at_rest)
                    }
                };
                let material = Some(&*scene.materials[material as usize].name);
                Self { name: &object.name, at, material }
            }
            Look::Nothing => Self { name: "", at: at_rest, material: None },
        }
    }
}

/// Where points of a thing at time `now` are at two other times; `None` if they are where they were.
fn moves(
    thing: &Thing<'_>,
    spaces: &Spaces,
    now: f64,
    others: [f64; 2],
) -> Result<Option<[Move; 2]>, FrameError> {
    let Whereabouts { key_frames, repeat, parent } = thing.at;
    if key_frames.len() < 2 && parent.is_none() {
        return Ok(None);
    }
    let path = spaces
        .path(key_frames, repeat, parent)
        .map_err(|reason| FrameError::Path { object: thing.name.to_owned(), reason })?;
    let now = path.pose(now);
    let others = others.map(|time| path.pose(time));
    let rests = others.iter().all(|other| *other == now);
    Ok((!rests).then(|| others.map(|other| Move::between(&now, &other))))
}

/// `x -> matrix x + translation`, in scene space.
#[derive(Clone, Copy, Debug)]
struct Move {
    matrix: DMat3,
    translation: DVec3,
}

impl Move {
    /// Where points of an object in one place are if it is in another place.
    fn between(from: &DAffine, to: &DAffine) -> Self {
        let matrix = to.linear * from.linear.inverse();
        Self { matrix, translation: to.translation - matrix * from.translation }
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.matrix * p + self.translation
    }
}

/// A pinhole that shows points of scene space on the film.
#[derive(Clone, Copy, Debug)]
struct Eye {
    position: DVec3,
    /// Unit vectors to the right, up, and into the picture.
    axes: [DVec3; 3],
    /// Pixels per unit at distance 1.
    scale: f64,
}

impl Eye {
    /// The camera when a shutter opens; `None` if it sees nothing.
    fn of(scene: &SceneDescription, shutter: &Shutter) -> Option<Self> {
        let segment = &scene.camera.segments[shutter.segment];
        let view: View = view_at(segment, shutter.segment_parameter(0.0));
        let scale = f64::from(scene.camera.film.height) / (2.0 * view.fov);
        Some(Self { position: view.position, axes: axes(&view)?, scale })
    }

    /// Returns where a point is on the film, in pixels to the right and up of its middle; `None` for
    /// points behind the camera.
    fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let way = point - self.position;
        let [right, up, forward] = self.axes.map(|axis| axis.dot(way));
        (forward > 0.0).then(|| [right, up].map(|side| side / forward * self.scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::animation::DRigid;

    #[test]
    fn points_are_shown_where_rays_start() {
        let eye = Eye {
            position: DVec3::new(1.0, 2.0, 3.0),
            axes: [DVec3::X, DVec3::Z, DVec3::Y],
            scale: 100.0,
        };
        assert_eq!(eye.project(DVec3::new(2.0, 4.0, 2.0)), Some([50.0, -50.0]));
        assert_eq!(eye.project(DVec3::new(1.0, 1.0, 3.0)), None);
    }

    #[test]
    fn points_go_with_their_object() {
        let from = DRigid { rotation: DMat3::from_rotation_z(0.3), translation: DVec3::X };
        let from = DAffine::scaled(DVec3::new(2.0, 1.0, 0.5), from);
        let to: DAffine =
            DRigid { rotation: DMat3::from_rotation_x(1.3), translation: DVec3::Y }.into();
        let point = DVec3::new(0.2, -0.7, 1.5);
        let moved = Move::between(&from, &to).point(from.point(point));
        assert!((moved - to.point(point)).length() < 1e-12);
    }
}
