//! Rays that go on behind what they hit, unbent: through surfaces that are partly transparent, and
//! through lamps that the camera does not see.

use glam::Vec3;
use slo_accel::math::columns::BATCH;

use super::hits::Hits;
use super::points::Points;
use crate::frame::{FrameScene, Look};
use crate::integrator::batch::{Batch, Labels, Past, Sent, marks};
use crate::integrator::chosen::Chosen;
use crate::integrator::machine::Machine;
use crate::sampling::{Purpose, Use, next_path};

/// Share of the distance by which a ray goes on behind a lamp that it does not see. A ray that hits
/// the same lamp again passes again.
const BEHIND: f32 = 1e-5;

/// Rays that go on.
#[derive(Debug, Default)]
pub(in crate::integrator) struct Passing {
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    pub(in crate::integrator) past: Past,
    pub(in crate::integrator) chosen: Chosen,
    len: usize,
}

impl Passing {
    /// Finds the rays of a batch, after `depth` bounces, that go on behind a lamp.
    pub(in crate::integrator) fn lamps(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        hits: &Hits,
        depth: u32,
    ) {
        self.len = 0;
        for i in hits.shaded.others(batch.len()) {
            if let Look::Light(light) = Look::of_word(hits.looks[i])
                && (frame.is_passable(light) || (depth == 0 && frame.is_hidden(light)))
            {
                let t = hits.found.hits.t[i] * (1.0 + BEHIND);
                let from = batch.rays.origin(i) + batch.rays.direction(i) * t;
                self.push(batch, i, from, batch.weight.get(i));
            }
        }
        self.choose(frame);
    }

    /// Finds the rays of a batch that pass through the surface that they hit: those of points with
    /// a mark in `passes`. What is left for these points is nothing.
    pub(in crate::integrator) fn surfaces(
        &mut self,
        frame: &FrameScene,
        batch: &Batch,
        points: &mut Points,
    ) {
        self.len = 0;
        for i in 0..points.len() {
            if points.passes[i] != 0 {
                let ray = points.surfaces.ray[i] as usize;
                let from = points.surfaces.leave(i, points.direction.get(i));
                self.push(batch, ray, from, points.weight.get(i));
                points.weight.set(i, Vec3::ZERO);
            }
        }
        self.choose(frame);
    }

    /// Queues the rays as rays after `depth` bounces.
    pub(in crate::integrator) fn queue(&self, machine: &mut Machine, depth: u32) {
        machine.extend_path(depth, &self.sent, &self.labels, &self.past, &self.chosen);
    }

    fn push(&mut self, batch: &Batch, ray: usize, origin: Vec3, weight: Vec3) {
        if marks::passed(batch.past.marks[ray]) >= marks::MOST_PASSES || self.len >= BATCH {
            return;
        }
        let Self { sent, labels, past, len, .. } = self;
        let (i, from) = (*len, &batch.labels);
        sent.origin.set(i, origin);
        sent.direction.set(i, batch.rays.direction(ray));
        sent.t_max[i] = f32::INFINITY;
        sent.weight.set(i, weight);
        sent.density[i] = batch.density[ray];
        labels.time[i] = from.time[ray];
        labels.slot[i] = from.slot[ray];
        labels.path[i] = next_path(from.path[ray], Use::from(Purpose::Surface));
        labels.index[i] = from.index[ray];
        past.from.set(i, batch.past.from.get(ray));
        past.normal[i] = batch.past.normal[ray];
        past.marks[i] = batch.past.marks[ray] + marks::PASS;
        past.rough.is_kept = batch.past.rough.is_kept;
        if past.rough.is_kept {
            let (rough, before) = (&mut past.rough, &batch.past.rough);
            let way = (origin - batch.rays.origin(ray)).length();
            rough.rival[i] = before.rival[ray];
            rough.width[i] = before.width[ray] + before.spread[ray] * way;
            rough.spread[i] = before.spread[ray];
        }
        *len += 1;
    }

    fn choose(&mut self, frame: &FrameScene) {
        let (sent, len) = (&self.sent, self.len);
        self.chosen.set(frame.isa, len, |i| sent.is_ray(i));
    }
}
