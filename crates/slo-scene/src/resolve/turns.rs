//! `turn` and `turn_deg`: orientations by angles. Between key frames they become so many more that the
//! object turns evenly.

use glam::{DMat3, DQuat, DVec3};

use crate::animation::{about, bezier, cubic, sin_cos_deg};
use crate::attributes::{Bound, Fields};
use crate::description::{KeyFrame, Placement};
use crate::diagnostics::{Diagnostic, Span};

/// Most degrees between two key frames. A turn of 20 degrees in one piece is even to 0.002 degrees.
const MOST_DEGREES: f64 = 20.0;

/// Most pieces that the path of one object is divided into: about a thousand even turns.
const MOST_PIECES: f64 = 20_000.0;

/// Sine of the angle between two axes below which they are one.
const SAME_AXIS: f64 = 1e-9;

/// Half of the step, as a share of a piece, by which the speed of a turn without a fixed axis is found.
const STEP: f64 = 1e-5;

/// An orientation, as it is written.
#[derive(Clone, Copy, Debug)]
pub(super) enum Turn {
    /// Degrees about a unit axis: any number of turns.
    About(DVec3, f64),
    /// Degrees about x, then about y, then about z, the axes of the scene.
    Angles(DVec3),
}

/// What `key`, `pre` or `nex` say about the orientation.
#[derive(Clone, Debug, Default)]
pub(super) struct Turned {
    pub(super) turn: Option<Turn>,
    /// The attributes that say it.
    places: Vec<(&'static str, Span)>,
}

/// A key frame with its places in the text.
pub(super) struct Written {
    pub(super) key_frame: KeyFrame,
    /// What `pre`, `key` and `nex` say about the orientation.
    pub(super) turned: [Turned; 3],
    pub(super) time: Span,
    pub(super) keyword: Span,
}

/// Reads what a block says about the orientation.
pub(super) fn turned(fields: &mut Fields<'_, '_, '_>) -> Turned {
    let places = ["up", "right", "turn", "turn_deg"].into_iter();
    let places = places.filter_map(|name| Some((name, fields.get(name)?.keyword.span))).collect();
    let about = fields.get("turn").and_then(|field| {
        let mut fields = fields.open(field)?;
        let (axis, degrees) = (fields.direction("axis"), fields.number("angle_deg", Bound::Any));
        Some(Turn::About(axis?.value.normalize(), degrees?.value))
    });
    let angles = || fields.vector("turn_deg").map(|angles| Turn::Angles(angles.value));
    Turned { turn: about.or_else(angles), places }
}

/// Key frames with turns as key frames with `up` and `right`, of which as many are added as it takes for
/// the object to turn evenly. What is wrong is reported.
pub(super) fn even(written: &[Written], fields: &mut Fields<'_, '_, '_>) -> Vec<KeyFrame> {
    let plain = || written.iter().map(|w| w.key_frame).collect();
    if report_ways(written, fields) {
        return plain();
    }
    let keys = complete(written);
    let pieces = keys.windows(2).zip(written.windows(2));
    let pieces: Vec<_> =
        pieces.map(|(keys, w)| Piece::new([&keys[0], &keys[1]], [&w[0], &w[1]])).collect();
    if pieces.iter().map(|piece| piece.parts).sum::<f64>() > MOST_PIECES {
        report_many(fields);
        return plain();
    }
    let mut frames = Vec::new();
    let mut pre = Placement::default();
    for piece in &pieces {
        for part in 0..piece.parts as u32 {
            let mut key_frame = piece.part(f64::from(part));
            std::mem::swap(&mut key_frame.pre, &mut pre);
            frames.push(key_frame);
        }
    }
    if let Some(last) = keys.last() {
        let key = facing(Some(last.pivot), last.scale, last.turn.rotation());
        frames.push(KeyFrame { time: last.time, pre, key, nex: Placement::default() });
    }
    frames
}

/// Reports an object that is turned in two ways. Returns whether it is.
fn report_ways(written: &[Written], fields: &mut Fields<'_, '_, '_>) -> bool {
    let way = |name: &'static str| if name == "right" { "up" } else { name };
    let mut places = written.iter().flat_map(|w| w.turned.iter().flat_map(|t| t.places.clone()));
    let Some((first, at)) = places.next() else { return false };
    let Some((other, there)) = places.find(|(name, _)| way(name) != way(first)) else {
        return false;
    };
    let message = format!("{} is turned by `{first}` and by `{other}`", fields.element.title());
    let error = Diagnostic::error(message).at(at.max(there), "").also(at.min(there), "");
    let help = "write `turn`, `turn_deg`, or `up` and `right`, the same in all of its key frames";
    fields.diagnostics.push(error.help(help));
    true
}

fn report_many(fields: &mut Fields<'_, '_, '_>) {
    let message = format!(
        "{} turns too far in its key frames: by more than {MOST_PIECES} pieces of {MOST_DEGREES} degrees",
        fields.element.title()
    );
    let span = fields.get("addKframe").map_or(fields.element.head(), |field| field.keyword.span);
    let help = "write a single turn, and `repeat CYCLE` or `repeat OFFSET`";
    fields.diagnostics.push(Diagnostic::error(message).at(span, "").help(help));
}

/// A key with all parts filled in.
struct Key {
    time: f64,
    pivot: DVec3,
    /// `None` if no key frame has one.
    scale: Option<DVec3>,
    turn: Turn,
}

fn complete(written: &[Written]) -> Vec<Key> {
    let is_angles = |w: &Written| w.turned.iter().any(|t| matches!(t.turn, Some(Turn::Angles(_))));
    let none = match written.iter().any(is_angles) {
        true => Turn::Angles(DVec3::ZERO),
        false => Turn::About(DVec3::Z, 0.0),
    };
    let scales = |w: &Written| {
        let KeyFrame { pre, key, nex, .. } = w.key_frame;
        [pre, key, nex].iter().any(|placement| placement.scale.is_some())
    };
    let scale = written.iter().any(scales).then_some(DVec3::ONE);
    let mut last = Key { time: 0.0, pivot: DVec3::ZERO, scale, turn: none };
    let key = |Written { key_frame, turned: [_, turned, _], .. }: &Written| {
        last.time = key_frame.time;
        last.pivot = key_frame.key.pivot.unwrap_or(last.pivot);
        last.scale = key_frame.key.scale.or(last.scale);
        last.turn = turned.turn.unwrap_or(last.turn);
        Key { ..last }
    };
    written.iter().map(key).collect()
}

/// From one key to the next.
struct Piece {
    time: [f64; 2],
    pivot: Curve,
    scale: Option<Curve>,
    course: Course,
    /// How many key frames it becomes; a whole number.
    parts: f64,
}

impl Piece {
    fn new([from, to]: [&Key; 2], [before, after]: [&Written; 2]) -> Self {
        let handles = [before.key_frame.nex.pivot, after.key_frame.pre.pivot];
        let course =
            Course::new([from.turn, to.turn], [before.turned[2].turn, after.turned[0].turn]);
        let parts = (course.most_degrees() / MOST_DEGREES - 1e-9).ceil().max(1.0);
        let pivot = Curve::new([from.pivot, to.pivot], handles);
        let handles = [before.key_frame.nex.scale, after.key_frame.pre.scale];
        let scales = from.scale.zip(to.scale);
        let scale = scales.map(|(from, to)| Curve::new([from, to], handles));
        Self { time: [from.time, to.time], pivot, scale, course, parts }
    }

