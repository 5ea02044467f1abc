//! What images and mixes make of surfaces: pictures whose values follow from the texels.

use std::f64::consts::PI;
use std::sync::Arc;

use slo_accel::Isa;
use slo_picture::film::FileLayer;
use slo_render::frame::FrameScene;
use slo_scene::{Layer, Mesh, SceneDescription, Shape, Texture};

use crate::support::{Picture, Shot, describe, expose, expose_frame, material, panel};

/// A texture of one texel, whose place the tests give to other images.
const TEXTURE: &str = "texture t { filename files/plank.png filter NEAREST } ";

/// The same, of texels that are never decoded.
const RAW: &str = "texture t { filename files/plank.png filter NEAREST encoding RAW } ";

/// An even grey of 0.8, as bytes.
fn grey() -> Texture {
    Texture::from_rgb8(1, 1, vec![204; 3]).expect("a texel")
}

/// Texels, red, green, blue and alpha, the top row first.
fn texels(width: u32, texels: &[[f32; 4]]) -> Texture {
    let height = texels.len() as u32 / width;
    // Stored multiplied by alpha.
    let stored = texels.iter().flat_map(|&[r, g, b, a]| [r * a, g * a, b * a, a]);
    Texture::from_rgba_f32(width, height, stored.collect()).expect("an image")
}

/// Gives a scene's first texture other texels.
fn paint(scene: &mut SceneDescription, image: Texture) {
    let old = &scene.textures[0];
    let image = image.with_wrap(old.wrap()).with_filter(old.filter());
    scene.textures[0] = Arc::new(image.with_encoding(old.encoding()));
}

/// Takes a picture in which the texture `t` has other texels.
fn take(shot: &Shot, elements: &str, image: Texture) -> Picture {
    let mut scene = describe(&shot.of(elements));
    paint(&mut scene, image);
    Picture(expose(&scene, Isa::best()).image())
}

/// A view of the floor's middle from above, up is +y.
fn above(settings: &str) -> Shot {
    Shot {
        from: vec![[0.0, 0.0, 6.0]],
        sky: [0.0, 1.0, 0.0],
        fov: 0.02,
        settings: format!("integrator PATH {settings}"),
        ..Shot::default()
    }
}

/// A square about the z axis: u grows along x, v along y.
fn square(name: &str, material: &str, z: f64) -> String {
    format!(
        "rectangle {name} {{ material {material} vertex0 {{ -9 -9 {z} }} vertex1 {{ 9 -9 {z} }}
         vertex2 {{ 9 9 {z} }} }} "
    )
}

fn matte(name: &str, more: &str) -> String {
    format!("material_principled {name} {{ ior 1 specular_ior_level 0 {more} }} ")
}

#[test]
fn an_even_image_is_a_factor_of_every_input() {
    let inputs = [
        ("metallic", 0.5),
        ("roughness", 0.7),
        ("diffuse_roughness", 0.6),
        ("ior", 1.75),
        ("alpha", 0.9),
        ("specular_ior_level", 0.5),
        ("anisotropic", 0.6),
        ("anisotropic_rotation", 0.3),
        ("transmission", 0.5),
        ("coat", 0.5),
        ("coat_roughness", 0.4),
        ("coat_ior", 1.9),
        ("sheen", 0.7),
        ("sheen_roughness", 0.6),
        ("emission_strength", 0.5),
        ("base_color", 0.9),
        ("specular_tint", 0.9),
        ("coat_tint", 0.5),
        ("sheen_tint", 0.9),
        ("emission_color", 0.5),
    ];
    let shot = Shot {
        fov: 0.15,
        samples: 1,
        settings: "integrator PATH background { .7 .8 .9 }".to_owned(),
        ..Shot::default()
    };
    let scene = |name: &str, value: f32, image: &str| {
        let numbers = inputs.map(|(input, usual)| {
            let value = if input == name { value } else { usual };
            if input.ends_with("color") || input.ends_with("tint") {
                format!("{input} {{ {value} {value} {value} }}")
            } else {
                format!("{input} {value}")
            }
        });
        let numbers = numbers.join(" ");
        format!(
            "{RAW} material_principled m {{ {numbers} {image} }}
             sphere s {{ material m center {{ 0 0 0 }} radius 1.4 sampled 0 }}
             lamp_point l {{ power {{ 40 40 40 }} position {{ 2 -3 2 }} radius .5 }}"
        )
    };
    for (name, usual) in inputs {
        let image = format!("{name}_texture t");
        let by_image = take(&shot, &scene(name, usual, &image), grey());
        let by_value = take(&shot, &scene(name, usual * 0.8, ""), grey());
        let without = take(&shot, &scene(name, usual, ""), grey());
        assert_eq!(by_image.0.rgb, by_value.0.rgb, "{name}");
        assert_ne!(by_image.0.rgb, without.0.rgb, "{name}");
    }
}

