//! What key frames cannot say: that things are mirrored, or flat.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};

use crate::model::{LampKind, Mesh, Model, Pose, Shape, Space};
use crate::solids::{add_disc, add_side, cuboid, sphere};

/// Mirrors meshes by their vertices instead of by the spaces that they hang in. What is flat at some time,
/// or turns inside out, is placed once and for all.
pub(crate) fn straighten(model: &mut Model) {
    let flips = flips(model);
    if flips.iter().all(|flip| *flip == Some(DVec3::ONE)) {
        return;
    }
    let matrix = |space: usize| model.matrix(Some(space), 0.0);
    let matrices: Vec<DMat4> = (0..flips.len())
        .map(|space| flips[space].map_or_else(|| matrix(space), DMat4::from_scale))
        .collect();
    place_objects(model, &flips, &matrices);
    place_lamps(model, &flips, &matrices);
    turn_spaces(model, &flips);
}

/// For each space, the signs by which what hangs in it is mirrored; `None` if they change.
fn flips(model: &Model) -> Vec<Option<DVec3>> {
    let mut flips: Vec<Option<DVec3>> = Vec::new();
    for space in &model.spaces {
        let around = space.parent.map_or(Some(DVec3::ONE), |parent| flips[parent]);
        let signs = space.keys[0].pose.scale.signum();
        let is_steady = space.keys.iter().all(|key| (key.pose.scale * signs).min_element() > 0.0);
        flips.push(around.filter(|_| is_steady).map(|around| around * signs));
    }
    flips
}

/// Turns spaces so that none is mirrored.
///
/// In a space that is mirrored by the signs `F`, a pose says `F T R S`, which is `(F T) (F R F) |S|` with the
/// signs `F sign(S)`; `F R F` is a turn.
fn turn_spaces(model: &mut Model, flips: &[Option<DVec3>]) {
    for (number, flip) in flips.iter().enumerate() {
        let space = &mut model.spaces[number];
        let around = space.parent.map_or(Some(DVec3::ONE), |parent| flips[parent]);
        let (Some(_), Some(around)) = (flip, around) else { continue };
        for key in &mut space.keys {
            let Pose { pivot, turn, scale } = key.pose;
            let v = DVec3::new(turn.x, turn.y, turn.z) * around * around.element_product();
            let turn = DQuat::from_xyzw(v.x, v.y, v.z, turn.w);
            key.pose = Pose { pivot: pivot * around, turn, scale: scale.abs() };
        }
    }
}

fn place_objects(model: &mut Model, flips: &[Option<DVec3>], matrices: &[DMat4]) {
    let mut known: HashMap<(usize, usize), usize> = HashMap::new();
    for number in 0..model.objects.len() {
        let Some(space) = model.objects[number].space else { continue };
        let (flip, matrix) = (flips[space], matrices[space]);
        if flip == Some(DVec3::ONE) {
            continue;
        }
        if flip.is_none() {
            if model.moves(Some(space)) {
                let note = "that something moves which is flat at times, or turns inside out";
                model.notes.leave_out(note);
            }
            model.objects[number].space = None;
        }
        // Spaces with the same signs share the mirrored meshes.
        let signs = flip.map_or(8 + space, |f| {
            usize::from(f.x < 0.0) + 2 * usize::from(f.y < 0.0) + 4 * usize::from(f.z < 0.0)
        });
        let mut place = |mesh: usize| {
            *known.entry((mesh, signs)).or_insert_with(|| {
                model.meshes.push(model.meshes[mesh].transformed(matrix));
                model.meshes.len() - 1
            })
        };
        let point = |point: DVec3| matrix.transform_point3(point);
        let shape = match model.objects[number].shape {
            Shape::Mesh(mesh) => Shape::Mesh(place(mesh)),
            Shape::Changing { first, count, ref times } => {
                let times = times.clone();
                let places: Vec<usize> = (first..first + count).map(place).collect();
                Shape::Changing { first: places[0], count, times }
            }
            Shape::Box { half } if flip.is_some() => Shape::Box { half },
            Shape::Sphere { center, radius } if flip.is_some() => {
                Shape::Sphere { center: point(center), radius }
            }
            Shape::Cylinder { base, top, radius } if flip.is_some() => {
                Shape::Cylinder { base: point(base), top: point(top), radius }
            }
            Shape::Cone { base, apex, radius } if flip.is_some() => {
                Shape::Cone { base: point(base), apex: point(apex), radius }
            }
            Shape::Sphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Cone { .. }
            | Shape::Box { .. } => {
                model.notes.leave_out("that a flat shape is round: it became a mesh");
                let mesh = as_mesh(&model.objects[number].shape);
                model.meshes.push(mesh.transformed(matrix));
                Shape::Mesh(model.meshes.len() - 1)
            }
        };
        model.objects[number].shape = shape;
    }
}

/// A solid as triangles.
fn as_mesh(shape: &Shape) -> Mesh {
    let closed = |base: DVec3, top: DVec3, radii: [f64; 2]| {
        let mut mesh = Mesh::default();
        let along = (top - base).normalize();
        add_side(&mut mesh, [base, top], radii);
        add_disc(&mut mesh, base, -along, radii[0]);
        if radii[1] > 0.0 {
            add_disc(&mut mesh, top, along, radii[1]);
        }
        mesh
    };
    match *shape {
        Shape::Sphere { center, radius } => sphere(center, radius),
        Shape::Cylinder { base, top, radius } => closed(base, top, [radius; 2]),
        Shape::Cone { base, apex, radius } => closed(base, apex, [radius, 0.0]),
        Shape::Box { half } => cuboid(half),
        Shape::Mesh(_) | Shape::Changing { .. } => Mesh::default(),
    }
}

fn place_lamps(model: &mut Model, flips: &[Option<DVec3>], matrices: &[DMat4]) {
    for number in 0..model.lamps.len() {
        let Some(space) = model.lamps[number].space else { continue };
        let (parent, pose) = match flips[space] {
            // Lamps shine along -z; those without a direction stay.
            Some(flip)
                if flip.z < 0.0 && !matches!(model.lamps[number].kind, LampKind::Point { .. }) =>
            {
                let turn = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
                (Some(space), Pose { turn, ..Pose::default() })
            }
            Some(_) => continue,
            None => {
                let (_, turn, pivot) = matrices[space].to_scale_rotation_translation();
                // What has no size has no direction.
                let turn = if turn.is_finite() { turn } else { DQuat::IDENTITY };
                (None, Pose { pivot, turn, scale: DVec3::ONE })
            }
        };
        let name = model.spaces[space].name.clone();
        model.lamps[number].space = Some(model.spaces.len());
        model.spaces.push(Space::still(name, parent, pose));
    }
}
