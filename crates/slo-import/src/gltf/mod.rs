//! glTF 2.0.
//!
//! Source: the specification of the Khronos group, and its extensions `KHR_lights_punctual`,
//! `KHR_texture_transform`, `KHR_mesh_quantization` and `KHR_materials_*`. Lights have photometric units
//! there; as Blender does by default, 683 lm are 1 W.

mod accessor;
mod animation;
mod buffers;
mod material;
mod mesh;
mod nodes;

use ::gltf::json::validation::Checked;
use ::gltf::{Gltf, json};

use crate::error::ImportError;
use crate::files::Source;
use crate::model::Model;

/// Extensions that change what a file means and that are understood.
const UNDERSTOOD: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
];

/// Reads a file.
pub(crate) fn read(source: &Source) -> Result<Model, ImportError> {
    check_container(source)?;
    // The crate refuses files that require extensions which it does not know; what it does not check
    // without that, `checked` does.
    let file = Gltf::from_slice_without_validation(&source.bytes)
        .map_err(|error| source.bad(format!("it is not glTF: {error}")))?;
    let unknown: Vec<&str> =
        file.extensions_required().filter(|name| !UNDERSTOOD.contains(name)).collect();
    if !unknown.is_empty() {
        let message = format!("it requires {}, which slo-rt does not read", unknown.join(", "));
        return Err(source.bad(message));
    }
    let file = checked(source, file)?;
    let mut model = Model::default();
    let blob = file.blob.as_deref();
    let (buffers, left) = buffers::load(source, &file.document, blob)?;
    let sets = material::read(source, &file.document, &buffers, &left, &mut model)?;
    nodes::read(source, &file.document, &buffers, &left, &sets, &mut model)?;
    for name in file.extensions_used().filter(|name| !UNDERSTOOD.contains(name)) {
        model.notes.leave_out(format!("the extension {name}"));
    }
    Ok(model)
}

/// Checks the beginning of a binary file, and that it is whole.
fn check_container(source: &Source) -> Result<(), ImportError> {
    let bytes = &source.bytes;
    if !bytes.starts_with(b"glTF") {
        let is_text = source.ending() != "glb" || bytes.first() == Some(&b'{');
        let message = "it does not begin with `glTF`, as binary glTF files do";
        return if is_text { Ok(()) } else { Err(source.bad(message)) };
    }
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    match (word(4), word(8)) {
        (Some(version), _) if version != 2 => {
            Err(source.bad(format!("its version is {version}; version 2 is read")))
        }
        (_, Some(length)) if length as usize <= bytes.len() && length >= 20 => Ok(()),
        (_, Some(length)) => {
            Err(source.bad(format!("it ends early: after {} of {length} bytes", bytes.len())))
        }
        _ => Err(source.bad(format!("it ends early: after {} bytes", bytes.len()))),
    }
}

/// Checks all references between the parts of a file.
fn checked(source: &Source, file: Gltf) -> Result<Gltf, ImportError> {
    let blob = file.blob;
    let mut json = file.document.into_json();
    // The crate takes them for errors if it does not know them.
    json.extensions_required.clear();
    if let Some(message) = unchecked(&json) {
        return Err(source.bad(format!("it is damaged: {message}")));
    }
    let document = ::gltf::Document::from_json(json)
        .map_err(|error| source.bad(format!("it is damaged: {error}")))?;
    Ok(Gltf { document, blob })
}

/// What the crate relies on without checking it; `None` if all of that is right.
fn unchecked(json: &json::Root) -> Option<&'static str> {
    let accessors = json.accessors.len();
    let positions = Checked::Valid(json::mesh::Semantic::Positions);
    let has_no_positions = |primitive: &json::mesh::Primitive| {
        primitive.attributes.get(&positions).is_some_and(|index| index.value() >= accessors)
    };
    let has_no_target = |channel: &json::animation::Channel| {
        let target = &channel.target;
        target.node.value() >= json.nodes.len() || target.path == Checked::Invalid
    };
    let has_no_view = |camera: &json::Camera| match camera.type_ {
        Checked::Valid(json::camera::Type::Perspective) => camera.perspective.is_none(),
        Checked::Valid(json::camera::Type::Orthographic) => camera.orthographic.is_none(),
        Checked::Invalid => true,
    };
    let has_no_data = |image: &json::Image| match image.buffer_view {
        Some(_) => image.mime_type.is_none(),
        None => image.uri.is_none(),
    };
    let mut channels = json.animations.iter().flat_map(|animation| &animation.channels);
    if json.meshes.iter().flat_map(|mesh| &mesh.primitives).any(has_no_positions) {
        Some("a mesh names an accessor that does not exist")
    } else if channels.any(has_no_target) {
        Some("an animation changes a node that does not exist, or nothing of it that is known")
    } else if json.cameras.iter().any(has_no_view) {
        Some("a camera lacks what its type asks for")
    } else if json.images.iter().any(has_no_data) {
        Some("an image has no data, or does not say of what kind it is")
    } else {
        None
    }
}
