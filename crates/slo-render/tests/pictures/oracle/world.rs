//! All things of a scene, and what rays meet.

use glam::DVec3;

use slo_scene::{KeyFrame, SceneDescription};

use super::motion::Shutter;
use super::solid::{Meeting, Ray, Solid, light_solids, solids};

/// Distance within which a ray meets the surface that it leaves, by rounding in f64. No two
/// surfaces of the scenes are as close as this.
const NEAR: f64 = 1e-7;

/// Objects and lights during a shutter.
pub(super) struct World<'a> {
    pub(super) shutter: Shutter,
    pub(super) things: Vec<Thing<'a>>,
}

pub(super) struct Thing<'a> {
    solids: Vec<Solid>,
    keys: &'a [KeyFrame],
    pub(super) look: Look,
    /// Whether the object has no inside.
    pub(super) open: bool,
    /// Index of the object or the light in the scene.
    pub(super) number: usize,
}

#[derive(Clone, Copy)]
pub(super) enum Look {
    Material(usize),
    Light(usize),
}

impl<'a> World<'a> {
    pub(super) fn new(scene: &'a SceneDescription, frame: i64) -> Self {
        let objects = scene.objects.iter().enumerate().map(|(number, object)| {
            let (solids, open) = solids(&object.shape);
            let look = Look::Material(object.material.0 as usize);
            Thing { solids, keys: &object.key_frames, look, open, number }
        });
        let lights = scene.lights.iter().enumerate().map(|(number, light)| Thing {
            solids: light_solids(&light.kind),
            keys: &[],
            look: Look::Light(number),
            open: true,
            number,
        });
        Self { shutter: Shutter::new(scene, frame), things: objects.chain(lights).collect() }
    }

    /// Returns the first object on a ray, leaving out the surface of light `but`.
    pub(super) fn nearest(&self, ray: &Ray, but: Option<usize>) -> Option<(&Thing<'a>, Meeting)> {
        let counts =
            |thing: &&Thing<'_>| !matches!((thing.look, but), (Look::Light(a), Some(b)) if a == b);
        let meet = |thing| self.meet(thing, ray).map(|meeting| (thing, meeting));
        let by_t = |a: &(&Thing<'a>, Meeting), b: &(&Thing<'a>, Meeting)| a.1.t.total_cmp(&b.1.t);
        self.things.iter().filter(counts).filter_map(meet).min_by(by_t)
    }

    fn meet(&self, thing: &Thing<'a>, ray: &Ray) -> Option<Meeting> {
        let pose = self.shutter.pose(thing.keys, ray.time);
        let local = pose.inverse(ray);
        let meetings = thing.solids.iter().enumerate().filter_map(|(part, solid)| {
            let meeting = solid.meet(&local, NEAR)?;
            Some(Meeting { part, ..meeting })
        });
        let meeting = meetings.min_by(|a, b| a.t.total_cmp(&b.t))?;
        Some(Meeting {
            outward: pose.rotation * meeting.outward,
            smooth: meeting.smooth.map(|n| pose.rotation * n),
            ..meeting
        })
    }
}

/// The triangles of a thing that has nothing else.
pub(super) fn triangles(thing: &Thing<'_>) -> Vec<[DVec3; 3]> {
    let corners = |solid: &Solid| match *solid {
        Solid::Triangle { corners, .. } => corners,
        _ => panic!("the oracle sends rays to flat emitters only"),
    };
    assert!(thing.keys.is_empty(), "the oracle knows no emitters that move");
    thing.solids.iter().map(corners).collect()
}
