//! Whole files: what their scenes say, and that slo-rt reads them.

mod aff;
mod inventor;

use std::fs;
use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};
use slo_scene::{Files, SceneDescription, Shape, load};

use crate::{Imported, import};

/// Imports a file from a folder that holds these files; the first is imported. Its scene is read again.
fn scene_of(files: &[(&str, &str)]) -> (Imported, SceneDescription) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let imported = import(&folder.path().join(files[0].0), false).unwrap();
    let scene = read(&imported);
    (imported, scene)
}

fn read(imported: &Imported) -> SceneDescription {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &imported.files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let loaded =
        load("scene.txt", &imported.text, &Files::on_disk(folder.path(), folder.path(), false));
    loaded
        .scene
        .unwrap_or_else(|| panic!("{}\n{}", loaded.diagnostics.render(false), imported.text))
}

fn says(imported: &Imported, expected: &str) {
    assert!(imported.text.contains(expected), "{expected}\n{}", imported.text);
}

/// The message about a file that can't be imported.
fn refused(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), bytes).unwrap();
    let error = import(&folder.path().join(name), false).unwrap_err().to_string();
    error.replace(&folder.path().display().to_string(), "").replace("/", "")
}

const NFF: &str = "# a comment
v
from 0 -5 1
at 0 0 0
up 0 0 1
angle 90
hither 1
resolution 64 32
b 0.1 0.2 0.3
l 3 -4 5
l 1 1 9 1 .5 .25
f 1 .5 0 .5 .25 8 0 0
s 0 0 1 1
f .2 .2 .2 1 0 0 .9 1.5
c 0 0 0 .5  0 0 2 .5
c 2 0 0 .5  2 0 2 0
f 1 .5 0 .5 .25 8 0 0
p 4  -5 -5 0  5 -5 0  5 5 0  -5 5 0
pp 3  0 0 3 0 0 1  1 0 3 0 0 1  0 1 3 0 0 1
";

#[test]
fn nff() {
    let (imported, scene) = scene_of(&[("a.nff", NFF)]);
    assert_eq!(imported.shapes, (64 + 2 + 1, 2));
    assert_eq!((imported.materials, imported.lamps), (2, 2), "equal fills are one material");
    assert_eq!(imported.left_out, ["that a cylinder is open at its ends"]);
    assert!(imported.made_up.is_empty());
    assert_eq!((scene.camera.film.width, scene.camera.film.height), (64, 32));
    // Two lights weigh sqrt(2) / 4.
    says(&imported, "light_point light_2 { color { 0.3535534 0.1767767 0.0883883 }");
    says(&imported, "phong_info fill { diffuse { 0.5 0.25 0 }");
    says(&imported, "background { 0.1 0.2 0.3 }");
}

#[test]
fn a_camera_that_looks_along_its_up_vector_gets_another() {
    let made_up = ["which way is up, as the camera looks along its up vector"];
    for (from, up, expected) in [
        ("0 0 5", "0 0 1", "skyStart { 0 1 0 }"),
        ("0 0 5", "1e-9 0 -3", "skyStart { 0 1 0 }"),
        ("0 -5 0", "0 2 0", "skyStart { 0 0 1 }"),
    ] {
        let text = NFF.replace("from 0 -5 1", &format!("from {from}"));
        let (imported, _) = scene_of(&[("a.nff", &text.replace("up 0 0 1", &format!("up {up}")))]);
        says(&imported, expected);
        assert_eq!(imported.made_up, made_up);
    }
    // A target so near that it would be rounded to where the camera is.
    let text = NFF.replace("from 0 -5 1\nat 0 0 0", "from 0 -5 1\nat 0 -4.99999999 1");
    let (imported, _) = scene_of(&[("a.nff", &text)]);
    says(&imported, "addTarget { 0 0 1 }");
    assert!(imported.made_up.is_empty());
}

/// slo-rt refuses a mesh of which nothing can be seen.
#[test]
fn meshes_without_an_area_are_left_out() {
    let seen = "v 0 0 0\nv 1 0 0\nv 0 1 0\no seen\nf 1 2 3\no hollow\n";
    let (a, b) = ("0.1 0.2 0.3", "0.4 0.8 1.2");
    for face in [
        // On one line, though not if differences are rounded to f32.
        "v 14599 39305 0\nv 344604 927780 0\nv 9374144 25238080 0\nf 4 5 6".to_owned(),
        // Points that single precision does not tell apart.
        format!("v {a}\nv {b}\nv 0.400000001 0.8 1.2\nf 4 5 6"),
        // Polygons.
        format!("v {a}\nv {b}\nv {a}\nv {b}\nf 4 5 6 7"),
        "v 1 1 1\nv 2 2 2\nv 3 3 3\nv 5 5 5\nf 4 5 6 7".to_owned(),
    ] {
        let (imported, scene) = scene_of(&[("a.obj", &format!("{seen}{face}"))]);
        assert_eq!(scene.objects.len(), 1, "{face}");
        assert!(
            imported.left_out[0].starts_with("a triangle without an area"),
            "{:?}",
            imported.left_out
        );
    }
    // A polygon that crosses itself is seen.
    let (_, scene) =
        scene_of(&[("a.obj", &format!("{seen}v 0 0 5\nv 1 1 5\nv 1 0 5\nv 0 1 5\nf 4 5 6 7"))]);
    assert_eq!(scene.objects.len(), 2);
}

