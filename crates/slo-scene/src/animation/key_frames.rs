//! Paths of objects: cubic Bézier pieces between key frames.

use std::fmt;

use glam::DVec3;

use crate::description::{KeyFrame, Placement};
use crate::settings::Repeat;

use super::affine::DAffine;
use super::bezier::cubic;
use super::orientation::orientation;
use super::piece::Piece;
use super::repeat::{Cycles, Stretch};
use super::rigid::DRigid;

/// The path of an object through scene time, in its parent: where it is, how it is turned, and how
/// large.
///
/// Between two keys, pivot, up, right and scale each run along the cubic Bézier curve of (key, nex of
/// it, pre of the next, next key), linear in time; outside the keys the object rests, or its motion is
/// [repeated](Self::repeated). At a time that two keys share, the later one counts from that time on.
#[derive(Clone, Debug)]
pub struct KeyFrames {
    keys: Vec<Key>,
    pieces: Vec<Piece>,
    /// Whether the scale is 1 at all times.
    is_rigid: bool,
    cycles: Option<Cycles>,
}

/// A key with all parts filled in.
#[derive(Clone, Copy, Debug)]
struct Key {
    time: f64,
    control: Control,
    pose: DRigid,
}

/// Pivot, up, right and scale.
type Control = [DVec3; 4];

/// Where a time lies among the keys.
enum Place<'a> {
    /// There are none.
    Anywhere,
    /// At a key, or at rest outside of all keys.
    Key(&'a Key),
    /// In the piece with this index, at a parameter from 0 to 1.
    Between(usize, f64),
}

impl Key {
    fn scale(&self) -> DVec3 {
        self.control[3]
    }

    /// Whether the object leaps from one key to the other.
    fn differs(&self, other: &Self) -> bool {
        self.pose != other.pose || self.scale() != other.scale()
    }
}

/// Why a list of key frames is no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyFrameError {
    /// `up` of the key with this index is parallel to its `right`, or one of them is zero (or was
    /// taken from the key before, if this one leaves it out).
    NoOrientation(usize),
    /// The key with this index has an earlier time than the one before it, or a time that is not
    /// finite.
    OutOfOrder(usize),
}

/// A moment at which a path jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Index of the key before the jump.
    pub key: usize,
    /// Scene time of the jump.
    pub time: f64,
    /// Whether `up` and `right` pass through a state without orientation (as in a half turn in
    /// one piece) there; otherwise the next key has the same time.
    pub collapse: bool,
}

impl KeyFrames {
    /// The path through some key frames; without any, object space is scene space.
    ///
    /// A missing part of a key comes from the key before it (the first key: pivot 0, up z, right x,
    /// scale 1); a missing handle lies at a third of the straight line between the keys.
    ///
    /// # Errors
    /// A key without an orientation; keys out of order.
    pub fn new(key_frames: &[KeyFrame]) -> Result<Self, KeyFrameError> {
        let keys = complete(key_frames)?;
        let pieces = (1..keys.len())
            .map(|i| {
                let [from, to] = [keys[i - 1].control, keys[i].control];
                let handles = [key_frames[i - 1].nex, key_frames[i].pre];
                let curve = |c: usize| with_handles(from[c], handles.map(|h| parts(h)[c]), to[c]);
                Piece { pivot: curve(0), up: curve(1), right: curve(2), scale: curve(3) }
            })
            .collect::<Vec<_>>();
        let is_one = |scale: &DVec3| *scale == DVec3::ONE;
        let is_rigid = keys.iter().all(|key| is_one(&key.scale()))
            && pieces.iter().all(|piece| piece.scale.iter().all(is_one));
        Ok(Self { keys, pieces, is_rigid, cycles: None })
    }

    /// The same path, whose motion goes on before the first key and after the last. Without `repeat`, or
    /// without time between these keys, the object rests there.
    #[must_use]
    pub fn repeated(self, repeat: Option<Repeat>) -> Self {
        let ends = || Some([self.keys.first()?, self.keys.last()?].map(|key| (key.time, key.pose)));
        let cycles = repeat.and_then(|repeat| Cycles::new(repeat, ends()?));
        Self { cycles, ..self }
    }

