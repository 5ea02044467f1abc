//! What files of other programs say, in the words of slo-rt.

mod mesh;

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};

pub(crate) use mesh::{KnownMeshes, Mesh};

/// Everything that a file says. Lengths are in metres; +z is up.
#[derive(Debug, Default)]
pub(crate) struct Model {
    pub(crate) camera: Option<Camera>,
    pub(crate) lamps: Vec<Lamp>,
    /// Light from everywhere, W/(m² sr).
    pub(crate) background: Option<[f64; 3]>,
    pub(crate) images: Vec<Image>,
    pub(crate) materials: Vec<Material>,
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) spaces: Vec<Space>,
    pub(crate) objects: Vec<Object>,
    /// Whether materials and lights are those of the thesis instead of physical ones.
    pub(crate) is_classical: bool,
    /// Whether light passes through what is transparent, if it is classical.
    pub(crate) has_clear_shadows: bool,
    /// Seconds that the animation takes; 0 for a still.
    pub(crate) duration: f64,
    /// Frames a second; `None` if the file does not say.
    pub(crate) fps: Option<f64>,
    pub(crate) notes: Notes,
}

/// What the scene text lacks or was made up, each with how often.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    pub(crate) left_out: BTreeMap<String, usize>,
    pub(crate) made_up: Vec<String>,
}

impl Notes {
    pub(crate) fn leave_out(&mut self, what: impl Into<String>) {
        self.leave_out_many(what, 1);
    }

    pub(crate) fn leave_out_many(&mut self, what: impl Into<String>, count: usize) {
        if count > 0 {
            *self.left_out.entry(what.into()).or_default() += count;
        }
    }
}

/// Where something is in its space, at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) pivot: DVec3,
    pub(crate) turn: DQuat,
    pub(crate) scale: DVec3,
}

impl Default for Pose {
    fn default() -> Self {
        Self { pivot: DVec3::ZERO, turn: DQuat::IDENTITY, scale: DVec3::ONE }
    }
}

impl Pose {
    pub(crate) fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, self.turn, self.pivot)
    }
}

/// A time and a pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub(crate) time: f64,
    pub(crate) pose: Pose,
}

/// A space that things hang in: a group.
#[derive(Debug)]
pub(crate) struct Space {
    pub(crate) name: String,
    pub(crate) parent: Option<usize>,
    /// At least one.
    pub(crate) keys: Vec<Key>,
}

impl Space {
    /// A space that does not move.
    pub(crate) fn still(name: String, parent: Option<usize>, pose: Pose) -> Self {
        Self { name, parent, keys: vec![Key { time: 0.0, pose }] }
    }

    /// The space of a file in which y is up.
    pub(crate) fn y_up(name: String) -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = DQuat::from_xyzw(half, 0.0, 0.0, half);
        Self::still(name, None, Pose { turn, ..Pose::default() })
    }
}

/// A shape of a material in a space.
#[derive(Debug)]
pub(crate) struct Object {
    pub(crate) name: String,
    pub(crate) space: Option<usize>,
    pub(crate) material: usize,
    pub(crate) shape: Shape,
    /// Whether it is there, but not seen.
    pub(crate) is_hidden: bool,
}

#[derive(Debug)]
pub(crate) enum Shape {
    Mesh(usize),
    /// Meshes with the same faces: this one and those that follow.
    Changing {
        first: usize,
        count: usize,
        times: Times,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Cylinder {
        base: DVec3,
        top: DVec3,
        radius: f64,
    },
    /// A closed one.
    Cone {
        base: DVec3,
        apex: DVec3,
        radius: f64,
    },
    /// A box around the origin, with half of its sides.
    Box {
        half: DVec3,
    },
}

/// When a mesh has its shapes.
#[derive(Clone, Debug)]
pub(crate) enum Times {
    /// The first at time 0, and so many a second.
    Even(f64),
    /// At these rising times.
    At(Vec<f64>),
}

/// An image file, as it was.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
}

/// How a material uses an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageUse {
    pub(crate) image: usize,
    pub(crate) channel: Option<char>,
    pub(crate) wrap: &'static str,
    pub(crate) nearest: bool,
    /// Scale, offset and turn in degrees of texture coordinates.
    pub(crate) scale: [f64; 2],
    pub(crate) offset: [f64; 2],
    pub(crate) turn_deg: f64,
}

impl ImageUse {
    /// An image that repeats.
    pub(crate) fn of(image: usize) -> Self {
        Self {
            image,
            channel: None,
            wrap: "REPEAT",
            nearest: false,
            scale: [1.0; 2],
            offset: [0.0; 2],
            turn_deg: 0.0,
        }
    }
}

