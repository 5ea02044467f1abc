//! Shapes of the current file, gathered into meshes of one space and material.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::fills::Fills;
use crate::corners::{Corner, Corners};
use crate::error::ImportError;
use crate::files::Source;
use crate::images::Images;
use crate::model::{KnownMeshes, Mesh, Model, Object, Shape, Times};
use crate::solids::add_side;
use crate::words::Words;

/// Most corners of a polygon.
const MOST_CORNERS: usize = 65536;

/// Most vertices of a mesh, and most moments of a triangle.
const MOST_VERTICES: usize = 1 << 30;

/// What is one mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Kind {
    space: Option<usize>,
    material: usize,
    /// Whether corners have normals.
    is_smooth: bool,
}

/// Faces that become a mesh.
#[derive(Debug, Default)]
struct Batch {
    corners: Corners,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
}

/// Triangles whose corners move, with the same times.
#[derive(Debug)]
struct Moving {
    space: Option<usize>,
    material: usize,
    times: Vec<f64>,
    /// For each time, corners and their normals.
    rows: Vec<Vec<[DVec3; 2]>>,
}

/// What a file draws.
#[derive(Debug, Default)]
pub(super) struct Batches {
    name: String,
    all: Vec<(Kind, Batch)>,
    places: HashMap<Kind, usize>,
    /// Sides of cones.
    cones: Vec<(Kind, Mesh)>,
    moving: Vec<Moving>,
}

impl Batches {
    /// Nothing yet of a file with this name.
    fn new(name: String) -> Self {
        let (all, places) = (Vec::new(), HashMap::new());
        Self { name, all, places, cones: Vec::new(), moving: Vec::new() }
    }

    fn of(&mut self, kind: Kind) -> &mut Batch {
        let Self { all, places, .. } = self;
        let place = *places.entry(kind.clone()).or_insert_with(|| {
            all.push((kind, Batch::default()));
            all.len() - 1
        });
        &mut all[place].1
    }
}

impl Batch {
    fn position(&mut self, position: DVec3) -> u32 {
        self.positions.push(position.as_vec3().to_array());
        self.positions.len() as u32 - 1
    }

    fn normal(&mut self, normal: DVec3) -> u32 {
        self.normals.push(normal.normalize_or_zero().as_vec3().to_array());
        self.normals.len() as u32 - 1
    }

    /// Adds a face. A normal without length becomes that of the face.
    fn add(&mut self, face: &[Corner]) {
        let position = |i: usize| Vec3::from(self.positions[face[i].0 as usize]);
        let across = (position(1) - position(0)).cross(position(2) - position(0));
        for normal in face.iter().filter_map(|corner| corner.1) {
            let normal = &mut self.normals[normal as usize];
            if *normal == [0.0; 3] {
                *normal = across.normalize_or(Vec3::Z).to_array();
            }
        }
        self.corners.add(face);
    }
}

/// The model, with what is being added to it.
pub(super) struct Drawing<'a> {
    /// The file that is imported.
    main: &'a Source,
    pub(super) model: Model,
    pub(super) fills: Fills,
    /// The space of the current group.
    pub(super) space: Option<usize>,
    images: Images,
    meshes: KnownMeshes,
    /// Shapes of the current file.
    batches: Batches,
}

impl<'a> Drawing<'a> {
    pub(super) fn new(main: &'a Source, model: Model) -> Self {
        Self {
            main,
            model,
            fills: Fills::default(),
            space: None,
            images: Images::default(),
            meshes: KnownMeshes::default(),
            batches: Batches::new(main.stem()),
        }
    }

    /// Goes on with the shapes of a file that is read in place.
    pub(super) fn begin(&mut self, name: String) -> Batches {
        std::mem::replace(&mut self.batches, Batches::new(name))
    }

    fn kind(&mut self, image: Option<usize>, is_smooth: bool) -> Kind {
        let material = self.fills.material(image, &mut self.model);
        Kind { space: self.space, material, is_smooth }
    }

    fn object(&mut self, name: &str, kind: &Kind, shape: Shape) {
        let Kind { space, material, .. } = *kind;
        self.model.objects.push(Object {
            name: name.into(),
            space,
            material,
            shape,
            is_hidden: false,
        });
    }

