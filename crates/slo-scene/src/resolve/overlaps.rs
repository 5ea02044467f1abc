//! Surfaces that overlap in one plane: rounding decides which one a ray meets first, so the picture
//! shows specks of both.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::animation::{DAffine, Spaces};
use crate::description::{KeyFrame, Object, SceneDescription, SpaceId};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::light::Light;
use crate::shape::{Shape, axes_about};

/// Most flat faces that are compared; scenes with more are not checked.
const MOST_FACES: usize = 100_000;

/// Most triangles of a shape that is checked: a larger shape hardly has flat faces that lie on
/// others, and takes long.
const MOST_SHAPE_FACES: usize = 1000;

/// Most pairs of nearly coplanar faces that are compared.
const MOST_PAIRS: usize = 10_000_000;

/// Most pairs of elements that are reported.
const MOST_REPORTED: usize = 5;

/// Distance between two planes that rounding may bridge, relative to their distance from the
/// camera: 8 units in the last place of an f32.
const TOLERANCE: f64 = 8.0 / (1 << 24) as f64;

/// Least part of the smaller face that two faces must share.
const LEAST_SHARE: f64 = 1e-6;

/// Cells for components of normals, over a range of 2.
const NORMAL_CELLS: f64 = 512.0;

/// Warns of still objects and lights that overlap in one plane if the camera may see both.
pub(super) fn check(
    scene: &SceneDescription,
    object_places: &[Span],
    light_places: &[Span],
    diagnostics: &mut Diagnostics,
) {
    let SceneDescription { objects, lights, .. } = scene;
    let Ok(spaces) = Spaces::new(&scene.spaces) else { return };
    let hides = |parent| scene.hides(parent);
    let Some(faces) = faces(objects, lights, &spaces, &hides) else { return };
    let eyes: Vec<DVec3> = scene.camera.segments.iter().flat_map(|s| s.positions.clone()).collect();
    let span_of = |owner: usize| match objects.get(owner) {
        Some(object) => (object.name.as_str(), object_places[owner]),
        None => {
            let light = owner - objects.len();
            (lights[light].name.as_str(), light_places[light])
        }
    };
    let mut pairs: Vec<[usize; 2]> = overlaps(&faces, &eyes);
    pairs.sort_unstable();
    for (i, [first, again]) in pairs.iter().enumerate().take(MOST_REPORTED) {
        let ((a, a_span), (b, b_span)) = (span_of(*first), span_of(*again));
        let mut warning = Diagnostic::warning(format!("`{a}` and `{b}` overlap in one plane"))
            .at(b_span, "rounding decides which of the two is seen")
            .also(a_span, "this lies in the same plane")
            .help("move one of them a little, so that it lies in front of the other");
        if i + 1 == MOST_REPORTED && pairs.len() > MOST_REPORTED {
            let others = pairs.len() - MOST_REPORTED;
            warning = warning.help(format!("{others} more pairs of objects overlap too"));
        }
        diagnostics.push(warning);
    }
}

