//! The camera sampled over one shutter, densely enough for linear interpolation.

use slo_scene::animation::{Shutter, View, axes, between, view_at};
use slo_scene::{CamSegment, Film};

use super::sampled::{MAX_SAMPLES, least_count, time_of};

/// Largest error, in pixels at the distance of the camera's target, of a camera interpolated
/// between neighbouring samples (half a pixel for objects eight times nearer).
const MAX_ERROR_PX: f64 = 1.0 / 16.0;

/// The camera at evenly spaced shutter times.
#[derive(Clone, Debug)]
pub(super) struct SampledCamera {
    views: Vec<View>,
    aspect: f64,
    height_px: f64,
}

impl SampledCamera {
    /// Samples the camera over a shutter. A camera at rest gets one sample. A moving camera gets at
    /// least two samples, at least `samples_per_ms` for every millisecond of video time that the
    /// shutter is open, and enough that linear interpolation between neighbours deviates from the
    /// path by at most a sixteenth of a pixel at the distance of the target, but never more than
    /// [`MAX_SAMPLES`].
    pub(super) fn new(
        segment: &CamSegment,
        shutter: &Shutter,
        film: &Film,
        samples_per_ms: f64,
    ) -> Self {
        let aspect = f64::from(film.width) / f64::from(film.height);
        let height_px = f64::from(film.height);
        let view = |s: f64| view_at(segment, shutter.segment_parameter(s));
        if rests(segment, shutter) {
            return Self { views: vec![view(0.0)], aspect, height_px };
        }
        let mut count = least_count(shutter, samples_per_ms);
        loop {
            let views = (0..count).map(|k| view(time_of(k, count))).collect();
            let camera = Self { views, aspect, height_px };
            if count == MAX_SAMPLES || camera.interpolates(view) {
                return camera;
            }
            count = (2 * count).min(MAX_SAMPLES);
        }
    }

    /// The sampled views, in scene space. View `k` of `n` is at shutter time `k / (n - 1)`.
    pub(super) fn views(&self) -> &[View] {
        &self.views
    }

    /// Returns the camera at a shutter time, interpolated linearly between samples.
    pub(super) fn at(&self, time: f64) -> View {
        if let [rest] = self.views[..] {
            return rest;
        }
        let place = time.clamp(0.0, 1.0) * (self.views.len() - 1) as f64;
        let k = (place as usize).min(self.views.len() - 2);
        between(&self.views[k], &self.views[k + 1], place - k as f64)
    }

    /// Whether the camera interpolated half way between samples is close enough to the path.
    fn interpolates(&self, view: impl Fn(f64) -> View) -> bool {
        (1..self.views.len()).all(|k| {
            let middle = between(&self.views[k - 1], &self.views[k], 0.5);
            let exact = view((k as f64 - 0.5) / (self.views.len() - 1) as f64);
            middle == exact || self.difference_px(&middle, &exact) <= MAX_ERROR_PX
        })
    }

    /// Estimates how far apart, in pixels, two cameras see a point at the distance of the target.
    fn difference_px(&self, a: &View, b: &View) -> f64 {
        let (Some(axes_a), Some(axes_b)) = (axes(a), axes(b)) else { return 0.0 };
        let turn = (0..3).map(|i| (axes_a[i] - axes_b[i]).length()).fold(0.0, f64::max);
        let shift = (a.position - b.position).length() / (b.target - b.position).length();
        (turn + shift) * self.px_per_radian(b)
    }

    /// Returns the pixels per radian where the picture is stretched most, in its corners: 1 / cos^2
    /// of the angle there, times height / (2 fov).
    pub(super) fn px_per_radian(&self, view: &View) -> f64 {
        let corner = view.fov * view.fov * (1.0 + self.aspect * self.aspect);
        (1.0 + corner) * self.height_px / (2.0 * view.fov)
    }
}

