//! Materials and images.

use gltf::Document;
use gltf::image::Source as ImageSource;
use gltf::material::AlphaMode;
use gltf::texture::{Info, MagFilter, Texture, TextureTransform, WrappingMode};
use serde_json::Value;

use super::accessor::Buffers;
use super::buffers::{Bytes, Left, bytes_of};
use crate::error::ImportError;
use crate::files::Source;
use crate::model::{Image, ImageUse, Material, Model, Notes};

/// Reads all images and materials. The last material is that of primitives without one. Returns for each
/// material which set of texture coordinates its images use.
pub(super) fn read(
    source: &Source,
    document: &Document,
    bytes: &[Bytes],
    left: &Left,
    model: &mut Model,
) -> Result<Vec<u32>, ImportError> {
    let buffers = Buffers { source, bytes, left };
    // Images of kinds that can't be read have no place in the model.
    let mut places = Vec::new();
    for image in document.images() {
        let (bytes, name) = match image.source() {
            ImageSource::View { view, .. } => (buffers.view(&view)?.to_vec(), image.name()),
            ImageSource::Uri { uri, .. } => {
                let name = if uri.starts_with("data:") { image.name() } else { Some(uri) };
                (bytes_of(source, uri)?, name)
            }
        };
        left.take(source, bytes.len())?;
        let Some(ending) = ending(&bytes) else {
            model.notes.leave_out("an image that is neither PNG nor JPEG");
            places.push(None);
            continue;
        };
        let name = name.map_or("image", |name| name.rsplit('/').next().unwrap_or(name));
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        places.push(Some(model.images.len()));
        model.images.push(Image { name: format!("{stem}.{ending}"), bytes });
    }
    let mut sets = Vec::new();
    for material in document.materials() {
        let (notes, to) = (&mut model.notes, Material::default());
        let mut reader = Reader { images: &places, notes, to, set: None };
        reader.read(&material);
        sets.push(reader.set.unwrap_or(0));
        model.materials.push(reader.to);
    }
    let plain = Material { name: "plain".into(), ..Material::default() };
    model.materials.push(plain);
    Ok(sets)
}

/// The ending of an image's file, by its first bytes.
fn ending(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("png"),
        [0xff, 0xd8, 0xff, ..] => Some("jpg"),
        _ => None,
    }
}

struct Reader<'a> {
    images: &'a [Option<usize>],
    notes: &'a mut Notes,
    to: Material,
    /// The set of texture coordinates that its images use.
    set: Option<u32>,
}