/// A flat, convex piece of a surface.
struct Face {
    /// Index of the object, or of the light counted on after all objects.
    owner: usize,
    /// What it shows: faces that look the same may overlap.
    look: Look,
    corners: Vec<DVec3>,
    /// A ball about all corners.
    center: DVec3,
    radius: f64,
    /// Unit; outward if only this side can be seen.
    normal: DVec3,
    two_sided: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Look {
    Material(u32),
    Light(usize),
}

/// All flat faces of still objects and lights; `None` if there are too many.
fn faces(
    objects: &[Object],
    lights: &[Light],
    spaces: &Spaces,
    hides: &dyn Fn(Option<SpaceId>) -> bool,
) -> Option<Vec<Face>> {
    let place = |key_frames: &[KeyFrame], repeat, parent: Option<SpaceId>| {
        if hides(parent) {
            return None;
        }
        let path = spaces.path(key_frames, repeat, parent).ok()?;
        path.rests().then(|| path.pose(0.0))
    };
    let mut faces = Vec::new();
    for (owner, object) in objects.iter().enumerate() {
        if object.hidden {
            continue;
        }
        let Some(place) = place(&object.key_frames, object.repeat, object.parent) else { continue };
        add_faces(&mut faces, owner, Look::Material(object.material.0), &object.shape, &place)?;
    }
    for (number, light) in lights.iter().enumerate() {
        let Some(place) = place(&light.key_frames, light.repeat, light.parent) else { continue };
        let (owner, look) = (objects.len() + number, Look::Light(number));
        light.kind.for_flat_parts(&mut |corners| {
            let corners = corners.iter().map(|corner| place.point(*corner)).collect();
            faces.extend(face(owner, look, corners, true));
            faces.len() <= MOST_FACES
        });
    }
    (faces.len() <= MOST_FACES).then_some(faces)
}

/// Adds the flat parts of a surface, placed; `None` if there are too many.
fn add_faces(
    faces: &mut Vec<Face>,
    owner: usize,
    look: Look,
    shape: &Shape,
    place: &DAffine,
) -> Option<()> {
    if shape.triangle_count() > MOST_SHAPE_FACES {
        return Some(());
    }
    shape.for_flat_parts(&mut |corners| {
        let corners = corners.iter().map(|corner| place.point(*corner)).collect();
        faces.extend(face(owner, look, corners, !shape.is_closed()));
        faces.len() <= MOST_FACES
    });
    (faces.len() <= MOST_FACES).then_some(())
}

fn face(owner: usize, look: Look, corners: Vec<DVec3>, two_sided: bool) -> Option<Face> {
    let [a, b, c] = *corners.first_chunk::<3>()?;
    let normal = (b - a).cross(c - a).try_normalize()?;
    let center = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f64::max);
    Some(Face { owner, look, corners, center, radius, normal, two_sided })
}

/// Pairs of elements, the first one first, of which two faces overlap.
fn overlaps(faces: &[Face], eyes: &[DVec3]) -> Vec<[usize; 2]> {
    let center = eyes.first().copied().unwrap_or_default();
    let size = |face: &Face| {
        let reach = face.corners.iter().map(|corner| (*corner - center).abs().max_element());
        reach.fold(0.0, f64::max)
    };
    let largest = faces.iter().map(size).fold(0.0, f64::max);
    let grid = Grid { center, margin: 2.0 * TOLERANCE * largest, cell: 1e-4 * largest };
    let mut planes: HashMap<[i64; 4], Vec<usize>> = HashMap::new();
    let mut found = Vec::new();
    let mut left = MOST_PAIRS;
    for (i, face) in faces.iter().enumerate() {
        let plane = grid.plane(face);
        let [low, high] = grid.cells_about(plane);
        // Every choice of an end for each of the four coordinates; a bit that chooses between equal
        // ends is 0.
        let apart =
            (0..4).fold(0, |bits, axis| bits | usize::from(low[axis] != high[axis]) << axis);
        for choice in (0..16_usize).filter(|choice| choice & !apart == 0) {
            let key = std::array::from_fn(|axis| [low, high][choice >> axis & 1][axis]);
            for &j in planes.get(&key).into_iter().flatten() {
                let Some(rest) = left.checked_sub(1) else { return found };
                left = rest;
                let other = &faces[j];
                let pair = [face.owner.min(other.owner), face.owner.max(other.owner)];
                let reach = face.radius + other.radius;
                if face.look == other.look
                    || pair[0] == pair[1]
                    || face.center.distance_squared(other.center) > reach * reach
                    || found.contains(&pair)
                {
                    continue;
                }
                let tolerance = TOLERANCE * size(face).max(size(other));
                if are_coplanar(face, other, tolerance)
                    && are_seen(face, other, eyes)
                    && share_area(face, other)
                {
                    found.push(pair);
                    if found.len() > 100 {
                        return found;
                    }
                }
            }
        }
        planes.entry(cell(plane)).or_default().push(i);
    }
    found
}

