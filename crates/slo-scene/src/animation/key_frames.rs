//! Paths of objects: cubic Bézier pieces between key frames.

use std::fmt;

use glam::DVec3;

use crate::description::{KeyFrame, Placement};
use crate::settings::Repeat;

use super::orientation::orientation;
use super::piece::Piece;
use super::repeat::{Cycles, Stretch};
use super::rigid::DRigid;

/// The path of an object through scene time: where it is, and how it is turned.
///
/// Between two keys, pivot, up and right each run along the cubic Bézier curve of (key, nex of
/// it, pre of the next, next key), linear in time; outside the keys the object rests, or its motion is
/// [repeated](Self::repeated). At a time that two keys share, the later one counts from that time on.
#[derive(Clone, Debug)]
pub struct KeyFrames {
    keys: Vec<Key>,
    pieces: Vec<Piece>,
    cycles: Option<Cycles>,
}

/// A key with all parts filled in.
#[derive(Clone, Copy, Debug)]
struct Key {
    time: f64,
    control: Control,
    pose: DRigid,
}

/// Pivot, up and right.
type Control = [DVec3; 3];

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
    /// A missing pivot, up or right of a key comes from the key before it (the first key: pivot 0,
    /// up z, right x); a missing handle lies at a third of the straight line between the keys.
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
                Piece { pivot: curve(0), up: curve(1), right: curve(2) }
            })
            .collect::<Vec<_>>();
        Ok(Self { keys, pieces, cycles: None })
    }

    /// The same path, whose motion goes on before the first key and after the last. Without `repeat`, or
    /// without time between these keys, the object rests there.
    #[must_use]
    pub fn repeated(self, repeat: Option<Repeat>) -> Self {
        let ends = || Some([self.keys.first()?, self.keys.last()?].map(|key| (key.time, key.pose)));
        let cycles = repeat.and_then(|repeat| Cycles::new(repeat, ends()?));
        Self { cycles, ..self }
    }

    /// The transform from object space to scene space at a scene time; always finite.
    ///
    /// Where `up` and `right` pass through a state without orientation inside a piece, the object
    /// keeps the orientation that it had just before.
    pub fn pose(&self, time: f64) -> DRigid {
        let Some(cycles) = &self.cycles else { return self.pose_among_keys(time) };
        let (cycle, local) = cycles.fold(time);
        cycles.carry(cycle, self.pose_among_keys(local))
    }

    fn pose_among_keys(&self, time: f64) -> DRigid {
        let after = self.keys.partition_point(|key| key.time <= time);
        match (after.checked_sub(1), self.keys.get(after)) {
            (None, None) => DRigid::IDENTITY,
            (None, Some(first)) => first.pose,
            (Some(last), None) => self.keys[last].pose,
            (Some(before), Some(next)) => {
                let from = &self.keys[before];
                let u = (time - from.time) / (next.time - from.time);
                self.pieces[before].pose(u, from.pose.rotation)
            }
        }
    }

    /// Whether the object changes its place or orientation within an interval of scene time.
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
        let ends = [self.keys.first(), self.keys.last()].map(|key| key.map(|key| key.pose));
        !cycles.is_closed(ends[0] != ends[1])
    }

    fn moves_among_keys(&self, interval: [f64; 2]) -> bool {
        let [start, end] = interval;
        let moving = |i: usize| {
            let [from, to] = [&self.keys[i], &self.keys[i + 1]];
            if from.time < to.time {
                from.time < end && start < to.time && !self.pieces[i].rests()
            } else {
                start < from.time && from.time <= end && from.pose != to.pose
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
        } else if from.pose != to.pose {
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

fn parts(placement: Placement) -> [Option<DVec3>; 3] {
    [placement.pivot, placement.up, placement.right]
}

/// Fills in what keys leave out.
fn complete(key_frames: &[KeyFrame]) -> Result<Vec<Key>, KeyFrameError> {
    let mut control: Control = [DVec3::ZERO, DVec3::Z, DVec3::X];
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
        let [pivot, up, right] = control;
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
mod tests {
    use glam::DMat3;

    use super::*;

    fn at(pivot: [f64; 3]) -> Placement {
        Placement { pivot: Some(pivot.into()), ..Placement::default() }
    }

    fn facing(right: DVec3) -> Placement {
        Placement { right: Some(right), ..Placement::default() }
    }

    fn key(time: f64, key: Placement) -> KeyFrame {
        KeyFrame { time, key, ..KeyFrame::default() }
    }

    fn path(keys: &[KeyFrame]) -> KeyFrames {
        KeyFrames::new(keys).unwrap()
    }

    fn is_rotation(m: DMat3) -> bool {
        let error = m.transpose() * m - DMat3::IDENTITY;
        m.is_finite() && error.to_cols_array().iter().all(|x| x.abs() < 1e-14)
    }

    #[test]
    fn no_key_frame_is_scene_space() {
        let path = path(&[]);
        assert_eq!(path.pose(3.0), DRigid::IDENTITY);
        assert!(!path.moves([0.0, 9.0]));
    }

    #[test]
    fn one_key_frame_places_a_still_object() {
        let path = path(&[key(2.0, Placement { right: Some(DVec3::Y), ..at([1.0, 2.0, 3.0]) })]);
        for time in [-5.0, 2.0, 7.0] {
            // object x goes to scene y, object y to scene -x
            let p = path.pose(time).point(DVec3::new(1.0, 10.0, 100.0));
            assert_eq!(p, DVec3::new(-9.0, 3.0, 103.0));
        }
        assert!(!path.moves([-9.0, 9.0]));
    }

    #[test]
    fn without_handles_motion_is_linear_in_time() {
        let path = path(&[key(1.0, at([0.0, 3.0, -1.0])), key(5.0, at([8.0, 3.0, 1e3]))]);
        for i in 0..=100 {
            let u = i as f64 / 100.0;
            let p = path.pose(1.0 + 4.0 * u).translation;
            let expected = DVec3::new(8.0 * u, 3.0, -1.0 + 1001.0 * u);
            assert!((p - expected).length() < 1e-12 * 1e3, "{p} at {u}");
        }
    }

    #[test]
    fn a_lone_handle_meets_a_third_of_the_straight_line() {
        let mut first = key(0.0, at([0.0; 3]));
        first.nex = at([0.0, 6.0, 0.0]);
        let path = path(&[first, key(1.0, at([3.0, 0.0, 0.0]))]);
        // control points 0, (0, 6), (2, 0), (3, 0); half way: (p0 + 3 p1 + 3 p2 + p3) / 8
        let middle = path.pose(0.5).translation;
        assert!((middle - DVec3::new(9.0 / 8.0, 18.0 / 8.0, 0.0)).length() < 1e-15);
    }

    #[test]
    fn handles_are_separate_for_every_component() {
        let mut first = key(0.0, at([0.0; 3]));
        first.nex = Placement { up: Some(DVec3::new(0.0, 1.0, 1.0)), ..Placement::default() };
        let path = path(&[first, key(1.0, at([4.0, 0.0, 0.0]))]);
        assert!((path.pose(0.25).translation - DVec3::X).length() < 1e-15); // still linear
        // up: (z + 3 (y + z) + 3 z + z) / 8 = z + 3/8 y
        let up = path.pose(0.5).rotation.z_axis;
        assert!((up - DVec3::new(0.0, 0.375, 1.0).normalize()).length() < 1e-15);
    }

    #[test]
    fn handles_of_the_far_sides_take_no_part() {
        let mut keys = [key(0.0, at([0.0; 3])), key(1.0, at([1.0, 0.0, 0.0]))];
        keys[0].pre = at([99.0; 3]);
        keys[1].nex = at([99.0; 3]);
        assert!((path(&keys).pose(0.5).translation - DVec3::X * 0.5).length() < 1e-15);
    }

    #[test]
    fn what_a_key_leaves_out_comes_from_the_key_before() {
        let full = Placement { pivot: Some(DVec3::ONE), up: Some(DVec3::X), right: Some(DVec3::Y) };
        let path = path(&[
            key(0.0, Placement::default()),
            key(1.0, full),
            key(2.0, Placement::default()),
            key(3.0, at([5.0; 3])),
        ]);
        assert_eq!(path.pose(0.0), DRigid::IDENTITY);
        assert_eq!(path.pose(1.0), path.pose(2.0));
        // columns (right, forward, up), forward = up x right = x x y = z
        assert_eq!(path.pose(3.0).rotation, DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
        assert_eq!(path.pose(3.0).translation, DVec3::splat(5.0));
    }

    #[test]
    fn a_quarter_turn_in_one_piece() {
        let path = path(&[key(0.0, facing(DVec3::X)), key(1.0, facing(DVec3::Y))]);
        let right = |u: f64| path.pose(u).rotation.x_axis;
        // right runs along the straight line (1 - u, u): the angle is atan(u / (1 - u))
        for (u, degrees) in [(0.0, 0.0), (0.25, 18.434_948_822_922_01), (0.5, 45.0), (1.0, 90.0)] {
            let angle = libm::atan2(right(u).y, right(u).x).to_degrees();
            assert!((angle - degrees).abs() < 1e-12, "{angle} at {u}");
        }
    }

    #[test]
    fn outside_the_keys_the_object_rests() {
        let path = path(&[key(1.0, at([1.0; 3])), key(2.0, at([2.0; 3]))]);
        assert_eq!(path.pose(f64::NEG_INFINITY).translation, DVec3::splat(1.0));
        assert_eq!(path.pose(0.999).translation, DVec3::splat(1.0));
        assert_eq!(path.pose(2.0).translation, DVec3::splat(2.0));
        assert_eq!(path.pose(1e9).translation, DVec3::splat(2.0));
        for rest in [[0.0, 1.0], [2.0, 3.0], [-9.0, -8.0], [1.5, 1.5]] {
            assert!(!path.moves(rest), "{rest:?}");
        }
        for motion in [[0.0, 1.01], [1.99, 3.0], [0.0, 3.0], [1.5, 1.500_001]] {
            assert!(path.moves(motion), "{motion:?}");
        }
    }

    #[test]
    fn an_object_that_returns_moves() {
        let mut there_and_back = [key(0.0, at([0.0; 3])), key(1.0, at([0.0; 3]))];
        assert!(!path(&there_and_back).moves([0.0, 1.0]));
        there_and_back[1].pre = at([0.0, 0.0, 5.0]);
        assert!(path(&there_and_back).moves([0.0, 1.0]));
        let keys = [0.0, 1.0, 0.0].map(|x| key(x * 2.0, at([x, 0.0, 0.0])));
        let path = path(&[keys[0], keys[1], key(4.0, at([0.0; 3]))]);
        assert_eq!(path.pose(0.0), path.pose(4.0));
        assert!(path.moves([0.0, 4.0]));
    }

    #[test]
    fn path_is_continuous_at_its_keys() {
        let handle = Placement { up: Some(DVec3::new(0.3, 1.0, 1.0)), ..at([7.0, -3.0, 2.0]) };
        let mut keys = [
            key(0.0, at([0.0; 3])),
            key(0.3, facing(DVec3::new(0.2, 1.0, 0.0))),
            key(1.0, at([0.1, 0.2, 0.3])),
        ];
        keys.iter_mut().for_each(|key| (key.pre, key.nex) = (handle, handle));
        let path = path(&keys);
        for time in [0.0, 0.3, 1.0] {
            let [a, b] = [path.pose(time - 1e-12), path.pose(time + 1e-12)];
            assert!((a.translation - b.translation).length() < 1e-9);
            assert!((a.rotation - b.rotation).to_cols_array().iter().all(|x| x.abs() < 1e-9));
        }
        assert!(path.jumps([0.0, 1.0]).is_empty());
    }

    #[test]
    fn keys_without_orientation_are_named() {
        let upright = key(0.0, Placement::default());
        let parallel = key(1.0, facing(DVec3::NEG_Z));
        assert_eq!(
            KeyFrames::new(&[upright, parallel]).unwrap_err(),
            KeyFrameError::NoOrientation(1)
        );
        let gone = key(0.0, Placement { up: Some(DVec3::ZERO), ..Placement::default() });
        let error = KeyFrames::new(&[gone]).unwrap_err();
        assert_eq!(error, KeyFrameError::NoOrientation(0));
        assert_eq!(error.to_string(), "`up` of key frame 1 is parallel to its `right`, or zero");
        assert_eq!(
            KeyFrames::new(&[key(1.0, Placement::default()), upright]).unwrap_err(),
            KeyFrameError::OutOfOrder(1)
        );
        assert!(KeyFrames::new(&[key(f64::NAN, Placement::default())]).is_err());
    }

    #[test]
    fn two_keys_of_one_time_are_a_cut() {
        let path = path(&[
            key(0.0, at([0.0; 3])),
            key(1.0, at([1.0; 3])),
            key(1.0, at([5.0; 3])),
            key(2.0, at([6.0; 3])),
        ]);
        assert!((path.pose(1.0 - 1e-9).translation - DVec3::ONE).length() < 1e-8);
        assert_eq!(path.pose(1.0).translation, DVec3::splat(5.0));
        let cut = Jump { key: 1, time: 1.0, collapse: false };
        assert_eq!(path.jumps([0.0, 2.0]), [cut]);
        assert!(path.jumps([1.1, 2.0]).is_empty());
    }

    #[test]
    fn half_a_turn_in_one_piece_keeps_the_side_it_came_from() {
        let path = path(&[key(2.0, facing(DVec3::X)), key(4.0, facing(DVec3::NEG_X))]);
        assert_eq!(path.pose(2.99).rotation.x_axis, DVec3::X);
        assert_eq!(path.pose(3.0).rotation.x_axis, DVec3::X); // right is exactly 0 here
        assert_eq!(path.pose(3.01).rotation.x_axis, DVec3::NEG_X);
        let jumps = path.jumps([0.0, 9.0]);
        assert_eq!(jumps.len(), 1);
        assert!(jumps[0].collapse && jumps[0].key == 0 && (jumps[0].time - 3.0).abs() < 1e-6);
    }

    #[test]
    fn up_that_runs_through_right_is_found_off_the_grid_of_the_search() {
        // up turns in the xz plane from z to -z by way of x = right, at an odd place
        let up =
            |x: f64, z: f64| Placement { up: Some(DVec3::new(x, 0.0, z)), ..Placement::default() };
        let path = path(&[key(0.0, up(0.0, 1.0)), key(1.0, up(1.0, -0.7))]);
        let expected = 1.0 / 1.7; // z of up is 1 - 1.7 u
        let jumps = path.jumps([0.0, 1.0]);
        assert_eq!(jumps.len(), 1);
        assert!((jumps[0].time - expected).abs() < 1e-6);
        assert!(is_rotation(path.pose(jumps[0].time).rotation));
    }

    #[test]
    fn a_touch_without_a_leap_is_continuous() {
        // right shrinks to 0 half way and grows again in the same direction: r = (1 - 2u)^2
        let mut keys = [key(0.0, facing(DVec3::X)), key(1.0, facing(DVec3::X))];
        (keys[0].nex, keys[1].pre) = (facing(DVec3::X / -3.0), facing(DVec3::X / -3.0));
        let path = path(&keys);
        for i in 0..=1000 {
            let right = path.pose(i as f64 / 1000.0).rotation.x_axis;
            assert!((right - DVec3::X).length() < 1e-15);
        }
        assert!(path.jumps([0.0, 1.0]).is_empty());
    }

    #[test]
    fn poses_are_rotations_on_random_paths() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / 8_388_608.0 - 1.0
        };
        for _ in 0..200 {
            let mut vector = || Some(DVec3::new(random(), random(), random()));
            let mut placement = || Placement { pivot: vector(), up: vector(), right: vector() };
            let keys: Vec<_> = (0..4)
                .map(|i| KeyFrame {
                    time: i as f64,
                    pre: placement(),
                    key: placement(),
                    nex: placement(),
                })
                .collect();
            let path = path(&keys);
            for i in -10..=410 {
                let pose = path.pose(i as f64 / 100.0);
                assert!(is_rotation(pose.rotation) && pose.translation.is_finite());
                assert!(pose.translation.abs().max_element() <= 1.0 + 1e-12); // hull of the controls
            }
        }
    }

    #[test]
    fn tiny_and_huge_vectors_turn_as_others_do() {
        let far = Placement {
            up: Some(DVec3::Z * 1e200),
            right: Some(DVec3::Y * 1e-200),
            ..at([0.0; 3])
        };
        let path = path(&[key(0.0, far), key(1.0, facing(DVec3::Y * 3e-200))]);
        for u in [0.0, 0.4, 1.0] {
            assert_eq!(path.pose(u).rotation.x_axis, DVec3::Y);
        }
    }
}
