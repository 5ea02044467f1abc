//! Camera rays: a thin lens, moving through the shutter.

use glam::{DVec3, Vec3};

use crate::sampling::batch::CameraSamples;
use crate::sampling::{CameraSample, warp};
use slo_accel::math::columns::{Column, Vec3s, lanes};
use slo_scene::animation::View;

/// Why nothing can be rendered from a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DegenerateView {
    /// Position and target coincide.
    NoDirection,
    /// The sky is zero or parallel to the direction of view.
    SkyAlongView,
}

/// One sampled view in render space, scaled such that a ray is a sum of products.
#[derive(Clone, Copy, Debug)]
struct Pose {
    position: Vec3,
    /// Unit direction of view.
    forward: Vec3,
    /// Half width and half height of the view at distance 1, as vectors to the right and up.
    half_right: Vec3,
    half_up: Vec3,
    /// Vectors of the lens radius to the right and up.
    lens_right: Vec3,
    lens_up: Vec3,
    /// 1 / distance of the plane in focus; 0 for a pinhole.
    inverse_dof: f32,
}

impl Pose {
    /// Vector from the middle of the lens to a point of the film, at distance 1 along the view; not
    /// unit.
    #[inline(always)]
    fn through(&self, [film_x, film_y]: [f32; 2]) -> Vec3 {
        self.forward + self.half_right * film_x + self.half_up * film_y
    }

    /// Interpolates every number linearly: `self` at `x` = 0, `other` at `x` = 1.
    #[inline(always)]
    fn lerp(&self, other: &Self, x: f32) -> Self {
        let v = |a: Vec3, b: Vec3| a + (b - a) * x;
        Self {
            position: v(self.position, other.position),
            forward: v(self.forward, other.forward),
            half_right: v(self.half_right, other.half_right),
            half_up: v(self.half_up, other.half_up),
            lens_right: v(self.lens_right, other.lens_right),
            lens_up: v(self.lens_up, other.lens_up),
            inverse_dof: self.inverse_dof + (other.inverse_dof - self.inverse_dof) * x,
        }
    }
}

/// The camera during one shutter, in render space.
///
/// It interpolates linearly between sampled views.
#[derive(Clone, Debug)]
pub struct Camera {
    poses: Vec<Pose>,
    width: u32,
    height: u32,
}

impl Camera {
    /// Creates a camera from one or more views, in scene space, that are spaced evenly over the
    /// shutter. `origin` is the origin of render space in scene space; width and height are in
    /// pixels.
    ///
    /// # Errors
    /// Fails if nothing can be seen from one of the views.
    pub fn new(
        views: &[View],
        origin: DVec3,
        width: u32,
        height: u32,
    ) -> Result<Self, DegenerateView> {
        let ratio = f64::from(width) / f64::from(height);
        let poses =
            views.iter().map(|view| pose(view, origin, ratio)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { poses, width, height })
    }

    /// Width of the picture in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the picture in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Middle of the lens when the shutter opens, in render space.
    pub(crate) fn position(&self) -> Vec3 {
        self.poses[0].position
    }

    /// Angle that a pixel in the middle of the picture spans, radians.
    pub(crate) fn pixel_angle(&self) -> f32 {
        2.0 * self.poses[0].half_up.length() / self.height as f32
    }

    /// Returns the distance of a point, in render space, along the view at a shutter time.
    pub(crate) fn depth(&self, time: f32, point: Vec3) -> f32 {
        let pose = self.pose_at(time);
        // Between two views, the direction is a little shorter than 1.
        pose.forward.dot(point - pose.position) / pose.forward.length()
    }

    /// Whether rays start at more than one point, so that the lens dimensions of a sample matter.
    pub(crate) fn has_lens(&self) -> bool {
        self.poses.iter().any(|pose| pose.lens_right != Vec3::ZERO)
    }

    /// Returns the origin and unit direction, in render space, of the ray of one sample of the
    /// pixel in column `x` and row `y` (downward).
    ///
    /// Source: thesis 5.6 to 5.9, divided by the distance of the plane in focus, so that a pinhole
    /// needs no such distance.
    #[inline(always)]
    pub fn ray(&self, x: u32, y: u32, sample: &CameraSample) -> (Vec3, Vec3) {
        self.ray_of(&self.pose_at(sample.time), x, y, sample)
    }

    /// Computes [`ray`](Self::ray) for a batch of samples of the given pixels.
    #[inline(always)]
    pub(crate) fn rays(
        &self,
        [x, y]: [&Column<u32>; 2],
        samples: &CameraSamples,
        [origins, directions]: [&mut Vec3s; 2],
        len: usize,
    ) {
        // The same loop three times: in the first two, constants stay in registers.
        if let [pose] = *self.poses
            && !self.has_lens()
        {
            for i in lanes(len) {
                let direction = pose.through(self.on_film(x[i], y[i], samples.get(i).pixel));
                origins.set(i, pose.position);
                directions.set(i, direction * (1.0 / direction.length()));
            }
        } else if let [pose] = *self.poses {
            for i in lanes(len) {
                let (origin, direction) = self.ray_of(&pose, x[i], y[i], &samples.get(i));
                origins.set(i, origin);
                directions.set(i, direction);
            }
        } else {
            for i in lanes(len) {
                let (origin, direction) = self.ray(x[i], y[i], &samples.get(i));
                origins.set(i, origin);
                directions.set(i, direction);
            }
        }
    }

