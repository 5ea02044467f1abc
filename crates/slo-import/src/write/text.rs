//! Scene text.

use std::fmt::Write;

use glam::DVec3;

use super::numbers::{number, rounded, significant, triple, vector};
use super::spaces::Spaces;
use super::{Paths, shape_path};
use crate::model::{
    Camera, ImageUse, Lamp, LampKind, Material, Model, Notes, Object, Shape, Times, View,
};
use crate::names::Names;

/// Frames a second of files that do not say.
const FPS: f64 = 25.0;

/// Writes the text.
pub(super) fn text(model: &Model, source: &str, paths: &Paths) -> String {
    let mut text = format!("# Imported from {}.\n", one_line(source));
    notes(&model.notes, &mut text);
    settings(model, &mut text);
    if let Some(camera) = &model.camera {
        text += &camera_text(camera, model);
    }
    if let Some(color) = model.background.filter(|_| !model.is_classical) {
        writeln!(text, "environment sky {{ radiance {} }}", triple(color)).ok();
    }
    let (textures, materials) = (texture_names(model), material_names(model));
    let spaces = Spaces::of(model);
    part(&mut text, "Textures", textures.iter().map(|texture| texture.text(&paths.images)));
    let material = |(m, name): (&Material, &String)| material_text(m, name, model, &textures);
    part(&mut text, "Materials", model.materials.iter().zip(&materials).map(material));
    part(&mut text, "Spaces", spaces.groups());
    let lamp = |(l, name): (&Lamp, &String)| lamp_text(l, name, &spaces.place(l.space));
    part(&mut text, "Lamps", model.lamps.iter().zip(&spaces.lamps).map(lamp));
    let writer = ObjectWriter { model, materials: &materials, spaces: &spaces };
    let objects = model.objects.iter().zip(&paths.meshes).zip(&spaces.objects);
    part(&mut text, "Objects", objects.map(|((o, path), name)| writer.text(o, name, path)));
    text
}

fn part(text: &mut String, title: &str, lines: impl Iterator<Item = String>) {
    let mut lines = lines.peekable();
    if lines.peek().is_some() {
        writeln!(text, "\n# {title}").ok();
        text.extend(lines);
    }
}

/// What a comment may hold.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn notes(notes: &Notes, text: &mut String) {
    for made_up in &notes.made_up {
        writeln!(text, "# Made up: {}.", one_line(made_up)).ok();
    }
    for (what, count) in &notes.left_out {
        writeln!(text, "# Left out: {}{}.", one_line(what), times(*count)).ok();
    }
    text.push('\n');
}

/// How often something happened, in brackets; nothing if once.
pub(crate) fn times(count: usize) -> String {
    if count == 1 { String::new() } else { format!(" ({count} times)") }
}

fn settings(model: &Model, text: &mut String) {
    if model.is_classical {
        let sky =
            model.background.map(|c| format!("  background {}", triple(c))).unwrap_or_default();
        let is_clear = |m: &Material| m.numbers.iter().any(|(input, _)| *input == "refraction");
        let has_clear = model.has_clear_shadows && model.materials.iter().any(is_clear);
        let shadow = if has_clear { "  shadow TRANSPARENT" } else { "" };
        writeln!(
            text,
            "settings imported {{ imageSamples 64  noise .02  recursion 5{shadow}{sky} }}"
        )
        .ok();
    } else {
        writeln!(text, "settings imported {{ integrator PATH  imageSamples 256  noise .02 }}").ok();
    }
}

