//! Which faces lie in which texels.

use glam::DVec2;

/// How far, in texels, a face must reach into a texel to lie in it.
const LEAST_REACH: f64 = 1e-4;

/// How far, in texels, the middle of a texel must lie inside two faces that overlap there.
const LEAST_OVERLAP: f64 = 0.05;

/// How far, in texels, a place at the edge of a face is moved into the face: rays that start exactly in
/// a corner of a room would see the outside.
const INWARD: f64 = 0.02;

/// Faces of a texel in the mean, and texels of a face, that are no accident. Beyond both, texture
/// coordinates are piled up.
const MOST_FACES: usize = 64;
const MOST_TEXELS: usize = 16;

/// How faces lie in a square image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    side: u32,
    /// Corners of the faces in texels, rightward and downward.
    corners: Vec<[[f32; 2]; 3]>,
    /// For each texel, row by row, where its faces begin in `faces`; one more at the end.
    starts: Vec<u32>,
    /// Indices of faces, ascending in each texel.
    faces: Vec<u32>,
}

/// A place on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Index of the face.
    pub face: u32,
    /// Weights of its second and its third corner.
    pub weights: [f32; 2],
    /// Area of the face in texels.
    pub area: f32,
}

impl Layout {
    /// Finds the texels of faces with these texture coordinates: all that a face touches. `None` if
    /// there are far too many faces for the texels.
    pub fn new(faces: &[[[f32; 2]; 3]], side: u32) -> Option<Self> {
        let scale = side as f32;
        let in_texels = |[u, v]: [f32; 2]| [u * scale, (1.0 - v) * scale];
        let corners: Vec<_> = faces.iter().map(|face| face.map(in_texels)).collect();
        let texels = (side as usize).pow(2);
        let most = MOST_FACES * texels + MOST_TEXELS * faces.len();
        let most = most.min(u32::MAX as usize);
        let (mut starts, mut all) = (vec![0_u32; texels + 1], 0);
        for face in &corners {
            touched(face, side, |texel| {
                starts[texel + 1] += 1;
                all += 1;
            });
            if all > most {
                return None;
            }
        }
        for i in 0..texels {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut listed = vec![0; all];
        for (number, face) in (0..).zip(&corners) {
            touched(face, side, |texel| {
                listed[next[texel] as usize] = number;
                next[texel] += 1;
            });
        }
        Some(Self { side, corners, starts, faces: listed })
    }

    /// Number of texels along each side.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Whether any face lies in a texel, in column `x` and row `y` from the top.
    pub fn is_covered(&self, x: u32, y: u32) -> bool {
        !self.at(x, y).is_empty()
    }

    /// The faces that lie in a texel.
    fn at(&self, x: u32, y: u32) -> &[u32] {
        let texel = y as usize * self.side as usize + x as usize;
        &self.faces[self.starts[texel] as usize..self.starts[texel + 1] as usize]
    }

    /// Returns the place of a point of a texel; `within` is from 0 to 1 rightward and downward. A point
    /// that lies on no face stands for the nearest place of a face in the texel. `None` if there is no
    /// face.
    pub fn place(&self, x: u32, y: u32, within: [f32; 2]) -> Option<Place> {
        let point = DVec2::new(f64::from(x), f64::from(y)) + DVec2::from(within.map(f64::from));
        let (mut nearest, mut square) = (None, f64::INFINITY);
        for &number in self.at(x, y) {
            let face = Face::new(&self.corners[number as usize])?;
            let there = face.nearest(point);
            let distance = there.distance_squared(point);
            if distance < square {
                (nearest, square) = (Some((number, face, there)), distance);
            }
            if distance == 0.0 {
                break;
            }
        }
        let (number, face, there) = nearest?;
        let there = if square == 0.0 { there } else { face.inward(there) };
        let weights = face.weights(there).map(|weight| weight.clamp(0.0, 1.0) as f32);
        Some(Place { face: number, weights, area: (0.5 * face.double_area) as f32 })
    }

    /// Returns the number of texels whose middle lies in several faces.
    pub fn overlapping(&self) -> usize {
        let side = self.side;
        let overlaps = |x: u32, y: u32| {
            let faces = self.at(x, y);
            if faces.len() < 2 {
                return false;
            }
            let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let is_inside = |number: &&u32| {
                let face = Face::new(&self.corners[**number as usize]);
                face.is_some_and(|face| face.depth(middle) > LEAST_OVERLAP)
            };
            faces.iter().filter(is_inside).count() > 1
        };
        let all = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
        all.filter(|&(x, y)| overlaps(x, y)).count()
    }
}

/// A triangle in an image, in texels.
struct Face {
    /// In such an order that all edges have the triangle on one side.
    corners: [DVec2; 3],
    /// Whether the order of the second and third corner was changed.
    is_mirrored: bool,
    double_area: f64,
}

impl Face {
    /// `None` for triangles without an area.
    fn new(corners: &[[f32; 2]; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| DVec2::from(corner.map(f64::from)));
        let double_area = (b - a).perp_dot(c - a);
        if !double_area.is_finite() || double_area == 0.0 {
            return None;
        }
        let is_mirrored = double_area < 0.0;
        let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
        Some(Self { corners, is_mirrored, double_area: double_area.abs() })
    }