    /// Whether the scale is 1 at all times.
    pub fn is_rigid(&self) -> bool {
        self.is_rigid
    }

    /// The transform from object space to the parent's space at a scene time; always finite.
    pub fn placed(&self, time: f64) -> DAffine {
        let pose = self.pose(time);
        if self.is_rigid { pose.into() } else { DAffine::scaled(self.scale(time), pose) }
    }

    /// The scale along the object's own axes at a scene time.
    fn scale(&self, time: f64) -> DVec3 {
        let Some(cycles) = &self.cycles else { return self.scale_among_keys(time) };
        let (cycle, local) = cycles.fold(time);
        let ends =
            [self.keys.first(), self.keys.last()].map(|key| key.map_or(DVec3::ONE, Key::scale));
        cycles.grown(cycle, self.scale_among_keys(local), ends)
    }

    fn scale_among_keys(&self, time: f64) -> DVec3 {
        match self.place(time) {
            Place::Anywhere => DVec3::ONE,
            Place::Key(key) => key.scale(),
            Place::Between(before, u) => cubic(&self.pieces[before].scale, u),
        }
    }

    /// The place and orientation at a scene time, without the scale; always finite.
    ///
    /// Where `up` and `right` pass through a state without orientation inside a piece, the object
    /// keeps the orientation that it had just before.
    pub fn pose(&self, time: f64) -> DRigid {
        let Some(cycles) = &self.cycles else { return self.pose_among_keys(time) };
        let (cycle, local) = cycles.fold(time);
        cycles.carry(cycle, self.pose_among_keys(local))
    }

    fn pose_among_keys(&self, time: f64) -> DRigid {
        match self.place(time) {
            Place::Anywhere => DRigid::IDENTITY,
            Place::Key(key) => key.pose,
            Place::Between(before, u) => {
                self.pieces[before].pose(u, self.keys[before].pose.rotation)
            }
        }
    }

