//! A sky that an image shows.

use std::sync::Arc;

use glam::Vec3;

use super::even::bounds;
use super::table::{Cell, SkyShare, SkyTable, TableSample, TableView};
use crate::shading::light::bounds::LightBounds;
use crate::shading::light::lamp::{Lamp, Sampled, Samples};
use crate::shading::texture::{equirect_uv, sample_around};
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};
use slo_accel::{Isa, Lanewise};
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

    fn sample_each(
        &self,
        isa: Isa,
        (_, len): (&Vec3s, usize),
        u: [&Column<f32>; 2],
        asks: impl Fn(usize) -> bool,
        to: &mut Samples,
    ) {
        isa.run(FindCells { table: self.table, len, u, asks: &asks, to });
        isa.run(Ways { sky: *self, len, to });
        isa.run(Shown { sky: *self, len, asks, to });
    }

    fn found_each(&self, isa: Isa, _hits: &Vec3s, len: usize, to: &mut Samples) {
        isa.run(Places { sky: *self, len, to });
        isa.run(Shown { sky: *self, len, asks: |_| true, to });
    }

    #[inline(always)]
    fn shadow_ray(&self, _from: Vec3, point: Vec3) -> (Vec3, f32) {
        (point, f32::INFINITY)
    }

    fn bounds(&self) -> LightBounds {
        bounds(self.table.mean() * self.strength)
    }
}

/// Finds the cells of samples, and where in their cells these lie.
struct FindCells<'a, A> {
    table: TableView<'a>,
    len: usize,
    u: [&'a Column<f32>; 2],
    asks: &'a A,
    to: &'a mut Samples,
}

impl<A: Fn(usize) -> bool> Lanewise for FindCells<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { table, len, u, asks, to } = self;
        for i in (0..len.min(BATCH)).filter(|i| asks(*i)) {
            let Cell { row, column, versine, right } = table.find(u.map(|column| column[i]));
            (to.cell[0][i], to.cell[1][i]) = (row as u32, column as u32);
            (to.uv[0][i], to.uv[1][i]) = (right, versine);
        }
    }
}

/// Computes the directions of samples in their cells.
struct Ways<'a> {
    sky: ImageView<'a>,
    len: usize,
    to: &'a mut Samples,
}

impl Lanewise for Ways<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, len, to } = self;
        let (rows, columns) = sky.table.size();
        for i in lanes(len) {
            let [right, versine] = [to.uv[0][i], to.uv[1][i]];
            let is_upper = 2 * to.cell[0][i] < rows;
            let (way, uv) = TableView::way(is_upper, to.cell[1][i], columns, versine, right);
            to.way.set(i, sky.turned(way));
            (to.uv[0][i], to.uv[1][i]) = (uv[0], uv[1]);
        }
    }
}

/// Finds where the image shows directions, and their cells.
struct Places<'a> {
    sky: ImageView<'a>,
    len: usize,
    to: &'a mut Samples,
}

impl Lanewise for Places<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, len, to } = self;
        for i in lanes(len) {
            let uv = sky.uv(to.way.get(i));
            (to.uv[0][i], to.uv[1][i]) = (uv[0], uv[1]);
        }
        for i in 0..len.min(BATCH) {
            let [row, column] = sky.table.cell([to.uv[0][i], to.uv[1][i]]);
            (to.cell[0][i], to.cell[1][i]) = (row as u32, column as u32);
        }
    }
}

/// Looks up what the image shows at places, and the densities of their cells.
struct Shown<'a, A> {
    sky: ImageView<'a>,
    len: usize,
    asks: A,
    to: &'a mut Samples,
}

impl<A: Fn(usize) -> bool> Lanewise for Shown<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, len, asks, to } = self;
        for i in (0..len.min(BATCH)).filter(|i| asks(*i)) {
            to.radiance.set(i, sky.shown([to.uv[0][i], to.uv[1][i]]));
        }
        for i in (0..len.min(BATCH)).filter(|i| asks(*i)) {
            let [row, column] = [0, 1].map(|k| to.cell[k][i] as usize);
            to.density[i] = sky.table.density_in(row, column);
        }
    }
}
