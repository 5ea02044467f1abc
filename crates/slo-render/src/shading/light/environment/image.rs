//! A sky that an image shows.

use std::sync::Arc;

use glam::Vec3;

use super::equirect::{place, sample_equirect};
use super::even::bounds;
use super::table::{SkyTable, TableView};
use crate::shading::light::bounds::LightBounds;
use crate::shading::light::lamp::Lamp;
use slo_scene::Texture;

/// A sky that an image shows. It is sampled by the image's luminance. A sky has no density less
/// than its light asks for to leave more to rays of lobes: integrators may have none of these.
#[derive(Clone, Debug)]
pub struct ImageSky {
    texture: Arc<Texture>,
    table: Arc<SkyTable>,
    strength: f32,
    /// Full turns from +x toward +y.
    turn: f32,
}

impl ImageSky {
    /// The sky of an image. The table is taken from `before`, a sky of another frame, if it is that
    /// of the same image.
    pub fn new(
        texture: &Arc<Texture>,
        strength: f32,
        turn_deg: f32,
        before: Option<&Self>,
    ) -> Self {
        let table = before.filter(|sky| Arc::ptr_eq(&sky.texture, texture));
        let table =
            table.map_or_else(|| Arc::new(SkyTable::new(texture)), |sky| Arc::clone(&sky.table));
        let turns = f64::from(turn_deg) / 360.0;
        let turn = (turns - turns.floor()) as f32;
        Self { texture: Arc::clone(texture), table, strength, turn }
    }

    /// Returns the image.
    pub fn texture(&self) -> &Arc<Texture> {
        &self.texture
    }

    /// Whether another sky has the same table.
    #[cfg(test)]
    pub(in crate::shading::light) fn shares_table(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.table, &other.table)
    }

    /// Returns the sky as loops use it.
    pub fn view(&self) -> ImageView<'_> {
        let Self { texture, table, strength, turn } = self;
        ImageView { texture, table: table.view(), strength: *strength, turn: *turn }
    }
}

/// An [`ImageSky`] as loops use it.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    texture: &'a Texture,
    table: TableView<'a>,
    strength: f32,
    turn: f32,
}

impl Lamp for ImageView<'_> {
    const IS_AREA: bool = true;
    const IS_DELTA: bool = false;
    const IS_DISTANT: bool = true;

    #[inline(always)]
    fn radiance(&self, way: Vec3) -> Vec3 {
        sample_equirect(self.texture, place(way, self.turn)) * self.strength
    }

    #[inline(always)]
    fn point(&self, from: Vec3, u: [f32; 2]) -> Vec3 {
        self.way(from, u)
    }

    #[inline(always)]
    fn way(&self, _from: Vec3, u: [f32; 2]) -> Vec3 {
        self.table.sample(u, self.turn)
    }

    #[inline(always)]
    fn density(&self, _from: Vec3, way: Vec3) -> f32 {
        self.table.density(place(way, self.turn))
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        bounds(self.table.mean() * self.strength)
    }
}
