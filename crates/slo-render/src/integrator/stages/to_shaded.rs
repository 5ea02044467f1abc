//! Rays to lights that are shaded where the rays arrive: surfaces that emit light unevenly, toward
//! some directions more than others, or only in part.
//!
//! They are rays of paths, one bounce later, that bring nothing but the emitted light of the light
//! that they ask. So this light is the same that other rays find when they hit the surface, with its
//! images, layers and alpha.

use glam::Vec3;

use super::lamp_light::LampLight;
use super::points::Points;
use crate::frame::FrameScene;
use crate::integrator::batch::{Labels, Past, Sent, marks};
use crate::integrator::chosen::Chosen;
use crate::sampling::{Purpose, Use, next_path};

/// Rays to such lights, one from every point that asks one.
#[derive(Debug, Default)]
pub(in crate::integrator) struct ToShaded {
    pub(in crate::integrator) sent: Sent,
    pub(in crate::integrator) labels: Labels,
    pub(in crate::integrator) past: Past,
    pub(in crate::integrator) chosen: Chosen,
}

impl ToShaded {
    /// Takes the rays to such lights. If surface features are collected, `first_behind` is the first
    /// slot of light through rough lobes.
    pub(in crate::integrator) fn find(
        &mut self,
        frame: &FrameScene,
        points: &Points,
        asked: &LampLight,
        first_behind: Option<u32>,
    ) {
        let Self { sent, labels, past, chosen } = self;
        let (first, count) = (frame.first_shaded, frame.lights.len() as u32);
        let is_sent = |i: usize| {
            let light = asked.light[i];
            (light >= first) & (light < count) & (asked.sent.weight.get(i) != Vec3::ZERO)
        };
        chosen.set(frame.isa, points.len(), is_sent);
        if chosen.len() == 0 {
            return;
        }
        past.rough.is_kept = points.rough.is_kept;
        for i in (0..points.len()).filter(|i| is_sent(*i)) {
            sent.origin.set(i, asked.sent.origin.get(i));
            sent.direction.set(i, asked.toward.get(i));
            sent.t_max[i] = f32::INFINITY;
            sent.weight.set(i, asked.sent.weight.get(i));
            sent.density[i] = 0.0;
            past.from.set(i, points.surfaces.start.get(i));
            past.normal[i] = points.receiver[i];
            past.marks[i] = marks::asking(asked.light[i] - first);
            for column in past.rough.columns_mut() {
                column[i] = 0.0;
            }
            labels.time[i] = points.labels.time[i];
            labels.slot[i] = points.labels.slot[i];
            labels.path[i] = next_path(points.labels.path[i], Use::from(Purpose::AnyLight));
            labels.index[i] = points.labels.index[i];
            if let Some(behind) = first_behind
                && labels.slot[i] < behind
            {
                labels.slot[i] += behind;
            }
        }
    }
}
