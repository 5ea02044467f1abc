//! The scene that shapes are added to.

use std::collections::HashMap;

use glam::DMat4;

use super::ROOT;
use super::looks::Looks;
use super::state::State;
use crate::model::{KnownMeshes, Mesh, Model, Object, Pose, Shape, Space};

/// The model, and what it has already.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) model: Model,
    pub(super) looks: Looks,
    meshes: KnownMeshes,
    /// Spaces by their matrices.
    spaces: HashMap<[u64; 16], Option<usize>>,
    /// How many corners of faces there are.
    pub(super) corners: usize,
}

impl Scene {
    pub(super) fn new(model: Model) -> Self {
        let (looks, meshes, spaces) = (Looks::default(), KnownMeshes::default(), HashMap::new());
        Self { model, looks, meshes, spaces, corners: 0 }
    }

    /// Adds a mesh in the space of the state.
    pub(super) fn mesh(&mut self, mesh: Mesh, material: usize, state: &State) {
        self.corners += mesh.positions.len() + 3 * mesh.triangles();
        let (mesh, space) = match self.space(state.matrix) {
            Some(space) => (mesh, space),
            None => (mesh.transformed(state.matrix), ROOT),
        };
        let name = mesh.name.clone();
        let mesh = self.meshes.number(mesh, &mut self.model.meshes);
        self.object(name, space, material, Shape::Mesh(mesh), state);
    }

    /// Adds a solid, unless it is too much skewed to be one.
    pub(super) fn solid(&mut self, name: String, shape: Shape, state: &State) -> bool {
        let Some(space) = self.space(state.matrix) else { return false };
        let material = self.looks.material(&[0], state, &mut self.model);
        self.object(name, space, material, shape, state);
        true
    }

    fn object(&mut self, name: String, space: usize, material: usize, shape: Shape, state: &State) {
        if state.is_outlined {
            let note = "that something is drawn as lines or points: it is hidden";
            self.model.notes.leave_out(note);
        }
        let is_hidden = state.is_hidden || state.is_outlined;
        self.model.objects.push(Object { name, space: Some(space), material, shape, is_hidden });
    }

    /// The space of a matrix; `None` if key frames can't say it.
    fn space(&mut self, matrix: DMat4) -> Option<usize> {
        if matrix == DMat4::IDENTITY {
            return Some(ROOT);
        }
        let key = matrix.to_cols_array().map(f64::to_bits);
        *self.spaces.entry(key).or_insert_with(|| {
            let pose = pose(matrix)?;
            let spaces = &mut self.model.spaces;
            spaces.push(Space::still("place".into(), Some(ROOT), pose));
            Some(spaces.len() - 1)
        })
    }
}

/// A matrix as a pose, if it is one.
fn pose(matrix: DMat4) -> Option<Pose> {
    let (scale, turn, pivot) = matrix.to_scale_rotation_translation();
    let pose = Pose { pivot, turn: turn.normalize(), scale };
    let size = matrix.to_cols_array().into_iter().fold(0.0, |most: f64, n| most.max(n.abs()));
    (turn.is_finite() && pose.matrix().abs_diff_eq(matrix, 1e-7 * size)).then_some(pose)
}

/// The part of a name that a person chose; programs write names such as `+3` and `leg+12`.
pub(super) fn name_of(name: &str) -> Option<String> {
    let name = name.split('+').next().unwrap_or_default();
    (!name.is_empty()).then(|| name.to_owned())
}
