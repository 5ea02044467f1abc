//! Very many copies, which are kept as a crowd, are what they would be one by one.

use std::sync::Arc;

use rand::{RngExt, SeedableRng, rngs::StdRng};
use slo_accel::Isa;
use slo_accel::glam::DVec3;
use slo_render::frame::FrameScene;
use slo_scene::shape::MeshSurface;
use slo_scene::{Mesh, Placements, SceneDescription, Shape};

use crate::support::{Picture, Shot, describe, expose_frame};

const LOOKS: &str = "material_principled red { base_color { .8 .2 .1 } roughness .3 }
    material_principled grey { base_color { .5 .5 .5 } }
    plane floor { material grey normal { 0 0 1 } position { 0 0 -9 } }
    lamp_point l { power { 3000 3000 2500 } position { 3 -20 9 } }
    environment sky { radiance { .3 .3 .4 } } ";

fn shot(blur: f64) -> Shot {
    let settings = "integrator PATH".to_owned();
    Shot { samples: 8, blur, from: vec![[0.0, -30.0, 0.0]], settings, ..Shot::default() }
}

/// A bumpy ball of `2 * side * side` triangles.
fn ball(side: usize) -> Mesh {
    use std::f64::consts::PI;
    let point = |i: usize, j: usize| {
        let (u, v) =
            (2.0 * PI * i as f64 / side as f64, PI * (j as f64 + 0.5) / (side as f64 + 1.0));
        let ([(sin_u, cos_u), (sin_v, cos_v)], bump) =
            ([u, v].map(libm::sincos), libm::sin(5.0 * u));
        DVec3::new(sin_v * cos_u, sin_v * sin_u, cos_v) * (0.3 + 0.05 * bump)
    };
    let positions: Vec<_> = (0..=side).flat_map(|i| (0..=side).map(move |j| point(i, j))).collect();
    let at = |i: usize, j: usize| (i * (side + 1) + j) as u32;
    let faces = (0..side).flat_map(|i| {
        (0..side).flat_map(move |j| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
    });
    let normals = positions.iter().map(|p| p.normalize().as_vec3().to_array()).collect();
    Mesh { faces: faces.collect(), normals, positions, ..mesh_of_nothing() }
}

fn mesh_of_nothing() -> Mesh {
    Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        faces: Vec::new(),
        uvs: Vec::new(),
        face_uvs: Vec::new(),
        tangents: Vec::new(),
    }
}

/// Places in a box, scaled, turned and tinted.
fn places(count: usize, size: [f64; 3], kinds: u32) -> Placements {
    let mut rng = StdRng::seed_from_u64(7);
    let mut all = Placements::default();
    for _ in 0..count {
        let place = DVec3::from_array(size.map(|size| rng.random_range(-size..size)));
        let turn = [0; 4].map(|_| rng.random_range(-1.0f32..1.0));
        let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt().max(0.01);
        all.positions.push(place);
        all.turns.push(turn.map(|x| x / length));
        all.scales.push([0; 3].map(|_| rng.random_range(0.5f32..1.5)));
        all.kinds.push(rng.random_range(0..kinds));
        all.tints.push([0; 3].map(|_| rng.random_range(0.1f32..1.0)));
    }
    all
}

/// Placements `range` of others.
fn some(of: &Placements, range: std::ops::Range<usize>) -> Arc<Placements> {
    Arc::new(Placements {
        positions: of.positions[range.clone()].to_vec(),
        turns: of.turns[range.clone()].to_vec(),
        scales: of.scales[range.clone()].to_vec(),
        kinds: of.kinds[range.clone()].to_vec(),
        tints: of.tints[range].to_vec(),
    })
}

/// A scene whose meshes are `mesh`.
fn scene(shot: &Shot, elements: &str, mesh: &Arc<Mesh>) -> SceneDescription {
    let mut scene = describe(&shot.of(&format!("{LOOKS} {elements}")));
    for object in &mut scene.objects {
        if let Shape::Mesh(surface) = &object.shape {
            object.shape = Shape::Mesh(MeshSurface::new(mesh.clone(), surface.smooth));
        }
    }
    scene
}

const ORIGINALS: &str = "group pair { hidden 1 }
    mesh a { filename files/ball.obj material red smooth_normals 1 parent pair }
    mesh b { filename files/ball.obj material grey parent pair
        addKframe { time 0 key { pivot { .4 0 .2 } right { 0 1 0 } scale { .5 1 .5 } } } }
    sphere d { center { .2 0 -.4 } radius .15 material grey parent pair }
    mesh c { filename files/ball.obj material grey hidden 1 } ";

#[track_caller]
fn assert_same(a: &Picture, b: &Picture) {
    let differ = a.0.rgb.iter().zip(&b.0.rgb).filter(|(a, b)| a != b).count();
    assert!(differ == 0 && a.sum(0) > 100.0, "{differ} pixels differ, of {}", a.sum(0));
}

/// How many pixels differ by more than `by` in any channel.
fn differ(a: &Picture, b: &Picture, by: f32) -> usize {
    let far = |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).any(|c| (a[c] - b[c]).abs() > by);
    a.0.rgb.iter().zip(&b.0.rgb).filter(far).count()
}

