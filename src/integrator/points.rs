//! The hits of one batch that are to be shaded, with everything that shading reads.

use super::queue::{Batch, Labels};
use crate::accel::Lanewise;
use crate::frame::{FrameScene, Surfaces};
use crate::math::columns::{BATCH, Column, Vec3s, lanes, look_up};
use crate::sampling::batch::SetNames;
use crate::sampling::{PixelSeed, Purpose};
use crate::scene::Settings;
use crate::shading::MaterialTable;

/// Hits in columns; `surfaces.len` of them.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) surfaces: Surfaces,
    /// Unit directions of the rays that came here.
    pub(super) direction: Vec3s,
    /// What light that leaves toward where the ray came from is worth.
    pub(super) weight: Vec3s,
    pub(super) labels: Labels,
    /// k_a of the material, tinted and weighted: what comes from everywhere.
    pub(super) ambient: Vec3s,
    /// Words of the seeds of the pixels.
    pub(super) seed: Column<u32>,
    /// k_d of the material, tinted and weighted.
    pub(super) diffuse: Vec3s,
    /// k_s of the material, weighted.
    pub(super) specular: Vec3s,
    pub(super) shininess: Column<f32>,
    /// Whether any material has a highlight.
    pub(super) shines: bool,
}

impl Default for Points {
    fn default() -> Self {
        Self {
            surfaces: Surfaces::default(),
            direction: Vec3s::default(),
            weight: Vec3s::default(),
            labels: Labels::default(),
            ambient: Vec3s::default(),
            seed: [0; BATCH],
            diffuse: Vec3s::default(),
            specular: Vec3s::default(),
            shininess: [0.0; BATCH],
            shines: false,
        }
    }
}

impl Points {
    /// Fills in what goes with the surfaces: from the batch whose rays hit them, and from tables.
    pub(super) fn gather(&mut self, frame: &FrameScene, batch: &Batch, seeds: &[PixelSeed]) {
        frame.isa.run(FromRays { batch, to: self });
        frame.isa.run(FromTables { table: &frame.material_table, seeds, to: self });
        frame.isa.run(Weighted(self));
        let some = |column: &Column<f32>| column[..self.surfaces.len].iter().any(|k| *k != 0.0);
        self.shines = self.specular.columns().into_iter().any(some);
    }

    /// Which random numbers ray `i` of `count` takes that is sent from every point, `depth` bounces
    /// behind the camera.
    pub(super) fn names(
        &self,
        settings: &Settings,
        depth: u32,
        purpose: Purpose,
        [i, count]: [u32; 2],
    ) -> SetNames<'_> {
        let split_before =
            settings.diffuse_reflection_samples.max(settings.diffuse_refraction_samples) > 1;
        SetNames {
            seed: &self.seed,
            path: &self.labels.path,
            index: &self.labels.index,
            depth,
            split: count > 1 || (depth > 0 && split_before),
            purpose: purpose.into(),
            place: [i, count],
            len: self.surfaces.len,
        }
    }
}

/// Fetches what goes with the rays.
struct FromRays<'a> {
    batch: &'a Batch,
    to: &'a mut Points,
}

impl Lanewise for FromRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { batch, to } = self;
        let len = to.surfaces.len;
        let [x, y, z] = batch.rays.direction.each_ref();
        fetch(x, &to.surfaces.ray, len, &mut to.direction.x);
        fetch(y, &to.surfaces.ray, len, &mut to.direction.y);
        fetch(z, &to.surfaces.ray, len, &mut to.direction.z);
        fetch(&batch.weight.x, &to.surfaces.ray, len, &mut to.weight.x);
        fetch(&batch.weight.y, &to.surfaces.ray, len, &mut to.weight.y);
        fetch(&batch.weight.z, &to.surfaces.ray, len, &mut to.weight.z);
        fetch(&batch.labels.time, &to.surfaces.ray, len, &mut to.labels.time);
        fetch(&batch.labels.slot, &to.surfaces.ray, len, &mut to.labels.slot);
        fetch(&batch.labels.path, &to.surfaces.ray, len, &mut to.labels.path);
        fetch(&batch.labels.index, &to.surfaces.ray, len, &mut to.labels.index);
    }
}

#[inline(always)]
fn fetch<T: Copy>(from: &[T], ray: &Column<u32>, len: usize, to: &mut Column<T>) {
    let Some(from) = from.first_chunk::<BATCH>() else { return };
    for i in lanes(len) {
        to[i] = from[(ray[i] as usize).min(BATCH - 1)];
    }
}

/// Fetches what goes with the pixels and the materials.
struct FromTables<'a> {
    table: &'a MaterialTable,
    seeds: &'a [PixelSeed],
    to: &'a mut Points,
}

impl Lanewise for FromTables<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { table, seeds, to } = self;
        let len = to.surfaces.len;
        look_up(seeds, &to.labels.slot, len, PixelSeed::word, &mut to.seed);
        let material = &to.surfaces.material;
        for (from, to) in [
            (&table.ambient, &mut to.ambient),
            (&table.diffuse, &mut to.diffuse),
            (&table.specular, &mut to.specular),
        ] {
            look_up(&from[0], material, len, |x| x, &mut to.x);
            look_up(&from[1], material, len, |x| x, &mut to.y);
            look_up(&from[2], material, len, |x| x, &mut to.z);
        }
        look_up(&table.shininess, material, len, |x| x, &mut to.shininess);
    }
}

/// Multiplies materials with weights and tints.
struct Weighted<'a>(&'a mut Points);

impl Lanewise for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let points = self.0;
        for i in lanes(points.surfaces.len) {
            let weight = points.weight.get(i);
            let tint = points.surfaces.tint.get(i);
            points.ambient.set(i, weight * points.ambient.get(i) * tint);
            points.diffuse.set(i, points.diffuse.get(i) * tint * weight);
            points.specular.set(i, points.specular.get(i) * weight);
        }
    }
}
