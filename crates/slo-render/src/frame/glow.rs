//! How much light materials emit, for the choice among emitters.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::shading::material::Image;
use slo_scene::material::{Principled, Varying};
use slo_scene::{MaterialKind, SceneDescription, Texture};

/// What a material emits, without what its layers keep back.
#[derive(Debug)]
pub(super) enum Glow {
    /// Nothing.
    Dark,
    /// A colour, multiplied by images of colours, by images of numbers, and by alpha.
    Bright {
        color: Vec3,
        colors: Vec<Image>,
        numbers: Vec<Image>,
    },
    Mix {
        both: Box<[Self; 2]>,
        factor: (f32, Option<Image>),
    },
}

impl Glow {
    /// Returns what a material emits.
    pub(super) fn of(scene: &SceneDescription, material: u32) -> Self {
        match &scene.materials[material as usize].kind {
            MaterialKind::Phong(_) => Self::Dark,
            MaterialKind::Principled(of) => Self::of_principled(of),
            MaterialKind::Mix(mix) => {
                let both = [mix.first, mix.second].map(|part| Self::of(scene, part.0));
                if both.iter().all(|part| matches!(part, Self::Dark)) {
                    return Self::Dark;
                }
                let image = mix.factor.image.as_ref().map(Image::new);
                Self::Mix { both: Box::new(both), factor: (mix.factor.value, image) }
            }
        }
    }

    fn of_principled(of: &Principled) -> Self {
        let Principled { emission_color, emission_strength, alpha, .. } = of;
        let color = Vec3::from(emission_color.value) * emission_strength.value * alpha.value;
        if color == Vec3::ZERO {
            return Self::Dark;
        }
        let image = |of: &Varying<f32>| of.image.as_ref().map(Image::new);
        Self::Bright {
            color,
            colors: emission_color.image.iter().map(Image::new).collect(),
            numbers: [image(emission_strength), image(alpha)].into_iter().flatten().collect(),
        }
    }

    /// Whether it is the same at all texture coordinates.
    fn is_even(&self) -> bool {
        match self {
            Self::Dark => true,
            Self::Bright { colors, numbers, .. } => colors.is_empty() && numbers.is_empty(),
            Self::Mix { both, factor } => factor.1.is_none() && both.iter().all(Self::is_even),
        }
    }

    /// Returns the radiance at texture coordinates.
    fn at(&self, textures: &[Arc<Texture>], uv: Vec2) -> Vec3 {
        match self {
            Self::Dark => Vec3::ZERO,
            Self::Bright { color, colors, numbers } => {
                let color = colors.iter().fold(*color, |c, image| c * image.color(textures, uv));
                numbers.iter().fold(color, |c, image| c * image.number(textures, uv))
            }
            Self::Mix { both, factor: (factor, image) } => {
                let [a, b] = both.each_ref().map(|part| part.at(textures, uv));
                let image = image.as_ref().map_or(1.0, |image| image.number(textures, uv));
                a.lerp(b, (factor * image).clamp(0.0, 1.0))
            }
        }
    }

    /// Returns the mean radiance over the unit square of texture coordinates.
    pub(super) fn mean(&self, textures: &[Arc<Texture>], count: u32) -> Vec3 {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let upper = [Vec2::ONE, Vec2::Y, Vec2::X];
        let both = [corners, upper].map(|corners| self.mean_in(textures, corners, count));
        (both[0] + both[1]) * 0.5
    }

    /// Returns the mean radiance in a triangle of texture coordinates, by `count` places in it.
    pub(super) fn mean_in(
        &self,
        textures: &[Arc<Texture>],
        [a, b, c]: [Vec2; 3],
        count: u32,
    ) -> Vec3 {
        let count = if self.is_even() { 1 } else { count };
        let one = |i: u32| {
            // Source: M. Roberts, the R2 sequence.
            let step = |factor: f64| {
                let x = 0.5 + factor * f64::from(i);
                (x - x.floor()) as f32
            };
            let (u, v) = (step(0.754_877_666_246_693), step(0.569_840_290_998_053_3));
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            self.at(textures, a + (b - a) * u + (c - a) * v)
        };
        (0..count).map(one).sum::<Vec3>() / count as f32
    }
}
