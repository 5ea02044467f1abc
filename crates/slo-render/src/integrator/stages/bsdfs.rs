//! The lobes of a batch of hits.

use glam::Vec3;
use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes, look_up, look_up_each};
use slo_accel::math::elementary::exp2;

use super::features::Own;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::Batch;
use crate::shading::bsdf::{At, Bsdf, Lobe, WithLobe, WithLobeMut, principled};
use crate::shading::light::receiver;
use crate::shading::material::Kind;
use crate::shading::material::principled::Parameters;
use crate::shading::{MaterialTable, lobe};

/// The lobes of a batch of hits, and the numbers that they follow from.
#[derive(Debug)]
pub(in crate::integrator) struct Bsdfs {
    pub(super) bsdf: Bsdf,
    pub(super) parameters: Box<Parameters>,
    /// 1 for hits on physical materials, 0 for others.
    is_principled: Column<u32>,
    /// Index of refraction on the incident side divided by the index on the other side, of Phong
    /// materials.
    eta: Column<f32>,
    /// Share of emitted light that the layers above let through to the eye.
    emitted: Vec3s,
    total: Column<f32>,
    /// Estimates of the albedos of all lobes that are not perfect.
    own: Vec3s,
    /// Estimates of the shares of light of perfect lobes.
    perfect: Column<f32>,
}

/// Lobes of physical materials as they look from elsewhere.
#[derive(Debug)]
pub(super) struct LookBack {
    pub(super) bsdf: Bsdf,
    from_outside: Column<u32>,
    emitted: Vec3s,
}

impl Default for LookBack {
    fn default() -> Self {
        Self { bsdf: Bsdf::default(), from_outside: [0; BATCH], emitted: Vec3s::default() }
    }
}

impl Default for Bsdfs {
    fn default() -> Self {
        Self {
            bsdf: Bsdf::default(),
            parameters: Box::default(),
            is_principled: [0; BATCH],
            eta: [0.0; BATCH],
            emitted: Vec3s::default(),
            own: Vec3s::default(),
            perfect: [0.0; BATCH],
            total: [0.0; BATCH],
        }
    }
}

impl Bsdfs {
    /// Looks up the numbers of the materials of all points.
    pub(in crate::integrator) fn look_up(&mut self, frame: &FrameScene, points: &mut Points) {
        let table = &frame.material_table;
        let len = points.len();
        let is_principled = |kind| u32::from(kind == Kind::Principled);
        look_up(
            &table.kinds,
            &points.surfaces.material,
            len,
            is_principled,
            &mut self.is_principled,
        );
        if table.is_physical() {
            let multiplied = frame.multiplies();
            frame.isa.run(LookUp { table, points, multiplied, to: &mut self.parameters });
            frame.multiply_images(&points.surfaces, &mut self.parameters);
            let Self { is_principled, parameters, .. } = self;
            let is_opaque =
                |i: usize| (is_principled[i] == 1) & (parameters.transmission[i] <= 0.0);
            frame.soften(&points.direction, is_opaque, &mut points.surfaces);
            frame.bend_normals(&self.parameters, &mut points.surfaces);
        }
    }

    /// Finds how points look by themselves, without perfect lobes.
    pub(in crate::integrator) fn find_own(&mut self, frame: &FrameScene, points: &Points) {
        let Self { bsdf, own, perfect, .. } = self;
        *own = Vec3s::default();
        *perfect = [0.0; BATCH];
        bsdf.for_each(&mut AddOwn { frame, points, own, perfect });
    }

    /// Returns how point `i` looks by itself.
    pub(in crate::integrator) fn own(&self, i: usize) -> Own {
        let albedo = self.own.get(i).clamp(Vec3::ZERO, Vec3::ONE);
        Own { albedo, share: (1.0 - self.perfect[i]).max(0.0) }
    }

    /// Finds the points that have a rough lobe which rays follow: 1, or 0.
    pub(in crate::integrator) fn find_rough(
        &self,
        frame: &FrameScene,
        points: &Points,
        is_rough: &mut Column<u32>,
    ) {
        *is_rough = [0; BATCH];
        self.bsdf.for_each(&mut FindRough { frame, points, is_rough });
    }

    /// Finds the points that have a diffuse lobe: 1, or 0.
    pub(in crate::integrator) fn find_diffuse(
        &self,
        frame: &FrameScene,
        points: &Points,
        is_diffuse: &mut Column<u32>,
    ) {
        *is_diffuse = [0; BATCH];
        self.bsdf.for_each(&mut FindDiffuse { frame, points, is_diffuse });
    }

