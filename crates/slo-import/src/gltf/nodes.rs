//! The hierarchy: what hangs in what, and where.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::scene::Transform;
use gltf::{Document, Node};

use super::accessor::Buffers;
use super::animation::{Animation, STEPS};
use super::buffers::{Bytes, Left};
use super::mesh::{Part, parts};
use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Camera, Lamp, LampKind, Model, Object, Pose, Shape, Space, Times, View};
use crate::view::SIZE;

/// Lumens of a watt, as Blender converts them.
const LUMENS: f64 = 683.0;

/// Deepest hierarchy.
const DEEPEST: usize = 200;

/// Most numbers of all shapes of meshes that bones or morph targets change.
const MOST_SHAPE_VERTICES: usize = 40_000_000;

/// Reads the scene of a file.
pub(super) fn read(
    source: &Source,
    document: &Document,
    bytes: &[Bytes],
    left: &Left,
    sets: &[u32],
    model: &mut Model,
) -> Result<(), ImportError> {
    let buffers = Buffers { source, bytes, left };
    let animation = Animation::read(buffers, document, &mut model.notes)?;
    model.duration = animation.duration;
    let count = document.nodes().count();
    let mut meshes = Vec::new();
    for mesh in document.meshes() {
        let parts = parts(buffers, &mesh, sets, &mut model.notes)?;
        meshes.push(parts.into_iter().map(|part| (part, None)).collect());
    }
    let tree =
        Tree { parents: vec![None; count], is_reached: vec![false; count], ..Tree::default() };
    let (plain, tints) = (model.materials.len() - 1, HashMap::new());
    let mut reader =
        Reader { buffers, animation, model, meshes, tree, plain, tints, shape_vertices: 0 };
    reader.root(source);
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<Node<'_>> = match scene {
        Some(scene) => scene.nodes().collect(),
        None => document.nodes().collect(),
    };
    for node in roots {
        reader.enter(&node, None, 0)?;
    }
    for node in document.nodes() {
        if reader.tree.is_reached[node.index()] {
            reader.add(&node)?;
        }
    }
    reader.cameras(document);
    Ok(())
}

/// Where nodes hang.
#[derive(Default)]
struct Tree {
    parents: Vec<Option<usize>>,
    is_reached: Vec<bool>,
    /// The space of each node that was entered.
    spaces: HashMap<usize, usize>,
}

struct Reader<'a> {
    buffers: Buffers<'a>,
    animation: Animation,
    model: &'a mut Model,
    /// The parts of all meshes, and the meshes of the model that they became.
    meshes: Vec<Vec<(Part, Option<usize>)>>,
    tree: Tree,
    /// The material of primitives without one.
    plain: usize,
    /// Materials by the materials and the colours that made them.
    tints: HashMap<(usize, [u32; 3]), usize>,
    shape_vertices: usize,
}

/// The space of the file, where y is up.
const ROOT: usize = 0;

