//! Tests the library as other programs use it.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use slo_rt::description::{
    CamSegment, Camera, Film, Light, LightKind, Material, MaterialId, MaterialKind, Mesh, Object,
    SceneDescription, Settings, Shape, TextureId, light, material, shape,
};
use slo_rt::{Error, Layer, Render, Scene};

const TEXT: &str = "
    settings s { imageSamples 4 }
    Camera c {
        fps 25
        Film f { width 64 height 48 }
        CamSegment only {
            videoStart 0 videoEnd 1
            addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 0.4
        }
    }
    light_point lamp { color { 1 1 1 } position { 2 -3 4 } }
    phong_info matte { diffuse { .7 .6 .5 } }
    material_phong matte { phong_info matte }
    sphere ball { center { 0 0 0 } radius 1 material matte }
";

fn scene() -> Scene {
    Scene::parse(TEXT, ".").unwrap()
}

/// The same scene, built in memory.
fn built() -> Scene {
    let info = material::PhongInfo { diffuse: [0.7, 0.6, 0.5], ..material::PhongInfo::default() };
    let phong = material::Phong { info, texture: None };
    let sphere = shape::Sphere { center: [0.0; 3].into(), radius: 1.0 };
    let mut settings = Settings::default();
    settings.set_camera_samples(4);
    let mut film = Film::default();
    (film.width, film.height) = (64, 48);
    Scene::from_description(SceneDescription {
        settings,
        camera: Camera {
            fps: 25.0,
            film,
            segments: vec![CamSegment {
                name: "only".into(),
                video: [0.0, 1.0],
                scene: [0.0, 1.0],
                positions: vec![[0.0, -5.0, 1.0].into()],
                targets: vec![[0.0; 3].into()],
                sky: [[0.0, 0.0, 1.0].into(); 2],
                fov: [0.4; 2],
                dof: [1.0; 2],
                lens_radius: [0.0; 2],
                blur_duration: 0.0,
            }],
        },
        lights: vec![Light::new(
            "lamp",
            LightKind::Point(light::PointLight {
                color: [1.0; 3],
                position: [2.0, -3.0, 4.0].into(),
            }),
        )],
        materials: vec![Material { name: "matte".into(), kind: MaterialKind::Phong(phong) }],
        textures: vec![],
        objects: vec![Object::new("ball", MaterialId(0), Shape::Sphere(sphere))],
        copies: Vec::new(),
        spaces: Vec::new(),
        content_hash: [0; 32],
    })
    .unwrap()
}

#[test]
fn a_scene_in_memory_is_the_scene_of_its_text() {
    let pictures = [scene(), built()].map(|scene| Render::new(&scene).run().unwrap());
    assert_eq!(pictures[0].pixels(), pictures[1].pixels());
    assert!(pictures[0].pixels().iter().any(|pixel| pixel[0] > 0.3));
    let recipes = pictures.map(|picture| picture.recipe());
    assert_ne!(recipes[0], recipes[1], "their hashes are of text and of values");
    assert_eq!(recipes[1], Render::new(&built()).run().unwrap().recipe());
    let mut other = built().description().clone();
    other.settings.seed = 1;
    other.objects[0].name = "other".into();
    let other = Scene::from_description(other).unwrap();
    assert_ne!(other.description().content_hash, built().description().content_hash);
}

#[test]
fn settings_replace_those_of_the_scene() {
    let scene = scene();
    let picture = Render::new(&scene)
        .frame(10)
        .size(32, 18)
        .samples(2)
        .seed(7)
        .settings(|settings| settings.recursion = Some(0))
        .film(|film| film.prefix = "p".into())
        .layers(&[Layer::Normal, Layer::Albedo])
        .threads(2)
        .run()
        .unwrap();
    assert_eq!((picture.width(), picture.height(), picture.pixels().len()), (32, 18, 32 * 18));
    assert_eq!(picture.srgb8().len(), 3 * 32 * 18);
    let albedo = picture.layer(Layer::Albedo).unwrap();
    assert!(albedo.iter().any(|pixel| (pixel[0] - 0.7).abs() < 1e-6));
    let recipe = picture.recipe();
    for part in [r#""frame": 10"#, r#""seed": 7"#, r#""imageSamples": 2"#, r#""recursion": 0"#] {
        assert!(recipe.contains(part), "{part} in {recipe}");
    }
    assert_eq!(Render::new(&scene).run().unwrap().layer(Layer::Albedo), None);
}

#[test]
fn progress_grows_to_the_whole_and_cancelling_stops() {
    let scene = scene();
    let seen = Mutex::new(Vec::new());
    let render = Render::new(&scene).progress(|done| seen.lock().unwrap().push(done));
    render.run().unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.is_sorted() && seen.len() > 1, "{seen:?}");
    assert!((seen[seen.len() - 1] - 1.0).abs() < 1e-9, "{seen:?}");
    let cancel = AtomicBool::new(false);
    let render = Render::new(&scene).size(640, 480).cancel(&cancel);
    let cancelled = render.progress(|_| cancel.store(true, Ordering::Relaxed)).run();
    assert!(matches!(cancelled, Err(Error::Cancelled)));
}

