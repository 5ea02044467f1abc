//! Cameras and lights.

use glam::{DQuat, DVec3};

use super::ROOT;
use super::state::State;
use super::tree::Node;
use crate::model::{Camera, Lamp, LampKind, Model, Pose, Space, View};
use crate::view::SIZE;

/// How many times its own size from the middle of a scene lights stand that are infinitely far.
const FAR: f64 = 1000.0;

/// Tangent of half the angle of view of a distant camera.
const NARROW: f64 = 0.05;

/// A light in the scene.
#[derive(Clone, Copy, Debug)]
struct Light {
    color: DVec3,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Point(DVec3),
    /// The direction in which it shines.
    Distant(DVec3),
    /// Position, direction, half the angle of the cone, and how fast it falls off to its rim.
    Spot(DVec3, DVec3, f64, f64),
}

/// Lights, and the first camera.
#[derive(Debug, Default)]
pub(super) struct Seen {
    lights: Vec<Light>,
    camera: Option<Camera>,
}

impl Seen {
    /// Notes a camera or a light. Returns whether the node is one.
    pub(super) fn add(&mut self, node: &Node, state: &State, model: &mut Model) -> bool {
        let matrix = model.matrix(Some(ROOT), 0.0) * state.matrix;
        let point = |name, usual| matrix.transform_point3(node.vector(name, usual));
        let direction = || {
            let direction = node.vector("direction", DVec3::NEG_Z);
            matrix.transform_vector3(direction).normalize_or(DVec3::NEG_Z)
        };
        let kind = match node.class.as_str() {
            "PointLight" => Kind::Point(point("location", DVec3::Z)),
            "DirectionalLight" => Kind::Distant(direction()),
            "SpotLight" => {
                let angle = node.number("cutOffAngle", std::f64::consts::FRAC_PI_4);
                let angle = angle.clamp(1e-3, std::f64::consts::FRAC_PI_2);
                let drop = node.number("dropOffRate", 0.0);
                Kind::Spot(point("location", DVec3::Z), direction(), angle, drop)
            }
            "PerspectiveCamera" | "OrthographicCamera" => {
                self.see(node, state, model);
                return true;
            }
            _ => return false,
        };
        if node.flag("on", true) {
            let color = node.vector("color", DVec3::ONE) * node.number("intensity", 1.0);
            self.lights.push(Light { color: color.max(DVec3::ZERO), kind });
        }
        true
    }

    fn see(&mut self, node: &Node, state: &State, model: &mut Model) {
        if self.camera.is_some() {
            model.notes.leave_out("a further camera");
            return;
        }
        let matrix = model.matrix(Some(ROOT), 0.0) * state.matrix;
        let turn = node.turn("orientation");
        let mut position = matrix.transform_point3(node.vector("position", DVec3::Z));
        let ahead = matrix.transform_vector3(turn * DVec3::NEG_Z).normalize_or(DVec3::Y);
        let up = matrix.transform_vector3(turn * DVec3::Y).normalize_or(DVec3::Z);
        let mut distance = node.number("focalDistance", 5.0).max(1e-6);
        let mut fov = libm::tan(node.number("heightAngle", std::f64::consts::FRAC_PI_4) / 2.0);
        if node.class == "OrthographicCamera" {
            model.notes.leave_out("an orthographic camera, which became a distant one");
            let away = node.number("height", 2.0).abs() / 2.0 / NARROW;
            position += ahead * (distance - away);
            (fov, distance) = (NARROW, away);
        }
        let aspect = node.numbers("aspectRatio").and_then(|numbers| numbers.first().copied());
        let width = aspect.map_or(f64::from(SIZE[0]), |aspect| f64::from(SIZE[1]) * aspect);
        let size = [width.round().clamp(16.0, 16384.0) as u32, SIZE[1]];
        let view = View { position, target: position + ahead * distance, up };
        let can_see =
            fov.is_finite() && fov > 0.0 && view.position != view.target && position.is_finite();
        self.camera = can_see.then(|| Camera { size, fov, views: vec![view] });
    }

    /// Gives the model its lights, and a camera in front of everything if the file has none.
    pub(super) fn finish(self, model: &mut Model) {
        let Self { lights, camera } = self;
        let [least, most] = model.bounds().unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
        let (middle, radius) = ((least + most) / 2.0, ((most - least).length() / 2.0).max(1e-6));
        for Light { color, kind } in lights {
            let lamp = match kind {
                Kind::Point(position) => classical(color, position),
                Kind::Distant(direction) => classical(color, middle - direction * radius * FAR),
                Kind::Spot(position, direction, angle, drop) => {
                    model.notes.leave_out("that a spot light does not fall off with distance");
                    let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, direction);
                    let pose = Pose { pivot: position, turn, scale: DVec3::ONE };
                    model.spaces.push(Space::still("spot".into(), None, pose));
                    spot(
                        color,
                        (middle - position).length().max(radius),
                        angle,
                        drop,
                        model.spaces.len() - 1,
                    )
                }
            };
            model.lamps.push(lamp);
        }
        model.camera = camera.or_else(|| {
            model.notes.made_up.push("a camera that sees everything".into());
            let half = std::f64::consts::FRAC_PI_8;
            // The ball around everything touches the edges of the view.
            let position = middle - DVec3::Y * radius / libm::sin(half);
            let view = View { position, target: middle, up: DVec3::Z };
            Some(Camera { size: SIZE, fov: libm::tan(half), views: vec![view] })
        });
    }
}

fn classical(color: DVec3, position: DVec3) -> Lamp {
    let kind = LampKind::Classical { color: color.to_array(), position };
    Lamp { name: "light".into(), space: None, kind }
}

/// A lamp that falls off, and is as bright as the light at a distance.
fn spot(color: DVec3, distance: f64, angle: f64, drop: f64, space: usize) -> Lamp {
    let cone = (1.0 - libm::cos(angle)) / 2.0;
    let intensity = std::f64::consts::PI * distance * distance;
    let power = color * intensity * 4.0 * std::f64::consts::PI * cone;
    let kind = LampKind::Spot {
        power: power.to_array(),
        angle_deg: (2.0 * angle).to_degrees(),
        blend: (drop * 10.0).clamp(0.0, 1.0),
    };
    Lamp { name: "spot".into(), space: Some(space), kind }
}