    /// The key frame at which a part begins; `pre` is that of the next one.
    fn part(&self, number: f64) -> KeyFrame {
        let [start, end] = [number, number + 1.0].map(|n| n / self.parts);
        let [pivot, handles] = self.pivot.part(start, end);
        let scale = self.scale.as_ref().map(|scale| scale.part(start, end));
        let [scale, scale_handles] = scale.unwrap_or_default();
        let [here, there] = [start, end].map(|u| self.course.rotation(u));
        let third = (end - start) / 3.0;
        let rests = self.course.most_degrees() == 0.0;
        let handle = |side: usize, u: f64, rotation: DMat3, step: f64| {
            let (pivot, scale) = (handles[side], scale_handles[side]);
            if rests {
                return Placement { pivot, scale, ..Placement::default() };
            }
            let spin = self.course.spin(u) * step;
            let moved = |axis: DVec3| axis + spin.cross(axis);
            Placement {
                pivot,
                up: Some(moved(rotation.z_axis)),
                right: Some(moved(rotation.x_axis)),
                scale,
            }
        };
        let [from, to] = self.time;
        KeyFrame {
            time: from + (to - from) * start,
            key: facing(pivot[0], scale[0], here),
            nex: handle(0, start, here, third),
            pre: handle(1, end, there, -third),
        }
    }
}

fn facing(pivot: Option<DVec3>, scale: Option<DVec3>, rotation: DMat3) -> Placement {
    let [up, right] = [rotation.z_axis, rotation.x_axis].map(Some);
    Placement { pivot, up, right, scale }
}

/// A cubic curve that runs beside a turn.
struct Curve {
    control: [DVec3; 4],
    /// Those that are written.
    handles: [Option<DVec3>; 2],
}

impl Curve {
    fn new(ends: [DVec3; 2], handles: [Option<DVec3>; 2]) -> Self {
        Self { control: thirds(ends, handles), handles }
    }

