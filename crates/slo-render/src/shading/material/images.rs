//! Images that change the numbers of physical materials over their surfaces.

use glam::{Mat2, Vec2, Vec3};
use std::sync::Arc;

use super::principled::Parameters;
use crate::shading::texture::sample;
use slo_scene::material::{Mix, Principled, Varying};
use slo_scene::{Channel, Curve, ImageUse, MaterialKind, Texture};

/// An image as a material uses it.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    texture: u32,
    curve: Curve,
    channel: Channel,
    /// Texture coordinates on the surface to those of the image.
    turn: Mat2,
    offset: Vec2,
}

impl Image {
    /// Prepares an image of a scene.
    pub fn new(of: &ImageUse) -> Self {
        let (sin, cos) = libm::sincos(f64::from(of.turn_deg).to_radians());
        let (sin, cos) = (sin as f32, cos as f32);
        let turn = Mat2::from_cols(Vec2::new(cos, sin), Vec2::new(-sin, cos));
        Self {
            texture: of.texture.0,
            curve: of.encoding,
            channel: of.channel,
            turn: turn * Mat2::from_diagonal(of.scale.into()),
            offset: of.offset.into(),
        }
    }

    /// Returns red, green, blue and alpha at texture coordinates of the surface.
    fn texel(&self, textures: &[Arc<Texture>], uv: Vec2) -> [f32; 4] {
        let at = self.turn * uv + self.offset;
        let texture = &textures[self.texture as usize];
        sample(texture, self.curve, at.x, at.y)
    }

    /// Returns the number that the image holds at texture coordinates of the surface.
    pub fn number(&self, textures: &[Arc<Texture>], uv: Vec2) -> f32 {
        let [r, g, b, a] = self.texel(textures, uv);
        match self.channel {
            // Of greys exactly their value.
            Channel::Color | Channel::Luminance => g + 0.2126 * (r - g) + 0.0722 * (b - g),
            Channel::Red => r,
            Channel::Green => g,
            Channel::Blue => b,
            Channel::Alpha => a,
        }
    }

    /// Returns the colour that the image holds at texture coordinates of the surface.
    pub fn color(&self, textures: &[Arc<Texture>], uv: Vec2) -> Vec3 {
        match self.channel {
            Channel::Color => {
                let [r, g, b, _] = self.texel(textures, uv);
                Vec3::new(r, g, b)
            }
            _ => Vec3::splat(self.number(textures, uv)),
        }
    }
}

/// Defines the numbers and colours that images may change.
macro_rules! inputs {
    (
        numbers { $( $Number:ident: $number:ident, )+ }
        colors { $( $Color:ident: $color:ident in $column:ident, )+ }
    ) => {
        /// A number or colour of a principled material.
        #[derive(Clone, Copy, Debug)]
        enum Input {
            $( $Number, )+
            $( $Color, )+
        }

        /// Returns the images that change a material.
        fn images(of: &Principled) -> Vec<(Input, Image)> {
            let mut all = Vec::new();
            $( all.extend(of.$number.image.iter().map(|image| (Input::$Number, Image::new(image)))); )+
            $( all.extend(of.$color.image.iter().map(|image| (Input::$Color, Image::new(image)))); )+
            all
        }

        impl Input {
            /// Multiplies the numbers of hit `i` by what an image holds.
            fn multiply(self, i: usize, to: &mut Parameters, image: &Image, textures: &[Arc<Texture>], uv: Vec2) {
                match self {
                    $( Self::$Number => inputs!(@number to, $number, i, image.number(textures, uv)), )+
                    $( Self::$Color => {
                        let color = to.$column.get(i) * image.color(textures, uv);
                        to.$column.set(i, color);
                    } )+
                }
            }
        }
    };
    (@number $to:ident, emission_strength, $i:ident, $value:expr) => {{
        let emission = $to.emission.get($i) * $value;
        $to.emission.set($i, emission);
    }};
    (@number $to:ident, normal_strength, $i:ident, $value:expr) => {
        $to.normal_strength[$i] *= $value
    };
    (@number $to:ident, $number:ident, $i:ident, $value:expr) => {
        $to.$number[$i] *= $value
    };
}

inputs! {
    numbers {
        Metallic: metallic,
        Roughness: roughness,
        DiffuseRoughness: diffuse_roughness,
        Ior: ior,
        Alpha: alpha,
        NormalStrength: normal_strength,
        SpecularIorLevel: specular_ior_level,
        Anisotropic: anisotropic,
        AnisotropicRotation: anisotropic_rotation,
        Transmission: transmission,
        Coat: coat,
        CoatRoughness: coat_roughness,
        CoatIor: coat_ior,
        Sheen: sheen,
        SheenRoughness: sheen_roughness,
        EmissionStrength: emission_strength,
    }
    colors {
        BaseColor: base_color in base_color,
        SpecularTint: specular_tint in specular_tint,
        CoatTint: coat_tint in coat_tint,
        SheenTint: sheen_tint in sheen_tint,
        EmissionColor: emission_color in emission,
    }
}

