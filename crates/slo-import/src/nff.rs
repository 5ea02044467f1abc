//! NFF, the format of Haines' Standard Procedural Databases.
//!
//! Source: E. Haines, "A Proposal for Standard Graphics Environments" (1987). Lights do not fall off with
//! distance there, and materials are those of Phong, so scenes become classical ones. Each of n lights
//! has the weight sqrt(n) / (2 n).

use std::str::{FromStr, SplitWhitespace};

use glam::DVec3;

use crate::corners::Corners;
use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Camera, Lamp, LampKind, Material, Mesh, Model, Object, Shape, View};

/// Sides of a cone.
const SIDES: u32 = 64;

/// Most corners of a polygon, and pixels of a side.
const MOST: usize = 65536;

/// Reads a file.
pub(crate) fn read(source: &Source) -> Result<Model, ImportError> {
    let text = source.text();
    let mut reader = Reader {
        words: Words {
            source,
            lines: text.lines(),
            words: "".split_whitespace(),
            line: 0,
            ahead: None,
        },
        model: Model { is_classical: true, ..Model::default() },
        fill: None,
        polygons: Vec::new(),
        cones: Vec::new(),
        positions: Vec::new(),
        normals: Vec::new(),
    };
    while let Some(word) = reader.words.next() {
        reader.item(word)?;
    }
    reader.finish();
    Ok(reader.model)
}

struct Words<'a> {
    source: &'a Source,
    lines: std::str::Lines<'a>,
    words: SplitWhitespace<'a>,
    /// Number of the current line, from 1.
    line: usize,
    ahead: Option<&'a str>,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        if let Some(word) = self.ahead.take() {
            return Some(word);
        }
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            let line = self.lines.next()?;
            self.line += 1;
            self.words = line.split(['#', '%']).next().unwrap_or_default().split_whitespace();
        }
    }

    /// Whether a number follows.
    fn is_number(&mut self) -> bool {
        self.ahead = self.next();
        self.ahead.is_some_and(|word| f64::from_str(word).is_ok())
    }

    fn bad<T>(&self, message: impl Into<String>) -> Result<T, ImportError> {
        Err(self.source.bad_line(self.line, message))
    }

    fn number(&mut self) -> Result<f64, ImportError> {
        let Some(word) = self.next() else { return self.bad("a number is missing at the end") };
        match f64::from_str(word) {
            Ok(number) if number.is_finite() => Ok(number),
            _ => self.bad(format!("expected a number instead of `{word}`")),
        }
    }

    fn vector(&mut self) -> Result<DVec3, ImportError> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    fn count(&mut self, least: usize) -> Result<usize, ImportError> {
        let number = self.number()?;
        if number.fract() != 0.0 || number < least as f64 || number > MOST as f64 {
            return self.bad(format!(
                "expected a whole number from {least} to {MOST} instead of {number}"
            ));
        }
        Ok(number as usize)
    }

    fn word(&mut self, expected: &str) -> Result<(), ImportError> {
        match self.next() {
            Some(word) if word == expected => Ok(()),
            Some(word) => self.bad(format!("expected `{expected}` instead of `{word}`")),
            None => self.bad(format!("`{expected}` is missing at the end")),
        }
    }
}