#[test]
fn a_crowd_at_rest_is_its_copies_to_the_last_bit() {
    let (shot, mesh) = (shot(0.0), Arc::new(ball(16)));
    let places = places(3000, [9.0, 9.0, 5.0], 2);
    let at = "placements files/row.ply
        addKframe { time 0 key { pivot { 0 2 0 } right { 1 .3 0 } scale { 1 1 1.2 } } }";
    let crowd = format!("{ORIGINALS} copies one {{ of pair of c {at} }}");
    let mut crowd = scene(&shot, &crowd, &mesh);
    crowd.copies[0].placements = Some(some(&places, 0..3000));
    // Fewer copies are written out, one by one.
    let halves = format!(
        "{ORIGINALS} copies one {{ of pair of c {at} }} copies two {{ of pair of c {at} }}"
    );
    let mut halves = scene(&shot, &halves, &mesh);
    halves.copies[0].placements = Some(some(&places, 0..1500));
    halves.copies[1].placements = Some(some(&places, 1500..3000));
    let memory = |scene| FrameScene::build(scene, 0, Isa::best()).expect("it is built").memory();
    let [of_crowd, of_halves] = [&crowd, &halves].map(memory);
    assert!(3 * of_crowd < 2 * of_halves, "{of_crowd}, {of_halves}");
    // The next frame finds the crowd placed.
    let first = FrameScene::build(&crowd, 0, Isa::best()).expect("it is built");
    let next = FrameScene::build_with(&crowd, 0, Isa::best(), first.remains());
    let next = Picture(expose_frame(&crowd, &next.expect("it is built")).image());
    let [crowd, halves] = [&crowd, &halves].map(|scene| Picture(shot.film(scene).image()));
    assert_same(&crowd, &halves);
    assert_same(&crowd, &next);
}

#[test]
fn a_crowd_that_moves_is_blurred_as_its_copies_are() {
    let (shot, mesh) = (shot(1.0), Arc::new(ball(16)));
    let places = places(3000, [9.0, 9.0, 5.0], 2);
    let at = "placements files/row.ply
        addKframe { time 0 key { pivot { 0 2 0 } right { 1 .3 0 } } }
        addKframe { time 1 key { pivot { 2 2 0 } right { 1 .4 0 } } }";
    let crowd = format!("{ORIGINALS} copies one {{ of pair of c {at} }}");
    let mut crowd = scene(&shot, &crowd, &mesh);
    crowd.copies[0].placements = Some(some(&places, 0..3000));
    let halves = format!(
        "{ORIGINALS} copies one {{ of pair of c {at} }} copies two {{ of pair of c {at} }}"
    );
    let mut halves = scene(&shot, &halves, &mesh);
    halves.copies[0].placements = Some(some(&places, 0..1500));
    halves.copies[1].placements = Some(some(&places, 1500..3000));
    let still = at.split("addKframe { time 1").next().unwrap_or("");
    let still = format!("{ORIGINALS} copies one {{ of pair of c {still} }}");
    let mut still = scene(&shot, &still, &mesh);
    still.copies[0].placements = Some(some(&places, 0..3000));
    let [crowd, halves, still] =
        [&crowd, &halves, &still].map(|scene| Picture(shot.film(scene).image()));
    // Poses are sampled at other times, at most half a pixel apart.
    for channel in 0..3 {
        let ratio = crowd.sum(channel) / halves.sum(channel);
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }
    let (near, far) = (differ(&crowd, &halves, 0.1), differ(&crowd, &still, 0.1));
    assert!(near < 40 && far > 200, "{near}, {far}");
}

#[test]
fn copies_of_copies_stay_nested_if_they_are_very_many() {
    let (shot, mesh) = (shot(0.0), Arc::new(ball(4)));
    let leaves = places(400, [0.5, 0.5, 1.0], 1);
    let mut trees = places(3000, [9.0, 9.0, 5.0], 1);
    // All but 100 lie behind the floor.
    for place in &mut trees.positions[100..] {
        place.z -= 20.0;
    }
    let elements = "mesh leaf { filename files/ball.obj material red smooth_normals 1 hidden 1 }
        group tree { hidden 1 }
        mesh trunk { filename files/ball.obj material grey parent tree }
        copies leaves { of leaf placements files/many.ply parent tree }
        copies wood { of tree placements files/many.ply
            addKframe { time 0 key { pivot { 0 2 0 } right { 1 .3 0 } } } }";
    let taken = |count: usize| {
        let mut scene = scene(&shot, elements, &mesh);
        scene.copies[0].placements = Some(some(&leaves, 0..400));
        scene.copies[1].placements = Some(some(&trees, 0..count));
        let frame = FrameScene::build(&scene, 0, Isa::best()).expect("it is built");
        (frame.memory(), Picture(shot.film(&scene).image()))
    };
    let (memory, nested) = taken(3000);
    assert!(memory < 2 << 20, "{memory}");
    let (_, flat) = taken(100);
    let (near, far) = (differ(&nested, &flat, 0.02), differ(&nested, &taken(50).1, 0.02));
    assert!(near < 20 && far > 200, "{near}, {far}");
}