    pub(super) fn sphere(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        // A negative radius marks one that is seen from inside.
        let (center, radius) = (words.vector()?, words.number()?.abs());
        if radius == 0.0 {
            self.model.notes.leave_out("a sphere of radius 0");
            return Ok(());
        }
        let kind = self.kind(None, true);
        self.object("sphere", &kind, Shape::Sphere { center, radius });
        Ok(())
    }

    pub(super) fn cone(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let (base, r0) = (words.vector()?, words.number()?.abs());
        let (apex, r1) = (words.vector()?, words.number()?.abs());
        if (apex - base).length() == 0.0 || r0.max(r1) == 0.0 {
            self.model.notes.leave_out("a cone or cylinder without an area");
            return Ok(());
        }
        let kind = self.kind(None, true);
        if r0 == r1 {
            self.model.notes.leave_out("that a cylinder is open at its ends");
            self.object("cylinder", &kind, Shape::Cylinder { base, top: apex, radius: r0 });
            return Ok(());
        }
        let cones = &mut self.batches.cones;
        let place = cones.iter().position(|(known, _)| *known == kind).unwrap_or(cones.len());
        if place == cones.len() {
            cones.push((kind, Mesh::default()));
        }
        add_side(&mut cones[place].1, [base, apex], [r0, r1]);
        Ok(())
    }

    pub(super) fn polygon(
        &mut self,
        words: &mut Words<'_>,
        is_smooth: bool,
    ) -> Result<(), ImportError> {
        let count = words.count(3, MOST_CORNERS)?;
        let kind = self.kind(None, is_smooth);
        let batch = self.batches.of(kind);
        let mut face = Vec::new();
        for _ in 0..count {
            let position = batch.position(words.vector()?);
            let normal = if is_smooth { Some(batch.normal(words.vector()?)) } else { None };
            face.push((position, normal, None));
        }
        batch.add(&face);
        Ok(())
    }

    /// A triangle with an image.
    pub(super) fn triangle(
        &mut self,
        words: &mut Words<'_>,
        is_smooth: bool,
    ) -> Result<(), ImportError> {
        let image = self.image(words)?;
        let kind = self.kind(image, is_smooth);
        let batch = self.batches.of(kind);
        let mut face = Vec::new();
        for _ in 0..3 {
            let position = batch.position(words.vector()?);
            let normal = if is_smooth { Some(batch.normal(words.vector()?)) } else { None };
            batch.uvs.push([words.number()? as f32, words.number()? as f32]);
            face.push((position, normal, Some(batch.uvs.len() as u32 - 1)));
        }
        batch.add(&face);
        Ok(())
    }

    fn image(&mut self, words: &mut Words<'_>) -> Result<Option<usize>, ImportError> {
        let name = words.name("the name of an image")?;
        Ok(self.images.find(self.main, name, &["textures/", ""], &mut self.model))
    }

    pub(super) fn mesh(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        words.word("vertices")?;
        let vertices = list(words, Words::vector)?;
        let normals = if words.takes("normals") { Some(list(words, Words::vector)?) } else { None };
        let (mut image, mut uvs) = (None, None);
        if words.takes("texturecoords") {
            let count = words.count(0, MOST_VERTICES)?;
            image = self.image(words)?;
            let mut pairs = Vec::new();
            for _ in 0..count {
                pairs.push([words.number()? as f32, words.number()? as f32]);
            }
            uvs = Some(pairs);
        }
        words.word("triangles")?;
        let kind = self.kind(image, normals.is_some());
        let batch = self.batches.of(kind);
        let first = [batch.positions.len(), batch.normals.len(), batch.uvs.len()];
        let counts = [
            vertices.len(),
            normals.as_ref().map_or(0, Vec::len),
            uvs.as_ref().map_or(0, Vec::len),
        ];
        for vertex in vertices {
            batch.position(vertex);
        }
        for normal in normals.iter().flatten() {
            batch.normal(*normal);
        }
        batch.uvs.extend(uvs.iter().flatten());
        let has = [true, normals.is_some(), uvs.is_some()];
        for _ in 0..words.count(0, MOST_VERTICES)? {
            let mut face = [(0, None, None); 3];
            for part in (0..3).filter(|&part| has[part]) {
                for corner in &mut face {
                    let index = index(words, counts[part], first[part])?;
                    match part {
                        0 => corner.0 = index,
                        1 => corner.1 = Some(index),
                        _ => corner.2 = Some(index),
                    }
                }
            }
            batch.add(&face);
        }
        Ok(())
    }