#[test]
fn mistakes_in_nff_have_their_line() {
    for (text, expected) in [
        ("f 1 1 1\nx", "`a.nff`, line 2: expected a number instead of `x`"),
        ("s 0 0 0 1\nq 3", "`a.nff`, line 2: `q` is not an item of NFF"),
        (
            "p 2 0 0 0 1 1 1",
            "`a.nff`, line 1: expected a whole number from 3 to 65536 instead of 2",
        ),
        ("s 0 0", "`a.nff`, line 1: a number is missing at the end"),
        ("# nothing", "`a.nff`: there is nothing to see in it: no surface"),
    ] {
        assert_eq!(refused("a.nff", text), expected);
    }
    assert!(refused("a.xyz", "1 2 3").contains("its format is not known"));
    assert!(refused("a.ply", "ply\nformat ascii 1.0\nend_header\n").contains("`a.ply`"));
}

#[test]
fn obj_with_materials() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
               o sheet\nusemtl blue\nf 1/1 2/2 3/3\nf 1 3 4\nusemtl gone\nf -1 -2 -3 -4 -5\nl 1 2\n";
    let mtl = "newmtl blue\nKd 0 0 1\nPr .25\nPm 1\nmap_Bump gone.png\nnewmtl unused\nKe 1 1 1\n";
    let (imported, scene) = scene_of(&[("a.obj", obj), ("a.mtl", mtl)]);
    assert_eq!(imported.shapes, (5, 0));
    let left_out = imported.left_out.join("; ");
    assert_eq!(
        left_out,
        "`map_Bump` of MTL; points or lines; the material `gone`, which no file defines"
    );
    assert!(imported.made_up[0].starts_with("which axis is up"));
    assert_eq!(scene.objects.len(), 2);
    says(&imported, "blue { base_color { 0 0 1 }  roughness 0.25  metallic 1 }");
    assert_eq!(scene.materials.len(), 2, "what nothing has is dropped");
    let message = "`a.obj`, line 2: vertex 3 does not exist (so far there are 1)";
    assert_eq!(refused("a.obj", "v 0 0 0\nf 1 2 3\n".replace("f 1 2", "f 3 1")), message);
}

#[test]
fn files_outside_of_the_folder_are_not_read() {
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("a.mtl"), "newmtl m\nKd 1 0 0\n").unwrap();
    fs::create_dir(outside.path().join("in")).unwrap();
    let path = outside.path().join("in/a.obj");
    fs::write(&path, "mtllib ../a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n").unwrap();
    assert!(!import(&path, false).unwrap().text.contains("material_principled m "));
    assert!(import(&path, true).unwrap().text.contains("material_principled m "));
}

/// A glTF file of a triangle in the plane z = 0, with these parts added or replaced.
fn gltf(parts: &Value) -> String {
    use base64::Engine;
    let mut bytes: Vec<u8> = Vec::new();
    let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, /* times */ 0.0, 2.0];
    let values =
        [/* translations */ 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, /* weights */ 0.0, 1.0];
    for number in floats.into_iter().chain(values) {
        bytes.extend_from_slice(&f32::to_le_bytes(number));
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let mut file = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "tri" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}") }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 40 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2] },
            { "bufferView": 1, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3" },
            { "bufferView": 1, "byteOffset": 32, "componentType": 5126, "count": 2, "type": "SCALAR" },
        ],
    });
    for (key, value) in parts.as_object().unwrap() {
        file[key] = value.clone();
    }
    file.to_string()
}

#[test]
fn gltf_stands_upright_and_moves() {
    let parts = json!({
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 1, "output": 2 }],
        }],
    });
    let (imported, scene) = scene_of(&[("a.gltf", &gltf(&parts))]);
    assert_eq!((imported.shapes, imported.lamps), ((1, 0), 0));
    assert_eq!(imported.made_up, ["a camera that sees everything", "a white sky"]);
    assert_eq!(scene.objects[0].key_frames.len(), 2);
    says(&imported, "addKframe { time 2  key { pivot { 0 0 4 } } }");
    says(&imported, "turn { axis { 1 0 0 } angle_deg 90 }");
}