/// Whether the view stays the same during the whole shutter.
fn rests(segment: &CamSegment, shutter: &Shutter) -> bool {
    fn same<T: PartialEq>(controls: &[T]) -> bool {
        controls.windows(2).all(|pair| pair[0] == pair[1])
    }
    let vectors = [&segment.positions[..], &segment.targets, &segment.sky];
    let numbers = [segment.fov, segment.dof, segment.lens_radius];
    shutter.segment_parameter(0.0) == shutter.segment_parameter(1.0)
        || vectors.iter().all(|controls| same(controls)) && numbers.iter().all(|ends| same(ends))
}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec3;

    use slo_scene::Camera;
    use slo_scene::animation::Clock;

    use super::*;

    /// A segment of one second with a view from (0, -10, 0) to the origin.
    fn segment() -> CamSegment {
        CamSegment {
            name: "s".into(),
            video: [0.0, 1.0],
            scene: [0.0, 1.0],
            positions: vec![DVec3::new(0.0, -10.0, 0.0)],
            targets: vec![DVec3::ZERO],
            sky: [DVec3::Z; 2],
            fov: [0.5; 2],
            dof: [10.0; 2],
            lens_radius: [0.0; 2],
            blur_duration: 0.0,
        }
    }

    /// A camera with one frame per second of 100 x 100 pixels.
    fn camera(segment: CamSegment) -> Camera {
        let mut film = Film::default();
        (film.width, film.height) = (100, 100);
        Camera { fps: 1.0, film, segments: vec![segment] }
    }

    /// A second of scene time over a second of shutter, seen from (0, -10, 0), half height 0.5,
    /// in a picture of 100 x 100.
    pub(in crate::frame) fn shutter_and_camera(
        change: impl FnOnce(&mut CamSegment),
    ) -> (Shutter, SampledCamera) {
        let mut segment = segment();
        segment.blur_duration = 1.0;
        change(&mut segment);
        let camera = camera(segment.clone());
        let shutter = Clock::new(&camera).shutter(0).unwrap();
        let sampled = SampledCamera::new(&segment, &shutter, &camera.film, 0.0);
        (shutter, sampled)
    }

    /// Position at which a camera sees a point, in pixels of a picture of `height` pixels.
    pub(in crate::frame) fn seen(camera: &View, point: DVec3, height: f64) -> [f64; 2] {
        let [right, up, forward] = axes(camera).unwrap();
        let p = point - camera.position;
        [right, up].map(|axis| axis.dot(p) / forward.dot(p) / camera.fov * height / 2.0)
    }

    #[test]
    fn a_camera_in_straight_even_motion_needs_two_samples() {
        let (_, camera) = shutter_and_camera(|s| {
            s.positions = vec![DVec3::new(0.0, -10.0, 0.0), DVec3::new(5.0, -9.0, 1.0)];
            s.targets = vec![DVec3::ZERO, DVec3::X];
        });
        assert_eq!(camera.views().len(), 2);
        assert_eq!(camera.at(0.5).position, DVec3::new(2.5, -9.5, 0.5));
        assert_eq!(camera.at(0.5).target, DVec3::new(0.5, 0.0, 0.0));
    }

    #[test]
    fn a_camera_on_a_curve_is_interpolated_within_a_sixteenth_of_a_pixel() {
        let curve = |s: &mut CamSegment| {
            s.positions = vec![
                DVec3::new(-10.0, 0.0, 3.0),
                DVec3::new(-10.0, -14.0, 3.0),
                DVec3::new(10.0, -14.0, 3.0),
                DVec3::new(10.0, 0.0, 3.0),
            ];
            s.sky = [DVec3::Z, DVec3::new(1.0, 0.0, 1.0)];
        };
        let (shutter, camera) = shutter_and_camera(curve);
        let mut segment = segment();
        curve(&mut segment);
        let point = DVec3::new(0.4, 0.1, -0.3);
        for i in 0..=1000 {
            let time = i as f64 / 1000.0;
            let exact = view_at(&segment, shutter.segment_parameter(time));
            let [a, b] = [camera.at(time), exact].map(|pose| seen(&pose, point, 100.0));
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1.0 / 16.0);
        }
        assert!(camera.views().len() < 300, "{}", camera.views().len());
    }

    #[test]
    fn a_camera_that_outlasts_its_segment_stands_still_from_there() {
        let (shutter, camera) = shutter_and_camera(|s| {
            s.video = [0.0, 0.5];
            s.positions = vec![DVec3::new(0.0, -10.0, 0.0), DVec3::new(5.0, -10.0, 0.0)];
        });
        assert_eq!(shutter.scene_interval(), [0.0, 1.0]);
        assert!((camera.at(0.25).position.x - 2.5).abs() < 0.01);
        assert!((camera.at(0.75).position.x - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_camera_at_rest_is_one_view() {
        let (_, camera) = shutter_and_camera(|s| s.positions = vec![s.positions[0]; 4]);
        assert_eq!(camera.views().len(), 1);
        assert_eq!(camera.at(0.3), camera.views()[0]);
        // moving, but the shutter closes at once
        let (_, camera) = shutter_and_camera(|s| {
            s.targets.push(DVec3::X);
            s.blur_duration = 0.0;
        });
        assert_eq!(camera.views().len(), 1);
    }

    #[test]
    fn a_camera_without_a_view_is_sampled_all_the_same() {
        let (_, camera) = shutter_and_camera(|s| {
            s.positions.push(DVec3::X);
            s.targets = s.positions.clone();
        });
        assert_eq!(camera.views().len(), 2);
    }
}