    /// Its part from `a` to `b`: where it begins and ends, and its handles.
    fn part(&self, a: f64, b: f64) -> [[Option<DVec3>; 2]; 2] {
        if [a, b] == [0.0, 1.0] {
            return [[self.control[0], self.control[3]].map(Some), self.handles];
        }
        let at = |at: [f64; 3]| {
            let [p, q, r, s] = self.control;
            let mix = |p: DVec3, q: DVec3, u: f64| p + (q - p) * u;
            let [p, q, r] = [mix(p, q, at[0]), mix(q, r, at[0]), mix(r, s, at[0])];
            let [p, q] = [mix(p, q, at[1]), mix(q, r, at[1])];
            Some(mix(p, q, at[2]))
        };
        [[at([a, a, a]), at([b, b, b])], [at([a, a, b]), at([a, b, b])]]
    }
}

/// Control points, with handles that are left out at a third of the way.
fn thirds([from, to]: [DVec3; 2], handles: [Option<DVec3>; 2]) -> [DVec3; 4] {
    let third = (to - from) / 3.0;
    [from, handles[0].unwrap_or(from + third), handles[1].unwrap_or(to - third), to]
}

impl Turn {
    fn rotation(self) -> DMat3 {
        match self {
            Self::About(axis, degrees) => about(axis, degrees),
            Self::Angles(angles) => {
                about(DVec3::Z, angles.z) * about(DVec3::Y, angles.y) * about(DVec3::X, angles.x)
            }
        }
    }

    fn quaternion(self) -> DQuat {
        match self {
            Self::About(axis, degrees) => {
                let (sine, cosine) = sin_cos_deg(degrees / 2.0);
                DQuat::from_vec4((axis * sine).extend(cosine))
            }
            Self::Angles(_) => DQuat::from_mat3(&self.rotation()),
        }
    }

    /// Degrees about an axis; `None` for a turn about another one.
    fn degrees_about(self, axis: DVec3) -> Option<f64> {
        match self {
            Self::About(_, 0.0) => Some(0.0),
            Self::About(own, degrees) if own.cross(axis).length() < SAME_AXIS => {
                Some(degrees.copysign(degrees * own.dot(axis)))
            }
            _ => None,
        }
    }
}

/// How an object turns from one key to the next.
enum Course {
    /// Degrees about x, y and z.
    Angles([DVec3; 4]),
    /// Degrees about an axis, in x.
    About(DVec3, [DVec3; 4]),
    /// The shortest way, by de Casteljau's algorithm on the sphere (Shoemake, "Animating rotation with
    /// quaternion curves", 1985).
    Shortest([DQuat; 4]),
}

impl Course {
    fn new(ends: [Turn; 2], handles: [Option<Turn>; 2]) -> Self {
        if let [Turn::Angles(from), Turn::Angles(to)] = ends {
            let angles = |turn| if let Turn::Angles(angles) = turn { Some(angles) } else { None };
            return Self::Angles(thirds([from, to], handles.map(|handle| handle.and_then(angles))));
        }
        let all = [Some(ends[0]), handles[0], handles[1], Some(ends[1])];
        let axis = all.iter().flatten().find_map(|turn| match turn {
            Turn::About(axis, degrees) if *degrees != 0.0 => Some(*axis),
            _ => None,
        });
        let axis = axis.unwrap_or(DVec3::Z);
        let degrees = |turn: Turn| Some(DVec3::X * turn.degrees_about(axis)?);
        let known = all.map(|turn| turn.map_or(Some(None), |turn| degrees(turn).map(Some)));
        if let [Some(Some(from)), Some(nex), Some(pre), Some(Some(to))] = known {
            return Self::About(axis, thirds([from, to], [nex, pre]));
        }
        let [from, to] = ends.map(Turn::quaternion);
        let handle = |turn: Option<Turn>, u| turn.map_or(between(from, to, u), Turn::quaternion);
        Self::Shortest([from, handle(handles[0], 1.0 / 3.0), handle(handles[1], 2.0 / 3.0), to])
    }