    fn edges(&self) -> [[DVec2; 2]; 3] {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]]
    }

    /// Returns how far inside the triangle a point lies; negative outside.
    fn depth(&self, point: DVec2) -> f64 {
        let depth = |[a, b]: [DVec2; 2]| (b - a).perp_dot(point - a) / (b - a).length();
        self.edges().map(depth).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether the triangle reaches into the texel whose first corner is `low`. Texels are tested
    /// within its bounding box.
    fn reaches(&self, low: DVec2) -> bool {
        self.edges().into_iter().all(|[a, b]| {
            let way = (b - a).normalize_or_zero();
            let inward = DVec2::new(-way.y, way.x);
            let corner = low + DVec2::new(corner_of(inward.x), corner_of(inward.y));
            inward.dot(corner - a) > LEAST_REACH
        })
    }

    /// Returns the point of the triangle that is nearest to a point.
    fn nearest(&self, point: DVec2) -> DVec2 {
        let is_inside = |[a, b]: [DVec2; 2]| (b - a).perp_dot(point - a) >= 0.0;
        if self.edges().into_iter().all(is_inside) {
            return point;
        }
        let on_edge = |[a, b]: [DVec2; 2]| {
            let way = b - a;
            a + way * ((point - a).dot(way) / way.length_squared()).clamp(0.0, 1.0)
        };
        let [first, others @ ..] = self.edges().map(on_edge);
        let square = |there: DVec2| there.distance_squared(point);
        others.into_iter().fold(first, |best, it| if square(it) < square(best) { it } else { best })
    }

    /// Moves a point of an edge a little into the triangle.
    fn inward(&self, point: DVec2) -> DVec2 {
        let middle = self.corners.iter().sum::<DVec2>() / 3.0;
        let way = middle - point;
        point + way * (INWARD / way.length()).min(0.25)
    }

    /// Returns the weights of the second and third corner at a point, in the order of the shape.
    fn weights(&self, point: DVec2) -> [f64; 2] {
        let [a, b, c] = self.corners;
        let second = (point - a).perp_dot(c - a) / self.double_area;
        let third = (b - a).perp_dot(point - a) / self.double_area;
        if self.is_mirrored { [third, second] } else { [second, third] }
    }
}

fn corner_of(direction: f64) -> f64 {
    if direction > 0.0 { 1.0 } else { 0.0 }
}

