//! What a frame leaves to another frame of the same scene.

use std::collections::HashMap;
use std::sync::Arc;

use super::instance::Body;
use super::scene::FrameScene;
use super::world::World;
use crate::shading::light::ImageSky;
use slo_accel::Structure;
use slo_scene::animation::DAffine;

/// What another frame of the same scene may use again: structures, and tables of skies. It shares
/// them with the frame that it comes from.
#[derive(Clone, Debug)]
pub struct Remains {
    pub(super) still: Arc<Structure>,
    /// Index and place of each object of the still structure.
    pub(super) places: Arc<Vec<(u32, DAffine)>>,
    /// Structures of instances, by the index of the object.
    pub(super) moving: HashMap<u32, Arc<Structure>>,
    pub(super) skies: Vec<ImageSky>,
}

impl FrameScene {
    /// Returns what another frame of the same scene may use again.
    pub fn remains(&self) -> Remains {
        let World { still, instances, crowd, .. } = &self.world;
        let structure = |object, body: &Body| Some((object, body.structure()?.clone()));
        let mut moving: HashMap<_, _> =
            instances.iter().filter_map(|of| structure(of.object, &of.body)).collect();
        let casts = (crowd.first_cast..).zip(&crowd.casts);
        moving.extend(casts.filter_map(|(object, cast)| structure(object, &cast.body)));
        Remains {
            still: still.clone(),
            places: self.still_places.clone(),
            moving,
            skies: self.lights.image_skies().to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_accel::Isa;
    use slo_scene::{Files, load};

    const SCENE: &str = "
        settings s {}
        Camera c {
            fps 1
            Film f { width 16 height 9 prefix a_ output PNG_IMAGE }
            CamSegment only {
                videoStart 0 videoEnd 3 sceneStart 0 sceneEnd 3
                addPosition { 0 -5 1 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart 0.4
            }
        }
        light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
        phong_info matte { diffuse { .7 .6 .5 } }
        material_phong matte { phong_info matte }
        mesh still { filename a.slo material matte }
        mesh turning { filename a.slo material matte
            addKframe { time 0 key { pivot { 0 0 1 } } } addKframe { time 3 key { pivot { 0 0 2 } } } }
        mesh bending { addShape { time 0 filename a.slo } addShape { time 3 filename b.slo }
            material matte }";
    const FILES: &[(&str, &[u8])] = &[
        ("a.slo", b"slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }"),
        ("b.slo", b"slo_mesh 1 vertices { 0 0 0 1 0 0 0 2 0 } faces { 0 1 2 }"),
    ];

    /// Frames 0 and 1 of the scene, the second with what the first leaves.
    fn two_frames(text: &str) -> [FrameScene; 2] {
        let loaded = load("scene.txt", text, &Files::built_in("", FILES));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        let first = FrameScene::build(&scene, 0, Isa::best()).expect("frame 0");
        let remains = first.remains();
        let second = FrameScene::build_with(&scene, 1, Isa::best(), remains).expect("frame 1");
        [first, second]
    }

    #[test]
    fn a_mesh_with_another_shape_leaves_the_other_structures_as_they_are() {
        let blurred = SCENE.replace("fovStart 0.4", "fovStart 0.4 blurDuration 1");
        for (text, moves) in [(SCENE, false), (&blurred, true)] {
            let [first, second] = two_frames(text).map(|frame| frame.world);
            let expected = if moves { 1 } else { 2 };
            assert_eq!(first.still.triangle_count(), expected);
            assert_eq!(Arc::ptr_eq(&first.still, &second.still), moves, "the turning one moved");
            let address = |body: &Body| match body {
                Body::Still(of) => Arc::as_ptr(of).cast::<()>(),
                Body::Bending(of) => Arc::as_ptr(of).cast(),
            };
            let of = |world: &World, i: usize| address(&world.instances[i].body);
            let last = first.instances.len() - 1;
            assert_eq!(last, usize::from(moves));
            assert_ne!(of(&first, last), of(&second, last));
            if moves {
                assert_eq!(of(&first, 0), of(&second, 0));
            }
        }
    }

    #[test]
    fn still_objects_beside_a_mesh_that_changes_shape_are_built_once() {
        let start = SCENE.find("mesh turning").expect("it is there");
        let end = SCENE.find("mesh bending").expect("it is there");
        let [first, second] = two_frames(&(SCENE[..start].to_owned() + &SCENE[end..]));
        assert!(Arc::ptr_eq(&first.world.still, &second.world.still));
        assert_eq!(second.world.still.triangle_count(), 1);
        assert_eq!(second.primitives(), 2);
    }
}
