//! Materials of MTL files, with the statements of physical materials that many programs write (`Pr`,
//! `Pm`, ...).

use std::collections::HashMap;
use std::str::FromStr;

use crate::files::Source;
use crate::model::{Image, ImageUse, Material, Model, Notes};

/// Reads libraries. Returns where materials are, by their names. A file that is missing is noted.
pub(super) fn read(
    source: &Source,
    libraries: &[String],
    model: &mut Model,
) -> HashMap<String, usize> {
    let mut known = HashMap::new();
    let mut images = HashMap::new();
    for library in libraries {
        let Ok(file) = source.beside(library) else {
            model.notes.leave_out(format!("the materials of `{library}`, which can't be read"));
            continue;
        };
        let mut lines: Option<Lines> = None;
        let text = file.text();
        let is_blenders = text.starts_with("# Blender");
        let all = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
        for line in all.chain(["newmtl"]) {
            let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            if keyword == "newmtl" {
                if let Some(lines) = lines.take() {
                    let name = lines.name.clone();
                    let mut maker = Maker { file: &file, images: &mut images, model };
                    let material = maker.material(&lines);
                    known.entry(name).or_insert(model.materials.len());
                    model.materials.push(material);
                }
                let name = rest.trim().to_owned();
                lines = Some(Lines { name, is_blenders, ..Lines::default() });
            } else if let Some(lines) = &mut lines
                && !keyword.is_empty()
            {
                lines.add(keyword, rest.trim(), &mut model.notes);
            }
        }
    }
    known
}

/// The statements of a material.
#[derive(Debug, Default)]
struct Lines {
    name: String,
    /// Whether Blender wrote them.
    is_blenders: bool,
    colors: HashMap<&'static str, [f64; 3]>,
    numbers: HashMap<&'static str, f64>,
    maps: HashMap<&'static str, Map>,
}

/// An image and its options.
#[derive(Debug)]
struct Map {
    file: String,
    scale: [f64; 2],
    offset: [f64; 2],
    clamps: bool,
    strength: Option<f64>,
}

const COLORS: &[&str] = &["Ka", "Kd", "Ks", "Ke", "Tf"];
const NUMBERS: &[&str] =
    &["Ns", "Ni", "d", "Tr", "illum", "Pr", "Pm", "Pc", "Pcr", "Ps", "aniso", "anisor"];
const MAPS: &[(&str, &str)] = &[
    ("map_Kd", "base_color"),
    ("map_Ke", "emission_color"),
    ("map_d", "alpha"),
    ("map_Pr", "roughness"),
    ("map_Pm", "metallic"),
    ("norm", "normal"),
    ("map_Kn", "normal"),
];

impl Lines {
    fn add(&mut self, keyword: &str, rest: &str, notes: &mut Notes) {
        let values: Vec<f64> = rest
            .split_whitespace()
            .map_while(|word| f64::from_str(word).ok().filter(|value| value.is_finite()))
            .collect();
        if let Some(&keyword) = COLORS.iter().find(|known| **known == keyword) {
            match values[..] {
                [r, g, b, ..] => drop(self.colors.insert(keyword, [r, g, b])),
                [grey, ..] => drop(self.colors.insert(keyword, [grey; 3])),
                [] => notes.leave_out(format!("`{keyword}` of MTL without numbers")),
            }
        } else if let Some(&keyword) = NUMBERS.iter().find(|known| **known == keyword) {
            match values[..] {
                [value, ..] => drop(self.numbers.insert(keyword, value)),
                [] => notes.leave_out(format!("`{keyword}` of MTL without a number")),
            }
        } else if let Some((_, input)) = MAPS.iter().find(|(known, _)| *known == keyword) {
            self.maps.insert(input, Map::of(rest));
        } else {
            notes.leave_out(format!("`{keyword}` of MTL"));
        }
    }

    fn number(&self, keyword: &str) -> Option<f64> {
        self.numbers.get(keyword).copied()
    }

    /// The roughness whose highlight is as wide as that of the Phong exponent: alpha² = 2 / (n + 2).
    /// Blender writes 1000 (1 - roughness)² instead of an exponent.
    fn roughness(&self) -> Option<f64> {
        let exponent = self.number("Ns")?.max(0.0);
        let blenders = 1.0 - (exponent / 1000.0).min(1.0).sqrt();
        Some(if self.is_blenders { blenders } else { (2.0 / (exponent + 2.0)).sqrt().sqrt() })
    }
}

impl Map {
    /// Reads options, and the name of a file behind them.
    fn of(text: &str) -> Self {
        let mut map = Self {
            file: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            clamps: false,
            strength: None,
        };
        let mut rest = text;
        while let Some(option) = rest.strip_prefix('-') {
            let (option, mut behind) =
                option.split_once(char::is_whitespace).unwrap_or((option, ""));
            let mut values = Vec::new();
            // Options have one word, or up to three numbers.
            loop {
                behind = behind.trim_start();
                let (word, after) = behind.split_once(char::is_whitespace).unwrap_or((behind, ""));
                let value = f64::from_str(word).ok();
                let takes_word = values.is_empty()
                    && matches!(option, "clamp" | "blendu" | "blendv" | "cc" | "imfchan" | "type");
                if after.is_empty() || value.is_none() && !takes_word || values.len() == 3 {
                    break;
                }
                if option == "clamp" {
                    map.clamps = word == "on";
                }
                values.push(value.unwrap_or(0.0));
                behind = after;
                if takes_word {
                    break;
                }
            }
            let pair = |usual: f64| {
                [values.first().copied().unwrap_or(usual), values.get(1).copied().unwrap_or(usual)]
            };
            match option {
                "s" => map.scale = pair(1.0),
                "o" => map.offset = pair(0.0),
                "bm" => map.strength = values.first().copied(),
                _ => {}
            }
            rest = behind.trim_start();
        }
        map.file = rest.trim().trim_matches('"').to_owned();
        map
    }
}

