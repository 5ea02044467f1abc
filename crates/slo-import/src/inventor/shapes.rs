//! Shapes with faces, as meshes of one material each.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DVec2, DVec3};

use super::outline::{Bound, Outline, outlines};
use super::scene::{Scene, name_of};
use super::state::{Binding, Coordinates, State};
use super::tree::Node;

use crate::corners::Corners;

/// Adds a shape with faces. Returns whether the node is one.
pub(super) fn add(scene: &mut Scene, node: &Node, state: &State) -> bool {
    let own = node.node("vertexProperty");
    let state = &own.map_or_else(|| state.clone(), |own| with_own(own, state));
    let Some(mut faces) = outlines(node, state.points.len()) else { return false };
    let count = faces.len();
    faces.retain(|face| face.spots.iter().all(|spot| spot.point < state.points.len()));
    scene.model.notes.leave_out_many("a face of points that do not exist", count - faces.len());
    if state.is_clockwise {
        faces.iter_mut().for_each(|face| face.spots.reverse());
    }
    if faces.is_empty() {
        return true;
    }
    let (normals, normal_of) = normals(node, &faces, state);
    let uvs = state.texture.map(|_| uvs(node, &faces, state));
    let colors = Bound::new(node, "materialIndex", state.material_binding);
    let (mut meshes, mut places) = (Vec::new(), HashMap::new());
    let mut corner_number = 0;
    for face in &faces {
        let mut numbers: Vec<usize> =
            face.spots.iter().map(|spot| colors.number(face, spot).unwrap_or(0)).collect();
        if numbers.iter().any(|&number| number != numbers[0]) {
            scene.model.notes.leave_out("colours of vertices: a face has their mean");
        } else {
            numbers.truncate(1);
        }
        let material = scene.looks.material(&numbers, state, &mut scene.model);
        let place = *places.entry(material).or_insert_with(|| {
            meshes.push((material, Corners::default()));
            meshes.len() - 1
        });
        let corner = |(i, spot): (usize, &super::outline::Spot)| {
            let normal = normal_of.as_ref().map(|normal_of| normal_of[corner_number + i]);
            let uv = uvs.as_ref().map(|(_, uv_of)| uv_of[corner_number + i]);
            (spot.point as u32, normal, uv)
        };
        let corners: Vec<_> = face.spots.iter().enumerate().map(corner).collect();
        meshes[place].1.add(&corners);
        corner_number += face.spots.len();
    }
    let name = node.name.as_deref().and_then(name_of).or_else(|| state.name.clone());
    let name = name.unwrap_or_else(|| node.class.clone());
    let points: Vec<[f32; 3]> = state.points.iter().map(|p| p.as_vec3().to_array()).collect();
    let uvs = uvs.map(|(uvs, _)| uvs).unwrap_or_default();
    for (material, corners) in meshes {
        scene.mesh(corners.mesh(name.clone(), &points, &normals, &uvs), material, state);
    }
    true
}

/// The state with the lists of a shape's own, as far as they are not empty.
fn with_own(own: &Node, state: &State) -> State {
    let mut state = state.clone();
    let list = |name| own.vectors(name).filter(|list| !list.is_empty());
    if let Some(points) = list("vertex") {
        state.points = Rc::new(points);
    }
    if let Some(normals) = list("normal") {
        state.normals = Rc::new(normals);
        state.normal_binding = Binding::of(own.word("normalBinding"), Binding::VertexIndexed);
    }
    let uvs = own.pairs("texCoord");
    if !uvs.is_empty() {
        state.coordinates = Coordinates::Listed(Rc::new(uvs));
        state.coordinate_binding = Binding::VertexIndexed;
    }
    if let Some(colors) = own.numbers("orderedRGBA").filter(|colors| !colors.is_empty()) {
        state.materials.pack(colors);
        state.material_binding = Binding::of(own.word("materialBinding"), Binding::Overall);
    }
    state
}

/// For each corner of all faces, the number of its normal.
type OfCorners = Vec<u32>;

