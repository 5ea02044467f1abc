//! The faces of shapes: which points are their corners, and which normals, colours and texture coordinates
//! belong to them.

use super::state::Binding;
use super::tree::Node;

/// A corner of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// Which point it is.
    pub(super) point: usize,
    /// Which corner it is, in the order of use.
    order: usize,
    /// Its place in lists of indices.
    slot: usize,
}

/// A face: a polygon, a triangle of a strip, or a quad of a mesh.
#[derive(Debug)]
pub(super) struct Outline {
    pub(super) spots: Vec<Spot>,
    part: usize,
    face: usize,
}

/// The faces of a shape with this many points; `None` if the node is no shape with faces.
pub(super) fn outlines(node: &Node, points: usize) -> Option<Vec<Outline>> {
    let is_strip = node.class.contains("Strip");
    let rows = match node.class.as_str() {
        "IndexedFaceSet" | "IndexedTriangleStripSet" => indexed_rows(node),
        "FaceSet" | "TriangleStripSet" => rows(node, points),
        "QuadMesh" => return Some(quads(node, points)),
        _ => return None,
    };
    let mut outlines: Vec<Outline> = Vec::new();
    let mut face = 0;
    for (part, row) in rows.into_iter().enumerate() {
        if is_strip {
            for (i, three) in row.windows(3).enumerate() {
                let [a, b, c] = [three[0], three[1], three[2]];
                let spots = if i % 2 == 0 { vec![a, b, c] } else { vec![b, a, c] };
                outlines.push(Outline { spots, part, face });
                face += 1;
            }
        } else {
            outlines.push(Outline { spots: row, part, face: part });
        }
    }
    outlines.retain(|outline| outline.spots.len() >= 3);
    Some(outlines)
}

/// Faces or strips that end with -1.
fn indexed_rows(node: &Node) -> Vec<Vec<Spot>> {
    let (mut rows, mut row, mut order) = (Vec::new(), Vec::new(), 0);
    for (slot, index) in node.indices("coordIndex").unwrap_or_default().into_iter().enumerate() {
        match usize::try_from(index) {
            Ok(point) => {
                row.push(Spot { point, order, slot });
                order += 1;
            }
            Err(_) => rows.push(std::mem::take(&mut row)),
        }
    }
    rows.push(row);
    rows
}

/// Faces or strips of so many points, one after the other.
fn rows(node: &Node, points: usize) -> Vec<Vec<Spot>> {
    let first = node.number("startIndex", 0.0).max(0.0) as usize;
    let (mut rows, mut order) = (Vec::new(), 0);
    for count in node.indices("numVertices").unwrap_or_else(|| vec![-1]) {
        let left = points.saturating_sub(first + order);
        let count = usize::try_from(count).unwrap_or(left).min(left);
        rows.push(
            (order..order + count).map(|i| Spot { point: first + i, order: i, slot: i }).collect(),
        );
        order += count;
    }
    rows
}

fn quads(node: &Node, points: usize) -> Vec<Outline> {
    let [first, rows, columns] =
        [("startIndex", 0.0), ("verticesPerColumn", 1.0), ("verticesPerRow", 1.0)]
            .map(|(name, usual)| node.number(name, usual).max(0.0) as usize);
    let mut outlines = Vec::new();
    if rows.checked_mul(columns).is_none_or(|count| count > points) {
        return outlines;
    }
    for row in 1..rows {
        for column in 1..columns {
            let corners = [(1, 1), (0, 1), (0, 0), (1, 0)];
            let spot = |(up, left): (usize, usize)| {
                let order = (row - up) * columns + column - left;
                Spot { point: first + order, order, slot: order }
            };
            let face = outlines.len();
            outlines.push(Outline { spots: corners.map(spot).to_vec(), part: row - 1, face });
        }
    }
    outlines
}

/// The lists that a shape takes its normals, colours or texture coordinates from.
#[derive(Debug)]
pub(super) struct Bound {
    binding: Binding,
    /// Indices that the shape gives.
    indices: Option<Vec<i64>>,
    is_indexed: bool,
}

impl Bound {
    /// The way that a shape is bound; `field` may hold indices.
    pub(super) fn new(node: &Node, field: &str, binding: Binding) -> Self {
        let indices = node.indices(field).filter(|indices| indices.iter().any(|&i| i >= 0));
        Self { binding, indices, is_indexed: node.class.starts_with("Indexed") }
    }

    /// The number of the value of a corner; `None` if the file says none.
    pub(super) fn number(&self, outline: &Outline, spot: &Spot) -> Option<usize> {
        let index = |place: usize, usual: usize| match &self.indices {
            Some(indices) => usize::try_from(*indices.get(place)?).ok(),
            None => Some(usual),
        };
        match self.binding {
            Binding::Overall => Some(0),
            Binding::Part => Some(outline.part),
            Binding::PartIndexed => index(outline.part, outline.part),
            Binding::Face => Some(outline.face),
            Binding::FaceIndexed => index(outline.face, outline.face),
            Binding::Vertex => Some(spot.order),
            Binding::VertexIndexed => {
                index(spot.slot, if self.is_indexed { spot.point } else { spot.order })
            }
        }
    }
}