impl Reader<'_> {
    fn read(&mut self, material: &gltf::Material<'_>) {
        self.to.name = material.name().unwrap_or("material").to_owned();
        self.base(material);
        self.surface(material);
        self.transmission(material);
        self.layers(material);
        self.emission(material);
        if material.occlusion_texture().is_some() {
            self.notes.leave_out("an image of ambient occlusion, which path tracing computes");
        }
    }

    /// Writes a number that is not the usual one.
    fn number(&mut self, input: &'static str, value: f32, usual: f32) {
        if value != usual {
            self.to.numbers.push((input, f64::from(value)));
        }
    }

    fn color(&mut self, input: &'static str, color: [f32; 3], usual: [f32; 3]) {
        if color != usual {
            self.to.colors.push((input, color.map(f64::from)));
        }
    }

    fn image(
        &mut self,
        input: &'static str,
        info: Option<Info<'_>>,
        channel: Option<char>,
    ) -> bool {
        let Some(info) = info else { return false };
        let transform = info.texture_transform();
        self.use_image(input, &info.texture(), transform, info.tex_coord(), channel)
    }

    /// Returns whether the image is used.
    fn use_image(
        &mut self,
        input: &'static str,
        texture: &Texture<'_>,
        transform: Option<TextureTransform<'_>>,
        coordinates: u32,
        channel: Option<char>,
    ) -> bool {
        let coordinates =
            transform.as_ref().and_then(TextureTransform::tex_coord).unwrap_or(coordinates);
        let Some(Some(image)) = self.images.get(texture.source().index()).copied() else {
            return false;
        };
        if *self.set.get_or_insert(coordinates) != coordinates {
            let note = "an image that uses other texture coordinates than the rest of its material";
            self.notes.leave_out(note);
            return false;
        }
        let sampler = texture.sampler();
        let (s, t) = (sampler.wrap_s(), sampler.wrap_t());
        if s != t {
            self.notes.leave_out("that an image repeats in one direction only");
        }
        let wrap = match s {
            WrappingMode::Repeat => "REPEAT",
            WrappingMode::ClampToEdge => "CLAMP",
            WrappingMode::MirroredRepeat => "MIRROR",
        };
        let nearest = sampler.mag_filter() == Some(MagFilter::Nearest);
        let placed = Placed::of(transform);
        let Placed { scale, offset, turn_deg } = placed;
        self.to
            .images
            .push((input, ImageUse { image, channel, wrap, nearest, scale, offset, turn_deg }));
        true
    }

    fn base(&mut self, material: &gltf::Material<'_>) {
        let base = material.pbr_metallic_roughness();
        let [r, g, b, alpha] = base.base_color_factor();
        if material.unlit() {
            // It has the same colour under all light.
            self.to.colors.push(("base_color", [0.0; 3]));
            self.to.numbers.push(("specular_ior_level", 0.0));
            self.to.numbers.push(("emission_strength", 1.0));
            self.color("emission_color", [r, g, b], [1.0; 3]);
            self.image("emission_color", base.base_color_texture(), None);
        } else {
            let has_image = self.image("base_color", base.base_color_texture(), None);
            if !has_image || [r, g, b] != [1.0; 3] {
                self.to.colors.push(("base_color", [r, g, b].map(f64::from)));
            }
        }
        match material.alpha_mode() {
            AlphaMode::Opaque => {}
            AlphaMode::Blend | AlphaMode::Mask => {
                if material.alpha_mode() == AlphaMode::Mask && alpha < 1.0 {
                    self.notes.leave_out("the limit of a cut-out: its alpha is used as it is");
                }
                self.image("alpha", base.base_color_texture(), Some('A'));
                self.number("alpha", alpha, 1.0);
            }
        }
    }

    fn surface(&mut self, material: &gltf::Material<'_>) {
        if material.unlit() {
            return;
        }
        let base = material.pbr_metallic_roughness();
        let metal = base.metallic_factor();
        if metal > 0.0 {
            self.image("metallic", base.metallic_roughness_texture(), Some('B'));
        }
        self.number("metallic", metal, 0.0);
        let has_image = self.image("roughness", base.metallic_roughness_texture(), Some('G'));
        self.number("roughness", base.roughness_factor(), if has_image { 1.0 } else { 0.5 });
        if let Some(normal) = material.normal_texture() {
            let transform = normal.extension_value("KHR_texture_transform").cloned();
            if transform.is_some() {
                self.notes.leave_out("that the texture coordinates of normals are transformed");
            }
            self.use_image("normal", &normal.texture(), None, normal.tex_coord(), None);
            self.number("normal_strength", normal.scale(), 1.0);
        }
        self.number("ior", material.ior().unwrap_or(1.5), 1.5);
        if let Some(specular) = material.specular() {
            self.number(
                "specular_ior_level",
                0.5 * specular.specular_factor().clamp(0.0, 1.0),
                0.5,
            );
            let tint = specular.specular_color_factor();
            if tint.iter().any(|&c| c > 1.0) {
                self.notes.leave_out("a specular colour beyond 1");
            }
            self.color("specular_tint", tint.map(|c| c.min(1.0)), [1.0; 3]);
            if specular.specular_texture().is_some() || specular.specular_color_texture().is_some()
            {
                self.notes.leave_out("an image of specular reflection");
            }
        }
    }

    fn transmission(&mut self, material: &gltf::Material<'_>) {
        let Some(transmission) = material.transmission() else { return };
        let share = transmission.transmission_factor();
        if share <= 0.0 {
            return;
        }
        self.image("transmission", transmission.transmission_texture(), Some('R'));
        self.to.numbers.push(("transmission", f64::from(share)));
        match material.volume().filter(|volume| volume.thickness_factor() > 0.0) {
            Some(volume) => {
                let (color, distance) = (volume.attenuation_color(), volume.attenuation_distance());
                if distance.is_finite() && distance > 0.0 && color != [1.0; 3] {
                    self.color("absorption_color", color, [1.0; 3]);
                    self.to.numbers.push(("absorption_distance", f64::from(distance)));
                }
            }
            // Without a volume, the surface is a pane.
            None => self.to.numbers.push(("thin", 1.0)),
        }
    }

    /// Coat, sheen and anisotropy, which the crate leaves as JSON.
    fn layers(&mut self, material: &gltf::Material<'_>) {
        let number = |value: &Value, name: &str| value[name].as_f64().unwrap_or(0.0);
        if let Some(coat) = material.extension_value("KHR_materials_clearcoat") {
            let share = number(coat, "clearcoatFactor");
            if share > 0.0 {
                self.to.numbers.push(("coat", share.min(1.0)));
                self.to.numbers.push((
                    "coat_roughness",
                    number(coat, "clearcoatRoughnessFactor").clamp(0.0, 1.0),
                ));
            }
            self.images_of(coat, "clear coat");
        }
        if let Some(sheen) = material.extension_value("KHR_materials_sheen") {
            let color = [0, 1, 2]
                .map(|i| sheen["sheenColorFactor"][i].as_f64().unwrap_or(0.0).clamp(0.0, 1.0));
            let share = color.into_iter().fold(0.0, f64::max);
            if share > 0.0 {
                self.to.numbers.push(("sheen", share));
                self.to.numbers.push((
                    "sheen_roughness",
                    number(sheen, "sheenRoughnessFactor").clamp(0.0, 1.0),
                ));
                self.to.colors.push(("sheen_tint", color.map(|c| c / share)));
            }
            self.images_of(sheen, "sheen");
        }
        if let Some(brushed) = material.extension_value("KHR_materials_anisotropy") {
            let strength = number(brushed, "anisotropyStrength").clamp(0.0, 1.0);
            if strength > 0.0 {
                let turn = number(brushed, "anisotropyRotation") / std::f64::consts::TAU;
                self.to.numbers.push(("anisotropic", strength));
                self.to.numbers.push(("anisotropic_rotation", turn.rem_euclid(1.0)));
            }
            self.images_of(brushed, "anisotropy");
        }
    }

    fn images_of(&mut self, value: &Value, what: &str) {
        if value.as_object().is_some_and(|map| map.keys().any(|key| key.ends_with("Texture"))) {
            self.notes.leave_out(format!("an image of {what}"));
        }
    }

    fn emission(&mut self, material: &gltf::Material<'_>) {
        let color = material.emissive_factor();
        let strength = material.emissive_strength().unwrap_or(1.0);
        if color == [0.0; 3] || strength <= 0.0 || material.unlit() {
            return;
        }
        let has_image = self.image("emission_color", material.emissive_texture(), None);
        self.color("emission_color", color, if has_image { [1.0; 3] } else { [f32::NAN; 3] });
        self.to.numbers.push(("emission_strength", f64::from(strength)));
    }
}

/// How texture coordinates are changed, where v points up.
struct Placed {
    scale: [f64; 2],
    offset: [f64; 2],
    turn_deg: f64,
}

impl Placed {
    /// In the file v points down, so an offset along it depends on the scale.
    fn of(transform: Option<TextureTransform<'_>>) -> Self {
        let Some(transform) = transform else {
            return Self { scale: [1.0; 2], offset: [0.0; 2], turn_deg: 0.0 };
        };
        let (scale, offset) = (transform.scale().map(f64::from), transform.offset().map(f64::from));
        let turn = f64::from(transform.rotation());
        let (sin, cos) = (libm::sin(turn), libm::cos(turn));
        Self {
            scale,
            offset: [offset[0] + scale[1] * sin, 1.0 - offset[1] - scale[1] * cos],
            turn_deg: turn.to_degrees(),
        }
    }
}