/// How a material looks where only images tell.
#[derive(Clone, Debug)]
enum Look {
    Phong,
    Principled {
        images: Vec<(Input, Image)>,
        opacity: (f32, Option<Image>),
        normals: Option<Image>,
    },
    Mix {
        first: u32,
        second: u32,
        factor: (f32, Option<Image>),
    },
}

/// The images of all materials, indexed by the material.
#[derive(Clone, Debug, Default)]
pub struct MaterialImages {
    looks: Vec<Look>,
    /// Whether any material depends on texture coordinates, and which.
    needs_uv: Vec<bool>,
    any_uv: bool,
    /// Whether any material depends on tangents, and which.
    needs_tangent: Vec<bool>,
    any_tangent: bool,
    /// Which materials let light pass through unbent, somewhere.
    passes: Vec<bool>,
    any_pass: bool,
    any_bend: bool,
}

fn varying(of: &Varying<f32>) -> (f32, Option<Image>) {
    (of.value, of.image.as_ref().map(Image::new))
}

fn value((value, image): &(f32, Option<Image>), textures: &[Arc<Texture>], uv: Vec2) -> f32 {
    image.as_ref().map_or(*value, |image| value * image.number(textures, uv)).clamp(0.0, 1.0)
}

impl MaterialImages {
    /// Prepares the materials of a scene.
    pub fn new(materials: &[slo_scene::Material]) -> Self {
        let look = |material: &slo_scene::Material| match &material.kind {
            MaterialKind::Phong(_) => Look::Phong,
            MaterialKind::Principled(of) => {
                let normals = of.normal.as_ref().map(Image::new);
                Look::Principled { images: images(of), opacity: varying(&of.alpha), normals }
            }
            MaterialKind::Mix(Mix { first, second, factor }) => {
                Look::Mix { first: first.0, second: second.0, factor: varying(factor) }
            }
        };
        let looks: Vec<Look> = materials.iter().map(look).collect();
        // Whether it matters how a texture is turned.
        let turns = |number: usize| match &materials[number].kind {
            MaterialKind::Principled(of) => of.normal.is_some() || of.anisotropic.value != 0.0,
            MaterialKind::Phong(_) | MaterialKind::Mix(_) => false,
        };
        // Phong materials that are not mixed look up their textures themselves.
        let is_textured = |number: usize| match &materials[number].kind {
            MaterialKind::Phong(of) => of.texture.is_some(),
            MaterialKind::Principled(_) | MaterialKind::Mix(_) => false,
        };
        let uv = |number: usize| match &looks[number] {
            Look::Phong => false,
            Look::Principled { images, .. } => !images.is_empty() || turns(number),
            Look::Mix { factor, .. } => factor.1.is_some(),
        };
        let pass = |number: usize| match &looks[number] {
            Look::Principled { opacity, .. } => opacity.0 < 1.0 || opacity.1.is_some(),
            Look::Phong | Look::Mix { .. } => false,
        };
        // What a part of a mix needs, the mix needs too. Mixes may stand before their parts.
        let spread = |of: &dyn Fn(usize) -> bool, parts: &dyn Fn(usize) -> bool| {
            let mut all: Vec<bool> = (0..looks.len()).map(of).collect();
            let mut changed = true;
            while changed {
                changed = false;
                for (number, look) in looks.iter().enumerate() {
                    if let Look::Mix { first, second, .. } = look {
                        let of_part = |part: u32| all[part as usize] || parts(part as usize);
                        if !all[number] && (of_part(*first) || of_part(*second)) {
                            all[number] = true;
                            changed = true;
                        }
                    }
                }
            }
            all
        };
        let needs_uv = spread(&uv, &is_textured);
        let needs_tangent = spread(&turns, &|_| false);
        let passes = spread(&pass, &|_| false);
        let bends = |look: &Look| matches!(look, Look::Principled { normals: Some(_), .. });
        Self {
            any_bend: looks.iter().any(bends),
            any_uv: needs_uv.contains(&true),
            any_tangent: needs_tangent.contains(&true),
            any_pass: passes.contains(&true),
            looks,
            needs_uv,
            needs_tangent,
            passes,
        }
    }

    /// Whether any material depends on texture coordinates.
    pub fn any_needs_uv(&self) -> bool {
        self.any_uv
    }

    /// Whether a material depends on texture coordinates.
    pub fn needs_uv(&self, material: u32) -> bool {
        self.needs_uv.get(material as usize).is_some_and(|needs| *needs)
    }

