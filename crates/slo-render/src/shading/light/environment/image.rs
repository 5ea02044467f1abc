//! A sky that an image shows.

use std::sync::Arc;

use glam::Vec3;

use super::even::bounds;
use super::table::{SkyShare, SkyTable, TableSample, TableView};
use crate::shading::light::bounds::LightBounds;
use crate::shading::light::lamp::{Lamp, Sampled};
use crate::shading::texture::{equirect_uv, sample_around};
use slo_scene::{Curve, Texture};

/// A sky that an image shows. It is sampled by the image's luminance, or by what exceeds the mean;
/// see [`SkyShare`].
#[derive(Clone, Debug)]
pub struct ImageSky {
    texture: Arc<Texture>,
    table: Arc<SkyTable>,
    strength: f32,
    /// Where the middle of the image lies in the xy plane: the cosine and the sine.
    turn: [f32; 2],
}

impl ImageSky {
    /// The sky of an image. The table is taken from one of `before`, skies of another frame, if it
    /// is that of the same image.
    pub fn new(
        texture: &Arc<Texture>,
        strength: f32,
        turn_deg: f32,
        share: SkyShare,
        before: &[Self],
    ) -> Self {
        let is_same =
            |sky: &&Self| Arc::ptr_eq(&sky.texture, texture) && sky.table.share() == share;
        let table = before
            .iter()
            .find(is_same)
            .map_or_else(|| Arc::new(SkyTable::new(texture, share)), |sky| Arc::clone(&sky.table));
        // In degrees, whole turns are exact.
        let (sin, cos) = libm::sincos(f64::from(turn_deg % 360.0).to_radians());
        let turn = [cos as f32, sin as f32];
        Self { texture: Arc::clone(texture), table, strength, turn }
    }

    /// Whether another sky has the same table.
    #[cfg(test)]
    pub(in crate::shading::light) fn shares_table(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.table, &other.table)
    }

    /// Returns the sky as loops use it.
    pub fn view(&self) -> ImageView<'_> {
        let Self { texture, table, strength, turn } = self;
        let (table, curve) = (table.view(), texture.color_curve());
        ImageView { texture, curve, table, strength: *strength, turn: *turn }
    }
}

/// An [`ImageSky`] as loops use it.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    texture: &'a Texture,
    curve: Curve,
    table: TableView<'a>,
    strength: f32,
    turn: [f32; 2],
}

impl ImageView<'_> {
    /// Turns a direction of the image to render space.
    #[inline(always)]
    fn turned(&self, way: Vec3) -> Vec3 {
        let [cos, sin] = self.turn;
        Vec3::new(way.x * cos - way.y * sin, way.x * sin + way.y * cos, way.z)
    }

    /// Turns a direction back to the image.
    #[inline(always)]
    fn turned_back(&self, way: Vec3) -> Vec3 {
        let [cos, sin] = self.turn;
        Vec3::new(way.x * cos + way.y * sin, way.y * cos - way.x * sin, way.z)
    }
}

impl ImageView<'_> {
    /// Returns where the image shows a direction of render space.
    #[inline(always)]
    fn uv(&self, way: Vec3) -> [f32; 2] {
        equirect_uv(self.turned_back(way).to_array())
    }

    /// Returns the radiance of what the image shows at a place.
    #[inline(always)]
    fn shown(&self, uv: [f32; 2]) -> Vec3 {
        Vec3::from(sample_around(self.texture, self.curve, uv)) * self.strength
    }
}

impl Lamp for ImageView<'_> {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_DISTANT: bool = true;
    const LOOKS_UP: bool = true;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        self.shown(self.uv(way))
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.way(from, u)
    }

    #[inline(always)]
    fn way(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        self.turned(self.table.sample(u).way)
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        self.table.density(self.uv(way))
    }

    #[inline(always)]
    fn sample(&self, _from: Vec3, u: [f32; 2]) -> Sampled {
        let TableSample { way, uv, density } = self.table.sample(u);
        Sampled { way: self.turned(way), radiance: self.shown(uv), density }
    }

    #[inline(always)]
    fn found(&self, _from: Vec3, way: Vec3) -> (Vec3, f32) {
        let uv = self.uv(way);
        (self.shown(uv), self.table.density(uv))
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        bounds(self.table.mean() * self.strength)
    }
}