#[test]
fn an_even_image_is_a_factor_of_mixes() {
    let scene = |factor: &str| {
        let (black, white) =
            (matte("black", "base_color { 0 0 0 }"), matte("white", "base_color { .8 .8 .8 }"));
        format!(
            "{TEXTURE} {black} {white}
             material_mix m {{ first black second white factor {factor} }} {}",
            square("s", "m", 0.0)
        )
    };
    let shot = above("background { 1 1 1 }");
    let by_image = take(&shot, &scene(".5 factor_texture t"), grey());
    let by_value = take(&shot, &scene(".4"), grey());
    assert_eq!(by_image.0.rgb, by_value.0.rgb);
    by_image.assert_mean([0.4 * 0.8; 3], 0.01);
}

#[test]
fn colours_are_decoded_and_numbers_are_not() {
    // 188 is 0.5029 of the light that a screen shows, and 0.7373 of what a byte counts.
    let half = || Texture::from_rgb8(1, 1, vec![188; 3]).expect("a texel");
    let shot = above("background { 1 1 1 }");
    let floor = |more: &str| format!("{TEXTURE} {} {}", matte("m", more), square("s", "m", 0.0));
    let picture = take(&shot, &floor("base_color { 1 1 1 } base_color_texture t"), half());
    picture.assert_mean([0.502_886; 3], 0.002);
    let glow = "base_color { 0 0 0 } emission_strength 1 emission_strength_texture t";
    let picture = take(&shot, &floor(glow), half());
    picture.assert_is([188.0 / 255.0; 3], 1e-5);
    let glow = "base_color { 0 0 0 } emission_color { 1 .5 0 } emission_strength 2
        emission_color_texture t";
    let picture = take(&shot, &floor(glow), half());
    picture.assert_is([1.005_77, 0.502_886, 0.0], 1e-4);
}