    /// Keeps rays from following the diffuse lobes of marked points.
    pub(in crate::integrator) fn close_diffuse(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        is_closed: &Column<u32>,
    ) {
        let (len, total) = (points.len(), &mut self.total);
        *total = [0.0; BATCH];
        self.bsdf.for_each(&mut AddUp { frame, len, diffuse: false, total });
        self.bsdf.for_each_mut(&mut Close { len, is_closed, total });
    }

    /// Lets light from all directions count at points that light passes through.
    pub(in crate::integrator) fn open_receivers(&self, points: &mut Points) {
        let Bsdf { glass, refraction, .. } = &self.bsdf;
        if !glass.share().is_present && !refraction.share().is_present {
            return;
        }
        for i in 0..points.len() {
            let is_glass = self.is_principled[i] == 1 && self.parameters.transmission[i] > 0.0;
            let refracts = self.bsdf.refraction.share().is_present
                && self.bsdf.refraction.share().chance[i] > 0.0;
            if is_glass || refracts {
                points.receiver[i] = receiver::ANY;
            }
        }
    }

    /// Decides which points the rays pass through.
    pub(in crate::integrator) fn let_pass(&self, points: &mut Points) {
        for i in 0..points.len() {
            let alpha = self.parameters.alpha[i];
            let passes = self.is_principled[i] == 1 && points.surface[i] >= alpha;
            points.passes[i] = u32::from(passes);
        }
    }

    /// Returns the radiance that point `i` emits.
    pub(super) fn emitted(&self, i: usize) -> Vec3 {
        let emitted = self.parameters.emission.get(i) * self.emitted.get(i);
        if self.is_principled[i] == 1 { emitted } else { Vec3::ZERO }
    }

    /// Weakens the light that comes to points from inside of their objects, by Beer's law.
    pub(in crate::integrator) fn absorb(&self, batch: &Batch, points: &mut Points) {
        for i in 0..points.len() {
            let absorption = self.parameters.absorption.get(i);
            let is_inside = (self.is_principled[i] == 1)
                & (points.surfaces.from_outside[i] == 0)
                & (self.parameters.transmission[i] > 0.0);
            if is_inside && absorption != Vec3::ZERO {
                let origin = batch.rays.origin(points.surfaces.ray[i] as usize);
                let way =
                    (points.surfaces.point.get(i) - origin).length() * std::f32::consts::LOG2_E;
                let left = Vec3::from((absorption * -way).to_array().map(exp2));
                points.weight.set(i, points.weight.get(i) * left);
            }
        }
    }

    /// Sets up the lobes of physical materials as they look from where `way` leads to, in `to`. Returns
    /// false, and does nothing, if all lobes that are sharp look alike from everywhere.
    pub(super) fn look_back(
        &self,
        frame: &FrameScene,
        points: &Points,
        way: &Vec3s,
        to: &mut LookBack,
    ) -> bool {
        let p = &self.parameters;
        let depends = |i: usize| {
            self.is_principled[i] == 1
                && (p.roughness[i] > 0.0 || p.coat[i] > 0.0 || p.sheen[i] > 0.0)
        };
        if !(0..points.len()).any(depends) {
            return false;
        }
        sides(points, way, &mut to.from_outside);
        to.bsdf.clear();
        let at = |i: usize| {
            let (at, eye) = (points.at(i), way.get(i));
            let side = if at.n_geo.dot(eye) < 0.0 { -1.0 } else { 1.0 };
            At { eye, n: at.n * side, n_geo: at.n_geo * side, floor: at.floor * side, ..at }
        };
        let is_mine = |i: usize| self.is_principled[i] == 1;
        let LookBack { bsdf, from_outside, emitted } = to;
        principled(p, at, from_outside, is_mine, points.len(), frame.isa, bsdf, emitted);
        true
    }

    /// Sets up the lobes of all points, and the chance with which a ray follows each.
    /// `diffuse` says whether rays follow diffuse lobes.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        diffuse: bool,
    ) {
        self.bsdf.clear();
        let (table, len) = (&frame.material_table, points.len());
        let physical = self.is_principled[..len].iter().filter(|is| **is == 1).count();
        if physical < len {
            frame.isa.run(Phong { table, points, to: self });
        }
        let Self { bsdf, parameters, is_principled, emitted, .. } = self;
        if physical > 0 {
            let (at, from_outside) = (|i| points.at(i), &points.surfaces.from_outside);
            let is_mine = |i: usize| is_principled[i] == 1;
            principled(parameters, at, from_outside, is_mine, len, frame.isa, bsdf, emitted);
        }
        // The chances of all lobes that rays follow sum to 1.
        self.total = [0.0; BATCH];
        let Self { bsdf, total, .. } = self;
        bsdf.for_each(&mut AddUp { frame, len, diffuse, total });
        bsdf.for_each_mut(&mut Divide { frame, len, diffuse, total });
    }
}