struct Maker<'a> {
    file: &'a Source,
    /// Images by their names; `None` for those that can't be read.
    images: &'a mut HashMap<String, Option<usize>>,
    model: &'a mut Model,
}

impl Maker<'_> {
    fn material(&mut self, lines: &Lines) -> Material {
        let mut to = Material { name: lines.name.clone(), ..Material::default() };
        let unit = |color: [f64; 3]| color.map(|c| c.clamp(0.0, 1.0));
        let color = |keyword| lines.colors.get(keyword).copied();
        for (&input, map) in &lines.maps {
            self.image(input, map, &mut to);
        }
        to.images.sort_by_key(|(input, _)| *input);
        let has_image = |input| to.images.iter().any(|(of, _)| *of == input);
        // Exporters write a Kd of 0 or 1 beside an image, which the image replaces.
        if !has_image("base_color") {
            to.colors.push(("base_color", unit(color("Kd").unwrap_or([0.8; 3]))));
        }
        let specular = color("Ks").map_or(0.0, |ks| ks.into_iter().fold(0.0, f64::max));
        if !has_image("roughness") {
            let roughness = lines.number("Pr").or_else(|| lines.roughness());
            to.numbers.push(("roughness", roughness.unwrap_or(0.5).clamp(0.0, 1.0)));
        }
        // Blender marks metal so.
        let is_metal = lines.is_blenders && lines.number("illum") == Some(3.0);
        let metallic =
            lines.number("Pm").unwrap_or(if is_metal { 1.0 } else { 0.0 }).clamp(0.0, 1.0);
        if !has_image("metallic") && metallic > 0.0 {
            to.numbers.push(("metallic", metallic));
        }
        let is_glass =
            lines.number("illum").is_some_and(|model| [4.0, 6.0, 7.0, 9.0].contains(&model));
        let opaque = lines.number("d").or_else(|| lines.number("Tr").map(|tr| 1.0 - tr));
        let opaque = opaque.unwrap_or(1.0).clamp(0.0, 1.0);
        if let Some(ior) = lines.number("Ni").filter(|ior| *ior > 1.0 && *ior != 1.5) {
            to.numbers.push(("ior", ior));
        }
        if is_glass && opaque < 1.0 {
            to.numbers.push(("transmission", 1.0 - opaque));
        } else if opaque < 1.0 && !has_image("alpha") {
            to.numbers.push(("alpha", opaque));
        }
        if color("Ks").is_some() && specular == 0.0 && lines.number("Pr").is_none() && !is_glass {
            to.numbers.push(("specular_ior_level", 0.0));
        }
        if let Some(coat) = lines.number("Pc").filter(|coat| *coat > 0.0) {
            to.numbers.push(("coat", coat.min(1.0)));
            if let Some(roughness) = lines.number("Pcr") {
                to.numbers.push(("coat_roughness", roughness.clamp(0.0, 1.0)));
            }
        }
        if let Some(sheen) = lines.number("Ps").filter(|sheen| *sheen > 0.0) {
            to.numbers.push(("sheen", sheen.min(1.0)));
        }
        if let Some(aniso) = lines.number("aniso").filter(|aniso| *aniso > 0.0) {
            to.numbers.push(("anisotropic", aniso.min(1.0)));
        }
        let emission = color("Ke").unwrap_or([0.0; 3]).map(|c| c.max(0.0));
        if emission != [0.0; 3] || has_image("emission_color") {
            if emission != [0.0; 3] {
                to.colors.push(("emission_color", emission));
            }
            to.numbers.push(("emission_strength", 1.0));
        }
        to
    }

    fn image(&mut self, input: &'static str, map: &Map, to: &mut Material) {
        let (file, model) = (self.file, &mut *self.model);
        let image = *self.images.entry(map.file.clone()).or_insert_with(|| {
            let bytes = file.beside(&map.file).ok()?.bytes;
            let name = map.file.replace('\\', "/");
            let name = name.rsplit('/').next().unwrap_or_default().to_owned();
            model.images.push(Image { name, bytes });
            Some(model.images.len() - 1)
        });
        let Some(image) = image else {
            self.model.notes.leave_out(format!("the image `{}`, which can't be read", map.file));
            return;
        };
        let known = [".png", ".jpg", ".jpeg", ".exr", ".hdr"];
        let name = self.model.images[image].name.to_lowercase();
        if !known.iter().any(|ending| name.ends_with(ending)) {
            self.model.notes.leave_out(format!("the image `{name}`: its format is not read"));
            return;
        }
        let wrap = if map.clamps { "CLAMP" } else { "REPEAT" };
        let Map { scale, offset, strength, .. } = *map;
        let image_use =
            ImageUse { image, channel: None, wrap, nearest: false, scale, offset, turn_deg: 0.0 };
        to.images.push((input, image_use));
        if let ("normal", Some(strength)) = (input, strength) {
            to.numbers.push(("normal_strength", strength.max(0.0)));
        }
    }
}