#[test]
fn gltf_materials_lights_and_cameras() {
    let parts = json!({
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_clearcoat"],
        "nodes": [
            { "children": [1, 2, 3] },
            { "mesh": 0, "name": "tri" },
            { "camera": 0, "translation": [0, 0, 5] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.5, "znear": 0.1, "aspectRatio": 2.0 } }],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 54.35141, "color": [1, 0.5, 0.25] }] } },
        "materials": [{
            "name": "glass",
            "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1.0 },
                            "KHR_materials_clearcoat": { "clearcoatFactor": 0.5 } },
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
    });
    let (imported, scene) = scene_of(&[("a.gltf", &gltf(&parts))]);
    assert!(imported.made_up.is_empty() && imported.left_out.is_empty(), "{imported:?}");
    assert_eq!((scene.camera.film.width, scene.camera.film.height), (1440, 720));
    // y of the file is up.
    says(&imported, "addPosition { 0 -5 0 }");
    says(&imported, "fovStart 0.9315965 ");
    says(&imported, "lamp_point lamp { power { 0.9999999 0.5 0.25 }");
    says(&imported, "roughness 0  transmission 1  thin 1  coat 0.5  coat_roughness 0 }");
}

#[test]
fn what_is_mirrored_is_turned_round() {
    let nodes = json!({ "nodes": [{ "mesh": 0, "scale": [-1, 1, 1], "translation": [5, 0, 0] }] });
    let (imported, scene) = scene_of(&[("a.gltf", &gltf(&nodes))]);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    let mesh = &mesh.mesh;
    let corners = mesh.faces[0].map(|corner| mesh.positions[corner as usize]);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    // The triangle faces +z of the file, mirrored or not.
    assert!((normal - DVec3::Z).length() < 1e-6, "{normal}");
    assert!(mesh.positions.contains(&DVec3::NEG_X));
    says(&imported, "key { pivot { 5 0 0 } } }");
}

#[test]
fn images_may_use_a_second_set_of_texture_coordinates() {
    let image = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
    let texture = |set: u32| json!({ "index": 0, "texCoord": set });
    let mesh = json!([{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 4, "TEXCOORD_1": 5 }, "material": 0 }] }]);
    let mut accessors =
        serde_json::from_str::<Value>(&gltf(&json!({}))).unwrap()["accessors"].clone();
    for offset in [0, 12] {
        let pairs = json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": 3, "type": "VEC2" });
        accessors.as_array_mut().unwrap().push(pairs);
    }
    let parts = |normal: u32| {
        json!({
            "images": [{ "uri": image }], "textures": [{ "source": 0 }], "meshes": mesh, "accessors": accessors,
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": texture(1) }, "normalTexture": texture(normal) }],
        })
    };
    let (imported, scene) = scene_of(&[("a.gltf", &gltf(&parts(1)))]);
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    // The second set begins at the second vertex.
    assert!(mesh.mesh.uvs.contains(&[1.0, 1.0]), "{:?}", mesh.mesh.uvs);
    let (imported, _) = scene_of(&[("a.gltf", &gltf(&parts(0)))]);
    assert_eq!(
        imported.left_out,
        ["an image that uses other texture coordinates than the rest of its material"]
    );
}

#[test]
fn a_colour_that_all_vertices_have_is_one_of_the_material() {
    let primitive = json!({ "attributes": { "POSITION": 0, "COLOR_0": 4 } });
    let parts = |offset: u32, stride: u32| {
        let mut views = serde_json::from_str::<Value>(&gltf(&json!({}))).unwrap();
        let views = views["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": 36 - offset, "byteStride": stride }));
        let mut file = serde_json::from_str::<Value>(&gltf(&json!({}))).unwrap();
        let accessors = file["accessors"].as_array_mut().unwrap();
        accessors.push(json!({ "bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3" }));
        json!({ "bufferViews": views, "accessors": accessors, "meshes": [{ "primitives": [primitive] }] })
    };
    // The bytes of the vertices 0, 0 and of 1, as normalised colours.
    let (imported, _) = scene_of(&[("a.gltf", &gltf(&parts(0, 4)))]);
    says(&imported, "base_color { 0 0 0 }");
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    let (imported, _) = scene_of(&[("a.gltf", &gltf(&parts(4, 8)))]);
    assert_eq!(imported.left_out, ["colours of vertices"]);
}

#[test]
fn morph_targets_become_shapes() {
    let parts = json!({
        "meshes": [{ "weights": [0.0], "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 0 }] }] }],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": 1, "output": 3 }],
        }],
    });
    let (imported, _) = scene_of(&[("a.gltf", &gltf(&parts))]);
    // Two seconds at 25 shapes a second.
    assert_eq!(imported.files.len(), 51);
    says(&imported, "shapes { filename meshes/mesh_####.ply  first 0  last 50  fps 25 }");
    let last = &imported.files[50].1;
    let second_x = last.len() - 13 - 24;
    assert_eq!(last[second_x..second_x + 4], 2.0_f32.to_le_bytes());
}

