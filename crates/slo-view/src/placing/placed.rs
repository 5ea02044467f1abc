//! Where a thing is when the shutter opens.

use glam::{DMat3, DVec3};
use slo_scene::animation::{Clock, DAffine, DRigid, KeyFrames, Spaces};
use slo_scene::{LightKind, Repeat, SceneDescription, Shape, SpaceId};

/// Share by which a box is enlarged before its object's origin counts as outside of it.
const NEAR: f64 = 0.1;

/// Where a thing is when the shutter opens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    /// The map from the thing's own space to its parent's.
    pub(crate) pose: DAffine,
    /// The map from the parent's space to scene space.
    pub(crate) parent: DAffine,
    /// The point that it turns about, and that handles stand at, in its own space.
    pub(crate) anchor: DVec3,
    /// Half the diagonal of the box around it, in scene space; 0 of a point.
    pub(crate) radius: f64,
    /// Scene time.
    pub(crate) time: f64,
}

impl Placed {
    /// Where an object or a lamp is in a frame. `None` if there is none of this name, or the frame has
    /// no time.
    pub(crate) fn of(scene: &SceneDescription, name: &str, frame: i64) -> Option<Self> {
        let shutter = Clock::new(&scene.camera).shutter(frame).ok()?;
        let time = shutter.scene_time(0.0);
        let object = scene.objects.iter().find(|object| object.name == name);
        let light = || scene.lights.iter().find(|light| light.name == name);
        let (key_frames, repeat, parent, bounds, is_file) = match object {
            Some(of) => {
                let is_file = matches!(of.shape, Shape::Mesh(_));
                (&of.key_frames, of.repeat, of.parent, bounds_of(&of.shape), is_file)
            }
            None => {
                let of = light()?;
                (&of.key_frames, of.repeat, of.parent, bounds_of_light(&of.kind)?, false)
            }
        };
        let (pose, parent) = poses(scene, key_frames, repeat, parent, time)?;
        let [min, max] = bounds;
        let middle = (min + max) * 0.5;
        let room = (max - min) * (0.5 + NEAR);
        let holds_origin = middle.abs().cmple(room).all();
        // The origin of a model is where its author wants it to be held.
        let by_origin = holds_origin && (is_file || !key_frames.is_empty());
        let anchor = if by_origin { DVec3::ZERO } else { middle };
        let whole = parent.after(&pose);
        let radius = (whole.linear * (max - min)).length() * 0.5;
        (whole.point(anchor).is_finite() && radius.is_finite()).then_some(Self {
            pose,
            parent,
            anchor,
            radius,
            time,
        })
    }

    /// The point that it turns about, in scene space.
    pub(crate) fn at(&self) -> DVec3 {
        self.parent.after(&self.pose).point(self.anchor)
    }

    /// Its own axes, as unit vectors in scene space.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        let DMat3 { x_axis, y_axis, z_axis } = self.parent.after(&self.pose).linear;
        [
            x_axis.normalize_or(DVec3::X),
            y_axis.normalize_or(DVec3::Y),
            z_axis.normalize_or(DVec3::Z),
        ]
    }

    /// How it is turned in its parent.
    pub(super) fn rotation(&self) -> DMat3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.pose.linear;
        let [x, z] = [x_axis.normalize_or(DVec3::X), z_axis.normalize_or(DVec3::Z)];
        DMat3::from_cols(x, y_axis.normalize_or(z.cross(x)), z)
    }

    /// By how much it is larger along its own axes.
    pub(super) fn scale(&self) -> DVec3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.pose.linear;
        DVec3::new(x_axis.length(), y_axis.length(), z_axis.length())
    }
}

/// The maps of a thing into its parent, and of that into the scene.
fn poses(
    scene: &SceneDescription,
    key_frames: &[slo_scene::KeyFrame],
    repeat: Option<Repeat>,
    parent: Option<SpaceId>,
    time: f64,
) -> Option<(DAffine, DAffine)> {
    let pose = match key_frames.is_empty() {
        true => DAffine::from(DRigid::IDENTITY),
        false => KeyFrames::new(key_frames).ok()?.repeated(repeat).placed(time),
    };
    let spaces = Spaces::new(&scene.spaces).ok()?;
    Some((pose, spaces.path(&[], None, parent).ok()?.pose(time)))
}

/// The least and the greatest coordinates of a shape, in its own space.
pub(crate) fn bounds_of(shape: &Shape) -> [DVec3; 2] {
    let round = |center: DVec3, radius: f64| [center - radius, center + radius];
    let both = |[a, b]: [DVec3; 2], [c, d]: [DVec3; 2]| [a.min(c), b.max(d)];
    match shape {
        Shape::Plane(plane) => [plane.position; 2],
        Shape::Sphere(sphere) => round(sphere.center, sphere.radius),
        Shape::Triangle(triangle) => around(triangle.vertices.iter().copied()),
        Shape::Rectangle(rectangle) => around(rectangle.corners().into_iter()),
        Shape::Box(cuboid) => {
            let [a, b, c] = cuboid.vertices;
            let way = (c - b).cross(a - b).normalize_or_zero() * cuboid.height;
            let base = [a, b, c, a + c - b];
            around(base.into_iter().chain(base.map(|corner| corner + way)))
        }
        Shape::Cylinder(of) => both(round(of.base, of.radius), round(of.top, of.radius)),
        Shape::Cone(of) => both(round(of.base, of.radius), [of.apex; 2]),
        Shape::Mesh(of) => around(of.mesh.positions.iter().copied()),
    }
}

/// The same of a light that has a place.
fn bounds_of_light(light: &LightKind) -> Option<[DVec3; 2]> {
    match light {
        LightKind::Point(of) => Some([of.position; 2]),
        LightKind::PointLamp(of) => Some([of.position; 2]),
        LightKind::SpotLamp(of) => Some([of.position; 2]),
        LightKind::Rectangle(of) => Some(around(of.rectangle.corners().into_iter())),
        LightKind::RectangleLamp(of) => Some(around(of.rectangle.corners().into_iter())),
        LightKind::DiscLamp(of) => Some([of.center; 2]),
        LightKind::SunLamp(_) | LightKind::Environment(_) => None,
    }
}

fn around(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let bounds = points.fold(start, |[min, max], point| [min.min(point), max.max(point)]);
    if bounds[0].is_finite() { bounds } else { [DVec3::ZERO; 2] }
}