    /// A triangle whose corners move.
    pub(super) fn changing(&mut self, words: &mut Words<'_>) -> Result<(), ImportError> {
        let (mut times, mut rows) = (Vec::new(), Vec::new());
        for _ in 0..words.count(1, MOST_VERTICES)? {
            let time = words.number()?;
            if times.last().is_some_and(|before| time <= *before) {
                return words.bad("the times of a moving triangle do not rise");
            }
            times.push(time);
            let mut corner = || Ok([words.vector()?, words.vector()?]);
            rows.push([corner()?, corner()?, corner()?]);
        }
        let Kind { space, material, .. } = self.kind(None, true);
        let moving = &mut self.batches.moving;
        let same = |known: &Moving| {
            (known.space, known.material) == (space, material) && known.times == times
        };
        let place = moving.iter().position(same).unwrap_or(moving.len());
        if place == moving.len() {
            let rows = vec![Vec::new(); times.len()];
            moving.push(Moving { space, material, times, rows });
        }
        for (to, row) in moving[place].rows.iter_mut().zip(rows) {
            to.extend(row);
        }
        Ok(())
    }

    /// Makes meshes of what the current file drew, and goes on with the file around it.
    pub(super) fn end(&mut self, next: Batches) {
        let Batches { name, all, cones, moving, .. } = std::mem::replace(&mut self.batches, next);
        let meshes = all.into_iter().filter(|(_, batch)| !batch.corners.is_empty()).map(
            |(kind, Batch { corners, positions, normals, uvs })| {
                (kind, corners.mesh(name.clone(), &positions, &normals, &uvs))
            },
        );
        let cones = cones
            .into_iter()
            .map(|(kind, mesh)| (kind, Mesh { name: format!("{name}_cones"), ..mesh }));
        for (kind, mesh) in meshes.chain(cones).collect::<Vec<_>>() {
            let object = mesh.name.clone();
            let mesh = self.meshes.number(mesh, &mut self.model.meshes);
            self.object(&object, &kind, Shape::Mesh(mesh));
        }
        for Moving { space, material, times, rows } in moving {
            let first = self.model.meshes.len();
            self.model.meshes.extend(rows.iter().map(|row| moment(&name, row)));
            let count = rows.len();
            let shape = if count == 1 {
                Shape::Mesh(first)
            } else {
                Shape::Changing { first, count, times: Times::At(times) }
            };
            self.object(&name, &Kind { space, material, is_smooth: true }, shape);
        }
    }
}

/// Triangles at a moment.
fn moment(name: &str, corners: &[[DVec3; 2]]) -> Mesh {
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    for (i, triangle) in corners.chunks_exact(3).enumerate() {
        let [a, b, c] = [0, 1, 2].map(|k| triangle[k][0]);
        let across = (b - a).cross(c - a).normalize_or(DVec3::Z);
        for [position, normal] in triangle {
            mesh.positions.push(position.as_vec3().to_array());
            mesh.normals.push(normal.normalize_or(across).as_vec3().to_array());
        }
        mesh.faces.push([0, 1, 2].map(|k| 3 * i as u32 + k));
    }
    mesh
}

fn list<'a, T>(
    words: &mut Words<'a>,
    of: impl Fn(&mut Words<'a>) -> Result<T, ImportError>,
) -> Result<Vec<T>, ImportError> {
    let mut list = Vec::new();
    for _ in 0..words.count(0, MOST_VERTICES)? {
        list.push(of(words)?);
    }
    Ok(list)
}

/// An index below `count`, which counts from `first`.
fn index(words: &mut Words<'_>, count: usize, first: usize) -> Result<u32, ImportError> {
    let number = words.number()?;
    if number.fract() != 0.0 || number < 0.0 || number >= count as f64 {
        return words.bad(format!("index {number} does not exist (there are {count})"));
    }
    let index = u32::try_from(first + number as usize);
    index.or_else(|_| words.bad("there are too many vertices"))
}