impl Reader<'_> {
    fn root(&mut self, source: &Source) {
        self.model.spaces.push(Space::y_up(source.stem()));
    }

    /// Notes where a node and all that hangs in it are, if anything in it can be seen.
    fn enter(
        &mut self,
        node: &Node<'_>,
        parent: Option<usize>,
        depth: usize,
    ) -> Result<bool, ImportError> {
        let index = node.index();
        if depth > DEEPEST || std::mem::replace(&mut self.tree.is_reached[index], true) {
            let message = format!(
                "node {index} hangs in itself, in several nodes, or more than {DEEPEST} deep"
            );
            return Err(self.buffers.source.bad(message));
        }
        self.tree.parents[index] = parent;
        let space = self.model.spaces.len();
        let place = parent.map_or(ROOT, |parent| self.tree.spaces[&parent]);
        let name = node.name().unwrap_or("node").to_owned();
        let (rest, is_exact) = pose_of(&node.transform());
        if !is_exact {
            self.model.notes.leave_out("that a node is skewed by its matrix");
        }
        let keys = self.animation.keys(index, rest);
        self.model.spaces.push(Space { name, parent: Some(place), keys });
        self.tree.spaces.insert(index, space);
        let mut is_needed =
            node.mesh().is_some() || node.light().is_some() || node.camera().is_some();
        for child in node.children() {
            is_needed |= self.enter(&child, Some(index), depth + 1)?;
        }
        Ok(is_needed)
    }

    fn add(&mut self, node: &Node<'_>) -> Result<(), ImportError> {
        if let Some(light) = node.light() {
            self.light(node, &light);
        }
        if let Some(mesh) = node.mesh() {
            self.mesh(node, mesh.index())?;
        }
        Ok(())
    }

    fn light(&mut self, node: &Node<'_>, light: &gltf::khr_lights_punctual::Light<'_>) {
        let (color, intensity) = (light.color().map(f64::from), f64::from(light.intensity()));
        let times = |factor: f64| color.map(|c| (c * intensity * factor).max(0.0));
        let whole = 4.0 * std::f64::consts::PI / LUMENS;
        let kind = match light.kind() {
            Kind::Directional => LampKind::Sun { irradiance: times(1.0 / LUMENS) },
            Kind::Point => LampKind::Point { power: times(whole) },
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let (inner, outer) = (f64::from(inner_cone_angle), f64::from(outer_cone_angle));
                let outer = outer.clamp(1e-3, std::f64::consts::FRAC_PI_2);
                // A lamp's power is what leaves its cone; intensity is that of the middle.
                let cone = (1.0 - libm::cos(outer)) / 2.0;
                LampKind::Spot {
                    power: times(whole * cone),
                    angle_deg: (2.0 * outer).to_degrees(),
                    blend: (1.0 - inner / outer).clamp(0.0, 1.0),
                }
            }
        };
        if light.range().is_some() {
            self.model.notes.leave_out("the range of a light, beyond which it would be off");
        }
        let name = light.name().or(node.name()).unwrap_or("lamp").to_owned();
        let space = Some(self.tree.spaces[&node.index()]);
        self.model.lamps.push(Lamp { name, space, kind });
    }

    fn mesh(&mut self, node: &Node<'_>, mesh: usize) -> Result<(), ImportError> {
        let bones = self.bones_of(node)?;
        for number in 0..self.meshes[mesh].len() {
            let (part, _) = &self.meshes[mesh][number];
            let material = part.material.unwrap_or(self.plain);
            let material = match part.tint {
                Some(tint) => tinted(&mut self.tints, material, tint, self.model),
                None => material,
            };
            let changes = part.can_change() && self.is_changed(node, part, &bones);
            let has_shape = part.can_change()
                && (self.weights(node, 0.0).iter().any(|w| *w != 0.0) || part.has_bones());
            let space = if part.has_bones() { ROOT } else { self.tree.spaces[&node.index()] };
            let name = node.name().map_or_else(|| part.mesh.name.clone(), str::to_owned);
            let shape = if changes {
                self.changing(node, (mesh, number), &bones)
            } else if has_shape {
                let shaped = self.shaped(node, (mesh, number), &bones, 0.0);
                self.model.meshes.push(shaped);
                Shape::Mesh(self.model.meshes.len() - 1)
            } else {
                Shape::Mesh(self.resting(mesh, number))
            };
            self.model.objects.push(Object {
                name,
                space: Some(space),
                material,
                shape,
                is_hidden: false,
            });
        }
        Ok(())
    }

    /// The mesh of the model that a part is, which all nodes share.
    fn resting(&mut self, mesh: usize, number: usize) -> usize {
        let (part, place) = &mut self.meshes[mesh][number];
        *place.get_or_insert_with(|| {
            self.model.meshes.push(part.mesh.clone());
            self.model.meshes.len() - 1
        })
    }

    fn weights(&self, node: &Node<'_>, time: f64) -> Vec<f64> {
        let animated = self.animation.weights(node.index(), time);
        let usual = node.weights().or_else(|| node.mesh().and_then(|mesh| mesh.weights()));
        animated.unwrap_or_else(|| usual.unwrap_or(&[]).iter().map(|&w| f64::from(w)).collect())
    }

    /// The bones of a node's skin: nodes, and the matrices that take the mesh to them.
    fn bones_of(&self, node: &Node<'_>) -> Result<Vec<(usize, DMat4)>, ImportError> {
        let Some(skin) = node.skin() else { return Ok(Vec::new()) };
        let inverse: Vec<[f32; 16]> = match skin.inverse_bind_matrices() {
            Some(matrices) => self.buffers.read(&matrices)?,
            None => Vec::new(),
        };
        let matrix = |i: usize| {
            inverse.get(i).map_or(DMat4::IDENTITY, |m| DMat4::from_cols_array(&m.map(f64::from)))
        };
        let joints = skin.joints().enumerate();
        Ok(joints.map(|(i, joint)| (joint.index(), matrix(i))).collect())
    }

    fn is_changed(&self, node: &Node<'_>, part: &Part, bones: &[(usize, DMat4)]) -> bool {
        let moves = |node: usize| {
            let mut next = Some(node);
            while let Some(node) = next {
                if self.animation.changes(node) {
                    return true;
                }
                next = self.tree.parents[node];
            }
            false
        };
        self.animation.weights(node.index(), 0.0).is_some()
            || part.has_bones() && bones.iter().any(|(bone, _)| moves(*bone))
    }

    /// The mesh in the space of the file, as bones and weights shape it at a time.
    fn shaped(
        &self,
        node: &Node<'_>,
        (mesh, number): (usize, usize),
        bones: &[(usize, DMat4)],
        time: f64,
    ) -> crate::model::Mesh {
        // Matrices of bones lead to the scene; the mesh hangs in the space of the file.
        let root = self.model.matrix(Some(ROOT), 0.0).inverse();
        let matrix = |&(bone, inverse): &(usize, DMat4)| {
            let space = self.tree.spaces.get(&bone).copied();
            root * self.model.matrix(space.or(Some(ROOT)), time) * inverse
        };
        let bones: Vec<DMat4> = bones.iter().map(matrix).collect();
        self.meshes[mesh][number].0.shaped(&self.weights(node, time), &bones)
    }

    fn changing(
        &mut self,
        node: &Node<'_>,
        place: (usize, usize),
        bones: &[(usize, DMat4)],
    ) -> Shape {
        let steps = (self.animation.duration * STEPS).ceil().max(1.0) as usize;
        self.shape_vertices += steps * self.meshes[place.0][place.1].0.mesh.positions.len();
        if self.shape_vertices > MOST_SHAPE_VERTICES {
            self.model
                .notes
                .leave_out("how bones or morph targets move a mesh: its files would be too large");
            let shaped = self.shaped(node, place, bones, 0.0);
            self.model.meshes.push(shaped);
            return Shape::Mesh(self.model.meshes.len() - 1);
        }
        let first = self.model.meshes.len();
        for step in 0..=steps {
            let shaped = self.shaped(node, place, bones, step as f64 / STEPS);
            self.model.meshes.push(shaped);
        }
        Shape::Changing { first, count: steps + 1, times: Times::Even(STEPS) }
    }

    /// The first camera that is shown.
    fn cameras(&mut self, document: &Document) {
        let all = document.nodes().filter(|node| self.tree.is_reached[node.index()]);
        let mut all = all.filter_map(|node| node.camera().map(|camera| (node, camera)));
        let Some((node, camera)) = all.next() else { return };
        for _ in all {
            self.model.notes.leave_out("a further camera");
        }
        let (fov, aspect) = match camera.projection() {
            Projection::Perspective(view) => {
                (libm::tan(f64::from(view.yfov()) / 2.0), view.aspect_ratio().map(f64::from))
            }
            Projection::Orthographic(_) => {
                self.model.notes.leave_out("an orthographic camera, which became a distant one");
                (0.05, None)
            }
        };
        let space = Some(self.tree.spaces[&node.index()]);
        let moves = self.model.moves(space);
        let steps = if moves { (self.model.duration * STEPS).ceil().max(1.0) as usize } else { 0 };
        let distance =
            self.model.bounds().map_or(1.0, |[least, most]| (most - least).length().max(1e-3));
        let view = |time: f64| {
            let matrix = self.model.matrix(space, time);
            let position = matrix.transform_point3(DVec3::ZERO);
            let ahead = matrix.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::Y);
            let up = matrix.transform_vector3(DVec3::Y).normalize_or(DVec3::Z);
            View { position, target: position + ahead * distance, up }
        };
        let last = self.model.duration.max(1.0 / STEPS);
        let views =
            (0..=steps).map(|step| view(last * step as f64 / steps.max(1) as f64)).collect();
        let height = SIZE[1];
        let width = aspect.map_or(f64::from(SIZE[0]), |aspect| f64::from(height) * aspect);
        let size = [width.round().clamp(16.0, 16384.0) as u32, height];
        if fov.is_finite() && fov > 0.0 {
            self.model.camera = Some(Camera { size, fov, views });
        }
    }
}