fn camera_text(camera: &Camera, model: &Model) -> String {
    let [width, height] = camera.size;
    let (fps, duration) = (model.fps.unwrap_or(FPS), model.duration);
    // The colours of the thesis are values of pixels.
    let encoding = if model.is_classical { "" } else { "  encoding SRGB" };
    let mut text = format!(
        "\nCamera camera {{\n    fps {}\n    Film film {{ width {width}  height {height}{encoding} }}\n",
        number(fps)
    );
    let still = |view: &View| {
        format!("addPosition {}  addTarget {}", vector(view.position), vector(view.target))
    };
    let fov = number(rounded(camera.fov));
    match camera.views.as_slice() {
        [view] => {
            let end = number(duration.max(1.0 / fps));
            writeln!(
                text,
                "    CamSegment all {{ videoStart 0  videoEnd {end}  {}  skyStart {}  fovStart {fov} }}",
                still(view),
                vector(view.up)
            )
            .ok();
        }
        views => {
            let step = duration / (views.len() - 1).max(1) as f64;
            for (i, pair) in views.windows(2).enumerate() {
                let ([a, b], start) = ([pair[0], pair[1]], step * i as f64);
                writeln!(
                    text,
                    "    CamSegment s{i} {{ videoStart {}  videoEnd {}  {}  {}  skyStart {}  skyEnd {}  \
                     fovStart {fov} }}",
                    number(start),
                    number(step * (i + 1) as f64),
                    still(&a),
                    still(&b),
                    vector(a.up),
                    vector(b.up)
                )
                .ok();
            }
        }
    }
    text + "}\n"
}

/// A texture: an image with the way it is read.
struct Texture {
    name: String,
    image: usize,
    wrap: &'static str,
    nearest: bool,
}

impl Texture {
    fn text(&self, images: &[String]) -> String {
        let mut text = format!("texture {} {{ filename {}", self.name, images[self.image]);
        if self.wrap != "REPEAT" {
            text += &format!("  wrap {}", self.wrap);
        }
        if self.nearest {
            text += "  filter NEAREST";
        }
        text + " }\n"
    }

    fn serves(&self, of: &ImageUse) -> bool {
        (self.image, self.wrap, self.nearest) == (of.image, of.wrap, of.nearest)
    }
}

fn texture_names(model: &Model) -> Vec<Texture> {
    let (mut names, mut textures) = (Names::default(), Vec::<Texture>::new());
    for (_, image_use) in model.materials.iter().flat_map(|material| &material.images) {
        if !textures.iter().any(|texture| texture.serves(image_use)) {
            let ImageUse { image, wrap, nearest, .. } = *image_use;
            let file = &model.images[image].name;
            let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
            textures.push(Texture { name: names.new_name(stem, "image"), image, wrap, nearest });
        }
    }
    textures
}

fn material_names(model: &Model) -> Vec<String> {
    let mut names = Names::default();
    model.materials.iter().map(|material| names.new_name(&material.name, "material")).collect()
}

fn material_text(material: &Material, name: &str, model: &Model, textures: &[Texture]) -> String {
    let mut inputs = Vec::new();
    for (input, color) in &material.colors {
        inputs.push(format!("{input} {}", triple(color.map(rounded))));
    }
    for (input, value) in &material.numbers {
        inputs.push(format!("{input} {}", number(rounded(*value))));
    }
    if model.is_classical {
        return classical_text(material, name, &inputs, textures);
    }
    for (input, image_use) in &material.images {
        inputs.push(format!("{input}_texture {}", use_text(image_use, textures)));
    }
    format!("material_principled {name} {{ {} }}\n", inputs.join("  "))
}

/// A material of the thesis, which has one image at most.
fn classical_text(
    material: &Material,
    name: &str,
    inputs: &[String],
    textures: &[Texture],
) -> String {
    let info = format!("phong_info {name} {{ {} }}\n", inputs.join("  "));
    let image = material.images.first().map(|(_, image)| image);
    let texture = image.and_then(|image| Some((image, textures.iter().find(|t| t.serves(image))?)));
    let Some((image, texture)) = texture else {
        return info + &format!("material_phong {name} {{ phong_info {name} }}\n");
    };
    let mut more = String::new();
    for (word, scale) in [("scale_U", image.scale[0]), ("scale_V", image.scale[1])] {
        if scale != 1.0 {
            more += &format!("  {word} {}", number(rounded(scale)));
        }
    }
    let texture = &texture.name;
    info + &format!("material_texture {name} {{ phong_info {name}  texture {texture}{more} }}\n")
}