/// Hands out the indices of the texels that a triangle touches.
fn touched(corners: &[[f32; 2]; 3], side: u32, mut put: impl FnMut(usize)) {
    let Some(face) = Face::new(corners) else { return };
    let last = f64::from(side) - 1.0;
    let range = |axis: usize| {
        let all = face.corners.map(|corner| corner[axis]);
        let (low, high) = (all[0].min(all[1]).min(all[2]), all[0].max(all[1]).max(all[2]));
        (low <= last + 1.0 && high >= 0.0)
            .then(|| low.floor().clamp(0.0, last) as u32..=high.floor().clamp(0.0, last) as u32)
    };
    let (Some(columns), Some(rows)) = (range(0), range(1)) else { return };
    for y in rows {
        for x in columns.clone() {
            if face.reaches(DVec2::new(f64::from(x), f64::from(y))) {
                put(y as usize * side as usize + x as usize);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[[f32; 2]; 3]; 2] =
        [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];

    fn covered(layout: &Layout) -> Vec<String> {
        let side = layout.side();
        let row = |y| (0..side).map(|x| if layout.is_covered(x, y) { '#' } else { '.' }).collect();
        (0..side).map(row).collect()
    }

    #[test]
    fn faces_lie_in_all_texels_that_they_touch() {
        let quarter = [[[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]], [[0.0, 0.5], [0.5, 1.0], [0.0, 1.0]]];
        assert_eq!(covered(&Layout::new(&quarter, 4).unwrap()), ["##..", "##..", "....", "...."]);
        let tiny = [[[0.6, 0.1], [0.65, 0.1], [0.6, 0.11]]];
        assert_eq!(covered(&Layout::new(&tiny, 4).unwrap()), ["....", "....", "....", "..#."]);
        let sliver = [[[0.01, 0.6], [0.99, 0.61], [0.99, 0.62]]];
        assert_eq!(covered(&Layout::new(&sliver, 4).unwrap()), ["....", "####", "....", "...."]);
        let outside = [[[1.1, 0.0], [2.0, 0.0], [2.0, 1.0]]];
        assert_eq!(covered(&Layout::new(&outside, 2).unwrap()), ["..", ".."]);
        let flat = [[[0.25, 0.25], [0.5, 0.5], [0.75, 0.75]], [[f32::NAN; 2]; 3]];
        assert_eq!(covered(&Layout::new(&flat, 2).unwrap()), ["..", ".."]);
    }

    #[test]
    fn places_have_the_texture_coordinates_of_their_point() {
        let mirrored = SQUARE.map(|[a, b, c]| [a, c, b]);
        for faces in [SQUARE, mirrored] {
            let layout = Layout::new(&faces, 8).unwrap();
            for (x, y, within) in [(0, 0, [0.5, 0.5]), (7, 2, [0.1, 0.9]), (3, 4, [0.25, 0.75])] {
                let Place { face, weights: [u, v], area } = layout.place(x, y, within).unwrap();
                assert_eq!(area, 32.0);
                let corners = faces[face as usize];
                let at = |axis: usize| {
                    let [a, b, c] = corners.map(|corner| corner[axis]);
                    a * (1.0 - u - v) + b * u + c * v
                };
                let expected = [(x as f32 + within[0]) / 8.0, 1.0 - (y as f32 + within[1]) / 8.0];
                for (axis, expected) in expected.into_iter().enumerate() {
                    assert!((at(axis) - expected).abs() < 1e-6, "{x} {y}: {}", at(axis));
                }
            }
        }
    }

    #[test]
    fn a_point_beside_all_faces_stands_for_one_within() {
        let small = [[[0.0, 0.9], [0.1, 0.9], [0.0, 1.0]]];
        let layout = Layout::new(&small, 1).unwrap();
        let Place { weights: [u, v], .. } = layout.place(0, 0, [0.9, 0.9]).unwrap();
        assert!(u > 0.0 && v > 0.0 && u + v < 1.0, "{u} {v}");
        assert!(layout.place(0, 0, [0.02, 0.02]).is_some());
        assert_eq!(Layout::new(&[], 2).unwrap().place(1, 1, [0.5; 2]), None);
    }

    #[test]
    fn overlaps_are_counted_in_texels() {
        let overlaps = |faces: &[_], side| Layout::new(faces, side).unwrap().overlapping();
        assert_eq!(overlaps(&SQUARE, 16), 0);
        // The middles of four texels lie between the triangles.
        assert_eq!(overlaps(&[SQUARE, SQUARE].concat(), 4), 12);
        let quarter = SQUARE.map(|face| face.map(|corner| corner.map(|c| 0.5 * c)));
        assert_eq!(overlaps(&[&SQUARE[..1], &quarter[..1]].concat(), 4), 1);
        let piled: Vec<_> = (0..2000).map(|_| SQUARE[0]).collect();
        assert_eq!(Layout::new(&piled, 64), None);
    }
}