#[test]
fn textures_lie_on_surfaces_as_their_blocks_say() {
    // Red grows with u, green with v; the camera sees the middle of the floor, u = v = 0.5.
    let image = || {
        let [width, height] = [8u32, 4];
        let pixel = |i: u32| {
            let (x, y) = (i % width, height - 1 - i / width);
            [x as f32 / 8.0, y as f32 / 4.0, 0.25, 0.75]
        };
        texels(width, &(0..width * height).map(pixel).collect::<Vec<_>>())
    };
    let glow = |block: &str| {
        let more = format!(
            "base_color {{ 0 0 0 }} emission_strength 1 emission_color_texture {{ texture t {block} }}"
        );
        format!("{RAW} {} {}", matte("m", &more), square("s", "m", 0.0))
    };
    let cases = [
        ("offset_U .07 offset_V .07", [4.0 / 8.0, 2.0 / 4.0, 0.25]),
        // (0.5, 0.5) scaled: (0.15, 0.4), texel (1, 1).
        ("scale_U .3 scale_V .8", [1.0 / 8.0, 1.0 / 4.0, 0.25]),
        // Scaled: (0.15, 0.4), turned to the left: (-0.4, 0.15), moved: (0.3, 0.85).
        ("scale_U .3 scale_V .8 turn_deg 90 offset_U .7 offset_V .7", [2.0 / 8.0, 3.0 / 4.0, 0.25]),
        ("offset_U .07 offset_V .07 channel B", [0.25; 3]),
        ("offset_U .07 offset_V .07 channel A", [0.75; 3]),
    ];
    for (block, expected) in cases {
        let picture = take(&above("background { 0 0 0 }"), &glow(block), image());
        picture.assert_is(expected, 1e-5);
    }
    // A number is the luminance of its image.
    let more = "base_color { 0 0 0 } emission_strength 1
        emission_strength_texture { texture t offset_U .07 offset_V .07 }";
    let floor = format!("{RAW} {} {}", matte("m", more), square("s", "m", 0.0));
    let picture = take(&above("background { 0 0 0 }"), &floor, image());
    picture.assert_is([0.2126 * 0.5 + 0.7152 * 0.5 + 0.0722 * 0.25; 3], 1e-5);
}

#[test]
fn wrap_counts_on_materials() {
    let image = || texels(2, &[[0.2, 0.2, 0.2, 1.0], [0.6, 0.6, 0.6, 1.0]]);
    // u = 1.2.
    for (wrap, expected) in [("REPEAT", 0.2), ("CLAMP", 0.6), ("MIRROR", 0.6)] {
        let texture = RAW.replace("NEAREST", &format!("NEAREST wrap {wrap}"));
        let more = "base_color { 0 0 0 } emission_strength 1
            emission_color_texture { texture t offset_U .7 }";
        let floor = format!("{texture} {} {}", matte("m", more), square("s", "m", 0.0));
        take(&above(""), &floor, image()).assert_is([expected; 3], 1e-5);
    }
    // Interpolated: a quarter of the way between the centres, which lie at 0.25 and 0.75.
    let texture = RAW.replace("NEAREST", "LINEAR");
    let more = "base_color { 0 0 0 } emission_strength 1
        emission_color_texture { texture t offset_U -.125 }";
    let floor = format!("{texture} {} {}", matte("m", more), square("s", "m", 0.0));
    take(&above(""), &floor, image()).assert_mean([0.3; 3], 1e-3);
}

#[test]
fn phong_parts_of_mixes_show_their_textures() {
    let image = || texels(1, &[[0.8, 0.4, 0.2, 1.0]]);
    let mix = format!(
        "{TEXTURE} phong_info i {{ diffuse {{ .5 .5 .5 }} }}
         material_texture phong {{ phong_info i texture t }} {}
         material_mix m {{ first black second phong factor .5 }} {}",
        matte("black", "base_color { 0 0 0 }"),
        square("s", "m", 0.0)
    );
    let picture = take(&above("background { 1 1 1 }"), &mix, image());
    picture.assert_mean([0.2, 0.1, 0.05], 0.015);
}

const SUN: &str = "lamp_sun l { irradiance { 3 3 3 } direction { 0 0 -1 } angle_deg 0 } ";

#[test]
fn panes_in_a_row_multiply() {
    // The camera sees the floor through two panes, and the sun lights it through both.
    let pane = matte("pane", "base_color { 0 0 0 } alpha .25");
    let floor = matte("m", "base_color { .6 .6 .6 }") + &square("f", "m", 0.0) + SUN;
    let panes = square("p", "pane", 2.0) + &square("q", "pane", 3.0);
    let picture = above("").take(&(floor.clone() + &pane + &panes));
    picture.assert_mean([0.6 / PI * 3.0 * 0.5625 * 0.5625; 3], 0.012);
    // From below both: exact, since rays to lamps multiply.
    let shot = Shot { from: vec![[0.0, 0.0, 1.0]], recursion: 0, ..above("") };
    let picture = shot.take(&(floor.clone() + &pane + &panes));
    picture.assert_is([0.6 / PI * 3.0 * 0.5625; 3], 1e-5);
    // What blocks light blocks it behind a pane, too.
    let picture = shot.take(&(floor + &pane + &square("p", "pane", 2.0) + &square("q", "m", 3.0)));
    picture.assert_is([0.0; 3], 0.0);
}

