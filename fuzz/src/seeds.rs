//! Writes the inputs that fuzzing begins with: small files of every kind, from what slo-rt ships and writes.

use std::fs;
use std::path::{Path, PathBuf};

use slo_picture::film::{Area, Film, Subject};
use slo_picture::output::{Recipe, read_state, write_state};
use slo_rt::description::{Encoding, Layer, OutputFormat, Settings};
use slo_rt::{Render, Scene};

/// Larger files slow fuzzing down.
const MOST: u64 = 12_000;

/// Makes a folder for each fuzzer in a folder.
///
/// # Panics
/// If a file cannot be read or written.
pub fn write_all(to: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    scenes(root, to);
    let of_crate = |path: &str| root.join("crates/slo-scene").join(path);
    for folder in [of_crate("tests/scenes/files"), root.join("meshes"), root.join("textures")] {
        for (path, bytes) in files(&folder) {
            for target in targets(&path) {
                put(to, target, &path, &bytes);
            }
            moved_meshes(&path, &bytes, to);
        }
    }
    for (path, bytes) in files(&of_crate("src/texture/jpeg/files")) {
        put(to, "texture_jpeg", &path, &bytes);
    }
    put(to, "texture_hdr", Path::new("flat"), HDR);
    pictures(root, to);
    put(to, "claim", Path::new("claim"), CLAIM.as_bytes());
    put(to, "claim", Path::new("ledger"), LEDGER.as_bytes());
    for (i, request) in REQUESTS.iter().enumerate() {
        put(to, "view", Path::new(&format!("request-{i}")), request.as_bytes());
    }
    for folder in fs::read_dir(root.join("fuzz/seeds")).expect("seeds").flatten() {
        if folder.path().is_dir() {
            for (path, bytes) in files(&folder.path()) {
                put(to, &folder.file_name().to_string_lossy(), &path, &bytes);
            }
        }
    }
    put(to, "import_iv", Path::new("binary.iv"), &binary_inventor());
    put(to, "import_glb", Path::new("all.glb"), &glb(root));
    random(to);
}

/// Bytes for fuzzers that take numbers.
fn random(to: &Path) {
    for (i, count) in [3_u32, 40, 300].into_iter().enumerate() {
        let random: Vec<u8> =
            (0..count * 13).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
        for target in ["structures", "splits", "cache"] {
            put(to, target, Path::new(&format!("random-{i}")), &random);
        }
    }
}

fn put(to: &Path, target: &str, name: &Path, bytes: &[u8]) {
    let folder = to.join(target);
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join(name.file_name().expect("a name")), bytes).expect("a file");
}

/// The small files in a folder.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
    let is_small =
        |path: &PathBuf| path.metadata().is_ok_and(|of| of.is_file() && of.len() <= MOST);
    paths.filter(is_small).map(|path| (path.clone(), fs::read(path).expect("a file"))).collect()
}

/// The fuzzers that a file is for.
fn targets(path: &Path) -> &'static [&'static str] {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("slo") => &["mesh_slo"],
        Some("obj") => &["mesh_obj", "import_obj"],
        Some("ply") => &["mesh_ply", "import_ply", "placements"],
        Some("png") => &["texture_png", "picture"],
        Some("hdr") => &["texture_hdr"],
        _ => &[],
    }
}

/// A mesh with vertices to move, before a scene that uses another file of it.
fn moved_meshes(path: &Path, bytes: &[u8], to: &Path) {
    let extension = path.extension().and_then(|extension| extension.to_str());
    let Some(kind @ ("slo" | "obj" | "ply")) = extension else { return };
    for (i, moves) in MOVES.iter().enumerate() {
        let mark = format!("\n==== a.{kind}\n");
        let scene = b"\n==== scene.txt\nmesh a { filename b.obj fit { 2 } material m }\n";
        let input = [moves, mark.as_bytes(), bytes, scene].concat();
        put(to, "sculpt", &path.with_extension(format!("{kind}-{i}")), &input);
    }
}

/// Scenes, each with the small files of the tests behind it.
fn scenes(root: &Path, to: &Path) {
    let tests = root.join("crates/slo-scene/tests/scenes");
    let mut behind = Vec::new();
    for name in ["plank.png", "row.ply", "tetrahedron.slo"] {
        behind.extend(format!("\n==== files/{name}\n").into_bytes());
        behind.extend(fs::read(tests.join("files").join(name)).expect("a file"));
    }
    behind.extend(b"\n==== part.txt\nsphere part { center { 0 0 0 } radius 1 material m }");
    for folder in [tests.clone(), tests.join("errors"), root.join("scenes")] {
        for (path, bytes) in files(&folder) {
            put(to, "edit", &path, &bytes);
            let whole = [&bytes[..], &behind].concat();
            put(to, "scene", &path, &whole);
            put(to, "render", &path, &whole);
        }
    }
}

