//! Wavefront OBJ with the materials of its MTL files.

mod mtl;

use std::collections::HashMap;
use std::str::FromStr;

use crate::corners::{Corner, Corners};
use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Material, Model, Object, Shape, Space};

/// Most libraries of materials that a file names.
const MOST_LIBRARIES: usize = 256;

/// Reads a file. Most programs write y up.
pub(crate) fn read(source: &Source) -> Result<Model, ImportError> {
    let mut reader = Reader::new(source);
    let text = source.text();
    let mut line = String::new();
    let mut first = 1;
    for (number, part) in text.lines().enumerate() {
        if line.is_empty() {
            first = number + 1;
        }
        match part.strip_suffix('\\') {
            Some(part) => {
                line += part;
                line.push(' ');
            }
            None => {
                line += part;
                reader.statement(&line).map_err(|message| source.bad_line(first, message))?;
                line.clear();
            }
        }
    }
    reader.finish()
}

struct Reader<'a> {
    source: &'a Source,
    model: Model,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    /// Faces by the object and the material that they belong to, in the order of the file.
    meshes: Vec<(String, String, Corners)>,
    places: HashMap<(String, String), usize>,
    object: String,
    material: String,
    libraries: Vec<String>,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source) -> Self {
        Self {
            source,
            model: Model::default(),
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            meshes: Vec::new(),
            places: HashMap::new(),
            object: source.stem(),
            material: String::new(),
            libraries: Vec::new(),
        }
    }

    fn statement(&mut self, line: &str) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match keyword {
            "" | "s" => {}
            "v" => {
                if rest.split_whitespace().count() > 4 {
                    self.model.notes.leave_out("colours of vertices");
                }
                self.positions.push(numbers(rest)?);
            }
            "vn" => {
                let normal = glam::Vec3::from(numbers::<3>(rest)?).normalize_or(glam::Vec3::Z);
                self.normals.push(normal.to_array());
            }
            "vt" => {
                // The second number may be missing.
                let [u, v] = numbers(&format!("{rest} 0"))?;
                self.uvs.push([u, v]);
            }
            "f" => self.face(rest)?,
            "o" | "g" => {
                self.object = if rest.is_empty() { self.source.stem() } else { rest.to_owned() };
            }
            "usemtl" => self.material = rest.to_owned(),
            // Each once: what is known already stays.
            "mtllib" if self.libraries.iter().any(|library| library == rest) => {}
            "mtllib" if self.libraries.len() >= MOST_LIBRARIES => {
                self.model.notes.leave_out("a library of materials, since there are too many");
            }
            "mtllib" => self.libraries.push(rest.to_owned()),
            "l" | "p" => self.model.notes.leave_out("points or lines"),
            _ => self.model.notes.leave_out(format!("`{}` of OBJ", shortened(keyword))),
        }
        Ok(())
    }

    fn face(&mut self, text: &str) -> Result<(), String> {
        let face = text.split_whitespace().map(|corner| self.corner(corner));
        let mut face = face.collect::<Result<Vec<Corner>, String>>()?;
        if face.len() < 3 {
            self.model.notes.leave_out("a face of fewer than three corners");
            return Ok(());
        }
        if face.iter().any(|corner| corner.1.is_none()) {
            face.iter_mut().for_each(|corner| corner.1 = None);
        }
        let key = (self.object.clone(), self.material.clone());
        let Self { meshes, places, .. } = self;
        let place = *places.entry(key).or_insert_with_key(|(object, material)| {
            meshes.push((object.clone(), material.clone(), Corners::default()));
            meshes.len() - 1
        });
        meshes[place].2.add(&face);
        Ok(())
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, text: &str) -> Result<Corner, String> {
        let mut parts = text.split('/');
        let mut index = |len: usize, what: &str| match parts.next() {
            None | Some("") => Ok(None),
            Some(word) => {
                let number =
                    i64::from_str(word).map_err(|_| format!("`{word}` is not a number"))?;
                let index = if number < 0 { number + len as i64 } else { number - 1 };
                match u32::try_from(index) {
                    Ok(index) if (index as usize) < len => Ok(Some(index)),
                    _ => Err(format!("{what} {number} does not exist (so far there are {len})")),
                }
            }
        };
        let position = index(self.positions.len(), "vertex")?.ok_or("a corner has no vertex")?;
        let uv = index(self.uvs.len(), "texture coordinate")?;
        let normal = index(self.normals.len(), "normal")?;
        Ok((position, normal, uv))
    }

    fn finish(self) -> Result<Model, ImportError> {
        let Self { source, mut model, positions, normals, uvs, meshes, libraries, .. } = self;
        let known = mtl::read(source, &libraries, &mut model);
        model.spaces.push(Space::y_up(source.stem()));
        model.notes.made_up.push("which axis is up: y".into());
        let mut plain = None;
        for (object, material, corners) in meshes {
            let material = known.get(&material).copied().unwrap_or_else(|| {
                if !material.is_empty() {
                    model.notes.leave_out(format!(
                        "the material `{}`, which no file defines",
                        shortened(&material)
                    ));
                }
                *plain.get_or_insert_with(|| {
                    model.materials.push(Material { name: "plain".into(), ..Material::default() });
                    model.materials.len() - 1
                })
            });
            let name = format!("{object}_{}", model.materials[material].name);
            model.meshes.push(corners.mesh(name, &positions, &normals, &uvs));
            let shape = Shape::Mesh(model.meshes.len() - 1);
            model.objects.push(Object {
                name: object,
                space: Some(0),
                material,
                shape,
                is_hidden: false,
            });
        }
        Ok(model)
    }
}

/// The first `N` numbers of a text.
fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let mut words = text.split_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or_else(|| format!("expected {N} numbers"))?;
        *number =
            f32::from_str(word).map_err(|_| format!("`{}` is not a number", shortened(word)))?;
        if !number.is_finite() {
            return Err(format!("`{}` is not a finite number", shortened(word)));
        }
    }
    Ok(numbers)
}

/// A word that a message shows.
fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}
