//! Channels of animation: how translations, rotations, scales and weights change.

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use gltf::Document;
use gltf::animation::{Interpolation, Property};

use super::accessor::Buffers;
use crate::error::ImportError;
use crate::model::{Key, Notes, Pose};

/// Steps a second at which cubic splines are sampled, and shapes of bones and morph targets.
pub(super) const STEPS: f64 = 25.0;

/// Most steps of an animation.
const MOST_STEPS: f64 = 5000.0;

/// How long before a key a value that leaps still has its old value.
const LEAP: f64 = 1e-4;

/// What a channel changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum What {
    Translation,
    Rotation,
    Scale,
    Weights,
}

/// Values at rising times; as many numbers each.
#[derive(Debug)]
struct Channel {
    times: Vec<f64>,
    /// With a cubic spline: for each key its incoming tangent, its value, its outgoing tangent.
    values: Vec<f64>,
    width: usize,
    interpolation: Interpolation,
}

/// All channels that are applied.
#[derive(Debug, Default)]
pub(super) struct Animation {
    channels: HashMap<(usize, What), Channel>,
    /// The time of the last key.
    pub(super) duration: f64,
}

impl Animation {
    /// Reads the animations of a file: all, as far as they do not change the same things. The first key of
    /// each file is its time 0.
    pub(super) fn read(
        buffers: Buffers<'_>,
        document: &Document,
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let mut all = Self::default();
        for animation in document.animations() {
            let mut own = HashMap::new();
            for channel in animation.channels() {
                let (target, sampler) = (channel.target(), channel.sampler());
                let (what, width) = match target.property() {
                    Property::Translation => (What::Translation, 3),
                    Property::Rotation => (What::Rotation, 4),
                    Property::Scale => (What::Scale, 3),
                    Property::MorphTargetWeights => (What::Weights, 0),
                };
                let times = buffers.read::<1>(&sampler.input())?;
                let times: Vec<f64> = times.into_iter().map(|[time]| f64::from(time)).collect();
                let output = sampler.output();
                let values: Vec<f64> = match width {
                    3 => flat(buffers.read::<3>(&output)?),
                    4 => flat(buffers.read::<4>(&output)?),
                    _ => flat(buffers.read::<1>(&output)?),
                };
                let interpolation = sampler.interpolation();
                let rows =
                    if interpolation == Interpolation::CubicSpline { 3 } else { 1 } * times.len();
                let width = if width == 0 { values.len() / rows.max(1) } else { width };
                let is_rising = times.windows(2).all(|pair| pair[0] < pair[1]);
                let is_finite = times.iter().chain(&values).all(|value| value.is_finite());
                if times.is_empty() || values.len() != rows * width || !is_rising || !is_finite {
                    notes.leave_out("a damaged channel of an animation");
                    continue;
                }
                let channel = Channel { times, values, width, interpolation };
                own.insert((target.node().index(), what), channel);
            }
            if own.keys().any(|key| all.channels.contains_key(key)) {
                let name = animation.name().unwrap_or("without a name");
                notes.leave_out(format!("the animation `{name}`: another moves the same things"));
                continue;
            }
            all.channels.extend(own);
        }
        let ends = all.channels.values().filter_map(|channel| channel.times.last());
        all.duration = ends.fold(0.0_f64, |most, &end| most.max(end)).min(MOST_STEPS / STEPS);
        Ok(all)
    }