#[test]
fn files_have_the_bytes_that_the_program_writes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("scene.txt"), TEXT).unwrap();
    let scene = Scene::open(at("scene.txt")).unwrap();
    assert_eq!(scene.frames(), [0..=25]);
    for format in ["png", "exr"] {
        Render::new(&scene).frame(3).samples(3).save(at(&format!("ours.{format}"))).unwrap();
        let program = Command::new(env!("CARGO_BIN_EXE_slo-rt"))
            .args(["-s", "scene.txt", "-f", "3", "--samples", "3", "--format", format])
            .args(["--prefix", "theirs_"])
            .current_dir(&folder)
            .status();
        assert!(program.unwrap().success());
        let bytes = |name: &str| fs::read(at(name)).unwrap();
        let theirs = bytes(&format!("theirs_00003.{format}"));
        assert!(bytes(&format!("ours.{format}")) == theirs, "{format}");
    }
}

#[test]
fn errors_say_what_and_where() {
    let missing = Scene::open("no/such/scene.txt").unwrap_err();
    assert!(matches!(&missing, Error::Io { path, .. } if path == Path::new("no/such/scene.txt")));
    assert!(missing.to_string().starts_with("no/such/scene.txt: "), "{missing}");
    let wrong = Scene::parse(&TEXT.replace("radius 1", "radius -1"), ".").unwrap_err();
    assert!(wrong.to_string().contains("`radius`"), "{wrong}");
    let scene = scene();
    let beyond = Render::new(&scene).frame(1000).run().unwrap_err();
    assert!(beyond.to_string().contains("1000"), "{beyond}");
    let picture = Render::new(&scene).samples(1).run().unwrap();
    assert!(matches!(picture.save("picture.jpeg"), Err(Error::Format(_))));
    assert!(matches!(picture.save("no/such/folder/picture.png"), Err(Error::Io { .. })));
    let as_std: Box<dyn std::error::Error + Send + Sync> = beyond.into();
    assert!(as_std.to_string().contains("1000"));
}

#[test]
fn scenes_of_strangers_stay_in_their_folder() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    fs::write(
        folder.path().join("m.slo"),
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }",
    )
    .unwrap();
    let text = TEXT.to_owned() + "mesh m { filename ../m.slo material matte }";
    fs::write(inside.join("scene.txt"), text).unwrap();
    assert!(Scene::open(inside.join("scene.txt")).is_ok());
    let refused = Scene::open_within(inside.join("scene.txt"), &inside).unwrap_err();
    assert!(matches!(refused, Error::Scene(_)), "{refused}");
}

#[test]
fn impossible_values_are_errors() {
    let scene = scene();
    let name = |render: Render<'_>| match render.run() {
        Err(Error::Setting { name }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(Render::new(&scene).size(0, 0)), "width");
    assert_eq!(name(Render::new(&scene).samples(0)), "imageSamples");
    assert_eq!(name(Render::new(&scene).samples(u32::MAX)), "imageSamples");
    let no_rays = |settings: &mut Settings| settings.diffuse_reflection_samples = 0;
    assert_eq!(name(Render::new(&scene).settings(no_rays)), "diffuseReflectionSamples");
}

#[test]
fn built_scenes_hold_together() {
    let broken = |change: fn(&mut SceneDescription)| {
        let mut description = built().description().clone();
        change(&mut description);
        match Scene::from_description(description) {
            Err(Error::Description(why)) => why,
            other => panic!("{other:?}"),
        }
    };
    assert!(broken(|scene| scene.objects[0].material = MaterialId(1)).contains("`ball`"));
    assert!(broken(|scene| scene.materials[0].kind = textured()).contains("`matte`"));
    assert!(broken(|scene| scene.objects[0].shape = torn()).contains("index of `ball`"));
    assert!(broken(|scene| scene.camera.segments.clear()).contains("segment"));
    assert!(broken(|scene| scene.camera.segments[0].targets.clear()).contains("`only`"));
}

/// A material with a texture that no scene here has.
fn textured() -> MaterialKind {
    let texture = material::TextureUse { texture: TextureId(0), scale: [1.0; 2] };
    MaterialKind::Phong(material::Phong {
        info: material::PhongInfo::default(),
        texture: Some(texture),
    })
}

/// A mesh with a corner that is not there.
fn torn() -> Shape {
    let mesh = Mesh {
        positions: vec![[0.0; 3].into(), [1.0, 0.0, 0.0].into(), [0.0, 1.0, 0.0].into()],
        faces: vec![[0, 1, 3]],
        ..Mesh::default()
    };
    Shape::Mesh(shape::MeshSurface::new(mesh, false))
}
