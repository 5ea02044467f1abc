//! Which vertices of a mesh are shown: those on this side of it that are near a place of the picture.

use std::collections::BTreeSet;

use glam::DVec3;
use slo_scene::Mesh;
use slo_scene::animation::{DAffine, View};

use crate::camera::axes;

/// What the camera sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eye {
    position: DVec3,
    axes: [DVec3; 3],
    /// Half the width and half the height of the view at distance 1.
    half: [f64; 2],
}

impl Eye {
    /// What is seen in a picture whose width is `aspect` times its height.
    pub(crate) fn new(view: &View, aspect: f64) -> Self {
        Self { position: view.position, axes: axes(view), half: [view.fov * aspect, view.fov] }
    }

    /// Where a point is in the picture, from 0 to 1 to the right and down; `None` if it is outside.
    fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let way = point - self.position;
        let [right, up, forward] = self.axes.map(|axis| axis.dot(way));
        let at = [right / (forward * self.half[0]), up / (forward * self.half[1])];
        let is_inside = forward > 0.0 && at.iter().all(|part| part.abs() <= 1.0);
        is_inside.then_some([(at[0] + 1.0) * 0.5, (1.0 - at[1]) * 0.5])
    }
}

/// Returns at most so many vertices of a mesh at different places, with their places in scene space: those
/// of faces that face the camera and are nearest to a place of the picture; and whether these are all.
/// `pose` places the mesh.
pub(crate) fn near(
    mesh: &Mesh,
    pose: &DAffine,
    eye: &Eye,
    at: [f64; 2],
    most: usize,
) -> (Vec<(u32, DVec3)>, bool) {
    let places: Vec<DVec3> = mesh.positions.iter().map(|p| pose.point(*p)).collect();
    let front = facing(mesh, &places, eye.position);
    let is_seen = |vertex: usize| front.as_ref().is_none_or(|front| front[vertex]);
    let aspect = eye.half[0] / eye.half[1];
    let mut found: Vec<(f64, u32)> = Vec::new();
    for (vertex, place) in places.iter().enumerate().filter(|(vertex, _)| is_seen(*vertex)) {
        if let Some([x, y]) = eye.project(*place) {
            let [dx, dy] = [(x - at[0]) * aspect, y - at[1]];
            found.push((dx * dx + dy * dy, vertex as u32));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let bits = |point: DVec3| point.to_array().map(f64::to_bits);
    let mut known = BTreeSet::new();
    let different = found.into_iter().map(|(_, vertex)| (vertex, places[vertex as usize]));
    let mut different = different.filter(|(_, place)| known.insert(bits(*place)));
    let mut shown: Vec<_> = different.by_ref().take(most).collect();
    let is_all = different.next().is_none();
    shown.sort_by_key(|(vertex, _)| *vertex);
    (shown, is_all)
}

/// Whether vertices belong to faces that face a point. `None` if no face does.
fn facing(mesh: &Mesh, places: &[DVec3], from: DVec3) -> Option<Vec<bool>> {
    let mut front = vec![false; places.len()];
    let mut any = false;
    for face in &mesh.faces {
        let [a, b, c] = face.map(|vertex| places[vertex as usize]);
        if (b - a).cross(c - a).dot(from - a) > 0.0 {
            any = true;
            face.iter().for_each(|vertex| front[*vertex as usize] = true);
        }
    }
    any.then_some(front)
}

/// All vertices at the place of one, which move together: a mesh has several where its sides meet.
pub(crate) fn together(mesh: &Mesh, vertex: u32) -> Vec<u32> {
    let Some(at) = mesh.positions.get(vertex as usize) else { return Vec::new() };
    let same = mesh.positions.iter().zip(0..).filter(|(position, _)| *position == at);
    same.map(|(_, vertex)| vertex).collect()
}

#[cfg(test)]
mod tests {
    use slo_scene::animation::DRigid;

    use super::*;

    /// A square before and a square behind, which look at the camera and away from it; vertex 8 lies at
    /// the place of vertex 0.
    fn mesh() -> Mesh {
        let square = |y: f64| [[-1.0, y, -1.0], [1.0, y, -1.0], [1.0, y, 1.0], [-1.0, y, 1.0]];
        let mut positions: Vec<_> = square(0.0).into_iter().chain(square(1.0)).collect();
        positions.push(positions[0]);
        Mesh {
            positions: positions.into_iter().map(DVec3::from).collect(),
            faces: vec![[0, 1, 2], [8, 2, 3], [4, 6, 5], [4, 7, 6]],
            ..Mesh::default()
        }
    }

    #[test]
    fn the_nearest_vertices_in_front_are_shown_once() {
        let view = View {
            position: DVec3::new(0.0, -10.0, 0.0),
            target: DVec3::ZERO,
            sky: DVec3::Z,
            fov: 0.5,
            dof: 1.0,
            lens_radius: 0.0,
        };
        let eye = Eye::new(&view, 1.0);
        let pose = DAffine::from(DRigid::IDENTITY);
        let shown = |at, most| -> Vec<u32> {
            let (shown, is_all) = near(&mesh(), &pose, &eye, at, most);
            assert_eq!(is_all, most > 3);
            shown.into_iter().map(|(vertex, _)| vertex).collect()
        };
        assert_eq!(shown([0.5, 0.5], 9), [0, 1, 2, 3]);
        assert_eq!(shown([1.0, 0.0], 1), [2]);
        assert_eq!(shown([0.0, 1.0], 1), [0]);
        assert_eq!(together(&mesh(), 8), [0, 8]);
        assert_eq!(together(&mesh(), 99), [0; 0]);
        let back = Eye::new(&View { target: DVec3::new(0.0, -20.0, 0.0), ..view }, 1.0);
        assert!(near(&mesh(), &pose, &back, [0.5; 2], 9).0.is_empty());
    }
}