    fn place(&self, time: f64) -> Place<'_> {
        let after = self.keys.partition_point(|key| key.time <= time);
        match (after.checked_sub(1), self.keys.get(after)) {
            (None, None) => Place::Anywhere,
            (None, Some(first)) => Place::Key(first),
            (Some(last), None) => Place::Key(&self.keys[last]),
            (Some(before), Some(next)) => {
                let from = &self.keys[before];
                Place::Between(before, (time - from.time) / (next.time - from.time))
            }
        }
    }

    /// Whether the object changes its place, orientation or size within an interval of scene time.
    ///
    /// Answered from the control points, not from poses: an object that returns to where it was
    /// does move. An interval without length holds no motion.
    pub fn moves(&self, interval: [f64; 2]) -> bool {
        let Some(cycles) = &self.cycles else { return self.moves_among_keys(interval) };
        let mut stretches = cycles.stretches(interval, self.keys.len());
        let moves = |stretch: Stretch| {
            stretch.is_new && self.leaps_between_cycles(cycles)
                || self.moves_among_keys(stretch.local)
        };
        interval[0] < interval[1] && stretches.any(moves)
    }

    /// Whether the object leaps to the beginning of each cycle.
    fn leaps_between_cycles(&self, cycles: &Cycles) -> bool {
        let end = |key: &Key| (key.pose, key.scale());
        let ends = [self.keys.first(), self.keys.last()].map(|key| key.map(end));
        !cycles.is_closed(ends[0] != ends[1])
    }

    fn moves_among_keys(&self, interval: [f64; 2]) -> bool {
        let [start, end] = interval;
        let moving = |i: usize| {
            let [from, to] = [&self.keys[i], &self.keys[i + 1]];
            if from.time < to.time {
                from.time < end && start < to.time && !self.pieces[i].rests()
            } else {
                start < from.time && from.time <= end && from.differs(to)
            }
        };
        start < end && (0..self.pieces.len()).any(moving)
    }

    /// The moments within an interval of scene time, ends included, at which the path jumps, in
    /// order of time: usually not what was meant.
    pub fn jumps(&self, interval: [f64; 2]) -> Vec<Jump> {
        let Some(cycles) = &self.cycles else { return self.jumps_among_keys(interval) };
        let leaps = self.leaps_between_cycles(cycles);
        let jumps = |stretch: Stretch| {
            let time = stretch.start(cycles);
            let begins = leaps && (interval[0]..=interval[1]).contains(&time);
            let leap = begins.then_some(Jump { key: self.pieces.len(), time, collapse: false });
            let mut within = self.jumps_among_keys(stretch.local);
            if stretch.is_backward(cycles) {
                within.reverse();
            }
            let within = within.into_iter().map(move |jump| {
                let time = stretch.time(cycles, jump.time);
                Jump { time, ..jump }
            });
            leap.into_iter().chain(within)
        };
        cycles.stretches(interval, self.keys.len()).flat_map(jumps).collect()
    }

    fn jumps_among_keys(&self, interval: [f64; 2]) -> Vec<Jump> {
        let near =
            |i: &usize| self.keys[*i].time <= interval[1] && interval[0] <= self.keys[i + 1].time;
        let within = |jump: &Jump| (interval[0]..=interval[1]).contains(&jump.time);
        (0..self.pieces.len()).filter(near).flat_map(|i| self.jumps_of(i)).filter(within).collect()
    }

    fn jumps_of(&self, key: usize) -> Vec<Jump> {
        let (from, to, piece) = (&self.keys[key], &self.keys[key + 1], &self.pieces[key]);
        if from.time < to.time {
            let time = |u: f64| from.time + u * (to.time - from.time);
            let jump = |u| Jump { key, time: time(u), collapse: true };
            piece.collapses().into_iter().map(jump).collect()
        } else if from.differs(to) {
            vec![Jump { key, time: from.time, collapse: false }]
        } else {
            vec![]
        }
    }

    /// Times of the keys inside an interval, its ends left out, in no order. Of an interval that holds a great many
    /// cycles, only those of the first.
    pub fn key_times_within(&self, interval: [f64; 2]) -> impl Iterator<Item = f64> {
        let inside = move |time: &f64| interval[0] < *time && *time < interval[1];
        let times = self.keys.iter().map(|key| key.time);
        let repeated = self.cycles.as_ref().map(|cycles| {
            let stretches = cycles.stretches(interval, self.keys.len());
            let times = times.clone();
            stretches.flat_map(move |stretch| times.clone().map(move |t| stretch.time(cycles, t)))
        });
        let once = times.take(if repeated.is_some() { 0 } else { self.keys.len() });
        once.chain(repeated.into_iter().flatten()).filter(inside)
    }
}

impl fmt::Display for KeyFrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoOrientation(key) => {
                write!(f, "`up` of key frame {} is parallel to its `right`, or zero", key + 1)
            }
            Self::OutOfOrder(key) => {
                write!(f, "key frame {} is earlier than the one before it", key + 1)
            }
        }
    }
}

impl std::error::Error for KeyFrameError {}

fn parts(placement: Placement) -> [Option<DVec3>; 4] {
    [placement.pivot, placement.up, placement.right, placement.scale]
}

/// Fills in what keys leave out.
fn complete(key_frames: &[KeyFrame]) -> Result<Vec<Key>, KeyFrameError> {
    let mut control: Control = [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::ONE];
    let mut before = f64::NEG_INFINITY;
    let mut keys = Vec::with_capacity(key_frames.len());
    for (i, key_frame) in key_frames.iter().enumerate() {
        let time = key_frame.time;
        if !time.is_finite() || time < before {
            return Err(KeyFrameError::OutOfOrder(i));
        }
        before = time;
        for (component, given) in control.iter_mut().zip(parts(key_frame.key)) {
            *component = given.unwrap_or(*component);
        }
        let [pivot, up, right, _] = control;
        let rotation = orientation(right, up).ok_or(KeyFrameError::NoOrientation(i))?;
        keys.push(Key { time, control, pose: DRigid { rotation, translation: pivot } });
    }
    Ok(keys)
}

/// The control points of one component of a piece.
fn with_handles(from: DVec3, handles: [Option<DVec3>; 2], to: DVec3) -> [DVec3; 4] {
    let third = (to - from) / 3.0;
    [from, handles[0].unwrap_or(from + third), handles[1].unwrap_or(to - third), to]
}

#[cfg(test)]
mod repeated;

#[cfg(test)]
mod tests;
