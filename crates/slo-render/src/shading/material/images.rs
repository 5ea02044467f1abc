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
            Channel::Color | Channel::Luminance => 0.2126 * r + 0.7152 * g + 0.0722 * b,
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
    /// Nothing depends on images.
    Even {
        opacity: f32,
    },
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
            MaterialKind::Phong(_) => Look::Even { opacity: 1.0 },
            MaterialKind::Principled(of) => {
                let normals = of.normal.as_ref().map(Image::new);
                Look::Principled { images: images(of), opacity: varying(&of.alpha), normals }
            }
            MaterialKind::Mix(Mix { first, second, factor }) => {
                Look::Mix { first: first.0, second: second.0, factor: varying(factor) }
            }
        };
        let looks: Vec<Look> = materials.iter().map(look).collect();
        let normals = |number: usize| match &materials[number].kind {
            MaterialKind::Principled(of) => {
                of.normal.is_some() || of.anisotropic.value > 0.0 || of.anisotropic.image.is_some()
            }
            MaterialKind::Phong(of) => of.texture.is_some(),
            MaterialKind::Mix(_) => false,
        };
        let uv = |number: usize| match &looks[number] {
            Look::Even { .. } => false,
            Look::Principled { images, .. } => !images.is_empty() || normals(number),
            Look::Mix { factor, .. } => factor.1.is_some(),
        };
        let pass = |number: usize| match &looks[number] {
            Look::Even { opacity } => *opacity < 1.0,
            Look::Principled { opacity, .. } => opacity.0 < 1.0 || opacity.1.is_some(),
            Look::Mix { .. } => false,
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
        let needs_uv = spread(&uv, &normals);
        let passes = spread(&pass, &|_| false);
        let bends = |look: &Look| matches!(look, Look::Principled { normals: Some(_), .. });
        Self {
            any_bend: looks.iter().any(bends),
            any_uv: needs_uv.contains(&true),
            any_pass: passes.contains(&true),
            looks,
            needs_uv,
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
            u = if is_second { u / share } else { (u - share) / (1.0 - share) };
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
        let mut sum = 0.0;
        // Parts of mixes that are still to be added, with their shares.
        let mut left = vec![(material, 1.0)];
        while let Some((material, share)) = left.pop() {
            match self.looks.get(material as usize) {
                Some(Look::Mix { first, second, factor }) => {
                    let of_second = value(factor, textures, uv);
                    left.push((*first, share * (1.0 - of_second)));
                    left.push((*second, share * of_second));
                }
                Some(Look::Principled { opacity, .. }) => {
                    sum += share * value(opacity, textures, uv);
                }
                Some(Look::Even { opacity }) => sum += share * opacity,
                None => sum += share,
            }
        }
        sum
    }
}
