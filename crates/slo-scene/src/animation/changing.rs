//! What a frame depends on beside the files that were read with its scene.

use crate::description::SceneDescription;
use crate::shape::Shape;

use super::clock::Clock;

/// The hash of all files that tell the shapes of bending meshes while the shutter of a frame is open, in
/// the order of the objects. Reads the files that were not read before.
///
/// Returns `None` if no mesh of the scene changes its shape, or the frame lies in no segment of the
/// camera.
pub fn hash_of_shapes(scene: &SceneDescription, frame: i64) -> Option<[u8; 32]> {
    let bending = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => mesh.shapes.clone(),
        _ => None,
    };
    let mut bending = scene.objects.iter().filter_map(|object| bending(&object.shape)).peekable();
    bending.peek()?;
    let shutter = Clock::new(&scene.camera).shutter(frame).ok()?;
    let mut hasher = blake3::Hasher::new();
    bending.for_each(|shapes| shapes.hash_within(shutter.scene_interval(), &mut hasher));
    Some(*hasher.finalize().as_bytes())
}
