//! What a frame takes while it is built, estimated before.

use std::collections::HashMap;
use std::sync::Arc;

use super::error::FrameError;
use super::shared::MOST_COPIED;
use super::shown::Shown;
use super::survey::MOST_FLAT;
use crate::photons::{MOST_PATHS, Photon, pass_of, samples_of};
use slo_scene::settings::{Accelerator, Integrator};
use slo_scene::{MaterialId, Original, SceneDescription, Shape, memory};

/// Bytes of each triangle while a structure is built, beside the mesh itself. Those of `BVH` and `KDTREE` were
/// measured with ten million triangles; the others are at least what their structures hold.
fn bytes_of_triangle(accelerator: Accelerator, cuts: bool) -> u64 {
    match accelerator {
        Accelerator::Bvh if cuts => 160,
        Accelerator::Bvh | Accelerator::None => 110,
        Accelerator::KdTree => 150,
        _ => 200,
    }
}

/// Bytes of each object that has a place of its own.
const OF_OBJECT: u64 = 400;
/// Bytes of each photon in a map, with what sorts it and the estimates of irradiance.
const OF_PHOTON: u64 = 100;

/// Bytes of each place in the lists of a crowd, with the hierarchy over them; measured with a million and with
/// three million.
const OF_PLACE: u64 = 160;

/// Bytes of each texel of a light map that photons are stored in: where its faces are, while they are found,
/// a point in its middle, and its light.
const OF_TEXEL: u64 = 52;
/// Bytes of each pixel whose rays are counted, with the copy that becomes a map.
const OF_COST: u64 = 32;

/// Bytes of each photon of a pass, while its map is made.
const OF_PASS: u64 = 2 * (size_of::<Photon>() as u64 + 16);

/// Checks that there is memory for the structures of what a frame shows, and for its photons.
pub(super) fn check(scene: &SceneDescription, shown: &Shown<'_>) -> Result<(), FrameError> {
    check_bytes(
        structures(scene, shown),
        "the structures of the frame's objects need",
        "give meshes with fewer triangles, or leave objects out",
    )?;
    check_bytes(
        places(scene, shown).saturating_mul(OF_PLACE),
        "the places of the frame's copies need",
        "make fewer copies, or copies of copies, which are stored once for each level",
    )?;
    check_bytes(photons(scene), "the photons need", "lower `photonMapSize` and `causticMapSize`")?;
    check_bytes(
        texels(scene).saturating_mul(OF_TEXEL),
        "the light maps of photons need",
        "lower the `lightMap` of objects",
    )
}

/// Checks that there is memory to count the rays of so many pixels.
pub(super) fn check_costs(width: u32, height: u32) -> Result<(), FrameError> {
    let pixels = u64::from(width) * u64::from(height);
    check_bytes(pixels * OF_COST, "the costs of all pixels need", "make the picture smaller")
}

fn check_bytes(bytes: u64, what: &'static str, help: &'static str) -> Result<(), FrameError> {
    memory::check(bytes).map_err(|refusal| FrameError::Memory {
        what,
        why: refusal.to_string(),
        help,
    })
}

/// Checks that there is memory for the largest pass of photons that a sample of `PATH` uses, of a frame that
/// has something to send photons to.
pub(super) fn check_pass(scene: &SceneDescription) -> Result<(), FrameError> {
    let settings = &scene.settings;
    let samples = settings.image_samples.saturating_mul(settings.dof_samples).max(1);
    let film = &scene.camera.film;
    let pixels = f64::from(film.width) * f64::from(film.height);
    let served = samples_of(pass_of(samples - 1)).len() as f64;
    let paths = (f64::from(settings.photons) * pixels * served).min(MOST_PATHS as f64) as u64;
    check_bytes(paths * OF_PASS, "the photons of a pass need", "lower `photons`")
}

