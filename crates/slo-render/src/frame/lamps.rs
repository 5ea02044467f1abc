//! Lamps in spaces that stretch: a lamp follows their places and directions, and the sides of a lamp
//! with an area follow their lengths. Its power stays.

use glam::{DMat3, DVec3};

use slo_scene::animation::DAffine;
use slo_scene::shape::Rectangle;
use slo_scene::{Light, LightKind};

/// Cosine, and share of a length, by which a lamp's shape may change without notice.
const TOLERANCE: f64 = 1e-3;

/// Why a lamp cannot be where its space takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampFault {
    /// A rectangle would have no right angles any more, or a disc would be oval.
    Sheared,
    /// Its size would change while the shutter is open.
    Grows,
}

/// Returns a lamp of the size that it has in the spaces of all of `poses`, and the rigid poses that
/// take it there.
pub(super) fn carried(
    light: &Light,
    poses: &[DAffine],
) -> Result<(Light, Vec<DAffine>), LampFault> {
    let frame = Frame::of(&light.kind);
    let mut lengths: Option<[f64; 2]> = None;
    let mut rigid = Vec::with_capacity(poses.len());
    for pose in poses {
        let [along, across] = frame.sides.map(|side| pose.linear * side);
        let [a, b] = [along, across].map(DVec3::length);
        if frame.has_area {
            let cosine = |[a, b]: [DVec3; 2]| a.dot(b) / (a.length() * b.length());
            let is_oval = frame.is_round && !is_near(a, b);
            if (cosine([along, across]) - cosine(frame.sides)).abs() > TOLERANCE || is_oval {
                return Err(LampFault::Sheared);
            }
            let [first, second] = *lengths.get_or_insert([a, b]);
            if !is_near(first, a) || !is_near(second, b) {
                return Err(LampFault::Grows);
            }
        }
        let linear = axes([along, across]) * axes(frame.sides).transpose();
        let translation = pose.point(frame.center) - linear * frame.center;
        rigid.push(DAffine { linear, translation, growth: Some(1.0) });
    }
    let mut light = light.clone();
    if let Some(lengths) = lengths {
        let [a, b] = [0, 1].map(|side| lengths[side] / frame.sides[side].length());
        grow(&mut light.kind, [a, b], &frame);
    }
    Ok((light, rigid))
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * a.max(b)
}

/// Returns orthonormal axes, the first along the first side, the second in the plane of both.
fn axes([along, across]: [DVec3; 2]) -> DMat3 {
    let x = along.normalize_or(DVec3::X);
    let y = (across - x * x.dot(across)).normalize_or(x.any_orthonormal_vector());
    DMat3::from_cols(x, y, x.cross(y))
}

/// Where a lamp is in its own space, and which way it faces.
struct Frame {
    center: DVec3,
    /// The sides of a lamp with an area; otherwise the direction in which the lamp shines, and
    /// another one.
    sides: [DVec3; 2],
    has_area: bool,
    is_round: bool,
}

impl Frame {
    fn of(kind: &LightKind) -> Self {
        match kind {
            LightKind::Point(lamp) => Self::toward(lamp.position, DVec3::Z),
            LightKind::PointLamp(lamp) => Self::toward(lamp.position, DVec3::Z),
            LightKind::SpotLamp(lamp) => Self::toward(lamp.position, lamp.axis),
            LightKind::SunLamp(lamp) => Self::toward(DVec3::ZERO, lamp.direction),
            LightKind::Environment(_) => Self::toward(DVec3::ZERO, DVec3::Z),
            LightKind::Rectangle(lamp) => Self::flat(&lamp.rectangle),
            LightKind::RectangleLamp(lamp) => Self::flat(&lamp.rectangle),
            LightKind::DiscLamp(lamp) => {
                let (along, across) = lamp.normal.any_orthonormal_pair();
                let sides = [along, across];
                Self { center: lamp.center, sides, has_area: true, is_round: true }
            }
        }
    }

    fn toward(center: DVec3, direction: DVec3) -> Self {
        let sides = [direction, direction.normalize_or(DVec3::Z).any_orthonormal_vector()];
        Self { center, sides, has_area: false, is_round: false }
    }

    fn flat(rectangle: &Rectangle) -> Self {
        let [v0, v1, v2] = rectangle.vertices;
        let center = (v0 + v2) * 0.5;
        Self { center, sides: [v0 - v1, v2 - v1], has_area: true, is_round: false }
    }
}

