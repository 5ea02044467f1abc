//! Boxes around all objects.

use glam::DVec3;
use slo_scene::animation::{Clock, Spaces};
use slo_scene::{SceneDescription, Shape};

use super::placed::bounds_of;

/// Returns the boxes around the objects of a frame, in scene space, with their names: at most so many.
/// Planes have none.
pub(crate) fn boxes(scene: &SceneDescription, frame: i64, most: usize) -> Vec<(&str, [DVec3; 2])> {
    let (Ok(shutter), Ok(spaces)) =
        (Clock::new(&scene.camera).shutter(frame), Spaces::new(&scene.spaces))
    else {
        return Vec::new();
    };
    let time = shutter.scene_time(0.0);
    let objects = scene
        .objects
        .iter()
        .filter(|object| !object.hidden && !matches!(object.shape, Shape::Plane(_)));
    let around = objects.take(most).filter_map(|object| {
        let path = spaces.path(&object.key_frames, object.repeat, object.parent).ok()?;
        let (pose, [min, max]) = (path.pose(time), bounds_of(&object.shape));
        let corner = |i: usize| {
            let pick = |axis: usize| if (i >> axis) & 1 == 0 { min[axis] } else { max[axis] };
            pose.point(DVec3::new(pick(0), pick(1), pick(2)))
        };
        let corners = || (0..8).map(corner);
        let least = corners().fold(DVec3::INFINITY, DVec3::min);
        let greatest = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        (least.is_finite() && greatest.is_finite()).then_some((&*object.name, [least, greatest]))
    });
    around.collect()
}

/// Returns the middle of the scene: of the box around all objects.
pub(crate) fn middle(scene: &SceneDescription, frame: i64) -> Option<DVec3> {
    let boxes = boxes(scene, frame, usize::MAX);
    let whole = boxes.into_iter().map(|(_, bounds)| bounds);
    let [min, max] = whole.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
    Some((min + max) * 0.5)
}