    #[inline(always)]
    fn ray_of(&self, pose: &Pose, x: u32, y: u32, sample: &CameraSample) -> (Vec3, Vec3) {
        let [u, v] = warp::concentric_disc(sample.lens);
        let offset = pose.lens_right * u + pose.lens_up * v;
        let through = pose.through(self.on_film(x, y, sample.pixel));
        let direction = through - offset * pose.inverse_dof;
        (pose.position + offset, direction * (1.0 / direction.length()))
    }

    /// Position of a point of a pixel on the film: from -1 to 1, to the right and up.
    #[inline(always)]
    fn on_film(&self, x: u32, y: u32, [in_x, in_y]: [f32; 2]) -> [f32; 2] {
        let film_x = 2.0 * (x as f32 + in_x) / self.width as f32 - 1.0;
        let film_y = 1.0 - 2.0 * (y as f32 + in_y) / self.height as f32;
        [film_x, film_y]
    }

    #[inline(always)]
    fn pose_at(&self, time: f32) -> Pose {
        if self.poses.len() == 1 {
            return self.poses[0];
        }
        let last = self.poses.len() - 1;
        let at = time * last as f32;
        let i = (at as usize).min(last - 1);
        self.poses[i].lerp(&self.poses[i + 1], at - i as f32)
    }
}

fn pose(view: &View, origin: DVec3, ratio: f64) -> Result<Pose, DegenerateView> {
    let forward =
        (view.target - view.position).try_normalize().ok_or(DegenerateView::NoDirection)?;
    let sky = view.sky.try_normalize().ok_or(DegenerateView::SkyAlongView)?;
    let side = forward.cross(sky);
    // Below this length, rounding errors dominate the product.
    if side.length() < 1e-12 {
        return Err(DegenerateView::SkyAlongView);
    }
    let right = side.normalize();
    let up = right.cross(forward);
    Ok(Pose {
        position: (view.position - origin).as_vec3(),
        forward: forward.as_vec3(),
        half_right: (right * ratio * view.fov).as_vec3(),
        half_up: (up * view.fov).as_vec3(),
        lens_right: (right * view.lens_radius).as_vec3(),
        lens_up: (up * view.lens_radius).as_vec3(),
        inverse_dof: if view.lens_radius > 0.0 { (1.0 / view.dof) as f32 } else { 0.0 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: View = View {
        position: DVec3::new(0.0, -10.0, 2.0),
        target: DVec3::new(0.0, 0.0, 2.0),
        sky: DVec3::Z,
        fov: 0.5,
        dof: 10.0,
        lens_radius: 1.0,
    };

    fn sample(pixel: [f32; 2], lens: [f32; 2]) -> CameraSample {
        CameraSample { pixel, time: 0.0, lens }
    }

    #[test]
    fn x_grows_to_the_right_and_y_downward() {
        let camera = Camera::new(&[VIEW], DVec3::ZERO, 200, 100).unwrap();
        let direction = |x, y| camera.ray(x, y, &sample([0.0, 0.0], [0.5, 0.5])).1;
        let corner = direction(0, 0);
        // Half height 0.5 and half width 1 at distance 1.
        assert!((corner / corner.y - Vec3::new(-1.0, 1.0, 0.5)).length() < 1e-6, "{corner}");
        let center = direction(100, 50);
        assert!((center - Vec3::Y).length() < 1e-6, "{center}");
    }

    #[test]
    fn rays_of_one_film_point_meet_in_the_sharp_plane() {
        let camera = Camera::new(&[VIEW], DVec3::ZERO, 200, 100).unwrap();
        for lens in [[0.5, 0.5], [0.0, 0.3], [0.99, 0.99], [0.2, 0.8]] {
            let (o, d) = camera.ray(150, 20, &sample([0.5, 0.5], lens));
            let at = o + d * ((0.0 - o.y) / d.y);
            let expected = Vec3::new(10.0 * 0.505, 0.0, 2.0 + 10.0 * 0.5 * 0.59);
            assert!((at - expected).length() < 1e-4, "{lens:?}: {at}");
            assert!((o - Vec3::new(0.0, -10.0, 2.0)).length() <= 1.0 + 1e-6);
        }
    }

    #[test]
    fn a_moving_camera_is_interpolated() {
        let moved = View { position: VIEW.position + DVec3::X * 4.0, ..VIEW };
        let moved = View { target: VIEW.target + DVec3::X * 4.0, ..moved };
        let camera = Camera::new(&[VIEW, moved], DVec3::ZERO, 200, 100).unwrap();
        for (time, x) in [(0.0, 0.0), (0.25, 1.0), (0.999_999, 4.0)] {
            let sample = CameraSample { pixel: [0.0; 2], time, lens: [0.5; 2] };
            assert!((camera.ray(100, 50, &sample).0.x - x).abs() < 1e-4);
        }
    }

    #[test]
    fn degenerate_views_are_refused() {
        let blind = View { target: VIEW.position, ..VIEW };
        let rolled = View { sky: DVec3::Y, ..VIEW };
        let of = |view| Camera::new(&[view], DVec3::ZERO, 1, 1).err();
        assert_eq!(of(blind), Some(DegenerateView::NoDirection));
        assert_eq!(of(rolled), Some(DegenerateView::SkyAlongView));
    }
}