    /// The key frames of a node: one if it does not move.
    pub(super) fn keys(&self, node: usize, rest: Pose) -> Vec<Key> {
        let own = [What::Translation, What::Rotation, What::Scale]
            .map(|what| self.channels.get(&(node, what)));
        let mut times: Vec<f64> =
            own.iter().flatten().flat_map(|channel| channel.key_times()).collect();
        times.retain(|time| (0.0..=self.duration).contains(time));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|a, b| *a - *b < LEAP / 2.0);
        if times.is_empty() {
            times.push(0.0);
        }
        let pose = |time: f64| {
            let vector = |channel: &Option<&Channel>, rest: DVec3| {
                channel.map_or(rest, |channel| DVec3::from_slice(&channel.at(time)))
            };
            let turn = own[1].map(|channel| {
                let turn = DQuat::from_slice(&channel.at(time));
                if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY }
            });
            Pose {
                pivot: vector(&own[0], rest.pivot),
                turn: turn.unwrap_or(rest.turn),
                scale: vector(&own[2], rest.scale),
            }
        };
        let mut keys: Vec<Key> =
            times.into_iter().map(|time| Key { time, pose: pose(time) }).collect();
        thin(&mut keys);
        keys
    }

    /// The weights of a node's morph targets at a time, if they are animated.
    pub(super) fn weights(&self, node: usize, time: f64) -> Option<Vec<f64>> {
        self.channels.get(&(node, What::Weights)).map(|channel| channel.at(time))
    }

    /// Whether a node moves or its weights change.
    pub(super) fn changes(&self, node: usize) -> bool {
        let all = [What::Translation, What::Rotation, What::Scale, What::Weights];
        all.iter().any(|&what| self.channels.contains_key(&(node, what)))
    }
}

/// Leaves out key frames between two that are the same as it.
fn thin(keys: &mut Vec<Key>) {
    let same = |a: &Key, b: &Key| a.pose == b.pose;
    let mut kept: Vec<Key> = Vec::new();
    for (i, key) in keys.iter().enumerate() {
        let before = kept.last().is_some_and(|before| same(before, key));
        let after = keys.get(i + 1).is_none_or(|after| same(key, after));
        if !(before && after) {
            kept.push(*key);
        }
    }
    *keys = kept;
}

fn flat<const N: usize>(values: Vec<[f32; N]>) -> Vec<f64> {
    values.into_iter().flatten().map(f64::from).collect()
}

impl Channel {
    /// The times between which values change evenly.
    fn key_times(&self) -> Vec<f64> {
        match self.interpolation {
            Interpolation::Linear => self.times.clone(),
            Interpolation::Step => {
                let leaps = self.times.iter().skip(1).map(|time| time - LEAP);
                self.times.iter().copied().chain(leaps).collect()
            }
            Interpolation::CubicSpline => {
                let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
                let steps = ((last - first) * STEPS).min(MOST_STEPS) as usize;
                let between = (1..=steps).map(|step| first + step as f64 / STEPS);
                self.times.iter().copied().chain(between).collect()
            }
        }
    }

    /// The value at a time.
    fn at(&self, time: f64) -> Vec<f64> {
        let after = self.times.partition_point(|&key| key <= time);
        let (cubic, last) =
            (self.interpolation == Interpolation::CubicSpline, self.times.len() - 1);
        let row = |key: usize, part: usize| {
            let row = if cubic { 3 * key + part } else { key };
            &self.values[row * self.width..(row + 1) * self.width]
        };
        if after == 0 || after > last {
            return row(after.saturating_sub(1).min(last), 1).to_vec();
        }
        let (a, b) = (after - 1, after);
        let step = self.times[b] - self.times[a];
        let t = (time - self.times[a]) / step;
        match self.interpolation {
            Interpolation::Step => row(a, 1).to_vec(),
            Interpolation::Linear if self.width == 4 => {
                let (from, to) = (DQuat::from_slice(row(a, 1)), DQuat::from_slice(row(b, 1)));
                from.slerp(to, t).to_array().to_vec()
            }
            Interpolation::Linear => {
                row(a, 1).iter().zip(row(b, 1)).map(|(from, to)| from + (to - from) * t).collect()
            }
            Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                let shares =
                    [2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + t, 3.0 * t2 - 2.0 * t3, t3 - t2];
                let (from, out, to, into) = (row(a, 1), row(a, 2), row(b, 1), row(b, 0));
                (0..self.width)
                    .map(|i| {
                        shares[0] * from[i]
                            + step * (shares[1] * out[i] + shares[3] * into[i])
                            + shares[2] * to[i]
                    })
                    .collect()
            }
        }
    }
}
