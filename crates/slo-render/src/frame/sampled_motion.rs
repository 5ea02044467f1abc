//! The poses of an object sampled over one shutter, densely enough that no step between neighbours
//! is visible.

use glam::DVec3;

use slo_scene::animation::{DAffine, Path, Shutter};

use super::sampled::{MAX_SAMPLES, least_count, time_of};
use super::sampled_camera::SampledCamera;

/// Largest distance, in pixels, that a corner of an object's box may move between neighbouring
/// samples.
const MAX_STEP_PX: f64 = 0.5;

/// Distance from which an object counts as seen if its box contains the camera, as a share of the
/// box's diagonal. The distance from the box is 0 then.
const NEAREST_IN_DIAGONALS: f64 = 1.0 / 16.0;

/// Number of intervals between two keys in which the speed of a path is measured.
const PROBES_PER_PIECE: usize = 32;

/// Number of times that each axis is visited in the search for the nearest point of a sheared box.
const SWEEPS: usize = 16;

/// An axis-aligned bounding box of an object in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObjectBox {
    /// Lower corner.
    pub(super) min: DVec3,
    /// Upper corner.
    pub(super) max: DVec3,
}

/// The poses of an object at evenly spaced shutter times.
#[derive(Clone, Debug)]
pub(super) struct SampledMotion {
    poses: Vec<DAffine>,
}

impl SampledMotion {
    /// Samples the path of an object over a shutter. It takes at least two samples, at least
    /// `samples_per_ms` for every millisecond of video time that the shutter is open, and enough
    /// that no point of the object's box moves more than half a pixel between neighbours, wherever
    /// it is in the picture, even if it is seen in a mirror. It never takes more than
    /// [`MAX_SAMPLES`].
    ///
    /// Jumps of the path ([`Path::jumps`]) do not count as steps. A box that contains the
    /// camera counts as seen from a sixteenth of its diagonal away.
    pub(super) fn new(
        path: &Path,
        shutter: &Shutter,
        object: &ObjectBox,
        camera: &SampledCamera,
        samples_per_ms: f64,
    ) -> Self {
        let watch = Watch::new(path, shutter, object, camera);
        let mut count = least_count(shutter, samples_per_ms).max(watch.estimate());
        loop {
            let poses: Vec<DAffine> =
                (0..count).map(|k| path.pose(shutter.scene_time(time_of(k, count)))).collect();
            let step = watch.largest_step_px(&poses);
            if count == MAX_SAMPLES || step <= MAX_STEP_PX {
                return Self { poses };
            }
            count = raised(count, (step / MAX_STEP_PX).max(1.25));
        }
    }

    /// The sampled poses, `scene_from_object`. Pose `k` of `n` is at shutter time `k / (n - 1)`.
    pub(super) fn into_poses(self) -> Vec<DAffine> {
        self.poses
    }
}

impl ObjectBox {
    /// Returns the bounding box of points.
    pub(super) fn about(points: impl Iterator<Item = DVec3>) -> Self {
        let nothing = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        points.fold(nothing, |all, p| Self { min: all.min.min(p), max: all.max.max(p) })
    }

    /// Returns the point in the middle.
    pub(super) fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Returns the eight corners.
    pub(super) fn corners(&self) -> [DVec3; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
    }

    /// Returns the distance of a point in object space from the box; 0 inside.
    fn distance(&self, p: DVec3) -> f64 {
        (p - p.clamp(self.min, self.max)).length()
    }

    /// Returns the distance of a point in scene space from the box in a pose; 0 inside.
    fn distance_in(&self, pose: &DAffine, p: DVec3) -> f64 {
        let way = p - pose.translation;
        if pose.is_rigid() {
            return self.distance(pose.linear.transpose() * way);
        }
        // Axis by axis: exact at once if the images of the axes are perpendicular.
        let axes = [pose.linear.x_axis, pose.linear.y_axis, pose.linear.z_axis];
        let mut nearest = (pose.linear.inverse() * way).clamp(self.min, self.max);
        for _ in 0..SWEEPS {
            for (k, axis) in axes.iter().enumerate() {
                let step = axis.dot(way - pose.linear * nearest) / axis.length_squared();
                nearest[k] = (nearest[k] + step).clamp(self.min[k], self.max[k]);
            }
        }
        (way - pose.linear * nearest).length()
    }
}

