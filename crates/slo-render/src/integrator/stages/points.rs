//! The shaded hits of one batch, with everything that shading needs.

use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, look_up, look_up_each};
use slo_scene::Settings;

use super::hits::Hits;
use crate::frame::{FrameScene, SurfaceScratch, Surfaces};
use crate::integrator::batch::{Batch, Labels, RoughStart};
use crate::integrator::chosen::Chosen;
use crate::sampling::batch::{SetNames, SetPoints};
use crate::sampling::{PixelSeed, Purpose, Sampler};
use crate::shading::MaterialTable;
use crate::shading::bsdf::At;
use crate::shading::light::receiver;

/// Shaded hits in columns: `surfaces.len` of them.
#[derive(Debug)]
pub(in crate::integrator) struct Points {
    pub(super) surfaces: Surfaces,
    /// Unit directions of travel of the rays that hit the points.
    pub(super) direction: Vec3s,
    /// Weight of the radiance that leaves toward the ray's origin.
    pub(super) weight: Vec3s,
    pub(in crate::integrator) labels: Labels,
    /// k_a of the material, tinted and weighted: light from the ambient term.
    pub(in crate::integrator) ambient: Vec3s,
    /// Seeds of the pixels, as words.
    pub(super) seed: Column<u32>,
    /// k_d of the material, tinted and weighted.
    pub(super) diffuse: Vec3s,
    /// k_s of the material, weighted.
    pub(super) specular: Vec3s,
    pub(super) shininess: Column<f32>,
    /// Whether any point has a highlight.
    pub(super) shines: bool,
    /// Packed normals; see [`receiver`].
    pub(super) receiver: Column<u32>,
    /// What the paths remember, with the widths of the footprints at the points.
    pub(super) rough: RoughStart,
    /// Number of light paths of the point's map, times the area in which it finds photons; 0 where
    /// photons add nothing.
    pub(super) caught: Column<f32>,
    /// The instances that were hit, for frames with photons.
    pub(super) instance: Column<u32>,
    /// 1 for points that the ray passes through, whose weight is 0; otherwise 0.
    pub(super) passes: Column<u32>,
    /// A random number for the choice among mixed materials, and then for the choice of passing
    /// through.
    pub(super) surface: Column<f32>,
    set: SetPoints,
    scratch: SurfaceScratch,
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
            receiver: [receiver::ANY; BATCH],
            rough: RoughStart::default(),
            caught: [0.0; BATCH],
            instance: [0; BATCH],
            passes: [0; BATCH],
            surface: [0.0; BATCH],
            set: SetPoints::default(),
            scratch: SurfaceScratch::default(),
        }
    }
}

impl Points {
    /// Number of points.
    pub(in crate::integrator) fn len(&self) -> usize {
        self.surfaces.len
    }

    /// Computes everything about the shaded hits of a batch. `seeds` are the seeds of the slots.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        seeds: &[PixelSeed],
    ) {
        let (chosen, len) = (&hits.shaded, hits.shaded.len());
        self.surfaces.len = len;
        chosen.copy(&NUMBERS, &mut self.surfaces.ray[..len]);
        chosen.copy(&hits.looks, &mut self.surfaces.material[..len]);
        let (rays, time) = (&batch.rays, &batch.labels.time);
        frame.find_surfaces(rays, time, &hits.found, &mut self.surfaces, &mut self.scratch);
        self.take(batch, chosen);
        frame.isa.run(Seeds { seeds, to: self });
    }

    /// Finds the footprints of pixels on the points, for frames with photons.
    pub(in crate::integrator) fn find_footprints(&mut self, batch: &Batch, hits: &Hits) {
        let (chosen, len) = (&hits.shaded, self.len());
        self.rough.is_kept = batch.past.rough.is_kept;
        for (from, to) in batch.past.rough.columns().into_iter().zip(self.rough.columns_mut()) {
            chosen.copy(from, &mut to[..len]);
        }
        for i in 0..len {
            let ray = self.surfaces.ray[i] as usize;
            self.instance[i] = hits.found.instance[ray];
            let origin = batch.rays.origin(ray);
            let distance = (self.surfaces.point.get(i) - origin).length();
            self.rough.width[i] += self.rough.spread[i] * distance;
        }
    }

    /// Chooses a material at points where several are mixed, by random numbers of `sampler`.
    pub(in crate::integrator) fn choose_materials(
        &mut self,
        frame: &FrameScene,
        sampler: &Sampler,
        depth: u32,
    ) {
        let (table, len) = (&frame.material_table, self.len());
        self.passes[..len].fill(0);
        if !table.has_mixes && !table.images.any_passes() {
            return;
        }
        let mut set = std::mem::take(&mut self.set);
        let names = self.names(&frame.settings, depth, Purpose::Surface, [0, 1]);
        set.take::<2>(sampler, frame.isa, &names);
        self.surface = set.numbers[0];
        self.set = set;
        if table.has_mixes {
            frame.choose_materials(&mut self.surface, &mut self.surfaces);
        }
    }

    /// Packs the normals, if lights are chosen by them.
    pub(in crate::integrator) fn find_receivers(&mut self, frame: &FrameScene) {
        if frame.light_tree.len() > 1 {
            if frame.is_physical {
                frame.isa.run(Receivers::<true>(self));
            } else {
                frame.isa.run(Receivers::<false>(self));
            }
        }
    }

    /// Looks up the numbers of Phong materials.
    pub(in crate::integrator) fn look_up_phong(&mut self, frame: &FrameScene) {
        let len = self.len();
        frame.isa.run(FromTables { table: &frame.material_table, to: self });
        frame.isa.run(Weighted(self));
        let some = |column: &Column<f32>| column[..len].iter().any(|k| *k != 0.0);
        self.shines = frame.material_table.shines && self.specular.columns().into_iter().any(some);
    }

    /// Fetches the columns that belong to the rays.
    fn take(&mut self, batch: &Batch, chosen: &Chosen) {
        let len = chosen.len();
        let Self { direction, weight, labels, .. } = self;
        let [x, y, z] = batch.rays.direction.each_ref().map(|column| &column[..]);
        let Vec3s { x: weight_x, y: weight_y, z: weight_z } = &batch.weight;
        for (from, to) in [
            (x, &mut direction.x),
            (y, &mut direction.y),
            (z, &mut direction.z),
            (weight_x, &mut weight.x),
            (weight_y, &mut weight.y),
            (weight_z, &mut weight.z),
            (&batch.labels.time, &mut labels.time),
        ] {
            chosen.copy(from, &mut to[..len]);
        }
        for (from, to) in [
            (&batch.labels.slot, &mut labels.slot),
            (&batch.labels.path, &mut labels.path),
            (&batch.labels.index, &mut labels.index),
        ] {
            chosen.copy(from, &mut to[..len]);
        }
    }

    /// Returns the directions at point `i`.
    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> At {
        let Surfaces { n_shade, n_geo, floor, tangent, .. } = &self.surfaces;
        let Surfaces { is_bent, any_is_bent, .. } = &self.surfaces;
        At {
            eye: -self.direction.get(i),
            n: n_shade.get(i),
            n_geo: n_geo.get(i),
            floor: floor.get(i),
            is_bent: *any_is_bent & (is_bent[i] == 1),
            tangent: tangent.get(i),
        }
    }

    /// Returns the names of the random numbers of ray `i` of `count` from every point, after
    /// `depth` bounces.
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
            // Surfaces that a ray passes through one after the other must not decide alike, and the
            // numbers of the roulette must not depend on those of the direction.
            split: count > 1
                || (depth > 0 && split_before)
                || matches!(purpose, Purpose::Surface | Purpose::Survival),
            purpose: purpose.into(),
            place: [i, count],
            len: self.surfaces.len,
        }
    }
}

