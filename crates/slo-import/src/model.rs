//! What files of other programs say, in the words of slo-rt.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};

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
    /// Seconds that the animation takes; 0 for a still.
    pub(crate) duration: f64,
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
        *self.left_out.entry(what.into()).or_default() += 1;
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

    /// Whether key frames can say it.
    pub(crate) fn can_be_said(&self) -> bool {
        self.scale.min_element() > 0.0
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
    /// The space of a file in which y is up.
    pub(crate) fn y_up(name: String) -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = DQuat::from_xyzw(half, 0.0, 0.0, half);
        let key = Key { time: 0.0, pose: Pose { turn, ..Pose::default() } };
        Self { name, parent: None, keys: vec![key] }
    }
}

/// A shape of a material in a space.
#[derive(Debug)]
pub(crate) struct Object {
    pub(crate) name: String,
    pub(crate) space: Option<usize>,
    pub(crate) material: usize,
    pub(crate) shape: Shape,
}

#[derive(Debug)]
pub(crate) enum Shape {
    Mesh(usize),
    /// Meshes with the same faces: the first of this number at time 0, and the next ones at so many a
    /// second.
    Changing {
        first: usize,
        count: usize,
        fps: f64,
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
}

/// Triangles. Normals and texture coordinates belong to vertices, and are empty if there are none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) name: String,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) faces: Vec<[u32; 3]>,
    /// Faces with more corners, which slo-rt itself divides.
    pub(crate) polygons: Vec<Vec<u32>>,
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

/// Inputs of a material, under the names of the scene language.
#[derive(Debug, Default)]
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

    /// Drops meshes without an area, which slo-rt refuses.
    pub(crate) fn drop_hollow(&mut self) {
        let Self { objects, meshes, notes, .. } = self;
        objects.retain(|object| {
            let has_area = match object.shape {
                Shape::Mesh(mesh) => meshes[mesh].has_area(),
                _ => true,
            };
            if !has_area {
                notes.leave_out("a mesh without an area");
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

impl Mesh {
    /// Whether any face may have an area.
    fn has_area(&self) -> bool {
        let corner = |i: u32| glam::Vec3::from(self.positions[i as usize]);
        let has_area = |&[a, b, c]: &[u32; 3]| {
            let (x, y) = (corner(b) - corner(a), corner(c) - corner(a));
            x.cross(y) != glam::Vec3::ZERO
        };
        !self.polygons.is_empty() || self.faces.iter().any(has_area)
    }

    /// Number of triangles.
    pub(crate) fn triangles(&self) -> usize {
        self.faces.len() + self.polygons.iter().map(|polygon| polygon.len() - 2).sum::<usize>()
    }

    fn each_point(&self, mut of: impl FnMut(DVec3)) {
        for &[x, y, z] in &self.positions {
            of(DVec3::new(x.into(), y.into(), z.into()));
        }
    }

    /// The mesh as a matrix places it. Faces turn round where it mirrors.
    pub(crate) fn transformed(&self, matrix: DMat4) -> Self {
        let place = |p: &[f32; 3]| {
            matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3().to_array()
        };
        // The cofactors: the inverse transpose times the determinant, which also serves flat matrices.
        let (x, y, z) =
            (matrix.x_axis.truncate(), matrix.y_axis.truncate(), matrix.z_axis.truncate());
        let (a, b, c) = (y.cross(z), z.cross(x), x.cross(y));
        let sign = if a.dot(x) < 0.0 { -1.0 } else { 1.0 };
        let bend = |n: &[f32; 3]| {
            let [nx, ny, nz] = n.map(f64::from);
            ((a * nx + b * ny + c * nz) * sign).normalize_or_zero().as_vec3().to_array()
        };
        let face = |&[i, j, k]: &[u32; 3]| if sign < 0.0 { [i, k, j] } else { [i, j, k] };
        let turn = |polygon: &Vec<u32>| {
            let mut polygon = polygon.clone();
            if sign < 0.0 {
                polygon.reverse();
            }
            polygon
        };
        Self {
            name: self.name.clone(),
            positions: self.positions.iter().map(place).collect(),
            normals: self.normals.iter().map(bend).collect(),
            uvs: self.uvs.clone(),
            faces: self.faces.iter().map(face).collect(),
            polygons: self.polygons.iter().map(turn).collect(),
        }
    }
}