/// How many places the lists of crowds have. What copies show is listed one by one, or, if that is very
/// much, once for each level.
fn places(scene: &SceneDescription, shown: &Shown<'_>) -> u64 {
    let things =
        |part: &(Original, Option<MaterialId>)| shown.things.get(part).copied().unwrap_or(1);
    if !shown.is_nested {
        let crowds = shown.crowds.iter().map(|&number| things(&(Original::Copy(number), None)));
        return crowds.fold(0, u64::saturating_add);
    }
    let of_level = |(part, things): (&(Original, Option<MaterialId>), &u64)| match part.0 {
        Original::Copy(number) if *things > MOST_FLAT => {
            let placements = scene.copies[number as usize].placements.as_ref();
            placements.map_or(1, |placements| placements.len() as u64)
        }
        Original::Copy(_) | Original::Group(_) => (*things).min(MOST_FLAT),
        Original::Object(_) | Original::Light(_) => 0,
    };
    shown.things.iter().map(of_level).fold(0, u64::saturating_add)
}

/// How many texels the light maps have that photons are stored in.
fn texels(scene: &SceneDescription) -> u64 {
    let settings = &scene.settings;
    if settings.integrator != Integrator::PhotonMap || !settings.gather {
        return 0;
    }
    let maps = scene.objects.iter().filter_map(|object| object.light_map);
    maps.map(|map| u64::from(map.side).pow(2)).sum()
}

fn structures(scene: &SceneDescription, shown: &Shown<'_>) -> u64 {
    // Triangles of each mesh, how many there are, and whether it changes its shape.
    let mut meshes: HashMap<usize, (u64, u64, bool)> = HashMap::new();
    let mut add = |shape: &Shape, count: u64| {
        if let Shape::Mesh(surface) = shape {
            let faces = surface.mesh.faces.len() as u64;
            let of = meshes.entry(Arc::as_ptr(&surface.mesh) as usize).or_default();
            *of = (faces, of.1.saturating_add(count), surface.shapes.is_some());
        }
    };
    shown.objects.iter().for_each(|shown| add(&shown.object.shape, 1));
    // A crowd has each of its meshes once.
    shown.casts.iter().for_each(|(object, ..)| add(&scene.objects[*object as usize].shape, 1));
    let triangles = meshes.values().map(|&(faces, count, bends)| {
        let all = faces.saturating_mul(count);
        // Of many objects of a large mesh, each is an instance.
        let all = if all > MOST_COPIED as u64 { faces } else { all };
        if bends { all.saturating_mul(2) } else { all }
    });
    let triangles: u64 = triangles.fold(0, u64::saturating_add);
    let settings = &scene.settings;
    let each = bytes_of_triangle(settings.accelerator, settings.spatial_splits);
    triangles.saturating_mul(each).saturating_add(shown.objects.len() as u64 * OF_OBJECT)
}

fn photons(scene: &SceneDescription) -> u64 {
    let settings = &scene.settings;
    match settings.integrator {
        Integrator::PhotonMap => {
            let maps = [settings.photon_map_size, settings.caustic_map_size];
            maps.map(u64::from).iter().sum::<u64>() * OF_PHOTON
        }
        Integrator::Distributed | Integrator::Path => 0,
    }
}

#[cfg(test)]
mod tests {
    use slo_accel::Isa;
    use slo_scene::{Files, load};

    use super::super::FrameScene;
    use super::*;

