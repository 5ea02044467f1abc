//! Splines of Kochanek and Bartels through key frames at uneven times.
//!
//! D. Kochanek, R. Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias Control"
//! (1984). The first and the last key only shape tangents.

use glam::{DQuat, DVec3};

/// A key of a spline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot<T> {
    pub(super) time: f64,
    pub(super) value: T,
    /// Tension, continuity and bias.
    pub(super) shape: [f64; 3],
}

/// Sine of the angle below which two turns are taken for one.
const SAME_TURN: f64 = 1e-3;

/// Where a time lies: in the piece between the two middle ones of four keys, or at a key.
enum Place<'a, T> {
    At(T),
    /// Four keys, and the share of the way between the middle ones.
    Between([&'a Knot<T>; 4], f64),
}

/// There are four keys or more.
fn place<T: Copy>(knots: &[Knot<T>], time: f64) -> Place<'_, T> {
    let first = &knots[1];
    if time <= first.time {
        return Place::At(first.value);
    }
    match knots.windows(4).find(|piece| time < piece[2].time) {
        Some([a, b, c, d]) => {
            let step = c.time - b.time;
            let share = if step > 0.0 { ((time - b.time) / step).clamp(0.0, 1.0) } else { 0.0 };
            Place::Between([a, b, c, d], share)
        }
        _ => Place::At(knots[knots.len() - 2].value),
    }
}

/// Weights of the steps before, between and after two keys in the tangents there: of the first and second
/// step for the way out, of the second and third for the way in.
fn weights<T>([a, b, c, d]: [&Knot<T>; 4]) -> [[f64; 2]; 2] {
    // Keys that stand at one time shape nothing.
    let adjust = |whole: f64| {
        if whole == 0.0 { 1.0 } else { 2.0 * (c.time - b.time) / whole }
    };
    let (before, after) = (adjust(c.time - a.time), adjust(d.time - b.time));
    let [t1, c1, b1] = b.shape;
    let [t2, c2, b2] = c.shape;
    let (out, into) = (0.5 * before * (1.0 - t1), 0.5 * after * (1.0 - t2));
    [
        [out * (1.0 + c1) * (1.0 + b1), out * (1.0 - c1) * (1.0 - b1)],
        [into * (1.0 - c2) * (1.0 + b2), into * (1.0 + c2) * (1.0 - b2)],
    ]
}

/// The vector at a time.
pub(super) fn vector_at(knots: &[Knot<DVec3>], time: f64) -> DVec3 {
    let (piece, u) = match place(knots, time) {
        Place::At(value) => return value,
        Place::Between(piece, u) => (piece, u),
    };
    let [p0, p1, p2, p3] = piece.map(|knot| knot.value);
    let [[o0, o1], [i0, i1]] = weights(piece);
    let out = (p1 - p0) * o0 + (p2 - p1) * o1;
    let into = (p2 - p1) * i0 + (p3 - p2) * i1;
    let whole = p2 - p1;
    p1 + (out + (whole * 3.0 - out * 2.0 - into + (whole * -2.0 + out + into) * u) * u) * u
}

/// The turn at a time. Neighbouring keys have been turned to the same half.
pub(super) fn turn_at(knots: &[Knot<DQuat>], time: f64) -> DQuat {
    let (piece, u) = match place(knots, time) {
        Place::At(value) => return value,
        Place::Between(piece, u) => (piece, u),
    };
    let [q0, q1, q2, q3] = piece.map(|knot| knot.value);
    let [[o0, o1], [i0, i1]] = weights(piece);
    let step = |from: DQuat, to: DQuat| logarithm(from.conjugate() * to);
    let (l10, l21, l32) = (step(q0, q1), step(q1, q2), step(q2, q3));
    let out = l10 * o0 + l21 * o1;
    let into = l21 * i0 + l32 * i1;
    let a = q1 * exponential((out - l21) / 2.0);
    let b = q2 * exponential((l21 - into) / 2.0);
    slerp(2.0 * u * (1.0 - u), slerp(u, q1, q2), slerp(u, a, b)).normalize()
}