struct LookUp<'a> {
    table: &'a MaterialTable,
    points: &'a Points,
    /// Whether the numbers are multiplied afterwards.
    multiplied: bool,
    to: &'a mut Parameters,
}

impl Lanewise for LookUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { table, points, multiplied, to } = self;
        let surfaces = &points.surfaces;
        table.principled.look_up(&surfaces.material, surfaces.len, multiplied, to);
    }
}

/// Sets the lobes of Phong materials.
struct Phong<'a> {
    table: &'a MaterialTable,
    points: &'a Points,
    to: &'a mut Bsdfs,
}

impl Lanewise for Phong<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        phong(self.table, self.points, self.to);
    }
}

#[inline(always)]
fn phong(table: &MaterialTable, points: &Points, to: &mut Bsdfs) {
    let surfaces = &points.surfaces;
    let (len, material) = (surfaces.len, &surfaces.material);
    let Bsdfs { bsdf, eta, .. } = to;
    let Bsdf { diffuse, highlight, reflection, refraction, .. } = bsdf;
    let diffuse = &mut diffuse.0;
    let [dx, dy, dz] = [&table.diffuse[0][..], &table.diffuse[1], &table.diffuse[2]];
    let [sx, sy, sz] = [&table.specular[0][..], &table.specular[1], &table.specular[2]];
    let specular = &mut highlight.share_mut().weight;
    look_up_each(
        [dx, dy, dz, sx, sy, sz],
        material,
        len,
        [
            &mut diffuse.weight.x,
            &mut diffuse.weight.y,
            &mut diffuse.weight.z,
            &mut specular.x,
            &mut specular.y,
            &mut specular.z,
        ],
    );
    look_up(&table.shininess, material, len, |x| x, &mut highlight.shininess);
    look_up(&table.reflectance, material, len, |x| x, &mut reflection.share_mut().chance);
    look_up(&table.reflection_lobe, material, len, |x| x, &mut reflection.inverse);
    look_up(&table.refraction, material, len, |x| x, &mut refraction.share_mut().chance);
    look_up(&table.refraction_lobe, material, len, |x| x, &mut refraction.inverse);
    look_up(&table.refraction_index, material, len, |x| x, eta);
    let mut present = [0.0f32; 4];
    for i in lanes(len) {
        let albedo = diffuse.weight.get(i) * surfaces.tint.get(i);
        diffuse.weight.set(i, albedo);
        diffuse.chance[i] = albedo.max_element();
        let eta = if surfaces.from_outside[i] == 1 { 1.0 / eta[i] } else { eta[i] };
        let direction = points.direction.get(i);
        let (n_shade, n_geo) = (surfaces.n_shade.get(i), surfaces.n_geo.get(i));
        let n = if n_shade.dot(direction) < 0.0 { n_shade } else { n_geo };
        let (axis, passes) = lobe::refract(direction, n, eta);
        let passed = refraction.share().chance[i];
        let (refracted, mirrored) = if passes { (passed, 0.0) } else { (0.0, passed) };
        let reflected = reflection.share().chance[i] + mirrored;
        refraction.axis.set(i, axis);
        refraction.side.set(i, -n_geo);
        refraction.eta[i] = eta;
        refraction.share_mut().weight.set(i, Vec3::splat(refracted));
        refraction.share_mut().chance[i] = refracted;
        reflection.axis.set(i, lobe::reflect(direction, n_shade));
        reflection.side.set(i, n_geo);
        reflection.share_mut().weight.set(i, Vec3::splat(reflected));
        reflection.share_mut().chance[i] = reflected;
        let shines = highlight.share().weight.get(i).max_element();
        let values = [albedo.max_element(), shines, reflected, refracted];
        for (present, value) in present.iter_mut().zip(values) {
            *present = present.max(if i < len { value } else { 0.0 });
        }
    }
    diffuse.is_present = present[0] > 0.0;
    highlight.share_mut().is_present = present[1] > 0.0;
    highlight.share_mut().chance = [0.0; BATCH];
    reflection.share_mut().is_present = present[2] > 0.0;
    refraction.share_mut().is_present = present[3] > 0.0;
}

/// Adds up the estimated albedos of lobes that rays follow.
struct AddUp<'a> {
    frame: &'a FrameScene,
    len: usize,
    /// Whether rays follow diffuse lobes.
    diffuse: bool,
    total: &'a mut Column<f32>,
}

impl WithLobe for AddUp<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED && (self.diffuse || !L::IS_DIFFUSE) {
            let chance = &lobe.share().chance;
            self.frame.isa.run(Sum { chance, len: self.len, total: self.total });
        }
    }
}