/// Measures motion in pixels.
struct Watch<'a> {
    path: &'a Path,
    shutter: &'a Shutter,
    object: &'a ObjectBox,
    corners: [DVec3; 8],
    camera: &'a SampledCamera,
    /// Shutter times at which the path jumps.
    jumps: Vec<f64>,
}

impl<'a> Watch<'a> {
    fn new(
        path: &'a Path,
        shutter: &'a Shutter,
        object: &'a ObjectBox,
        camera: &'a SampledCamera,
    ) -> Self {
        let jumps = path.jumps(shutter.scene_interval());
        let jumps = jumps.filter_map(|time| shutter.shutter_time_of(time)).collect();
        Self { path, shutter, object, corners: object.corners(), camera, jumps }
    }

    /// Estimates the number of samples from the highest speed in any piece of the path.
    fn estimate(&self) -> usize {
        let mut borders = vec![0.0, 1.0];
        let inside = self.path.key_times_within(self.shutter.scene_interval());
        borders.extend(inside.filter_map(|time| self.shutter.shutter_time_of(time)));
        borders.sort_by(f64::total_cmp);
        let speed = borders.windows(2).map(|w| self.largest_speed(w[0], w[1])).fold(0.0, f64::max);
        raised(1, speed / MAX_STEP_PX)
    }

    /// Returns the highest speed between two shutter times, in pixels per shutter; 0 if all motion
    /// between them is short enough for a single step.
    fn largest_speed(&self, from: f64, to: f64) -> f64 {
        let width = (to - from) / PROBES_PER_PIECE as f64;
        let pose = |s: f64| self.path.pose(self.shutter.scene_time(s));
        let mut before = pose(from);
        let (mut speed, mut length) = (0.0_f64, 0.0);
        for i in 1..=PROBES_PER_PIECE {
            let s = from + i as f64 * width;
            let after = pose(s);
            if width > 0.0 && !self.leaps_between(s - width, s) {
                let step = self.step_px(&before, &after, s);
                speed = speed.max(step / width);
                length += step;
            }
            before = after;
        }
        if length > MAX_STEP_PX { speed } else { 0.0 }
    }

    /// Returns the largest distance, in pixels, that a corner moves between neighbouring poses.
    fn largest_step_px(&self, poses: &[DAffine]) -> f64 {
        let time = |k| time_of(k, poses.len());
        (1..poses.len())
            .filter(|&k| !self.leaps_between(time(k - 1), time(k)))
            .map(|k| self.step_px(&poses[k - 1], &poses[k], time(k)))
            .fold(0.0, f64::max)
    }

    fn leaps_between(&self, from: f64, to: f64) -> bool {
        let rounding = 1e-9;
        self.jumps.iter().any(|&jump| from - rounding <= jump && jump <= to + rounding)
    }

    /// Returns the distance, in pixels, between two poses as seen by the camera at a shutter time;
    /// infinite if it cannot be determined.
    fn step_px(&self, a: &DAffine, b: &DAffine, time: f64) -> f64 {
        let moved = |corner: &DVec3| (b.point(*corner) - a.point(*corner)).length();
        let step = self.corners.iter().map(moved).fold(0.0, f64::max);
        if step == 0.0 {
            return 0.0;
        }
        let camera = self.camera.at(time);
        let diagonal = self.object.max - self.object.min;
        let growth = if b.is_rigid() { 1.0 } else { libm::cbrt(b.linear.determinant()) };
        let nearest = diagonal.length() * NEAREST_IN_DIAGONALS * growth;
        let distance = self.object.distance_in(b, camera.position);
        let distance = if distance > 0.0 { distance } else { nearest };
        let px = step / distance * self.camera.px_per_radian(&camera);
        if px.is_finite() { px } else { f64::INFINITY }
    }
}

/// Multiplies the number of intervals between `count` samples by `factor`, rounded up, and returns
/// the number of samples.
fn raised(count: usize, factor: f64) -> usize {
    let intervals = (count.max(2) - 1) as f64 * factor;
    (intervals.ceil() as usize).saturating_add(1).clamp(2, MAX_SAMPLES)
}

#[cfg(test)]
mod tests {
    use super::super::sampled_camera::tests::{seen, shutter_and_camera};
    use super::*;
    use glam::DMat3;
    use slo_scene::animation::{DRigid, Spaces};
    use slo_scene::{KeyFrame, Placement};

    const UNIT_BOX: ObjectBox = ObjectBox { min: DVec3::splat(-0.5), max: DVec3::splat(0.5) };