/// Cells of planes: by their normal, whatever its sign, and their distance from a point.
struct Grid {
    center: DVec3,
    /// Largest computed distance of planes that are the same.
    margin: f64,
    cell: f64,
}

impl Grid {
    /// The plane of a face, in units of cells.
    fn plane(&self, face: &Face) -> [f64; 4] {
        let n = face.normal;
        let [ax, ay, az] = n.abs().to_array();
        let leading = if ax >= ay.max(az) - 1e-3 {
            n.x
        } else if ay >= az - 1e-3 {
            n.y
        } else {
            n.z
        };
        let n = n * leading.signum();
        let distance = n.dot(face.corners[0] - self.center) / self.cell;
        let [x, y, z] = (n * (0.5 * NORMAL_CELLS)).to_array();
        [x, y, z, distance]
    }

    /// The first and the last cell, in each coordinate, of all planes that may be one with a plane.
    fn cells_about(&self, plane: [f64; 4]) -> [[i64; 4]; 2] {
        let margins = [1e-3, 1e-3, 1e-3, self.margin / self.cell + 1e-6];
        [-1.0, 1.0].map(|sign| cell(std::array::from_fn(|i| plane[i] + sign * margins[i])))
    }
}

fn cell(plane: [f64; 4]) -> [i64; 4] {
    plane.map(|x| (x + 0.5).floor() as i64)
}

fn are_coplanar(a: &Face, b: &Face, tolerance: f64) -> bool {
    let within = |plane: &Face, face: &Face| {
        let distance = |corner: &DVec3| plane.normal.dot(*corner - plane.corners[0]).abs();
        face.corners.iter().all(|corner| distance(corner) <= tolerance)
    };
    within(a, b) && within(b, a)
}

/// Whether both faces can be seen from one side that an eye is on.
fn are_seen(a: &Face, b: &Face, eyes: &[DVec3]) -> bool {
    let outward = match [a, b].map(|face| (!face.two_sided).then_some(face.normal)) {
        [None, None] => return true,
        [Some(normal), None] | [None, Some(normal)] => normal,
        [Some(first), Some(second)] if first.dot(second) > 0.0 => first,
        [Some(_), Some(_)] => return false,
    };
    eyes.iter().any(|eye| outward.dot(*eye - a.corners[0]) > 0.0)
}

fn share_area(a: &Face, b: &Face) -> bool {
    let [x, y] = axes_about(a.normal);
    let flat = |face: &Face| -> Vec<DVec2> {
        let corner = |p: &DVec3| DVec2::new(x.dot(*p - a.corners[0]), y.dot(*p - a.corners[0]));
        let mut corners: Vec<_> = face.corners.iter().map(corner).collect();
        if area(&corners) < 0.0 {
            corners.reverse();
        }
        corners
    };
    let (a, b) = (flat(a), flat(b));
    let least = LEAST_SHARE * area(&a).min(area(&b));
    area(&clipped(a, &b)) > least
}

/// Area of a polygon, positive if it is counter-clockwise.
fn area(corners: &[DVec2]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    let pairs = corners.windows(2);
    pairs.map(|pair| 0.5 * (pair[0] - first).perp_dot(pair[1] - first)).sum()
}

/// The part of a polygon inside a convex, counter-clockwise one.
///
/// Source: I. Sutherland and G. Hodgman, "Reentrant Polygon Clipping" (1974).
fn clipped(mut polygon: Vec<DVec2>, by: &[DVec2]) -> Vec<DVec2> {
    for (i, &from) in by.iter().enumerate() {
        let to = by[(i + 1) % by.len()];
        let height = |p: DVec2| (to - from).perp_dot(p - from);
        let mut inside = Vec::with_capacity(polygon.len() + 1);
        for (k, &p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let (hp, hq) = (height(p), height(q));
            if hp >= 0.0 {
                inside.push(p);
            }
            if (hp < 0.0) != (hq < 0.0) {
                inside.push(p + (q - p) * (hp / (hp - hq)));
            }
        }
        polygon = inside;
    }
    polygon
}