#[test]
fn rays_to_near_lamps_end_there_behind_panes() {
    let pane = matte("pane", "base_color { 0 0 0 } alpha .25");
    let floor = matte("m", "base_color { .6 .6 .6 }") + &square("f", "m", 0.0);
    let panes = square("p", "pane", 2.0) + &square("q", "pane", 3.0);
    // What lies behind the lamps is no obstacle.
    let roof = square("r", "m", 5.0);
    let lamps = [
        ("lamp_point l { power { 90 90 90 } position { 0 0 4 } }", 90.0 / (4.0 * PI * 16.0)),
        (
            "lamp_disc l { radiance { 50 50 50 } center { 0 0 4 } normal { 0 0 -1 } radius .01 }",
            PI * 50.0 * 1e-4 / 16.0,
        ),
        (
            "lamp_point l { power { 90 90 90 } position { 0 0 4 } radius .01 }",
            90.0 / (4.0 * PI * 16.0),
        ),
    ];
    let shot = Shot { from: vec![[0.0, 0.0, 1.0]], recursion: 0, ..above("") };
    for (lamp, irradiance) in lamps {
        let picture = shot.take(&(floor.clone() + &pane + &panes + &roof + lamp));
        picture.assert_mean([0.6 / PI * irradiance * 0.5625; 3], 0.002);
    }
}

#[test]
fn continuations_pass_panes_in_proportion() {
    // Only rays that follow lobes find this sky: the floor is a mirror.
    let scene = "material_principled m { base_color { 1 1 1 } metallic 1 roughness 0 } ".to_owned()
        + &square("f", "m", 0.0)
        + &matte("pane", "base_color { 0 0 0 } alpha .25")
        + &square("p", "pane", 2.0)
        + &square("q", "pane", 3.0);
    let shot = Shot { from: vec![[0.0, 0.0, 1.0]], ..above("background { 1 1 1 }") };
    shot.take(&scene).assert_mean([0.5625; 3], 0.01);
}

#[test]
fn passing_is_no_bounce() {
    // The last ray of a path collects what glows, behind panes too.
    let scene = "material_principled m { base_color { 1 1 1 } metallic 1 roughness 0 } ".to_owned()
        + &square("f", "m", 0.0)
        + &matte("pane", "base_color { 0 0 0 } alpha .25")
        + &square("p", "pane", 2.0)
        + &square("q", "pane", 3.0);
    let from = vec![[0.0, 0.0, 1.0]];
    let shot = Shot { from, recursion: 0, ..above("background { 1 1 1 }") };
    shot.take(&scene).assert_mean([0.5625; 3], 0.01);
}

#[test]
fn cutouts_cast_shadows_of_their_holes() {
    // A pane that is solid on the left half. The camera looks at the floor from below the pane.
    let image = || texels(2, &[[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 0.0]]);
    let scene = |pane: &str| {
        TEXTURE.replace("plank", "clear")
            + pane
            + &matte("m", "base_color { .6 .6 .6 }")
            + &square("f", "m", 0.0)
            + &square("p", "pane", 2.0)
            + SUN
    };
    let cutout = matte("pane", "base_color { 0 0 0 } alpha_texture t");
    let mixed = matte("hole", "alpha 0")
        + &material("wall", "diffuse { 0 0 0 }")
        + "material_mix pane { first wall second hole factor 1
           factor_texture { texture t channel A scale_U -1 } } ";
    for pane in [cutout, mixed] {
        let shot = Shot { from: vec![[0.0, 0.0, 1.0]], recursion: 0, ..above("") };
        let picture = take(&shot, &scene(&pane), image());
        for x in 0..64 {
            let expected = if x < 32 { 0.0 } else { 0.6 / PI * 3.0 };
            assert!((picture.at(x, 32)[0] - expected).abs() < 1e-5, "{x}: {:?}", picture.at(x, 32));
        }
        // From above, the solid half hides the floor: the other half shows it lit.
        let picture = take(&above(""), &scene(&pane), image());
        assert_eq!(picture.at(10, 20), [0.0; 3]);
        assert!((picture.at(50, 20)[0] - 0.6 / PI * 3.0).abs() < 1e-5);
    }
}