    fn key(time: f64, pivot: DVec3, right: DVec3) -> KeyFrame {
        let key = Placement { pivot: Some(pivot), right: Some(right), ..Placement::default() };
        KeyFrame { time, key, ..KeyFrame::default() }
    }

    fn path_of(keys: &[KeyFrame]) -> Path {
        Spaces::default().path(keys, None).unwrap()
    }

    fn slide(from: DVec3, to: DVec3) -> Path {
        path_of(&[key(0.0, from, DVec3::X), key(1.0, to, DVec3::X)])
    }

    #[test]
    fn a_slide_gets_a_sample_for_every_half_pixel() {
        // 2 units at a distance of at least 9.5 (the box's front). A pixel is 9.5 x 2 x 0.5 / 100
        // there, so the slide is 21.05 pixels, and 1.5 times that in the corner of the picture.
        let (shutter, camera) = shutter_and_camera(|_| ());
        let path = slide(DVec3::NEG_X, DVec3::X);
        let count = SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, 0.0).poses.len();
        assert!((64..=70).contains(&count), "{count}");
    }

    #[test]
    fn the_samples_asked_for_are_a_lower_bound_in_video_time() {
        // A shutter of 1 s covers 1 s or 1000 s of scene time. Only video time counts.
        for scene_end in [1.0, 1000.0] {
            let (shutter, camera) = shutter_and_camera(|s| s.scene = [0.0, scene_end]);
            let path = slide(DVec3::ZERO, DVec3::X * 1e-3);
            let count = |per_ms| {
                SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, per_ms).poses.len()
            };
            assert_eq!(count(0.0), 2);
            assert_eq!(count(0.25), 250);
            assert_eq!(count(2.0), 2000);
            assert_eq!(count(1e9), MAX_SAMPLES);
        }
    }

    /// Largest step of a corner on the picture between neighbouring samples, in pixels.
    fn largest_step(motion: &SampledMotion, object: &ObjectBox, camera: &SampledCamera) -> f64 {
        let n = motion.poses.len();
        let mut largest = 0.0_f64;
        for k in 1..n {
            let camera = camera.at(time_of(k, n));
            for corner in object.corners() {
                let [a, b] =
                    [k - 1, k].map(|k| seen(&camera, motion.poses[k].point(corner), 100.0));
                largest = largest.max((a[0] - b[0]).hypot(a[1] - b[1]));
            }
        }
        largest
    }

    #[test]
    fn no_corner_moves_more_than_half_a_pixel() {
        let far = DVec3::new(3.0, 4.0, 1.0);
        let bent = KeyFrame {
            nex: Placement { pivot: Some(DVec3::new(9.0, -5.0, 3.0)), ..Placement::default() },
            ..key(0.0, -far, DVec3::X)
        };
        let paths = [
            vec![key(0.0, -far, DVec3::X), key(1.0, far, DVec3::X)],
            vec![key(0.0, -far, DVec3::X), key(1.0, far, DVec3::new(-1.0, 0.2, 0.0))],
            vec![bent, key(1.0, far, DVec3::Y)],
            vec![key(0.2, far, DVec3::X), key(0.5, -far, DVec3::Y), key(0.9, far, DVec3::NEG_X)],
        ];
        let (shutter, camera) = shutter_and_camera(|s| s.targets = vec![DVec3::ZERO, far]);
        for keys in paths {
            let path = path_of(&keys);
            let motion = SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, 0.0);
            let step = largest_step(&motion, &UNIT_BOX, &camera);
            assert!(step <= 0.5 && step > 0.05, "{step} with {}", motion.poses.len());
        }
    }

    #[test]
    fn a_whole_turn_is_not_mistaken_for_rest() {
        // 16 quarter turns within the shutter: a few samples would all see the same pose.
        let right = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let keys: Vec<_> =
            (0..=16).map(|i| key(i as f64 / 16.0, DVec3::ZERO, right[i % 4])).collect();
        let path = path_of(&keys);
        let (shutter, camera) = shutter_and_camera(|_| ());
        let motion = SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, 0.0);
        let step = largest_step(&motion, &UNIT_BOX, &camera);
        assert!(step <= 0.5 && motion.poses.len() > 16 * 10, "{step}");
    }

    #[test]
    fn boxes_about_and_behind_the_camera_are_sampled_within_the_cap() {
        let (shutter, camera) = shutter_and_camera(|_| ());
        let path = slide(DVec3::NEG_X, DVec3::X);
        let count = |min, max| {
            SampledMotion::new(&path, &shutter, &ObjectBox { min, max }, &camera, 0.0).poses.len()
        };
        // Behind the camera, as far away as the box in front of it.
        let behind = count(DVec3::new(-0.5, -20.5, -0.5), DVec3::new(0.5, -19.5, 0.5));
        assert!((64..=70).contains(&behind), "{behind}");
        // Around the camera: 2 units seen from 2000 sqrt(3) / 16 away, some 1.4 pixels.
        assert_eq!(count(DVec3::splat(-1000.0), DVec3::splat(1000.0)), 4);
        // A flat box with the camera on it, seen from 10 sqrt(2) / 16 away; and a box without any
        // extent.
        assert_eq!(count(DVec3::new(-5.0, -10.0, -5.0), DVec3::new(5.0, -10.0, 5.0)), 680);
        let at_camera = DVec3::new(0.0, -10.0, 0.0);
        assert_eq!(count(at_camera, at_camera), MAX_SAMPLES);
    }

    #[test]
    fn a_leap_costs_no_samples() {
        let (shutter, camera) = shutter_and_camera(|_| ());
        let still = DVec3::ZERO;
        let paths = [
            // A cut, inside the shutter and at its ends.
            vec![key(0.3, still, DVec3::X), key(0.3, DVec3::X * 3.0, DVec3::X)],
            vec![key(1.0, still, DVec3::X), key(1.0, DVec3::X * 3.0, DVec3::X)],
            vec![key(0.0, still, DVec3::X), key(0.0, DVec3::X * 3.0, DVec3::X)],
            // Half a turn in one piece, during which `right` passes through zero.
            vec![key(0.0, still, DVec3::X), key(0.7, still, DVec3::NEG_X)],
        ];
        for keys in paths {
            let path = path_of(&keys);
            let motion = SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, 0.1);
            assert_eq!(motion.poses.len(), 100);
        }
    }

    #[test]
    fn a_ball_that_grows_is_sampled_by_what_its_surface_moves() {
        let (shutter, camera) = shutter_and_camera(|_| ());
        let scaled = |time: f64, scale: f64| {
            let key = Placement { scale: Some(DVec3::splat(scale)), ..Placement::default() };
            KeyFrame { time, key, ..KeyFrame::default() }
        };
        let path = path_of(&[scaled(0.0, 1.0), scaled(1.0, 3.0)]);
        let motion = SampledMotion::new(&path, &shutter, &UNIT_BOX, &camera, 0.0);
        let step = largest_step(&motion, &UNIT_BOX, &camera);
        assert!(step <= 0.5 && step > 0.2, "{step} with {}", motion.poses.len());
    }

    #[test]
    fn distances_from_stretched_boxes() {
        let sides = DVec3::new(3.0, 0.5, 2.0);
        let turn = DMat3::from_axis_angle(DVec3::new(2.0, 1.0, -2.0) / 3.0, 1.1);
        let translation = DVec3::new(4.0, 5.0, 6.0);
        let pose = DAffine::scaled(sides, DRigid { rotation: turn, translation });
        let larger = ObjectBox { min: UNIT_BOX.min * sides, max: UNIT_BOX.max * sides };
        let sheared = pose.after(&DAffine::scaled(
            DVec3::ONE,
            DRigid { rotation: turn, translation: DVec3::ZERO },
        ));
        for p in [DVec3::ZERO, DVec3::new(9.0, -3.0, 2.0), DVec3::new(4.0, 9.0, 6.5)] {
            let expected = larger.distance(turn.transpose() * (p - translation));
            assert!((UNIT_BOX.distance_in(&pose, p) - expected).abs() < 1e-12, "{p}");
            // The nearest of many points of the box.
            let at =
                |i: usize| DVec3::new((i % 41) as f64, (i / 41 % 41) as f64, (i / 1681) as f64);
            let points = (0..41 * 41 * 41).map(|i| sheared.point(at(i) / 40.0 - 0.5));
            let nearest = points.map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
            let found = UNIT_BOX.distance_in(&sheared, p);
            assert!(found <= nearest && found > nearest - 0.05, "{found} {nearest}");
        }
        assert!(UNIT_BOX.distance_in(&sheared, translation) < 1e-12);
    }
}