struct Sum<'a> {
    chance: &'a Column<f32>,
    len: usize,
    total: &'a mut Column<f32>,
}

impl Lanewise for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for i in lanes(self.len) {
            self.total[i] += self.chance[i];
        }
    }
}

/// Adds up the albedos of lobes, each estimated by the sample in the middle of the lobe.
struct AddOwn<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    own: &'a mut Vec3s,
    perfect: &'a mut Column<f32>,
}

impl WithLobe for AddOwn<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        let Self { frame, points, own, perfect } = self;
        frame.isa.run(AddOwnOf { lobe, points, own, perfect });
    }
}

struct AddOwnOf<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    own: &'a mut Vec3s,
    perfect: &'a mut Column<f32>,
}

impl<L: Lobe> Lanewise for AddOwnOf<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, own, perfect } = self;
        for i in lanes(points.surfaces.len) {
            let sampled = lobe.sample(i, &points.at(i), [0.5; 3]);
            let is_perfect = sampled.density == 0.0;
            let albedo = if is_perfect { Vec3::ZERO } else { sampled.weight };
            own.set(i, own.get(i) + albedo);
            perfect[i] += if is_perfect { sampled.weight.max_element() } else { 0.0 };
        }
    }
}

/// Finds the points with rough lobes that rays follow.
struct FindRough<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    is_rough: &'a mut Column<u32>,
}

impl WithLobe for FindRough<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_FOLLOWED {
            let Self { frame, points, is_rough } = self;
            frame.isa.run(FindRoughOf { lobe, points, is_rough });
        }
    }
}

struct FindRoughOf<'a, L> {
    lobe: &'a L,
    points: &'a Points,
    is_rough: &'a mut Column<u32>,
}

impl<L: Lobe> Lanewise for FindRoughOf<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lobe, points, is_rough } = self;
        for i in lanes(points.surfaces.len) {
            let is_there = lobe.share().weight.get(i) != Vec3::ZERO;
            is_rough[i] |= u32::from(is_there & !lobe.is_sharp(i));
        }
    }
}

/// The sides of surfaces that `way` leads to: 1 for the outside, 0 for the inside.
fn sides(points: &Points, way: &Vec3s, to: &mut Column<u32>) {
    for (i, to) in to.iter_mut().enumerate().take(points.len()) {
        let passes = points.surfaces.n_geo.get(i).dot(way.get(i)) < 0.0;
        *to = points.surfaces.from_outside[i] ^ u32::from(passes);
    }
}

/// Finds the points with diffuse lobes.
struct FindDiffuse<'a> {
    frame: &'a FrameScene,
    points: &'a Points,
    is_diffuse: &'a mut Column<u32>,
}

impl WithLobe for FindDiffuse<'_> {
    fn run<L: Lobe>(&mut self, lobe: &L) {
        if L::IS_DIFFUSE {
            let Self { frame, points, is_diffuse } = self;
            frame.isa.run(FindRoughOf { lobe, points, is_rough: is_diffuse });
        }
    }
}

/// Takes the chances of diffuse lobes at marked points, and gives them to the others.
struct Close<'a> {
    len: usize,
    is_closed: &'a Column<u32>,
    /// Sum of the chances of the others.
    total: &'a Column<f32>,
}

impl WithLobeMut for Close<'_> {
    fn run<L: Lobe>(&mut self, lobe: &mut L) {
        let chance = &mut lobe.share_mut().chance;
        for i in lanes(self.len) {
            let others = if L::IS_DIFFUSE { 0.0 } else { chance[i] / self.total[i] };
            let others = if self.total[i] > 0.0 { others } else { 0.0 };
            chance[i] = if self.is_closed[i] == 1 { others } else { chance[i] };
        }
    }
}

/// Turns estimated albedos into chances.
struct Divide<'a> {
    frame: &'a FrameScene,
    len: usize,
    diffuse: bool,
    total: &'a Column<f32>,
}

impl WithLobeMut for Divide<'_> {
    fn run<L: Lobe>(&mut self, lobe: &mut L) {
        let follows = L::IS_FOLLOWED && (self.diffuse || !L::IS_DIFFUSE);
        let chance = &mut lobe.share_mut().chance;
        self.frame.isa.run(Quotient { chance, len: self.len, follows, total: self.total });
    }
}

struct Quotient<'a> {
    chance: &'a mut Column<f32>,
    len: usize,
    follows: bool,
    total: &'a Column<f32>,
}

impl Lanewise for Quotient<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chance, len, follows, total } = self;
        for i in lanes(len) {
            let share = chance[i] / total[i];
            chance[i] = if follows && total[i] > 0.0 { share } else { 0.0 };
        }
    }
}
