//! How the mesh of a file stands in a scene: which way is up, and how large it is.

use glam::DVec3;

use super::data::Mesh;
use crate::settings::Axes;

impl Mesh {
    /// Turns the mesh of a file with such axes so that z is up.
    pub(crate) fn stand_up(&mut self, axes: Axes) {
        match axes {
            Axes::ZUp => {}
            Axes::YUp => {
                self.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x, -p.z, p.y));
                self.normals.iter_mut().for_each(|[x, y, z]| [*x, *y, *z] = [*x, -*z, *y]);
            }
        }
    }

    /// Scales the mesh about its origin so that the longest side of the box around its triangles has
    /// a length.
    pub(crate) fn fit(&mut self, size: f64) {
        let corners = self.faces.as_flattened().iter().map(|&i| self.positions[i as usize]);
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = corners.fold(empty, |[min, max], p| [min.min(p), max.max(p)]);
        // A triangle with an area has a longest side of more than 0.
        let factor = size / (max - min).max_element();
        self.positions.iter_mut().for_each(|position| *position *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Mesh {
        let positions = [[1.0, 1.0, 1.0], [1.0, 5.0, 1.0], [3.0, 1.0, 2.0], [9e9, 0.0, 0.0]];
        Mesh {
            positions: positions.map(DVec3::from_array).to_vec(),
            faces: vec![[0, 1, 2]],
            normals: vec![[0.0, 0.6, 0.8]; 4],
            ..Mesh::default()
        }
    }

    #[test]
    fn y_becomes_z_by_a_rotation() {
        let mut mesh = corner();
        mesh.stand_up(Axes::ZUp);
        assert_eq!(mesh, corner());
        mesh.stand_up(Axes::YUp);
        assert_eq!(mesh.positions[2], DVec3::new(3.0, -2.0, 1.0));
        assert_eq!(mesh.normals[0], [0.0, -0.8, 0.6]);
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let mut mesh = Mesh { positions: vec![axis], ..Mesh::default() };
            mesh.stand_up(Axes::YUp);
            mesh.positions[0]
        });
        assert_eq!((y, x.cross(y)), (DVec3::Z, z));
    }

    #[test]
    fn the_longest_side_of_the_triangles_gets_the_size() {
        let mut mesh = corner();
        mesh.fit(2.0);
        assert_eq!(mesh.positions[0], DVec3::splat(0.5));
        assert_eq!(mesh.positions[1], DVec3::new(0.5, 2.5, 0.5));
        assert_eq!(mesh.positions[2], DVec3::new(1.5, 0.5, 1.0));
    }
}
