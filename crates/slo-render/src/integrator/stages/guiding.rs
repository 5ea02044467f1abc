//! Where the field guides the rays of the points, and how densely.

use slo_accel::Lanewise;
use slo_accel::math::columns::{BATCH, Column, Vec3s, lanes};

use super::points::Points;
use crate::guiding::{Field, Guide, NOWHERE, direction, pack};
use crate::integrator::work::Job;

/// What the field knows of the points of a batch.
#[derive(Debug)]
pub(in crate::integrator) struct Guiding {
    /// [Words](Guide::word) of the guides.
    guide: Column<u32>,
    /// Chance that a ray takes its direction from the field: of lobes that are not diffuse, and of those
    /// that are. 0 without a field.
    share: [Column<f32>; 2],
    /// Whether any share may be other than 0.
    is_on: bool,
}

impl Default for Guiding {
    fn default() -> Self {
        Self { guide: [NOWHERE; BATCH], share: [[0.0; BATCH]; 2], is_on: false }
    }
}

/// Densities of the field in some directions, per solid angle. They mean nothing without a field.
#[derive(Debug)]
pub(in crate::integrator) struct Densities {
    packed: Column<u32>,
    pub(super) of: Column<f32>,
}

impl Default for Densities {
    fn default() -> Self {
        Self { packed: [0; BATCH], of: [0.0; BATCH] }
    }
}

impl Densities {
    /// Returns packed direction `k`.
    pub(super) fn packed(&self, k: usize) -> u32 {
        self.packed[k]
    }
}

/// Returns the density of a lobe and the field together, of which the field has a share.
#[inline(always)]
pub(super) fn mixed(own: f32, field: f32, share: f32) -> f32 {
    own + share * (field - own)
}

impl Guiding {
    /// Finds the guides of all points.
    pub(in crate::integrator) fn find(&mut self, job: &Job<'_>, points: &Points) {
        let Some(field) = job.guide else {
            if self.is_on {
                *self = Self::default();
            }
            return;
        };
        self.is_on = true;
        for i in 0..points.len() {
            let guide: Guide = field.guide(points.surfaces.point.get(i));
            self.guide[i] = guide.word();
            self.share[0][i] = guide.share(false);
            self.share[1][i] = guide.share(true);
        }
    }

    /// Chances that rays take their directions from the field, of lobes of a class.
    #[inline(always)]
    pub(super) fn share(&self, is_diffuse: bool) -> &Column<f32> {
        &self.share[usize::from(is_diffuse)]
    }

    /// Finds how densely the field samples directions: direction `k` of `len` at point `point(k)`.
    pub(super) fn densities(
        &self,
        job: &Job<'_>,
        toward: &Vec3s,
        len: usize,
        point: impl Fn(usize) -> usize,
        to: &mut Densities,
    ) {
        if !job.is_guided() {
            return;
        }
        job.frame.isa.run(Pack { toward, len, to: &mut to.packed });
        let Some(field) = job.guide else { return };
        for k in 0..len {
            to.of[k] = field.density(self.guide[point(k)], to.packed[k]);
        }
    }

    /// Samples the field at the points with a mark, by two numbers of each.
    pub(super) fn sample(
        &self,
        field: &Field,
        job: &Job<'_>,
        len: usize,
        (marked, numbers): (&Column<u32>, [&Column<f32>; 2]),
        (square, toward): (&mut [Column<f32>; 2], &mut Vec3s),
    ) {
        let [u, v] = numbers;
        let [height, angle] = square;
        for i in 0..len {
            if marked[i] != 0 {
                [height[i], angle[i]] = field.sample(self.guide[i], [u[i], v[i]]);
            }
        }
        job.frame.isa.run(Unpack { marked, square: [height, angle], len, toward });
    }
}

struct Pack<'a> {
    toward: &'a Vec3s,
    len: usize,
    to: &'a mut Column<u32>,
}

impl Lanewise for Pack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for k in lanes(self.len) {
            self.to[k] = pack(self.toward.get(k));
        }
    }
}

struct Unpack<'a> {
    marked: &'a Column<u32>,
    square: [&'a Column<f32>; 2],
    len: usize,
    toward: &'a mut Vec3s,
}

impl Lanewise for Unpack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [height, angle] = self.square;
        for i in lanes(self.len) {
            let sampled = direction([height[i], angle[i]]);
            let old = self.toward.get(i);
            self.toward.set(i, if self.marked[i] != 0 { sampled } else { old });
        }
    }
}