    /// Whether any material depends on tangents.
    pub fn any_needs_tangent(&self) -> bool {
        self.any_tangent
    }

    /// Whether a material depends on tangents.
    pub fn needs_tangent(&self, material: u32) -> bool {
        self.needs_tangent.get(material as usize).is_some_and(|needs| *needs)
    }

    /// Whether an image bends the normals of any material.
    pub fn any_bends(&self) -> bool {
        self.any_bend
    }

    /// Returns the image that bends the normals of a material.
    pub fn normals(&self, material: u32) -> Option<&Image> {
        match self.looks.get(material as usize) {
            Some(Look::Principled { normals, .. }) => normals.as_ref(),
            _ => None,
        }
    }

    /// Whether any material lets light pass through unbent, somewhere.
    pub fn any_passes(&self) -> bool {
        self.any_pass
    }

    /// Whether a material lets light pass through unbent, somewhere.
    pub fn passes(&self, material: u32) -> bool {
        self.passes.get(material as usize).is_some_and(|passes| *passes)
    }

    /// Chooses one of the materials that a material mixes, at texture coordinates, by a random
    /// number. Returns the material, and the random number rescaled to be uniform again.
    pub fn choose(
        &self,
        mut material: u32,
        textures: &[Arc<Texture>],
        uv: Vec2,
        mut u: f32,
    ) -> (u32, f32) {
        while let Some(Look::Mix { first, second, factor }) = self.looks.get(material as usize) {
            let share = value(factor, textures, uv);
            let is_second = u < share;
            let rest = if is_second { u / share } else { (u - share) / (1.0 - share) };
            // Roundings must not make it 1, since then an opaque part would let rays pass.
            u = rest.min(1.0f32.next_down());
            material = if is_second { *second } else { *first };
        }
        (material, u)
    }

    /// Multiplies the numbers of hit `i` by what images hold at texture coordinates.
    pub fn multiply(
        &self,
        material: u32,
        textures: &[Arc<Texture>],
        uv: Vec2,
        i: usize,
        to: &mut Parameters,
    ) {
        if let Some(Look::Principled { images, .. }) = self.looks.get(material as usize) {
            for (input, image) in images {
                input.multiply(i, to, image, textures, uv);
            }
        }
    }