/// Inputs of a material, under the names of the scene language.
#[derive(Clone, Debug, Default)]
pub(crate) struct Material {
    pub(crate) name: String,
    pub(crate) colors: Vec<(&'static str, [f64; 3])>,
    pub(crate) numbers: Vec<(&'static str, f64)>,
    pub(crate) images: Vec<(&'static str, ImageUse)>,
}

/// Where the picture is taken from.
#[derive(Debug)]
pub(crate) struct Camera {
    /// Width and height.
    pub(crate) size: [u32; 2],
    /// Tangent of half the vertical angle of view.
    pub(crate) fov: f64,
    /// One for a camera at rest; otherwise at even times from 0 to the end.
    pub(crate) views: Vec<View>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) position: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: DVec3,
}

#[derive(Debug)]
pub(crate) struct Lamp {
    pub(crate) name: String,
    pub(crate) space: Option<usize>,
    pub(crate) kind: LampKind,
}

/// Lamps at the origin of their spaces. They shine along -z there.
#[derive(Debug)]
pub(crate) enum LampKind {
    /// W.
    Point { power: [f64; 3] },
    /// W, as if there were no cone; angles of the whole cone in degrees, and the share of its rim.
    Spot { power: [f64; 3], angle_deg: f64, blend: f64 },
    /// W/m².
    Sun { irradiance: [f64; 3] },
    /// A light of the thesis, which does not fall off with distance.
    Classical { color: [f64; 3], position: DVec3 },
}

impl Model {
    /// The matrix of a space at a time, in the scene.
    pub(crate) fn matrix(&self, space: Option<usize>, time: f64) -> DMat4 {
        let mut matrix = DMat4::IDENTITY;
        let mut next = space;
        while let Some(space) = next {
            matrix = pose_at(&self.spaces[space].keys, time).matrix() * matrix;
            next = self.spaces[space].parent;
        }
        matrix
    }

    /// Whether a space or one that it hangs in moves.
    pub(crate) fn moves(&self, space: Option<usize>) -> bool {
        let mut next = space;
        while let Some(space) = next {
            if self.spaces[space].keys.len() > 1 {
                return true;
            }
            next = self.spaces[space].parent;
        }
        false
    }

    /// Drops what hangs in these spaces, or in spaces that hang in them.
    pub(crate) fn drop_spaces(&mut self, is_gone: impl Fn(usize) -> bool) {
        let mut gone = vec![false; self.spaces.len()];
        for (number, space) in self.spaces.iter().enumerate() {
            gone[number] = is_gone(number) || space.parent.is_some_and(|parent| gone[parent]);
        }
        let stays = |space: Option<usize>| space.is_none_or(|space| !gone[space]);
        self.objects.retain(|object| stays(object.space));
        self.lamps.retain(|lamp| stays(lamp.space));
    }

    /// Drops meshes without an area, which slo-rt refuses.
    pub(crate) fn drop_hollow(&mut self) {
        let Self { objects, meshes, notes, .. } = self;
        objects.retain(|object| {
            let Shape::Mesh(mesh) = object.shape else { return true };
            let (has_area, triangles) = (meshes[mesh].has_area(), meshes[mesh].triangles());
            if !has_area {
                notes.leave_out_many("a triangle without an area", triangles);
            }
            has_area
        });
    }

    /// Drops materials that nothing has, and images that no material shows.
    pub(crate) fn drop_unused(&mut self) {
        let used = self.objects.iter_mut().map(|object| &mut object.material);
        keep_used(&mut self.materials, used.collect());
        let images = self.materials.iter_mut().flat_map(|material| &mut material.images);
        keep_used(&mut self.images, images.map(|(_, of)| &mut of.image).collect());
    }

    /// The corners of the box around everything at time 0; `None` without anything.
    pub(crate) fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut bounds: Option<[DVec3; 2]> = None;
        let mut add = |point: DVec3| {
            let [least, most] = bounds.unwrap_or([point; 2]);
            bounds = Some([least.min(point), most.max(point)]);
        };
        for object in &self.objects {
            let matrix = self.matrix(object.space, 0.0);
            let mut add_ball = |center: DVec3, radius: f64| {
                let center = matrix.transform_point3(center);
                let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
                let radius =
                    axes.map(|axis| axis.length()).into_iter().fold(0.0, f64::max) * radius;
                add(center - radius);
                add(center + radius);
            };
            match &object.shape {
                Shape::Mesh(mesh) => self.meshes[*mesh].each_point(|p| add_ball(p, 0.0)),
                Shape::Changing { first, .. } => {
                    self.meshes[*first].each_point(|p| add_ball(p, 0.0));
                }
                Shape::Sphere { center, radius } => add_ball(*center, *radius),
                Shape::Cylinder { base, top, radius } => {
                    add_ball(*base, *radius);
                    add_ball(*top, *radius);
                }
                Shape::Cone { base, apex, radius } => {
                    add_ball(*base, *radius);
                    add_ball(*apex, 0.0);
                }
                Shape::Box { half } => {
                    for corner in 0..8 {
                        let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                        add_ball(*half * DVec3::new(sign(0), sign(1), sign(2)), 0.0);
                    }
                }
            }
        }
        bounds
    }
}

/// Keeps the things that these indices name, and changes the indices with them.
fn keep_used<T>(things: &mut Vec<T>, indices: Vec<&mut usize>) {
    let mut places = vec![None; things.len()];
    for index in &indices {
        places[**index] = Some(0);
    }
    let mut is_used = places.iter().map(Option::is_some).collect::<Vec<_>>().into_iter();
    things.retain(|_| is_used.next().unwrap_or(false));
    for (new, place) in places.iter_mut().flatten().enumerate() {
        *place = new;
    }
    for index in indices {
        *index = places[*index].unwrap_or_default();
    }
}

/// The pose at a time, between key frames.
pub(crate) fn pose_at(keys: &[Key], time: f64) -> Pose {
    let after = keys.partition_point(|key| key.time <= time);
    let Some(before) = after.checked_sub(1) else {
        return keys.first().map(|k| k.pose).unwrap_or_default();
    };
    let (a, Some(b)) = (&keys[before], keys.get(after)) else { return keys[before].pose };
    let t = (time - a.time) / (b.time - a.time);
    Pose {
        pivot: a.pose.pivot.lerp(b.pose.pivot, t),
        turn: a.pose.turn.slerp(b.pose.turn, t),
        scale: a.pose.scale.lerp(b.pose.scale, t),
    }
}