#[test]
fn what_glows_in_part_lights_in_part() {
    // A ceiling whose alpha is 0.25 under a black sky; without an image and with one.
    let floor = matte("m", "base_color { .6 .6 .6 }") + &square("f", "m", 0.0);
    let image = || texels(1, &[[1.0, 1.0, 1.0, 0.25]]);
    for alpha in ["alpha .25", "alpha_texture t"] {
        let ceiling = matte("c", &format!("base_color {{ 0 0 0 }} emission_strength 1 {alpha}"));
        let scene = TEXTURE.replace("plank", "clear") + &floor + &ceiling + &square("c", "c", 0.01);
        let shot = Shot { from: vec![[0.0, 0.0, 0.009]], ..above("background { 0 0 0 }") };
        take(&shot, &scene, image()).assert_mean([0.6 * 0.25; 3], 0.02);
    }
}

/// The normals that a shot sees of a scene with other texels in its texture and other meshes.
fn normals(shot: &Shot, elements: &str, image: Texture, change: impl Fn(&mut Mesh)) -> Picture {
    let mut scene = describe(&shot.of(elements));
    scene.camera.film.layers = Layer::ALL.to_vec();
    paint(&mut scene, image);
    for object in &mut scene.objects {
        if let Shape::Mesh(surface) = &mut object.shape {
            change(Arc::make_mut(&mut surface.mesh));
        }
    }
    let frame = FrameScene::build(&scene, 0, Isa::best()).expect("the frame can be built");
    let film = expose_frame(&scene, &frame);
    Picture(film.layer_of(film.area(), &FileLayer::Normal))
}

/// The normal that a shot sees in its middle.
fn normal(shot: &Shot, elements: &str, image: Texture, change: impl Fn(&mut Mesh)) -> [f64; 3] {
    let shot = Shot { samples: 4, ..shot.clone() };
    normals(&shot, elements, image, change).at(32, 32)
}

#[track_caller]
fn assert_near(found: [f64; 3], expected: [f64; 3]) {
    let near = |k: usize| (found[k] - expected[k]).abs() < 2e-3;
    assert!((0..3).all(near), "{found:?}, expected {expected:?}");
}

/// Red shows along the tangent: the normal is (0.6, 0, 0.8) of tangent, bitangent and normal.
fn red() -> Texture {
    texels(1, &[[0.8, 0.5, 0.9, 1.0]])
}

/// The normal is (0, 0.6, 0.8).
fn green() -> Texture {
    texels(1, &[[0.5, 0.8, 0.9, 1.0]])
}

const BUMPY: &str = "texture t { filename files/plank.png }
    material_principled m { normal_texture t } ";

#[test]
fn maps_of_normals_bend_along_u_and_v() {
    let floor = BUMPY.to_owned() + &square("s", "m", 0.0);
    let shot = above("background { 1 1 1 }");
    assert_near(normal(&shot, &floor, red(), |_| ()), [0.6, 0.0, 0.8]);
    assert_near(normal(&shot, &floor, green(), |_| ()), [0.0, 0.6, 0.8]);
    // From the other side, the same bumps are dents.
    let below = Shot { from: vec![[0.0, 0.0, -6.0]], ..shot.clone() };
    assert_near(normal(&below, &floor, red(), |_| ()), [-0.6, 0.0, -0.8]);
    assert_near(normal(&below, &floor, green(), |_| ()), [0.0, -0.6, -0.8]);
    // Half as strong: (0.3, 0, 0.9).
    let weak = floor.replace("normal_texture t", "normal_texture t normal_strength .5");
    let length = 0.9f64.hypot(0.3);
    assert_near(normal(&shot, &weak, red(), |_| ()), [0.3 / length, 0.0, 0.9 / length]);
}