fn use_text(image_use: &ImageUse, textures: &[Texture]) -> String {
    let Some(texture) = textures.iter().find(|texture| texture.serves(image_use)) else {
        return String::new();
    };
    let mut more = String::new();
    if let Some(channel) = image_use.channel {
        more += &format!("  channel {channel}");
    }
    let ImageUse { scale, offset, turn_deg, .. } = *image_use;
    let values = [
        ("scale_U", scale[0], 1.0),
        ("scale_V", scale[1], 1.0),
        ("offset_U", offset[0], 0.0),
        ("offset_V", offset[1], 0.0),
        ("turn_deg", turn_deg, 0.0),
    ];
    for (word, value, usual) in values {
        if value != usual {
            more += &format!("  {word} {}", number(rounded(value)));
        }
    }
    if more.is_empty() {
        return texture.name.clone();
    }
    format!("{{ texture {}{more} }}", texture.name)
}

fn lamp_text(lamp: &Lamp, name: &str, place: &str) -> String {
    match lamp.kind {
        LampKind::Point { power } => {
            format!(
                "lamp_point {name} {{ power {}  position {{ 0 0 0 }}{place} }}\n",
                triple(power.map(significant))
            )
        }
        LampKind::Spot { power, angle_deg, blend } => format!(
            "lamp_spot {name} {{ power {}  position {{ 0 0 0 }}  target {{ 0 0 -1 }}  angle_deg {}  blend {}{place} }}\n",
            triple(power.map(significant)),
            number(rounded(angle_deg)),
            number(rounded(blend))
        ),
        LampKind::Sun { irradiance } => format!(
            "lamp_sun {name} {{ irradiance {}  direction {{ 0 0 -1 }}{place} }}\n",
            triple(irradiance.map(significant))
        ),
        LampKind::Classical { color, position } => format!(
            "light_point {name} {{ color {}  position {}{place} }}\n",
            triple(color.map(rounded)),
            vector(position)
        ),
    }
}

/// Writes objects.
struct ObjectWriter<'a> {
    model: &'a Model,
    materials: &'a [String],
    spaces: &'a Spaces<'a>,
}

impl ObjectWriter<'_> {
    /// `path` is that of its mesh.
    fn text(&self, object: &Object, name: &str, path: &str) -> String {
        let Self { model, materials, spaces } = self;
        let hidden = if object.is_hidden { "  hidden 1" } else { "" };
        let end = format!(
            "  material {}{hidden}{} }}\n",
            materials[object.material],
            spaces.place(object.space)
        );
        let smooth = |mesh: usize| {
            if model.meshes[mesh].normals.is_empty() { "" } else { "  smooth_normals 1" }
        };
        match &object.shape {
            Shape::Mesh(mesh) => format!("mesh {name} {{ filename {path}{}{end}", smooth(*mesh)),
            Shape::Changing { first, count, times: Times::Even(fps) } => format!(
                "mesh {name} {{ shapes {{ filename {path}  first 0  last {}  fps {} }}{}{end}",
                count - 1,
                number(*fps),
                smooth(*first)
            ),
            Shape::Changing { first, times: Times::At(times), .. } => {
                let shapes = times.iter().enumerate().map(|(i, time)| {
                    let path = shape_path(path, i);
                    format!("\n    addShape {{ time {}  filename {path} }}", number(rounded(*time)))
                });
                let shapes: String = shapes.collect();
                format!("mesh {name} {{{}{shapes}\n{end}", smooth(*first))
            }
            Shape::Sphere { center, radius } => {
                format!(
                    "sphere {name} {{ center {}  radius {}{end}",
                    vector(*center),
                    number(*radius)
                )
            }
            Shape::Cylinder { base, top, radius } => format!(
                "cylinder {name} {{ base {}  top {}  radius {}{end}",
                vector(*base),
                vector(*top),
                number(*radius)
            ),
            Shape::Box { half } => {
                let DVec3 { x, y, z } = *half;
                let [a, b, c] = [[-x, -y], [x, -y], [x, y]].map(|[x, y]| DVec3::new(x, y, -z));
                format!(
                    "box {name} {{ vertex0 {}  vertex1 {}  vertex2 {}  height {}{end}",
                    vector(a),
                    vector(b),
                    vector(c),
                    number(rounded(2.0 * z))
                )
            }
            Shape::Cone { base, apex, radius } => format!(
                "cone {name} {{ base {}  apex {}  radius {}{end}",
                vector(*base),
                vector(*apex),
                number(*radius)
            ),
        }
    }
}
