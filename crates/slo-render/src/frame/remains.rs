//! What a frame leaves to another frame of the same scene.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::crowd::Resting;
use super::instance::{Body, Instance};
use super::scene::FrameScene;
use super::shapes::Geometry;
use super::world::World;
use crate::shading::light::ImageSky;
use slo_accel::{Bending, Curved, Structure};
use slo_scene::animation::DAffine;
use slo_scene::{Accelerator, Mesh, Settings};

/// Most vertices of meshes that are compared one by one.
const MOST_COMPARED: usize = 64;

/// What another frame of the same scene may use again: structures, and tables of skies. It shares
/// them with the frame that it comes from.
#[derive(Clone, Debug)]
pub struct Remains {
    /// Origin of render space, in scene space.
    pub(super) origin: DVec3,
    /// What the structures were made of, if the scene may be another one.
    pub(super) made: Option<Arc<Made>>,
    pub(super) still: Arc<Structure>,
    /// Index and place of each object of the still structure.
    pub(super) places: Arc<Vec<(u32, DAffine)>>,
    /// Structures of instances, by the index of the object.
    pub(super) moving: HashMap<u32, Arc<Structure>>,
    /// Structures of meshes that bend, by the index of the object.
    pub(super) bending: HashMap<u32, Arc<Bending>>,
    pub(super) skies: Vec<ImageSky>,
    pub(super) crowd: Option<Resting>,
}

impl FrameScene {
    /// Returns what another frame of the same scene may use again.
    pub fn remains(&self) -> Remains {
        self.left(None)
    }

    /// Returns the same for a frame of another scene, which may have other objects, materials and
    /// settings: what fits is used again.
    pub fn remains_for_others(&self) -> Remains {
        let shapes = self.objects.iter().map(|object| Known::of(&object.geometry)).collect();
        self.left(Some(Arc::new(Made { shapes, by: by(&self.settings) })))
    }

    fn left(&self, made: Option<Arc<Made>>) -> Remains {
        let World { still, instances, crowd, .. } = &self.world;
        let structure = |object, body: &Body| Some((object, body.structure()?.clone()));
        let mut moving: HashMap<_, _> =
            instances.iter().filter_map(|of| structure(of.object, &of.body)).collect();
        let bending = |of: &Instance| match &of.body {
            Body::Bending(structure) => Some((of.object, structure.clone())),
            Body::Still(_) => None,
        };
        let casts = (crowd.first_cast..).zip(&crowd.casts);
        moving.extend(casts.filter_map(|(object, cast)| structure(object, &cast.body)));
        Remains {
            origin: self.compositing.origin,
            made,
            still: still.clone(),
            places: self.still_places.clone(),
            moving,
            bending: instances.iter().filter_map(bending).collect(),
            skies: self.lights.image_skies().to_vec(),
            crowd: self.world.many.as_ref().and_then(|all| crowd.resting(all)),
        }
    }
}

/// What structures were made of, and how.
#[derive(Debug)]
pub(super) struct Made {
    /// By the number of the object.
    shapes: Vec<Known>,
    by: (Accelerator, bool),
}

/// What is needed to tell whether a shape is another one.
#[derive(Debug)]
enum Known {
    Mesh(Arc<Mesh>),
    Curved(Curved),
}

impl Known {
    fn of(geometry: &Geometry) -> Self {
        match geometry {
            Geometry::Mesh(mesh, _) => Self::Mesh(mesh.clone()),
            Geometry::Curved(surface) => Self::Curved(surface.primitive(&DAffine::IDENTITY)),
        }
    }

    fn is(&self, geometry: &Geometry) -> bool {
        match (self, geometry) {
            (Self::Mesh(known), Geometry::Mesh(mesh, _)) => {
                let is_small = mesh.positions.len() <= MOST_COMPARED;
                let is_equal = || known.positions == mesh.positions && known.faces == mesh.faces;
                Arc::ptr_eq(known, mesh) || (is_small && is_equal())
            }
            (Self::Curved(known), Geometry::Curved(surface)) => {
                *known == surface.primitive(&DAffine::IDENTITY)
            }
            _ => false,
        }
    }
}

impl Made {
    /// Whether the object with a number had this shape.
    pub(super) fn is(&self, number: u32, geometry: &Geometry) -> bool {
        self.shapes.get(number as usize).is_some_and(|known| known.is(geometry))
    }