/// A few bytes in a file, used often, would otherwise fill all memory.
#[test]
fn parts_that_are_used_very_often_are_refused() {
    let primitives = vec![json!({ "attributes": { "POSITION": 0 } }); 2000];
    let data = "A".repeat(320_000);
    let parts = json!({
        "meshes": [{ "primitives": primitives }],
        "buffers": [{ "byteLength": 240_000, "uri": format!("data:;base64,{data}") }],
        "bufferViews": [{ "buffer": 0, "byteLength": 240_000 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 20_000, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
    });
    let message = refused("a.gltf", gltf(&parts));
    assert!(message.contains("its parts are used so often"), "{message}");
    // The file is its own buffer, many times.
    let mut buffers = vec![json!({ "byteLength": 1, "uri": "a.gltf" }); 3000];
    let first = serde_json::from_str::<Value>(&gltf(&json!({}))).unwrap()["buffers"][0].clone();
    buffers.insert(0, first);
    scene_of(&[("a.gltf", &gltf(&json!({ "buffers": buffers })))]);
    // So is its own library of materials, at every line.
    let obj = "mtllib a.obj\n".repeat(40_000) + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    scene_of(&[("a.obj", &obj)]);
}

#[test]
fn damaged_gltf_is_an_error() {
    let view = |length: u32| json!({ "bufferViews": [{ "buffer": 0, "byteLength": length }, { "buffer": 0, "byteLength": 40 }] });
    let nodes = |nodes: Value| json!({ "nodes": nodes });
    let animation = |target: Value| {
        json!({ "animations": [{
            "channels": [{ "sampler": 0, "target": target }],
            "samplers": [{ "input": 1, "output": 2 }],
        }] })
    };
    for (parts, expected) in [
        (view(35), "accessor 0 lies outside of its bytes"),
        (view(4_000_000), "buffer view 0 lies outside of its buffer"),
        (
            json!({ "buffers": [{ "byteLength": 90, "uri": "data:;base64,AAAA" }] }),
            "buffer 0 is shorter",
        ),
        (json!({ "buffers": [{ "byteLength": 76, "uri": "gone.bin" }] }), "can't read"),
        (json!({ "buffers": [{ "byteLength": 76, "uri": "..%2Fgone.bin" }] }), "can't read"),
        (nodes(json!([{ "children": [1] }, { "children": [0] }])), "hangs in itself"),
        (nodes(json!([{ "mesh": 7 }])), "it is damaged"),
        (
            json!({ "meshes": [{ "primitives": [{ "attributes": { "POSITION": 9 } }] }] }),
            "names an accessor that does not exist",
        ),
        (animation(json!({ "node": 9, "path": "translation" })), "a node that does not exist"),
        (animation(json!({ "node": 0, "path": "colour" })), "nothing of it that is known"),
        (
            json!({ "cameras": [{ "type": "perspective", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 1 } }] }),
            "a camera lacks",
        ),
        (json!({ "images": [{ "bufferView": 0 }] }), "an image has no data"),
        (nodes(json!([{ "mesh": 0, "scale": [0, 0, 0] }])), "nothing to see"),
        (nodes(json!([{ "mesh": 0, "scale": [1e30, 1, 1] }])), "a coordinate is"),
        (
            json!({ "extensionsRequired": ["X_any"], "extensionsUsed": ["X_any"] }),
            "it requires X_any",
        ),
        (
            json!({ "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 1 }] }] }),
            "nothing to see",
        ),
    ] {
        let message = refused("a.gltf", gltf(&parts));
        assert!(message.contains(expected), "{message} {expected}");
    }
    let whole = gltf(&json!({}));
    for cut in (0..whole.len()).step_by(41) {
        refused("a.gltf", &whole[..cut]);
    }
    for (bytes, expected) in [
        (&b""[..], "`a.glb`: the file is empty"),
        (b"glTF\x02\0\0\0", "`a.glb`: it ends early: after 8 bytes"),
        (b"glTF\x02\0\0\0\x20\0\0\0\x08\0\0\0", "`a.glb`: it ends early: after 16 of 32 bytes"),
        (b"glTF\x01\0\0\0", "`a.glb`: its version is 1; version 2 is read"),
        (b"PK\x03\x04", "`a.glb`: it does not begin with `glTF`, as binary glTF files do"),
    ] {
        assert_eq!(refused("a.glb", bytes), expected);
    }
    assert!(!Path::new("gone.bin").exists());
}

#[cfg(unix)]
#[test]
fn pipes_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("a.obj");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if made.is_ok_and(|status| status.success()) {
        let error = import(&pipe, false).unwrap_err().to_string();
        assert!(error.contains("it is not a regular file"), "{error}");
    }
}