/// A material whose colour is multiplied by another.
fn tinted(
    known: &mut HashMap<(usize, [u32; 3]), usize>,
    material: usize,
    tint: [f32; 3],
    model: &mut Model,
) -> usize {
    *known.entry((material, tint.map(f32::to_bits))).or_insert_with(|| {
        let mut tinted = model.materials[material].clone();
        let colors = &mut tinted.colors;
        let base = colors.iter().position(|(input, _)| *input == "base_color");
        let base = base.unwrap_or_else(|| {
            colors.push(("base_color", [1.0; 3]));
            colors.len() - 1
        });
        for (channel, tint) in colors[base].1.iter_mut().zip(tint) {
            *channel *= f64::from(tint.clamp(0.0, 1.0));
        }
        model.materials.push(tinted);
        model.materials.len() - 1
    })
}

/// A pose, and whether it says the same as the transform.
fn pose_of(transform: &Transform) -> (Pose, bool) {
    match transform {
        Transform::Decomposed { translation, rotation, scale } => {
            let turn = DQuat::from_array(rotation.map(f64::from));
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
            let vector = |v: &[f32; 3]| DVec3::from(v.map(f64::from));
            (Pose { pivot: vector(translation), turn, scale: vector(scale) }, true)
        }
        Transform::Matrix { matrix } => {
            let matrix = DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)));
            let (scale, turn, pivot) = matrix.to_scale_rotation_translation();
            let pose = Pose { pivot, turn: turn.normalize(), scale };
            let size =
                matrix.to_cols_array().into_iter().fold(1.0, |most: f64, n| most.max(n.abs()));
            (pose, pose.matrix().abs_diff_eq(matrix, 1e-4 * size))
        }
    }
}
