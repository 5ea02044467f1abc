//! What key frames cannot say: things that are mirrored, or flat, are placed once and for all.

use glam::{DQuat, DVec3};

use crate::model::{Key, Model, Pose, Shape, Space};

/// Places meshes by their vertices if a space around them is mirrored or flat, and lamps by spaces of
/// their own.
pub(crate) fn straighten(model: &mut Model) {
    let is_straight: Vec<bool> =
        (0..model.spaces.len()).map(|space| is_straight(model, space)).collect();
    for number in 0..model.objects.len() {
        let object = &model.objects[number];
        let Some(space) = object.space.filter(|&space| !is_straight[space]) else { continue };
        if model.moves(Some(space)) {
            model.notes.leave_out("that something mirrored moves");
        }
        let matrix = model.matrix(Some(space), 0.0);
        let mut place = |mesh: usize| {
            model.meshes.push(model.meshes[mesh].transformed(matrix));
            model.meshes.len() - 1
        };
        let shape = match &object.shape {
            &Shape::Mesh(mesh) => Shape::Mesh(place(mesh)),
            &Shape::Changing { first, count, fps } => {
                let places: Vec<usize> = (first..first + count).map(place).collect();
                Shape::Changing { first: places[0], count, fps }
            }
            // Only meshes hang in spaces with a scale.
            Shape::Sphere { .. } | Shape::Cylinder { .. } => continue,
        };
        let object = &mut model.objects[number];
        (object.space, object.shape) = (None, shape);
    }
    for number in 0..model.lamps.len() {
        let Some(space) = model.lamps[number].space.filter(|&space| !is_straight[space]) else {
            continue;
        };
        let (_, turn, pivot) = model.matrix(Some(space), 0.0).to_scale_rotation_translation();
        // What has no size has no direction.
        let turn = if turn.is_finite() { turn } else { DQuat::IDENTITY };
        let keys = vec![Key { time: 0.0, pose: Pose { pivot, turn, scale: DVec3::ONE } }];
        let name = model.spaces[space].name.clone();
        model.spaces.push(Space { name, parent: None, keys });
        model.lamps[number].space = Some(model.spaces.len() - 1);
    }
}

fn is_straight(model: &Model, space: usize) -> bool {
    let mut next = Some(space);
    while let Some(space) = next {
        if !model.spaces[space].keys.iter().all(|key| key.pose.can_be_said()) {
            return false;
        }
        next = model.spaces[space].parent;
    }
    true
}