/// Indices of the rays of a batch.
static NUMBERS: Column<u32> = {
    let mut numbers = [0; BATCH];
    let mut i = 0;
    while i < BATCH {
        numbers[i] = i as u32;
        i += 1;
    }
    numbers
};

/// Fetches the seeds of pixels.
struct Seeds<'a> {
    seeds: &'a [PixelSeed],
    to: &'a mut Points,
}

impl Lanewise for Seeds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { seeds, to } = self;
        let len = to.surfaces.len;
        look_up(seeds, &to.labels.slot, len, PixelSeed::word, &mut to.seed);
    }
}

/// Packs the normals of the planes above which light arrives.
struct Receivers<'a, const IS_PHYSICAL: bool>(&'a mut Points);

impl<const IS_PHYSICAL: bool> Lanewise for Receivers<'_, IS_PHYSICAL> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let points = self.0;
        for i in lanes(points.surfaces.len) {
            let Surfaces { floor, n_geo, .. } = &points.surfaces;
            let normal = if IS_PHYSICAL { floor.get(i) } else { n_geo.get(i) };
            points.receiver[i] = receiver::pack(normal);
        }
    }
}

/// Fetches the numbers of materials.
struct FromTables<'a> {
    table: &'a MaterialTable,
    to: &'a mut Points,
}

impl<'a> Lanewise for FromTables<'a> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { table, to } = self;
        let len = to.surfaces.len;
        let Points { surfaces, ambient, diffuse, specular, shininess, .. } = to;
        let colors = |[x, y, z]: &'a [Vec<f32>; 3]| [&x[..], &y[..], &z[..]];
        let ([ax, ay, az], [dx, dy, dz]) = (colors(&table.ambient), colors(&table.diffuse));
        let [sx, sy, sz] = colors(&table.specular);
        look_up_each(
            [ax, ay, az, dx, dy, dz, sx, sy, sz, &table.shininess],
            &surfaces.material,
            len,
            [
                &mut ambient.x,
                &mut ambient.y,
                &mut ambient.z,
                &mut diffuse.x,
                &mut diffuse.y,
                &mut diffuse.z,
                &mut specular.x,
                &mut specular.y,
                &mut specular.z,
                shininess,
            ],
        );
    }
}

/// Multiplies the colours of materials by weights and tints.
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

#[cfg(test)]
mod tests {
    use slo_accel::Isa;
    use slo_scene::Generator;

    use super::*;
    use crate::sampling::Sampler;

    #[test]
    fn roulette_does_not_depend_on_the_direction_of_the_same_bounce() {
        let sampler = Sampler::new(Generator::Quasi, 1, 0);
        let mut points = Points::default();
        points.surfaces.len = 1008;
        points.seed = [sampler.pixel(3, 5).word(); BATCH];
        points.labels.index = NUMBERS;
        let settings = Settings::default();
        for depth in 0..4 {
            let numbers = |purpose| {
                let mut set = SetPoints::default();
                let names = points.names(&settings, depth, purpose, [0, 1]);
                set.take::<3>(&sampler, Isa::Portable, &names);
                set.numbers[0]
            };
            let [direction, survival] = [Purpose::Continuation, Purpose::Survival].map(numbers);
            let mut cells = [[0; 4]; 4];
            for (a, b) in direction.iter().zip(&survival).take(1000) {
                cells[(a * 4.0) as usize][(b * 4.0) as usize] += 1;
            }
            // 62 or 63 of independent numbers.
            assert!(cells.iter().flatten().all(|count| *count > 30), "{depth}: {cells:?}");
        }
    }
}