#[test]
fn flat_maps_and_weak_ones_change_nothing() {
    let flat = || texels(1, &[[0.5, 0.5, 1.0, 1.0]]);
    let shot = Shot { fov: 0.15, samples: 4, ..above("background { 1 1 1 }") };
    let ball = "mesh b { material m filename files/ball.obj smooth_normals 1 } ";
    let sphere = "sphere b { material m center { 0 0 0 } radius 1.4 } ";
    for shape in [ball, sphere] {
        let plain = format!("{TEXTURE} material_principled m {{ roughness .5 }} {shape}");
        let expected = normals(&shot, &plain, flat(), |_| ());
        for (more, image) in [("", flat()), ("normal_strength 0", red())] {
            let bumpy = plain.replace(".5 }", &format!(".5 normal_texture t {more} }}"));
            let found = normals(&shot, &bumpy, image, |_| ());
            for (a, b) in found.0.rgb.iter().zip(&expected.0.rgb) {
                let near = (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5);
                assert!(near, "{a:?}, not {b:?}: {shape} {more}");
            }
        }
    }
}

/// Texture coordinates at x and y.
type Uv = fn(f32, f32) -> [f32; 2];

/// Makes a mesh a square about the z axis, of two triangles.
fn mapped(mesh: &mut Mesh, uv: Uv) {
    let corners = [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    *mesh = Mesh {
        positions: corners.map(|[x, y]| [x, y, 0.0].map(f64::from).into()).to_vec(),
        faces: vec![[0, 1, 2], [0, 2, 3]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: corners.map(|[x, y]| uv(x, y)).to_vec(),
        face_uvs: vec![[0, 1, 2], [0, 2, 3]],
        tangents: Vec::new(),
    };
}

#[test]
fn meshes_have_the_axes_of_their_uvs() {
    let ball = "mesh b { material m filename files/ball.obj smooth_normals SMOOTH MOVE } ";
    let moves = "addKframe { time 0 key { pivot { -.1 0 0 } right { 0 1 0 } up { 0 0 1 } } }
        addKframe { time 1 key { pivot { .1 0 0 } right { 0 1 0 } up { 0 0 1 } } }";
    let shot = Shot { blur: 1.0, ..above("background { 1 1 1 }") };
    // uv, and where red and green point.
    let cases: [(Uv, [f64; 3], [f64; 3]); 3] = [
        (|x, y| [x, y], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]),
        // Mirrored.
        (|x, y| [-x, y], [-0.6, 0.0, 0.8], [0.0, 0.6, 0.8]),
        // Turned.
        (|x, y| [y, -x], [0.0, 0.6, 0.8], [-0.6, 0.0, 0.8]),
    ];
    for smooth in ["0", "1"] {
        for (uv, of_red, of_green) in cases {
            for mikk in [false, true] {
                let change = |mesh: &mut Mesh| {
                    mapped(mesh, uv);
                    if mikk {
                        mesh.add_tangents();
                        assert_eq!(mesh.tangents.len(), 2);
                    }
                };
                let still = ball.replace("SMOOTH", smooth).replace("MOVE", "");
                let still = BUMPY.to_owned() + &still;
                assert_near(normal(&shot, &still, red(), change), of_red);
                assert_near(normal(&shot, &still, green(), change), of_green);
                let moving = ball.replace("SMOOTH", smooth).replace("MOVE", moves);
                let moving = BUMPY.to_owned() + &moving;
                // Turned by 90 degrees: x to y, and y to -x.
                let turned = |[x, y, z]: [f64; 3]| [-y, x, z];
                assert_near(normal(&shot, &moving, red(), change), turned(of_red));
                assert_near(normal(&shot, &moving, green(), change), turned(of_green));
            }
        }
    }
}

#[test]
fn round_shapes_have_the_axes_of_their_uvs() {
    let shot = Shot {
        fov: 0.002,
        from: vec![[3.0, -10.0, 0.0]],
        to: vec![[3.0, 0.0, 0.0]],
        settings: "integrator PATH background { 1 1 1 }".to_owned(),
        ..Shot::default()
    };
    // The camera sees -y. A sphere's u grows to the east, v to the north.
    let sphere = "sphere s { material m center { 3 0 0 } radius 1 }";
    // u runs around the axis, v along it.
    let upright = "cylinder c { material m base { 3 0 -1 } top { 3 0 1 } radius 1 }";
    let lying = "cylinder c { material m base { 2 0 0 } top { 4 0 0 } radius 1 }";
    let cases = [
        (sphere, [0.6, -0.8, 0.0], [0.0, -0.8, 0.6]),
        (upright, [0.6, -0.8, 0.0], [0.0, -0.8, 0.6]),
        (lying, [0.0, -0.8, -0.6], [0.6, -0.8, 0.0]),
    ];
    for (shape, of_red, of_green) in cases {
        let scene = BUMPY.to_owned() + shape;
        assert_near(normal(&shot, &scene, red(), |_| ()), of_red);
        assert_near(normal(&shot, &scene, green(), |_| ()), of_green);
    }
    // The ends of a cylinder: u along x, v along the axis times x.
    let ends = "cylinder c { material m base { 3 -1 0 } top { 3 1 0 } radius 1 }";
    let scene = BUMPY.to_owned() + ends;
    // Axis y: u starts along z x y = -x, v along y x -x = z.
    assert_near(normal(&shot, &scene, red(), |_| ()), [-0.6, -0.8, 0.0]);
    assert_near(normal(&shot, &scene, green(), |_| ()), [0.0, -0.8, 0.6]);
    let behind = Shot { from: vec![[3.0, 10.0, 0.0]], ..shot };
    assert_near(normal(&behind, &scene, red(), |_| ()), [-0.6, 0.8, 0.0]);
    assert_near(normal(&behind, &scene, green(), |_| ()), [0.0, 0.8, 0.6]);
}

#[test]
fn matte_bumps_are_lit_as_their_normals_say() {
    // The sun stands over the floor, so cos is 0.8 at first.
    let bumpy = "texture t { filename files/plank.png }
        material_principled m { base_color { .6 .6 .6 } ior 1 specular_ior_level 0 normal_texture t } ";
    let floor = bumpy.to_owned() + &square("s", "m", 0.0) + SUN;
    let shot = Shot { recursion: 0, ..above("") };
    take(&shot, &floor, red()).assert_mean([0.6 / PI * 3.0 * 0.8; 3], 1e-3);
    let slanted = floor.replace("{ 0 0 -1 }", "{ -.6 0 -.8 }");
    take(&shot, &slanted, red()).assert_mean([0.6 / PI * 3.0; 3], 1e-3);
    take(&shot, &slanted, green()).assert_mean([0.6 / PI * 3.0 * 0.64; 3], 1e-3);
    let panel = bumpy.to_owned() + &panel("s", "m", [-9.0, 9.0], 0.0, [-9.0, 9.0]);
    let sun = "lamp_sun l { irradiance { 3 3 3 } direction { 0 .8 -.6 } angle_deg 0 } ";
    let front =
        Shot { settings: "integrator PATH".to_owned(), fov: 0.02, recursion: 0, ..Shot::default() };
    take(&front, &(panel + sun), green()).assert_mean([0.6 / PI * 3.0; 3], 1e-3);
}