/// Pictures, textures, states and recipes as slo-rt writes them.
fn pictures(root: &Path, to: &Path) {
    let text = fs::read_to_string(root.join("fuzz/seeds/splits.txt")).expect("a scene");
    let text = text.replace("SETTINGS", "imageSamples 3 imageMinSamples 2 noise 0.1");
    let scene = Scene::parse(&text, ".").expect("a scene");
    let formats = [
        ("a.png", OutputFormat::Png8, &[][..]),
        ("b.png", OutputFormat::Png16, &[]),
        ("a.exr", OutputFormat::Exr, &[]),
        ("b.exr", OutputFormat::Exr, &Layer::ALL[..]),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for (name, format, layers) in formats {
        let path = folder.path().join(name);
        let render = Render::new(&scene).format(format).layers(layers);
        render.film(|film| film.encoding = Some(Encoding::Srgb)).save(&path).expect("a picture");
        let bytes = fs::read(&path).expect("a picture");
        put(to, "picture", Path::new(name), &bytes);
        let texture = if name.ends_with("png") { "texture_png" } else { "texture_exr" };
        put(to, texture, Path::new(name), &bytes);
    }
    let mut description = scene.description().clone();
    let recipe = Recipe { scene: &description, frame: 3 }.to_json();
    put(to, "recipe", Path::new("all"), recipe.as_bytes());
    description.settings = Settings::default();
    description.camera.film.layers = Layer::ALL.to_vec();
    let recipe = Recipe { scene: &description, frame: 3 }.to_json();
    put(to, "recipe", Path::new("layers"), recipe.as_bytes());
    (description.camera.film.width, description.camera.film.height) = (3, 2);
    for (name, with_layers) in [("plain", false), ("layers", true)] {
        let area = Area::whole(3, 2);
        let layers = if with_layers { Layer::ALL.to_vec() } else { Vec::new() };
        description.camera.film.layers = layers.clone();
        let recipe = Recipe { scene: &description, frame: 3 }.to_json();
        let subject = Subject {
            recipe,
            area,
            region: area,
            samples: None,
            with_spreads: slo_render::render::Plan::new(&description).needs_spreads(),
            with_features: with_layers,
            light_groups: with_layers.then(|| description.light_groups()),
            first_hits: slo_picture::film::FirstHitLayers::of(&layers, &description.layer_names()),
        };
        let film: Film = subject.film().expect("a film");
        let path = folder.path().join(name);
        let state = slo_picture::film::State { subject, film, is_complete: false };
        write_state(&path, &state).expect("a state");
        read_state(&path).expect("a state");
        let bytes = fs::read(&path).expect("a state");
        // The fuzzer adds the checksum.
        put(to, "state", Path::new(name), &bytes[..bytes.len() - 32]);
    }
}

/// Open Inventor, binary: units of four bytes.
fn binary_inventor() -> Vec<u8> {
    let mut file = b"#Inventor V2.1 binary  \n".to_vec();
    // Numbers, and texts behind their lengths.
    let mut write = |texts: &[&str], words: &[u32]| {
        for text in texts {
            file.extend((text.len() as u32).to_be_bytes());
            file.extend(text.as_bytes());
            file.resize(file.len().next_multiple_of(4), 0);
        }
        words.iter().for_each(|word| file.extend(word.to_be_bytes()));
    };
    write(&["Separator"], &[2, 1]);
    write(&["renderCaching", "AUTO"], &[0, 3]);
    write(&["DEF", "t", "Translation"], &[0, 1]);
    write(&["translation"], &[1.0_f32, 2.0, 3.0].map(f32::to_bits));
    write(&[], &[0]);
    write(&["Cylinder"], &[0, 2]);
    write(&["radius"], &[4.0_f32.to_bits(), 1]);
    write(&["parts", "ALL", ""], &[0]);
    write(&["USE", "t"], &[]);
    file
}

/// The glTF file among the seeds, with its buffer behind it.
fn glb(root: &Path) -> Vec<u8> {
    let text = fs::read_to_string(root.join("fuzz/seeds/import_gltf/all.gltf")).expect("a file");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("a glTF file");
    value["buffers"][0] = serde_json::json!({ "byteLength": 76 });
    let mut json = value.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut numbers = [0.0_f32; 19];
    (numbers[3], numbers[7], numbers[10]) = (1.0, 1.0, 2.0);
    let data: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let chunk =
        |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &data)].concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [&b"glTF\x02\0\0\0"[..], &length, &chunks].concat()
}

/// Moves of vertices: none, of a mesh in which y is up, of three of a smooth mesh.
const MOVES: [&[u8]; 3] =
    [b"", b"\x02", b"\x01\0\x01\x20\x30\x40\0\x02\x90\x21\x22\0\x03\x22\x22\x22"];

const HDR: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 8\n\
    \x02\x02\x00\x08\x88\x40\x88\x41\x88\x42\x88\x80\
    \x02\x02\x00\x08\x04\x01\x02\x03\x04\x84\x07\x88\x41\x88\x42\x88\x80";

const CLAIM: &str = "0123456789abcdef 0000060000 00000000000000000007 4711 anna 0a1b2c\n";

const LEDGER: &str = r#"{"of":"this","frames":{"-5":[7.0,0.25,40.5,40.5,0.1,0.01,0.02,1.5,1.75],"12":[1,0,0,0,0,0,0,0,1]}}"#;

const REQUESTS: [&str; 8] = [
    r#"{"do":"set","keyword":"sphere","name":"ball","attribute":"radius","value":"2","vector":false,"blocks":[]}"#,
    r#"{"do":"set","keyword":"Camera","name":"c","attribute":"addPosition","value":"2 1 1","vector":true,"blocks":[["CamSegment",0]]}"#,
    r#"{"do":"hide","name":"ball"}"#,
    r#"{"do":"copy","name":"floor"}"#,
    r#"{"do":"key","name":"ball"}"#,
    "{\"do\":\"remove\",\"name\":\"ball\"}\n==== text\nsphere ball { radius 1 }\nplane floor { }",
    "/TOKEN/picture\nhost: localhost:8000\norigin: http://localhost:8000\nsec-fetch-site: none\n",
    "a\nb\nc\n==== ours\na\nx\nb\nc\n==== theirs\na\nb\nc\ny\n",
];