/// Turns each key to the half of the one before it, so that the way between them is the shorter one.
pub(super) fn align(knots: &mut [Knot<DQuat>]) {
    for i in 1..knots.len() {
        if knots[i - 1].value.dot(knots[i].value) < 0.0 {
            knots[i].value = -knots[i].value;
        }
    }
}

fn logarithm(q: DQuat) -> DVec3 {
    let vector = DVec3::new(q.x, q.y, q.z);
    let sine = vector.length();
    if sine == 0.0 { DVec3::ZERO } else { vector * (libm::atan2(sine, q.w) / sine) }
}

fn exponential(vector: DVec3) -> DQuat {
    let angle = vector.length();
    let sine = if angle == 0.0 { 1.0 } else { libm::sin(angle) / angle };
    let v = vector * sine;
    DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(angle))
}

/// The way that the signs say, even if it is the longer one.
fn slerp(u: f64, from: DQuat, to: DQuat) -> DQuat {
    let angle = libm::acos(from.dot(to).clamp(-1.0, 1.0));
    let sine = libm::sin(angle);
    if sine < SAME_TURN {
        return from;
    }
    from * (libm::sin((1.0 - u) * angle) / sine) + to * (libm::sin(u * angle) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knots(values: &[(f64, f64)], shape: [f64; 3]) -> Vec<Knot<DVec3>> {
        values
            .iter()
            .map(|&(time, x)| Knot { time, value: DVec3::new(x, 0.0, 0.0), shape })
            .collect()
    }

    #[test]
    fn even_times_without_shapes_are_a_catmull_rom_spline() {
        let knots = knots(&[(0.0, 0.0), (1.0, 1.0), (2.0, 4.0), (3.0, 9.0)], [0.0; 3]);
        // Catmull-Rom passes parabolas exactly.
        for t in [1.0, 1.25, 1.5, 1.9] {
            assert!((vector_at(&knots, t).x - t * t).abs() < 1e-12);
        }
        assert_eq!((vector_at(&knots, -5.0).x, vector_at(&knots, 7.0).x), (1.0, 4.0));
    }

    #[test]
    fn uneven_times_keep_an_even_speed() {
        let knots = knots(&[(0.0, 0.0), (1.0, 1.0), (4.0, 4.0), (4.5, 4.5), (9.0, 9.0)], [0.0; 3]);
        for t in [1.5, 3.9, 4.2] {
            assert!((vector_at(&knots, t).x - t).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn full_tension_stops_at_each_key() {
        let knots = knots(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 3.0)], [1.0, 0.0, 0.0]);
        assert!((vector_at(&knots, 1.25).x - (1.0 + 3.0 / 16.0 - 2.0 / 64.0)).abs() < 1e-12);
    }

    #[test]
    fn keys_at_one_time_are_no_piece() {
        let knots = knots(
            &[(0.0, 5.0), (0.0, 1.0), (1.0, 2.0), (1.0, 7.0), (2.0, 8.0), (2.0, 8.0)],
            [0.0; 3],
        );
        assert!(vector_at(&knots, 0.5).is_finite());
        assert_eq!(vector_at(&knots, 1.0).x, 7.0);
        // A time that falls.
        let falls =
            self::knots(&[(0.0, 0.0), (1.0, 1.0), (5.0, 2.0), (4.0, 3.0), (6.0, 4.0)], [0.0; 3]);
        assert!((0..60).all(|i| vector_at(&falls, f64::from(i) / 10.0).is_finite()));
    }

    #[test]
    fn turns_about_one_axis_are_even() {
        let mut knots: Vec<Knot<DQuat>> = [0.0, 100.0, 200.0, 300.0, 400.0]
            .iter()
            .enumerate()
            .map(|(i, angle): (usize, &f64)| Knot {
                time: i as f64,
                value: DQuat::from_axis_angle(DVec3::Y, angle.to_radians()),
                shape: [0.0; 3],
            })
            .collect();
        align(&mut knots);
        for t in [1.0, 1.3, 2.5, 3.0] {
            let expected = DQuat::from_axis_angle(DVec3::Y, (100.0_f64 * t).to_radians());
            assert!(turn_at(&knots, t).dot(expected).abs() > 1.0 - 1e-9, "{t}");
        }
    }
}
