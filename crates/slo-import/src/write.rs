//! A model as scene text, with its meshes and images as files beside it.

mod numbers;
mod ply;
mod spaces;
mod text;

use crate::model::{Model, Shape};
use crate::names::Names;

pub(crate) use text::times;

/// A scene and its files.
pub(crate) struct Written {
    pub(crate) text: String,
    pub(crate) files: Vec<(String, Vec<u8>)>,
}

/// Paths of what is written beside the text.
struct Paths {
    /// For each object, the file of its mesh; `####` stands for the number of a shape.
    meshes: Vec<String>,
    /// For each image.
    images: Vec<String>,
}

/// Writes a model. `source` is the name of the file that it comes from.
pub(crate) fn write(model: &Model, source: &str) -> Written {
    let mut files = Vec::new();
    let paths = Paths { meshes: meshes(model, &mut files), images: images(model, &mut files) };
    Written { text: text::text(model, source, &paths), files }
}

fn meshes(model: &Model, files: &mut Vec<(String, Vec<u8>)>) -> Vec<String> {
    let mut names = Names::default();
    let mut known: Vec<Option<String>> = vec![None; model.meshes.len()];
    let mut paths = Vec::new();
    for object in &model.objects {
        let (first, count) = match object.shape {
            Shape::Mesh(mesh) => (mesh, 1),
            Shape::Changing { first, count, .. } => (first, count),
            Shape::Sphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Cone { .. }
            | Shape::Box { .. } => {
                paths.push(String::new());
                continue;
            }
        };
        let path = known[first].get_or_insert_with(|| {
            let name = names.new_name(&model.meshes[first].name, "mesh");
            let number = if count > 1 { "_####" } else { "" };
            let path = format!("meshes/{name}{number}.ply");
            for (i, mesh) in model.meshes[first..first + count].iter().enumerate() {
                files.push((shape_path(&path, i), ply::bytes(mesh)));
            }
            path
        });
        paths.push(path.clone());
    }
    paths
}

/// The path of a shape.
fn shape_path(path: &str, number: usize) -> String {
    path.replace("####", &format!("{number:04}"))
}

fn images(model: &Model, files: &mut Vec<(String, Vec<u8>)>) -> Vec<String> {
    let mut names = Names::default();
    let mut paths = Vec::new();
    for image in &model.images {
        let (stem, ending) = image.name.rsplit_once('.').unwrap_or((&image.name, ""));
        let path = format!("textures/{}.{}", names.new_name(stem, "image"), ending.to_lowercase());
        files.push((path.clone(), image.bytes.clone()));
        paths.push(path);
    }
    paths
}