/// Normals that the file gives, or those of smooth edges; none if all edges are sharp.
fn normals(node: &Node, faces: &[Outline], state: &State) -> (Vec<[f32; 3]>, Option<OfCorners>) {
    let bound = Bound::new(node, "normalIndex", state.normal_binding);
    let all = faces.iter().flat_map(|face| face.spots.iter().map(move |spot| (face, spot)));
    let given: Option<OfCorners> = all
        .map(|(face, spot)| {
            let number = bound.number(face, spot)?;
            (number < state.normals.len()).then_some(number as u32)
        })
        .collect();
    if let Some(given) = given {
        let unit = |normal: &DVec3| normal.normalize_or(DVec3::Y).as_vec3().to_array();
        return (state.normals.iter().map(unit).collect(), Some(given));
    }
    if state.crease <= 0.0 { (Vec::new(), None) } else { smoothed(faces, state) }
}

/// Normals of corners: the mean of those of the faces around a point that lie within the angle.
fn smoothed(faces: &[Outline], state: &State) -> (Vec<[f32; 3]>, Option<OfCorners>) {
    let across: Vec<DVec3> = faces.iter().map(|face| normal_of(face, &state.points)).collect();
    let mut around: HashMap<usize, Vec<usize>> = HashMap::new();
    for (number, face) in faces.iter().enumerate() {
        for spot in &face.spots {
            around.entry(spot.point).or_default().push(number);
        }
    }
    let least = libm::cos(state.crease.min(std::f64::consts::PI)) - 1e-9;
    let (mut normals, mut of_corners) = (Vec::new(), Vec::new());
    // Corners of a face at one point often have the same normal as those of others.
    let mut known: HashMap<(usize, [u32; 3]), u32> = HashMap::new();
    for (face, own) in faces.iter().zip(&across) {
        for spot in &face.spots {
            let others = around[&spot.point].iter().map(|&other| across[other]);
            let sum: DVec3 = others.filter(|other| own.dot(*other) >= least).sum();
            let normal = sum.normalize_or(*own).normalize_or(DVec3::Y).as_vec3().to_array();
            let key = (spot.point, normal.map(f32::to_bits));
            of_corners.push(*known.entry(key).or_insert_with(|| {
                normals.push(normal);
                normals.len() as u32 - 1
            }));
        }
    }
    (normals, Some(of_corners))
}

/// The normal of a face with any number of corners (Newell).
fn normal_of(face: &Outline, points: &[DVec3]) -> DVec3 {
    let spots = &face.spots;
    let pairs = spots.iter().zip(spots.iter().cycle().skip(1));
    let sum: DVec3 = pairs.map(|(a, b)| points[a.point].cross(points[b.point])).sum();
    sum.normalize_or_zero()
}

/// Texture coordinates, and for each corner of all faces which of them it has.
fn uvs(node: &Node, faces: &[Outline], state: &State) -> (Vec<[f32; 2]>, OfCorners) {
    let place = |uv: DVec2| state.texture_place.transform_point2(uv).as_vec2().to_array();
    let all = || faces.iter().flat_map(|face| face.spots.iter().map(move |spot| (face, spot)));
    if let Coordinates::Listed(list) = &state.coordinates {
        let bound = Bound::new(node, "textureCoordIndex", state.coordinate_binding);
        let numbers: Option<OfCorners> = all()
            .map(|(face, spot)| {
                bound.number(face, spot).filter(|&n| n < list.len()).map(|n| n as u32)
            })
            .collect();
        if let Some(numbers) = numbers {
            return (list.iter().map(|&uv| place(DVec2::from(uv))).collect(), numbers);
        }
    }
    let points = &state.points;
    let by_point = match &state.coordinates {
        Coordinates::Plane(axes) => {
            let [s, t] = axes.map(|axis| axis / axis.length_squared().max(1e-300));
            points.iter().map(|point| place(DVec2::new(point.dot(s), point.dot(t)))).collect()
        }
        _ => from_box(faces, points).into_iter().map(place).collect(),
    };
    (by_point, all().map(|(_, spot)| spot.point as u32).collect())
}

/// Coordinates along the longest side of the box around a shape, and the second longest, on one scale.
fn from_box(faces: &[Outline], points: &[DVec3]) -> Vec<DVec2> {
    let used = || faces.iter().flat_map(|face| &face.spots).map(|spot| points[spot.point]);
    let least = used().fold(DVec3::INFINITY, DVec3::min);
    let size = used().fold(DVec3::NEG_INFINITY, DVec3::max) - least;
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    let scale = 1.0 / size[axes[0]].max(1e-300);
    let uv = |p: &DVec3| DVec2::new(p[axes[0]] - least[axes[0]], p[axes[1]] - least[axes[1]]);
    points.iter().map(|point| uv(point) * scale).collect()
}