    const CAMERA: &str = "Camera c { fps 25 Film f { width 8 height 8 }
        CamSegment s { videoStart 0 videoEnd 1
            addPosition { 0 -5 1 } addTarget { 0 0 0 } fovStart 0.4 } }
        lamp_point l { power { 1 1 1 } position { 0 0 9 } }
        phong_info p { } material_phong m { phong_info p }";

    fn described(text: &str, files: Vec<(String, Vec<u8>)>) -> SceneDescription {
        let loaded = load("scene.txt", text, &Files::in_memory("", files));
        let said = loaded.diagnostics.render(false);
        loaded.scene.unwrap_or_else(|| panic!("{said}"))
    }

    /// Places of copies on a line.
    fn row(count: usize) -> Vec<u8> {
        let properties = "property float x\nproperty float y\nproperty float z";
        let mut ply =
            format!("ply\nformat ascii 1.0\nelement vertex {count}\n{properties}\nend_header\n");
        (0..count).for_each(|x| ply += &format!("{x} 0 0\n"));
        ply.into_bytes()
    }

    /// The lists of crowds take what is estimated, or a little less: they grow while they are made.
    #[test]
    fn estimates_of_crowds_are_close_to_what_there_is() {
        let count = 40_000;
        let text = format!(
            "{CAMERA} sphere s {{ center {{ 0 0 0 }} radius 1 material m }}
             group pair {{ hidden 1 }}
             sphere a {{ center {{ 0 0 0 }} radius .1 material m parent pair }}
             sphere b {{ center {{ 0 0 1 }} radius .1 material m parent pair }}
             copies flat {{ of s placements row.ply }} copies pairs {{ of pair placements row.ply }}"
        );
        let scene = described(&text, vec![("row.ply".into(), row(count))]);
        let shown = Shown::of(&scene).unwrap();
        assert_eq!((places(&scene, &shown), shown.is_nested), (3 * count as u64, false));
        let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
        let (taken, estimate) = (frame.memory() as u64, 3 * count as u64 * OF_PLACE);
        assert!((taken * 2 / 3..2 * taken).contains(&estimate), "{estimate}, {taken}");
        // Ten thousand million things are a few lists.
        let text = format!(
            "{CAMERA} sphere s {{ center {{ 0 0 0 }} radius 1 material m }}
             copies one {{ of s placements row.ply hidden 1 }}
             copies two {{ of one placements row.ply }}"
        );
        let scene = described(&text, vec![("row.ply".into(), row(count))]);
        let shown = Shown::of(&scene).unwrap();
        assert!(shown.is_nested);
        assert_eq!(places(&scene, &shown), 2 * count as u64);
    }

    #[test]
    fn light_maps_are_of_photons_only_where_light_is_gathered() {
        let texels_of = |settings: &str| {
            let text = format!(
                "settings s {{ {settings} }} {CAMERA}
                 sphere a {{ center {{ 0 0 0 }} radius 1 material m lightMap 64 }}
                 sphere b {{ center {{ 3 0 0 }} radius 1 material m lightMap 8 }}"
            );
            texels(&described(&text, Vec::new()))
        };
        assert_eq!(texels_of("integrator PHOTON_MAP gather 1"), 64 * 64 + 8 * 8);
        assert_eq!(
            [texels_of("integrator PHOTON_MAP gather 0"), texels_of("integrator PATH")],
            [0, 0]
        );
    }

    /// What is estimated is what the structures take, or a few times as much: they are larger while they are
    /// built.
    #[test]
    fn estimates_are_close_to_what_there_is() {
        const SIDE: usize = 100;
        let mut obj = String::new();
        for (x, y) in (0..=SIDE).flat_map(|x| (0..=SIDE).map(move |y| (x, y))) {
            obj += &format!("v {x} {y} {}\n", (x * 7 + y * 5) % 11);
        }
        for (x, y) in (0..SIDE).flat_map(|x| (0..SIDE).map(move |y| (x, y))) {
            let [a, b] = [x, x + 1].map(|x| x * (SIDE + 1) + y + 1);
            obj += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1);
        }
        for structure in ["BVH", "KDTREE", "MEDIAN", "BINARY", "RTREE"] {
            let text = format!(
                "settings s {{ accelerator {structure} integrator PHOTON_MAP photonMapSize 7 }}
                 Camera c {{ fps 25 Film f {{ width 8 height 8 }} CamSegment s {{ videoStart 0 videoEnd 1
                     addPosition {{ 0 -5 1 }} addTarget {{ 0 0 0 }} fovStart 0.4 }} }}
                 lamp_point l {{ power {{ 1 1 1 }} position {{ 0 0 9 }} }}
                 phong_info p {{ }} material_phong m {{ phong_info p }}
                 mesh land {{ filename land.obj material m }}"
            );
            let files = Files::in_memory("", [("land.obj".to_owned(), obj.clone().into_bytes())]);
            let loaded = load("scene.txt", text, &files);
            let said = loaded.diagnostics.render(false);
            let scene = loaded.scene.unwrap_or_else(|| panic!("{said}"));
            let estimate = structures(&scene, &Shown::of(&scene).unwrap());
            let frame = FrameScene::build(&scene, 0, Isa::best()).unwrap();
            let taken = frame.memory() as u64;
            assert!((taken..8 * taken).contains(&estimate), "{structure}: {estimate}, {taken}");
            assert_eq!(photons(&scene), (7 + 1_000_000) * OF_PHOTON);
        }
    }
}