    /// Returns the share of light that does not pass through a material unbent, at texture
    /// coordinates.
    pub fn opacity(&self, material: u32, textures: &[Arc<Texture>], uv: Vec2) -> f32 {
        if !self.passes(material) {
            return 1.0;
        }
        match &self.looks[material as usize] {
            Look::Phong => 1.0,
            Look::Principled { opacity, .. } => value(opacity, textures, uv),
            // Scenes do not nest mixes deeply.
            Look::Mix { first, second, factor } => {
                let share = value(factor, textures, uv);
                let part = |number, share: f32| {
                    if share > 0.0 { share * self.opacity(number, textures, uv) } else { 0.0 }
                };
                // At most 1: both shares are rounded.
                (part(*first, 1.0 - share) + part(*second, share)).min(1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::material::{Phong, PhongInfo};
    use slo_scene::{Filter, Material, MaterialId, TextureId, Wrap};

    fn image(channel: Channel) -> ImageUse {
        ImageUse {
            texture: TextureId(0),
            channel,
            encoding: Curve::Raw,
            scale: [1.0; 2],
            turn_deg: 0.0,
            offset: [0.0; 2],
        }
    }

    /// One texture of two texels, whose colours are multiplied by alpha.
    fn textures(left: [f32; 4], right: [f32; 4]) -> Vec<Arc<Texture>> {
        let texture = Texture::from_rgba_f32(2, 1, [left, right].as_flattened().to_vec());
        let texture = texture.expect("two texels").with_wrap(Wrap::Clamp);
        vec![Arc::new(texture.with_filter(Filter::Nearest))]
    }

    fn material(kind: MaterialKind) -> Material {
        Material { kind, name: String::new() }
    }

    fn phong() -> Material {
        let info = PhongInfo {
            ambient: [0.0; 3],
            diffuse: [0.5; 3],
            specular: [0.0; 3],
            shininess: 1.0,
            reflectance: 0.0,
            diffuse_reflection: 0.0,
            refraction: 0.0,
            diffuse_refraction: 0.0,
            refraction_index: 1.0,
        };
        material(MaterialKind::Phong(Phong { info, texture: None }))
    }

    fn see_through(value: f32, image: Option<ImageUse>) -> Material {
        material(MaterialKind::Principled(Principled {
            alpha: Varying { value, image },
            ..Principled::default()
        }))
    }

    fn mix(first: u32, second: u32, value: f32, image: Option<ImageUse>) -> Material {
        let factor = Varying { value, image };
        let (first, second) = (MaterialId(first), MaterialId(second));
        material(MaterialKind::Mix(Mix { first, second, factor }))
    }

    #[test]
    fn coordinates_are_scaled_then_turned_then_moved() {
        let of = ImageUse {
            scale: [2.0, -3.0],
            turn_deg: 30.0,
            offset: [0.25, -0.5],
            ..image(Channel::Color)
        };
        let image = Image::new(&of);
        let (s, c) = (0.5, 0.75f32.sqrt());
        for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.7)] {
            let (x, y) = (2.0 * uv.x, -3.0 * uv.y);
            let expected = Vec2::new(c * x - s * y + 0.25, s * x + c * y - 0.5);
            let found = image.turn * uv + image.offset;
            assert!((found - expected).length() < 1e-6, "{found}, not {expected}");
        }
    }

    #[test]
    fn channels_and_luminance() {
        let textures = textures([0.25, 0.125, 0.5, 0.5], [0.3, 0.3, 0.3, 1.0]);
        let number = |channel, u| Image::new(&image(channel)).number(&textures, Vec2::new(u, 0.5));
        let color = |channel| Image::new(&image(channel)).color(&textures, Vec2::new(0.2, 0.5));
        let luminance: f32 = 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722;
        for (channel, expected) in [
            (Channel::Red, 0.5),
            (Channel::Green, 0.25),
            (Channel::Blue, 1.0),
            (Channel::Alpha, 0.5),
            (Channel::Luminance, luminance),
        ] {
            assert!((number(channel, 0.2) - expected).abs() < 1e-6);
            assert!((color(channel) - Vec3::splat(expected)).length() < 1e-6);
        }
        assert_eq!(color(Channel::Color), Vec3::new(0.5, 0.25, 1.0));
        // Greys keep their bits, so that white is opaque.
        assert_eq!(number(Channel::Luminance, 0.8), 0.3);
    }

    #[test]
    fn mixes_choose_in_proportion_and_leave_a_number_below_one() {
        let materials =
            [see_through(1.0, None), phong(), mix(0, 1, 0.3, None), mix(2, 0, 0.1, None)];
        let images = MaterialImages::new(&materials);
        let mut counts = [0; 2];
        let mut largest = 0.0f32;
        for i in 0..1u32 << 16 {
            let (chosen, u) = images.choose(3, &[], Vec2::ZERO, i as f32 / 65536.0);
            assert!((0.0..1.0).contains(&u), "{u}");
            counts[chosen as usize] += 1;
            largest = largest.max(u);
        }
        assert!((f64::from(counts[1]) / 65536.0 - 0.27).abs() < 1e-4, "{counts:?}");
        assert!(largest > 0.999);
        let last = 1.0f32.next_down();
        for i in 1..1000_u16 {
            let share = f32::from(i) / 1000.0;
            let images = MaterialImages::new(&[see_through(1.0, None), mix(0, 0, share, None)]);
            for u in [0.0, share.next_down(), share, share.next_up(), last] {
                let (_, rest) = images.choose(1, &[], Vec2::ZERO, u);
                assert!((0.0..1.0).contains(&rest), "{share} {u}: {rest}");
            }
        }
    }

    #[test]
    fn opacity_of_mixes_is_the_mean_of_their_parts() {
        let materials = [
            see_through(0.5, Some(image(Channel::Alpha))),
            phong(),
            mix(0, 1, 0.25, None),
            mix(2, 4, 1.0, Some(image(Channel::Red))),
            see_through(0.1, None),
            mix(1, 1, 0.3, None),
        ];
        let images = MaterialImages::new(&materials);
        let textures = textures([0.5; 4], [0.5, 0.5, 0.5, 1.0]);
        let opacity = |material, u| images.opacity(material, &textures, Vec2::new(u, 0.5));
        for (material, left, right) in [
            (0, 0.25, 0.5),
            (1, 1.0, 1.0),
            (2, 0.75 * 0.25 + 0.25, 0.75 * 0.5 + 0.25),
            (3, 0.1, 0.5 * 0.625 + 0.5 * 0.1),
            (4, 0.1, 0.1),
            (5, 1.0, 1.0),
        ] {
            assert!((opacity(material, 0.2) - left).abs() < 1e-6, "{material}");
            assert!((opacity(material, 0.8) - right).abs() < 1e-6, "{material}");
        }
        let passes = [true, false, true, true, true, false];
        assert_eq!(std::array::from_fn(|material| images.passes(material as u32)), passes);
    }

    #[test]
    fn scenes_without_images_need_nothing() {
        let materials = [see_through(1.0, None), phong(), mix(0, 1, 0.3, None)];
        let images = MaterialImages::new(&materials);
        assert!(!images.any_needs_uv() && !images.any_needs_tangent());
        assert!(!images.any_passes() && !images.any_bends());
    }
}
