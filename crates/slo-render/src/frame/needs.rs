//! What a frame takes while it is built, estimated before.

use std::collections::HashMap;
use std::sync::Arc;

use super::error::FrameError;
use super::shared::MOST_COPIED;
use super::shown::Shown;
use crate::photons::{MOST_PATHS, Photon, pass_of, samples_of};
use slo_scene::settings::{Accelerator, Integrator};
use slo_scene::{SceneDescription, Shape, memory};

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

/// Bytes of each photon of a pass, while its map is made.
const OF_PASS: u64 = 2 * (size_of::<Photon>() as u64 + 16);

/// Checks that there is memory for the structures of what a frame shows, and for its photons.
pub(super) fn check(scene: &SceneDescription, shown: &Shown<'_>) -> Result<(), FrameError> {
    let refused = |what: &'static str, help: &'static str| {
        move |refusal: memory::Refusal| FrameError::Memory { what, why: refusal.to_string(), help }
    };
    memory::check(structures(scene, shown)).map_err(refused(
        "the structures of the frame's objects need",
        "give meshes with fewer triangles, or leave objects out",
    ))?;
    memory::check(photons(scene))
        .map_err(refused("the photons need", "lower `photonMapSize` and `causticMapSize`"))
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
    memory::check(paths * OF_PASS).map_err(|refusal| FrameError::Memory {
        what: "the photons of a pass need",
        why: refusal.to_string(),
        help: "lower `photons`",
    })
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
