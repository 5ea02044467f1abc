//! Positions of objects and of the camera, from docs/rendering.md, "Camera" and "Animation".

use glam::{DMat3, DVec3};

use slo_render::sampling::CameraSample;
use slo_scene::{KeyFrame, SceneDescription};

use super::solid::Ray;

/// A placement: x -> rotation x + translation.
#[derive(Clone, Copy)]
pub(super) struct Pose {
    pub(super) rotation: DMat3,
    pub(super) translation: DVec3,
}

impl Pose {
    /// Transforms a ray to the space of the placed object.
    pub(super) fn inverse(&self, ray: &Ray) -> Ray {
        let back = self.rotation.transpose();
        Ray {
            origin: back * (ray.origin - self.translation),
            direction: back * ray.direction,
            time: ray.time,
        }
    }
}

/// The shutter of one frame.
#[derive(Clone, Copy)]
pub(super) struct Shutter {
    opens: f64,
    duration: f64,
    video: [f64; 2],
    scene: [f64; 2],
    /// Poses of a moving object.
    samples: f64,
}

impl Shutter {
    /// Creates the shutter of a frame of a scene with one segment.
    pub(super) fn new(scene: &SceneDescription, frame: i64) -> Self {
        let segment = &scene.camera.segments[0];
        let duration = segment.blur_duration;
        let asked = (scene.settings.transform_samples_per_ms * duration * 1e3).ceil();
        Self {
            opens: frame as f64 / scene.camera.fps,
            duration,
            video: segment.video,
            scene: segment.scene,
            samples: asked.clamp(2.0, 16384.0),
        }
    }

    /// Returns the share of the segment that has passed at a shutter time. It stops at the
    /// segment's end.
    fn parameter(&self, time: f64) -> f64 {
        let along = self.opens + self.duration * time - self.video[0];
        (along / (self.video[1] - self.video[0])).clamp(0.0, 1.0)
    }

    /// Returns the placement of an object for a ray: the nearest of its samples.
    pub(super) fn pose(&self, keys: &[KeyFrame], time: f64) -> Pose {
        let last = self.samples - 1.0;
        let sampled = (time * last + 0.5).floor() / last;
        pose(keys, mix(self.scene[0], self.scene[1], self.parameter(sampled)))
    }
}

fn mix(a: f64, b: f64, u: f64) -> f64 {
    a + (b - a) * u
}

/// Evaluates a Bézier curve of any degree, by definition.
fn bezier(points: &[DVec3], u: f64) -> DVec3 {
    match points {
        [point] => *point,
        [.., _] => {
            let (left, right) = (&points[..points.len() - 1], &points[1..]);
            bezier(left, u) * (1.0 - u) + bezier(right, u) * u
        }
        [] => unreachable!("curves have points"),
    }
}

/// Pivot, up and right of every key. Missing values are taken from the key before.
fn complete(keys: &[KeyFrame]) -> Vec<[DVec3; 3]> {
    let mut last = [DVec3::ZERO, DVec3::Z, DVec3::X];
    let fill = |key: &KeyFrame| {
        let given = [key.key.pivot, key.key.up, key.key.right];
        last = std::array::from_fn(|i| given[i].unwrap_or(last[i]));
        last
    };
    keys.iter().map(fill).collect()
}

/// Returns the pose of an object at a scene time.
fn pose(keys: &[KeyFrame], time: f64) -> Pose {
    let controls = complete(keys);
    let [translation, up, right] = match keys.iter().position(|key| key.time > time) {
        _ if keys.is_empty() => [DVec3::ZERO, DVec3::Z, DVec3::X],
        Some(0) => controls[0],
        None => controls[keys.len() - 1],
        Some(next) => {
            let (from, to) = (&keys[next - 1], &keys[next]);
            let u = (time - from.time) / (to.time - from.time);
            let nex = [from.nex.pivot, from.nex.up, from.nex.right];
            let pre = [to.pre.pivot, to.pre.up, to.pre.right];
            std::array::from_fn(|i| {
                let (p, q) = (controls[next - 1][i], controls[next][i]);
                let third = (q - p) / 3.0;
                bezier(&[p, nex[i].unwrap_or(p + third), pre[i].unwrap_or(q - third), q], u)
            })
        }
    };
    let right = right.normalize();
    let up = (up - right * up.dot(right)).normalize();
    Pose { rotation: DMat3::from_cols(right, up.cross(right), up), translation }
}

/// Returns the ray of a camera sample of the pixel in column `x` and row `y`: (5.6) to (5.9).
pub(super) fn camera_ray(
    scene: &SceneDescription,
    shutter: &Shutter,
    [x, y]: [u32; 2],
    sample: &CameraSample,
) -> Ray {
    let (segment, film) = (&scene.camera.segments[0], &scene.camera.film);
    let [width, height] = [film.width, film.height].map(f64::from);
    let time = f64::from(sample.time);
    let parameter = shutter.parameter(time);
    let number = |[start, end]: [f64; 2]| mix(start, end, parameter);
    let position = bezier(&segment.positions, parameter);
    let d = (bezier(&segment.targets, parameter) - position).normalize();
    let r = d.cross(bezier(&segment.sky, parameter)).normalize();
    let u = r.cross(d);
    let film_x = 2.0 * (f64::from(x) + f64::from(sample.pixel[0])) / width - 1.0;
    let film_y = 1.0 - 2.0 * (f64::from(y) + f64::from(sample.pixel[1])) / height;
    let fov = number(segment.fov);
    let through = d + r * (film_x * fov * width / height) + u * (film_y * fov);
    let lens_radius = number(segment.lens_radius);
    let lens = disc(sample.lens.map(f64::from)).map(|c| c * lens_radius);
    let offset = r * lens[0] + u * lens[1];
    let sharp = if lens_radius > 0.0 { number(segment.dof) } else { 1.0 };
    let direction = (through * sharp - offset).normalize();
    Ray { origin: position + offset, direction, time }
}

/// Maps the unit square to the unit disc by Shirley's concentric map.
fn disc(u: [f64; 2]) -> [f64; 2] {
    let [a, b] = u.map(|c| 2.0 * c - 1.0);
    let quarter = std::f64::consts::FRAC_PI_4;
    let (radius, angle) = match (a, b) {
        (0.0, 0.0) => (0.0, 0.0),
        _ if a.abs() >= b.abs() => (a, quarter * b / a),
        _ => (b, quarter * (2.0 - a / b)),
    };
    [radius * libm::cos(angle), radius * libm::sin(angle)]
}