/// Makes the sides of a lamp with an area longer by these factors. Its power stays.
fn grow(kind: &mut LightKind, [a, b]: [f64; 2], frame: &Frame) {
    let dimmed = |radiance: [f32; 3]| radiance.map(|c| (f64::from(c) / (a * b)) as f32);
    let rectangle = || {
        let [along, across] = [frame.sides[0] * a, frame.sides[1] * b];
        let v1 = frame.center - (along + across) * 0.5;
        Rectangle { vertices: [v1 + along, v1, v1 + across] }
    };
    match kind {
        LightKind::Rectangle(lamp) => lamp.rectangle = rectangle(),
        LightKind::RectangleLamp(lamp) => {
            lamp.rectangle = rectangle();
            lamp.radiance = dimmed(lamp.radiance);
        }
        LightKind::DiscLamp(lamp) => {
            lamp.radius *= a;
            lamp.radiance = dimmed(lamp.radiance);
        }
        LightKind::Point(_)
        | LightKind::PointLamp(_)
        | LightKind::SpotLamp(_)
        | LightKind::SunLamp(_)
        | LightKind::Environment(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slo_scene::animation::DRigid;
    use slo_scene::light::{DiscLamp, RectangleLamp, SpotLamp};

    fn pose(scale: DVec3, angle: f64) -> DAffine {
        let rotation = DMat3::from_rotation_z(angle);
        DAffine::scaled(scale, DRigid { rotation, translation: DVec3::new(1.0, 2.0, 3.0) })
    }

    #[test]
    fn a_rectangle_has_its_corners_where_the_space_takes_them() {
        let vertices = [DVec3::new(4.0, 1.0, 0.0), DVec3::ONE, DVec3::new(1.0, 6.0, 1.0)]
            .map(|v| DVec3::new(v.x, v.y, 1.0));
        let lamp = RectangleLamp {
            radiance: [6.0; 3],
            rectangle: Rectangle { vertices },
            two_sided: false,
        };
        let light = Light::new("l", LightKind::RectangleLamp(lamp));
        let poses = [0.0, 0.4, 2.0].map(|angle| pose(DVec3::new(2.0, 3.0, 0.2), angle));
        let (carried, rigid) = super::carried(&light, &poses).unwrap();
        let LightKind::RectangleLamp(lamp) = carried.kind else { panic!("another kind") };
        for (pose, rigid) in poses.iter().zip(&rigid) {
            for (before, after) in vertices.into_iter().zip(lamp.rectangle.vertices) {
                assert!((pose.point(before) - rigid.point(after)).length() < 1e-12);
            }
        }
        assert_eq!(lamp.radiance, [1.0; 3]); // 2 x 3 times the area
        // Turned first and stretched then, it has no right angle.
        let sheared = pose(DVec3::new(2.0, 1.0, 1.0), 0.0).after(&pose(DVec3::ONE, 0.7));
        assert_eq!(super::carried(&light, &[sheared]).unwrap_err(), LampFault::Sheared);
        let growing = [1.0, 1.1].map(|scale| pose(DVec3::splat(scale), 0.0));
        assert_eq!(super::carried(&light, &growing).unwrap_err(), LampFault::Grows);
    }

    #[test]
    fn a_disc_stays_round_and_a_spot_keeps_its_size() {
        let normal = DVec3::new(0.6, 0.0, 0.8);
        let center = DVec3::new(1.0, 0.0, 0.0);
        let disc = DiscLamp { radiance: [4.0; 3], center, normal, radius: 3.0, two_sided: false };
        let light = Light::new("l", LightKind::DiscLamp(disc));
        let large = pose(DVec3::splat(2.0), 0.3);
        let (carried, rigid) = super::carried(&light, &[large]).unwrap();
        let LightKind::DiscLamp(lamp) = carried.kind else { panic!("another kind") };
        assert!((lamp.radius - 6.0).abs() < 1e-12 && lamp.radiance == [1.0; 3]);
        let turned = rigid[0].linear * normal - large.linear * normal / 2.0;
        assert!(turned.length() < 1e-12);
        assert!((rigid[0].point(center) - large.point(center)).length() < 1e-12);
        let oval = pose(DVec3::new(1.0, 2.0, 1.0), 0.0);
        assert_eq!(super::carried(&light, &[oval]).unwrap_err(), LampFault::Sheared);

        let spot = SpotLamp {
            power: [1.0; 3],
            position: center,
            radius: 0.5,
            axis: normal,
            angle_deg: 30.0,
            blend: 0.0,
        };
        let light = Light::new("l", LightKind::SpotLamp(spot));
        let poses = [oval, pose(DVec3::new(9.0, 1.0, 1.0), 1.0)];
        let (carried, rigid) = super::carried(&light, &poses).unwrap();
        let LightKind::SpotLamp(lamp) = carried.kind else { panic!("another kind") };
        assert_eq!((lamp.radius, lamp.power), (0.5, [1.0; 3]));
        for (pose, rigid) in poses.iter().zip(&rigid) {
            assert!((pose.point(center) - rigid.point(center)).length() < 1e-12);
            let direction = (pose.linear * normal).normalize();
            assert!((rigid.linear * normal - direction).length() < 1e-12);
        }
    }
}
