//! Spheres, cubes, cones and cylinders: as solids of slo-rt, or as meshes if they have an image, several
//! materials, or not all of their parts.

use glam::{DVec2, DVec3};

use super::scene::{Scene, name_of};
use super::state::{Binding, State};
use super::tree::Node;

use crate::model::{Mesh, Shape};
use crate::solids::SIDES;

/// Adds a solid. Returns whether the node is one.
pub(super) fn add(scene: &mut Scene, node: &Node, state: &State) -> bool {
    let size = |name: &str, usual: f64| node.number(name, usual).abs();
    let (shape, parts) = match node.class.as_str() {
        "Sphere" => {
            let radius = size("radius", 1.0);
            (
                Shape::Sphere { center: DVec3::ZERO, radius },
                vec![("", round(Round::Sphere(radius)))],
            )
        }
        "Cube" => {
            let half =
                DVec3::new(size("width", 2.0), size("height", 2.0), size("depth", 2.0)) / 2.0;
            (Shape::Box { half }, cube(half).into_iter().map(|mesh| ("", mesh)).collect())
        }
        "Cone" => {
            let (radius, half) = (size("bottomRadius", 1.0), DVec3::Y * size("height", 2.0) / 2.0);
            let side = round(Round::Side([radius, 0.0], half.y));
            let parts = vec![("SIDES", side), ("BOTTOM", disc(radius, -half.y))];
            (Shape::Cone { base: -half, apex: half, radius }, parts)
        }
        "Cylinder" => {
            let (radius, half) = (size("radius", 1.0), DVec3::Y * size("height", 2.0) / 2.0);
            let side = round(Round::Side([radius; 2], half.y));
            let parts = vec![
                ("SIDES", side),
                ("TOP", disc(radius, half.y)),
                ("BOTTOM", disc(radius, -half.y)),
            ];
            (Shape::Cylinder { base: -half, top: half, radius }, parts)
        }
        _ => return false,
    };
    let name = node.name.as_deref().and_then(name_of).or_else(|| state.name.clone());
    let name = name.unwrap_or_else(|| node.class.to_lowercase());
    if !has_size(&shape) {
        scene.model.notes.leave_out("a solid without a size");
        return true;
    }
    let shown = node.words("parts");
    let has_all = shown.is_empty() || shown.iter().any(|part| part == "ALL");
    let has_parts = matches!(state.material_binding, Binding::Part | Binding::PartIndexed)
        && state.materials.diffuse.len() > 1;
    let is_plain = has_all && !has_parts && state.texture.is_none();
    if is_plain && scene.solid(name.clone(), shape, state) {
        return true;
    }
    for (number, (part, mut mesh)) in parts.into_iter().enumerate() {
        if !has_all && !shown.iter().any(|shown| shown == part) {
            continue;
        }
        mesh.name.clone_from(&name);
        let place = |uv: &[f32; 2]| {
            let uv = DVec2::from(uv.map(f64::from));
            state.texture_place.transform_point2(uv).as_vec2().to_array()
        };
        mesh.uvs =
            if state.texture.is_some() { mesh.uvs.iter().map(place).collect() } else { Vec::new() };
        let look = if has_parts { number } else { 0 };
        let material = scene.looks.material(&[look], state, &mut scene.model);
        scene.mesh(mesh, material, state);
    }
    true
}

fn has_size(shape: &Shape) -> bool {
    match *shape {
        Shape::Sphere { radius, .. } => radius > 0.0,
        Shape::Cylinder { base, top: end, radius } | Shape::Cone { base, apex: end, radius } => {
            radius > 0.0 && base != end
        }
        Shape::Box { half } => half.min_element() > 0.0,
        Shape::Mesh(_) | Shape::Changing { .. } => true,
    }
}

/// Surfaces around the y axis.
#[derive(Clone, Copy, Debug)]
enum Round {
    Sphere(f64),
    /// Radii at the bottom and the top, and half of the height.
    Side([f64; 2], f64),
}

/// A surface around the y axis. Images begin at the back and run to the left, from the bottom up.
fn round(surface: Round) -> Mesh {
    let mut mesh = Mesh::default();
    let rows = match surface {
        Round::Sphere(_) => SIDES / 2,
        Round::Side(..) => 1,
    };
    for row in 0..=rows {
        let t = f64::from(row) / f64::from(rows);
        for i in 0..=SIDES {
            let s = f64::from(i) / f64::from(SIDES);
            let out = out(s);
            let (position, normal) = match surface {
                Round::Sphere(radius) => {
                    let angle = std::f64::consts::PI * (t - 0.5);
                    let normal = out * libm::cos(angle) + DVec3::Y * libm::sin(angle);
                    (normal * radius, normal)
                }
                Round::Side([bottom, top], half) => {
                    let position =
                        out * (bottom + (top - bottom) * t) + DVec3::Y * half * (2.0 * t - 1.0);
                    (position, (out + DVec3::Y * (bottom - top) / (2.0 * half)).normalize_or(out))
                }
            };
            mesh.positions.push(position.as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            mesh.uvs.push([s as f32, t as f32]);
        }
    }
    let (has_south, has_north) = match surface {
        Round::Sphere(_) => (false, false),
        Round::Side([bottom, top], _) => (bottom > 0.0, top > 0.0),
    };
    for row in 0..rows {
        for i in 0..SIDES {
            let a = row * (SIDES + 1) + i;
            let (b, c, d) = (a + 1, a + SIDES + 2, a + SIDES + 1);
            if row > 0 || has_south {
                mesh.faces.push([a, b, c]);
            }
            if row + 1 < rows || has_north {
                mesh.faces.push([a, c, d]);
            }
        }
    }
    mesh
}

/// The direction from the axis, at a share of the way around it.
fn out(s: f64) -> DVec3 {
    let angle = std::f64::consts::TAU * if s == 1.0 { 0.0 } else { s };
    DVec3::new(-libm::sin(angle), 0.0, -libm::cos(angle))
}

/// The top or the bottom of a cylinder, at this height. Images stand upright for one who bends over it.
fn disc(radius: f64, height: f64) -> Mesh {
    let (mut mesh, up) = (Mesh::default(), height.signum());
    for i in 0..SIDES {
        let out = out(f64::from(i) / f64::from(SIDES));
        mesh.positions.push((out * radius + DVec3::Y * height).as_vec3().to_array());
        mesh.normals.push([0.0, up as f32, 0.0]);
        mesh.uvs.push([(0.5 + out.x / 2.0) as f32, (0.5 - up * out.z / 2.0) as f32]);
    }
    let face = |i: u32| if up > 0.0 { [0, i, i + 1] } else { [0, i + 1, i] };
    mesh.faces.extend((1..SIDES - 1).map(face));
    mesh
}

/// Front, back, left, right, top and bottom. Each has the whole image.
fn cube(half: DVec3) -> [Mesh; 6] {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    // Where a face lies, and its right and its upper side.
    [[z, x, y], [-z, -x, y], [-x, z, y], [x, -z, y], [y, x, -z], [-y, x, z]].map(
        |[to, right, up]| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let position =
                |[s, t]: [f64; 2]| ((to + right * s + up * t) * half).as_vec3().to_array();
            Mesh {
                positions: corners.map(position).to_vec(),
                uvs: corners.map(|corner| corner.map(|c| (0.5 + 0.5 * c) as f32)).to_vec(),
                faces: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            }
        },
    )
}