struct Reader<'a> {
    words: Words<'a>,
    model: Model,
    /// The current material.
    fill: Option<usize>,
    /// Polygons of each material; some without normals, and some with.
    polygons: Vec<[Corners; 2]>,
    /// Cones of each material.
    cones: Vec<Mesh>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Reader<'_> {
    fn item(&mut self, word: &str) -> Result<(), ImportError> {
        match word {
            "v" => self.view(),
            "b" => {
                self.model.background = Some(self.words.vector()?.to_array());
                Ok(())
            }
            "l" => self.light(),
            "f" => self.fill(),
            "s" => {
                let (center, radius) = (self.words.vector()?, self.words.number()?.abs());
                if radius > 0.0 {
                    self.shape("sphere", Shape::Sphere { center, radius });
                }
                Ok(())
            }
            "c" => self.cone(),
            "p" => self.polygon(false),
            "pp" => self.polygon(true),
            _ => self.words.bad(format!("`{word}` is not an item of NFF")),
        }
    }

    fn view(&mut self) -> Result<(), ImportError> {
        let words = &mut self.words;
        words.word("from")?;
        let position = words.vector()?;
        words.word("at")?;
        let target = words.vector()?;
        words.word("up")?;
        let up = words.vector()?;
        words.word("angle")?;
        let angle = words.number()?;
        words.word("hither")?;
        words.number()?;
        words.word("resolution")?;
        let size = [words.count(1)? as u32, words.count(1)? as u32];
        let fov = libm::tan(angle.to_radians() / 2.0);
        if !(angle > 0.0 && angle < 180.0) || position == target || up == DVec3::ZERO {
            return words.bad("this view sees nothing");
        }
        self.model.camera = Some(Camera { size, fov, views: vec![View { position, target, up }] });
        Ok(())
    }

    fn light(&mut self) -> Result<(), ImportError> {
        let position = self.words.vector()?;
        let color = if self.words.is_number() { self.words.vector()? } else { DVec3::ONE };
        let kind = LampKind::Classical { color: color.max(DVec3::ZERO).to_array(), position };
        self.model.lamps.push(Lamp { name: "light".into(), space: None, kind });
        Ok(())
    }

    fn fill(&mut self) -> Result<(), ImportError> {
        let words = &mut self.words;
        let color = words.vector()?.max(DVec3::ZERO);
        let mut number = || words.number().map(|number| number.max(0.0));
        let (diffuse, specular, shine, transmission, ior) =
            (number()?, number()?, number()?, number()?, number()?);
        let mut material = Material { name: "fill".into(), ..Material::default() };
        material.colors.push(("diffuse", (color * diffuse).to_array()));
        if specular > 0.0 {
            material.colors.push(("specular", [specular; 3]));
            material.numbers.push(("shininess", shine));
            material.numbers.push(("reflectance", specular));
        }
        if transmission > 0.0 {
            material.numbers.push(("refraction", transmission));
            material.numbers.push(("refraction_index", if ior > 0.0 { ior } else { 1.0 }));
        }
        self.set_fill(material);
        Ok(())
    }

    /// Makes a fill the current one. Files repeat fills, so equal ones are one material.
    fn set_fill(&mut self, fill: Material) {
        let is_same =
            |known: &Material| (&known.colors, &known.numbers) == (&fill.colors, &fill.numbers);
        let known = self.model.materials.iter().position(is_same);
        self.fill = Some(known.unwrap_or_else(|| {
            self.model.materials.push(fill);
            self.polygons.push(Default::default());
            self.cones.push(Mesh::default());
            self.model.materials.len() - 1
        }));
    }

    /// The current fill; white before the first.
    fn material(&mut self) -> usize {
        if self.fill.is_none() {
            let colors = vec![("diffuse", [1.0; 3])];
            self.set_fill(Material { name: "fill".into(), colors, ..Material::default() });
        }
        self.fill.unwrap_or_default()
    }

    fn shape(&mut self, name: &str, shape: Shape) {
        let material = self.material();
        self.model.objects.push(Object { name: name.into(), space: None, material, shape });
    }

    fn cone(&mut self) -> Result<(), ImportError> {
        let (base, r0) = (self.words.vector()?, self.words.number()?.abs());
        let (apex, r1) = (self.words.vector()?, self.words.number()?.abs());
        let axis = apex - base;
        if axis.length() == 0.0 || r0.max(r1) == 0.0 {
            return Ok(());
        }
        if r0 == r1 {
            self.model.notes.leave_out("that a cylinder is open at its ends");
            self.shape("cylinder", Shape::Cylinder { base, top: apex, radius: r0 });
            return Ok(());
        }
        let along = axis.normalize();
        let (x, y) = along.any_orthonormal_pair();
        let slope = (r0 - r1) / axis.length();
        let material = self.material();
        let mesh = &mut self.cones[material];
        let first = mesh.positions.len() as u32;
        for i in 0..=SIDES {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(SIDES);
            let out = x * libm::cos(angle) + y * libm::sin(angle);
            let normal = (out + along * slope).normalize().as_vec3().to_array();
            for (center, radius) in [(base, r0), (apex, r1)] {
                mesh.positions.push((center + out * radius).as_vec3().to_array());
                mesh.normals.push(normal);
            }
        }
        for i in 0..SIDES {
            let [a, b, c, d] = [0, 2, 3, 1].map(|k| first + 2 * i + k);
            if r0 > 0.0 {
                mesh.faces.push([a, b, c]);
            }
            // A tip is one point, so one half has no area.
            if r1 > 0.0 {
                mesh.faces.push([a, c, d]);
            }
        }
        Ok(())
    }

    fn polygon(&mut self, has_normals: bool) -> Result<(), ImportError> {
        let count = self.words.count(3)?;
        let mut face = Vec::new();
        for _ in 0..count {
            let position = self.words.vector()?.as_vec3().to_array();
            self.positions.push(position);
            let normal =
                if has_normals { Some(self.words.vector()?.normalize_or_zero()) } else { None };
            let normal = normal.map(|normal| {
                self.normals.push(normal.as_vec3().to_array());
                self.normals.len() as u32 - 1
            });
            face.push((self.positions.len() as u32 - 1, normal, None));
        }
        let material = self.material();
        self.polygons[material][usize::from(has_normals)].add(&face);
        Ok(())
    }

    /// Makes meshes of polygons and cones, and weights the lights.
    fn finish(&mut self) {
        let (polygons, cones) =
            (std::mem::take(&mut self.polygons), std::mem::take(&mut self.cones));
        for (material, (kinds, cones)) in polygons.into_iter().zip(cones).enumerate() {
            let kinds = kinds.into_iter().filter(|corners| !corners.is_empty()).map(|corners| {
                corners.mesh("polygons".into(), &self.positions, &self.normals, &[])
            });
            let cones =
                Some(Mesh { name: "cones".into(), ..cones }).filter(|mesh| !mesh.faces.is_empty());
            for mesh in kinds.chain(cones) {
                let (name, shape) = (mesh.name.clone(), Shape::Mesh(self.model.meshes.len()));
                self.model.meshes.push(mesh);
                self.model.objects.push(Object { name, space: None, material, shape });
            }
        }
        let count = self.model.lamps.len() as f64;
        for lamp in &mut self.model.lamps {
            if let LampKind::Classical { color, .. } = &mut lamp.kind {
                *color = color.map(|c| c * count.sqrt() / (2.0 * count));
            }
        }
    }
}