    /// Degrees that the object would turn by at its highest speed, or more; 0 if it does not turn.
    fn most_degrees(&self) -> f64 {
        let fastest = |curve: &[DVec3; 4]| {
            let sum = |pair: &[DVec3]| (pair[1] - pair[0]).abs().element_sum();
            curve.windows(2).map(sum).fold(0.0, f64::max)
        };
        3.0 * match self {
            Self::Angles(curve) | Self::About(_, curve) => fastest(curve),
            Self::Shortest(turns) => {
                let angle = |pair: &[DQuat]| 2.0 * arc(pair[0], nearer(pair[0], pair[1]));
                turns.windows(2).map(angle).fold(0.0, f64::max).to_degrees()
            }
        }
    }

    fn rotation(&self, u: f64) -> DMat3 {
        match self {
            Self::Angles(curve) => Turn::Angles(cubic(curve, u)).rotation(),
            Self::About(axis, curve) => about(*axis, cubic(curve, u).x),
            Self::Shortest(turns) => DMat3::from_quat(spherical(*turns, u)),
        }
    }

    /// Radians per piece, about the axes of the scene.
    fn spin(&self, u: f64) -> DVec3 {
        let speed = |c: &[DVec3; 4]| {
            let speed = bezier(&[c[1] - c[0], c[2] - c[1], c[3] - c[2]], u) * 3.0;
            speed.map(f64::to_radians)
        };
        match self {
            Self::Angles(curve) => {
                let (angles, speed) = (cubic(curve, u), speed(curve));
                let about_z = about(DVec3::Z, angles.z);
                let y = about_z * DVec3::Y;
                let x = about_z * (about(DVec3::Y, angles.y) * DVec3::X);
                x * speed.x + y * speed.y + DVec3::Z * speed.z
            }
            Self::About(axis, curve) => *axis * speed(curve).x,
            Self::Shortest(turns) => {
                let [before, after] = [u - STEP, u + STEP].map(|u| spherical(*turns, u));
                let step = nearer(DQuat::IDENTITY, after * before.conjugate());
                step.xyz() / STEP
            }
        }
    }
}

/// The point at `u` of a curve of rotations.
fn spherical(turns: [DQuat; 4], u: f64) -> DQuat {
    let [p, q, r, s] = turns;
    let [p, q, r] = [between(p, q, u), between(q, r, u), between(r, s, u)];
    let [p, q] = [between(p, q, u), between(q, r, u)];
    between(p, q, u)
}

/// The rotation at `u` of the shortest way from one to another, at constant speed.
fn between(from: DQuat, to: DQuat, u: f64) -> DQuat {
    let to = nearer(from, to);
    let angle = arc(from, to);
    let sine = libm::sin(angle);
    if sine < SAME_AXIS {
        return (from + (to - from) * u).normalize();
    }
    let weights = [1.0 - u, u].map(|share| libm::sin(share * angle) / sine);
    (from * weights[0] + to * weights[1]).normalize()
}

/// The same rotation as `to`, written so that it is nearer to `from`.
fn nearer(from: DQuat, to: DQuat) -> DQuat {
    if from.dot(to) < 0.0 { -to } else { to }
}

/// Half of the angle between two rotations, in radians.
fn arc(from: DQuat, to: DQuat) -> f64 {
    2.0 * libm::atan2((to - from).length(), (to + from).length())
}

#[cfg(test)]
mod tests;
