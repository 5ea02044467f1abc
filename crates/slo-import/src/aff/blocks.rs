//! Blocks of key frames: how groups, lights and the camera move.

use glam::{DMat3, DQuat, DVec3};

use super::spline::{Knot, align, turn_at, vector_at};
use crate::error::ImportError;
use crate::model::{Key, Notes, Pose, View};
use crate::thin::thin;
use crate::words::Words;

/// Most keys of a channel.
const MOST_KEYS: usize = 1 << 20;

/// How long before a moment something still is what it was.
const LEAP: f64 = 1e-4;

/// The size of what is not there.
const NOTHING: f64 = 1e-6;

/// The channels of a block.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    places: Vec<Knot<DVec3>>,
    turns: Vec<Knot<DQuat>>,
    scales: Vec<Knot<DVec3>>,
    /// From when on something is there, or not.
    visible: Vec<(f64, bool)>,
}

/// When the frames are: their first time, and how many there are a second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) start: f64,
    pub(super) fps: f64,
    pub(super) frames: usize,
}

impl Range {
    /// The time of a frame, in the file.
    pub(super) fn time(&self, frame: usize) -> f64 {
        self.start + frame as f64 / self.fps
    }

    fn end(&self) -> f64 {
        self.time(self.frames - 1)
    }
}

impl Block {
    /// Reads a block behind its name.
    pub(super) fn read(words: &mut Words<'_>, notes: &mut Notes) -> Result<Self, ImportError> {
        words.word("{")?;
        let mut block = Self::default();
        loop {
            let channel = words.any("a channel or `}`")?;
            match channel {
                "}" => break,
                "transl" => block.places = knots(words, notes, |words, _| words.vector())?,
                "scale" => block.scales = knots(words, notes, |words, _| words.vector())?,
                "rot" => {
                    block.turns = knots(words, notes, turn)?;
                    align(&mut block.turns);
                }
                "visibility" => {
                    for _ in 0..words.count(0, MOST_KEYS)? {
                        block.visible.push((words.number()?, words.number()? != 0.0));
                    }
                    block.visible.sort_by(|a, b| a.0.total_cmp(&b.0));
                }
                _ => {
                    return words.bad(format!(
                        "`{channel}` is no channel: transl, rot, scale and visibility are"
                    ));
                }
            }
        }
        Ok(block)
    }

    /// The first and the last time of its keys.
    pub(super) fn times(&self) -> impl Iterator<Item = f64> + '_ {
        let vectors = self.places.iter().chain(&self.scales).map(|knot| knot.time);
        let turns = self.turns.iter().map(|knot| knot.time);
        vectors.chain(turns).chain(self.visible.iter().map(|row| row.0))
    }

    /// Its key frames for a light, which it only carries along.
    pub(super) fn keys_of_light(&self, range: &Range) -> Vec<Key> {
        Self { places: self.places.clone(), ..Self::default() }.keys(range)
    }

    fn place(&self, time: f64) -> DVec3 {
        if self.places.is_empty() { DVec3::ZERO } else { vector_at(&self.places, time) }
    }

    fn pose(&self, time: f64) -> Pose {
        let turn = if self.turns.is_empty() { DQuat::IDENTITY } else { turn_at(&self.turns, time) };
        let scale = if self.scales.is_empty() { DVec3::ONE } else { vector_at(&self.scales, time) };
        let scale = if self.is_visible(time) { scale } else { scale * NOTHING };
        Pose { pivot: self.place(time), turn, scale }
    }

    fn is_visible(&self, time: f64) -> bool {
        let after = self.visible.partition_point(|(from, _)| *from <= time);
        after.checked_sub(1).is_none_or(|row| self.visible[row].1)
    }

    /// Whether nothing of it is seen in any frame.
    pub(super) fn is_never_seen(&self, range: &Range) -> bool {
        let mut changes = self.visible.iter().map(|row| row.0);
        !self.is_visible(range.start)
            && !changes.any(|time| time <= range.end() && self.is_visible(time))
    }

    /// Whether it comes or goes.
    pub(super) fn comes_and_goes(&self, range: &Range) -> bool {
        let first = self.is_visible(range.start);
        self.visible.iter().any(|(time, _)| *time <= range.end() && self.is_visible(*time) != first)
    }

    /// Its key frames, at times from 0 on.
    pub(super) fn keys(&self, range: &Range) -> Vec<Key> {
        let mut times: Vec<f64> = (0..range.frames).map(|frame| range.time(frame)).collect();
        let changes = self.visible.iter().flat_map(|(time, _)| [time - LEAP, *time]);
        times.extend(changes.filter(|time| (range.start..=range.end()).contains(time)));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|a, b| *a - *b < LEAP / 2.0);
        let key = |time: f64| Key { time: time - range.start, pose: self.pose(time) };
        let mut keys = times.into_iter().map(key).collect();
        thin(&mut keys);
        keys
    }

    /// What a camera sees that it moves.
    pub(super) fn view(&self, time: f64) -> View {
        let Pose { pivot, turn, .. } = self.pose(time);
        let axes = DMat3::from_quat(turn);
        View { position: pivot, target: pivot - axes.z_axis, up: axes.y_axis }
    }
}

fn knots<T>(
    words: &mut Words<'_>,
    notes: &mut Notes,
    value: impl Fn(&mut Words<'_>, &mut Notes) -> Result<T, ImportError>,
) -> Result<Vec<Knot<T>>, ImportError> {
    let count = words.count(0, MOST_KEYS)?;
    if (1..4).contains(&count) {
        return words.bad(format!("a spline needs four keys or more instead of {count}"));
    }
    let mut knots: Vec<Knot<T>> = Vec::new();
    for _ in 0..count {
        let (time, value) = (words.number()?, value(words, notes)?);
        if knots.last().is_some_and(|before| before.time > time) {
            notes.leave_out("that the times of a spline's keys fall");
        }
        knots.push(Knot { time, value, shape: words.vector()?.to_array() });
    }
    Ok(knots)
}

/// An axis and an angle in degrees. An axis of any length is a direction.
fn turn(words: &mut Words<'_>, notes: &mut Notes) -> Result<DQuat, ImportError> {
    let (axis, angle) = (words.vector()?, words.number()?);
    if (axis.length() - 1.0).abs() > 1e-3 && angle != 0.0 {
        notes.leave_out("the length of an axis, which counts as 1");
    }
    Ok(about(axis, angle))
}

/// A turn by degrees; none about an axis without length.
pub(super) fn about(axis: DVec3, degrees: f64) -> DQuat {
    let (sin, cos) = (libm::sin(degrees.to_radians() / 2.0), libm::cos(degrees.to_radians() / 2.0));
    let v = axis.normalize_or_zero() * sin;
    if v == DVec3::ZERO { DQuat::IDENTITY } else { DQuat::from_xyzw(v.x, v.y, v.z, cos) }
}