    /// Whether these settings build the same structures.
    pub(super) fn is_by(&self, settings: &Settings) -> bool {
        self.by == by(settings)
    }
}

/// The settings that structures depend on.
fn by(settings: &Settings) -> (Accelerator, bool) {
    (settings.accelerator, settings.spatial_splits)
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
    fn another_scene_takes_what_fits() {
        let scene = |text: &str| {
            let loaded = load("scene.txt", text, &Files::built_in("", FILES));
            loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)))
        };
        let start = SCENE.find("mesh turning").expect("it is there");
        let text = SCENE[..start].to_owned()
            + "sphere ball { center { 0 0 0 } radius 1 material matte }
               box crate { vertex0 { 0 0 0 } vertex1 { 1 0 0 } vertex2 { 1 1 0 } height 1
                   material matte }";
        let before = scene(&text);
        let aids = |before: Option<super::Remains>| super::super::kept::Aids {
            before,
            stays: true,
            apart: Some("ball".into()),
            ..Default::default()
        };
        let build = |scene: &slo_scene::SceneDescription, before| {
            FrameScene::build_with(scene, 0, Isa::best(), aids(before)).expect("a frame")
        };
        let first = build(&before, None);
        let mut scene = before.clone();
        let remains = || Some(first.remains_for_others());
        let keeps = |scene: &slo_scene::SceneDescription| {
            let second = build(scene, remains());
            Arc::ptr_eq(&first.world.still, &second.world.still)
        };
        // The camera goes elsewhere, and the ball, which stands apart, changes.
        scene.camera.segments[0].positions[0] += DVec3::new(3.0, -2.0, 1.0);
        assert!(keeps(&scene));
        let slo_scene::Shape::Sphere(ball) = &mut scene.objects[1].shape else { panic!("no ball") };
        ball.radius = 2.0;
        assert!(keeps(&scene));
        let second = build(&scene, remains());
        let of = |frame: &FrameScene| frame.world.instances[0].body.bounds();
        assert_ne!(of(&first), of(&second), "the ball has grown");
        // A box changes, or the way in which structures are built.
        let slo_scene::Shape::Box(cuboid) = &mut scene.objects[2].shape else { panic!("no box") };
        cuboid.height = 2.0;
        assert!(!keeps(&scene));
        let mut scene = before.clone();
        scene.settings.accelerator = slo_scene::Accelerator::KdTree;
        assert!(!keeps(&scene));
    }

    #[test]
    fn a_crowd_at_rest_is_placed_once() {
        const POINTS: &[u8] = b"ply
format ascii 1.0
element vertex 1
property float x
property float y
property float z
end_header
0 0 0
";
        let start = SCENE.find("mesh still").expect("it is there");
        let text = SCENE[..start].to_owned()
            + "sphere ball { center { 0 0 0 } radius 1 material matte hidden 1 }
               copies balls { of ball placements points.ply }";
        let scene = |text: &str| {
            let files = Files::built_in("", &[("points.ply", POINTS)]);
            let loaded = load("scene.txt", text, &files);
            let mut scene =
                loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
            let positions = (0..17_000).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
            let places = slo_scene::Placements { positions, ..Default::default() };
            scene.copies[0].placements = Some(Arc::new(places));
            scene
        };
        let many = |frame: &FrameScene| frame.world.many.clone().expect("a crowd");
        let at_rest = scene(&text);
        let first = FrameScene::build(&at_rest, 0, Isa::best()).expect("frame 0");
        let second = FrameScene::build_with(&at_rest, 1, Isa::best(), first.remains());
        let second = second.expect("frame 1");
        assert!(Arc::ptr_eq(&many(&first), &many(&second)));
        assert!(second.world.crowd.resting(&many(&second)).is_some(), "for the frame after");
        // Another scene may have other copies, and other instances would be placed with them.
        let other = FrameScene::build_with(&at_rest, 1, Isa::best(), first.remains_for_others());
        assert!(!Arc::ptr_eq(&many(&first), &many(&other.expect("frame 1"))));
        let text = text
            + "sphere egg { center { 0 0 0 } radius 1 material matte
            addKframe { time 0 key { scale { 1 1 2 } pivot { 0 0 5 } } } }";
        let with_egg = scene(&text);
        let [first, second] = [0, 1].map(|number| {
            FrameScene::build(&with_egg, number, Isa::best()).expect("a frame").remains()
        });
        assert!(first.crowd.is_none() && second.crowd.is_none());
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
