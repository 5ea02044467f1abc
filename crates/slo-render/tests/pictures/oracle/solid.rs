//! Surfaces and their intersections with rays, in f64, tested one after the other.

use glam::{DVec2, DVec3};

use slo_scene::shape::{Cone, Cuboid, Cylinder, Plane, Rectangle, Sphere, Triangle};
use slo_scene::{LightKind, Mesh, Shape};

/// A ray in f64 with a unit direction.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// Shutter time.
    pub(super) time: f64,
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// An intersection of a ray with a surface.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub(super) t: f64,
    /// Unit geometric normal.
    pub(super) outward: DVec3,
    /// Interpolated normal, not unit.
    pub(super) smooth: Option<DVec3>,
    pub(super) uv: DVec2,
    /// Index of the surface among those of its object.
    pub(super) part: usize,
}

/// A surface in object space.
pub(super) enum Solid {
    Triangle { corners: [DVec3; 3], uvs: [DVec2; 3], normals: Option<[DVec3; 3]> },
    Sphere { center: DVec3, radius: f64 },
    Cylinder { base: DVec3, top: DVec3, radius: f64 },
    Cone { base: DVec3, apex: DVec3, radius: f64 },
    Disc { center: DVec3, normal: DVec3, radius: f64 },
}

/// Returns the surfaces of a shape, and whether the shape has no inside.
pub(super) fn solids(shape: &Shape) -> (Vec<Solid>, bool) {
    match *shape {
        Shape::Plane(Plane { normal, position, side }) => {
            let across = if normal.x == 0.0 && normal.y == 0.0 { DVec3::X } else { DVec3::Z };
            let x = across.reject_from(normal).normalize() * side / 2.0;
            let y = normal.normalize().cross(x);
            (rectangle([position - x - y, position + x - y, position + x + y]), true)
        }
        Shape::Triangle(Triangle { vertices }) => {
            let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE];
            (vec![Solid::Triangle { corners: vertices, uvs, normals: None }], true)
        }
        Shape::Rectangle(Rectangle { vertices }) => (rectangle(vertices), true),
        Shape::Box(Cuboid { vertices, height }) => (cuboid(vertices, height), false),
        Shape::Sphere(Sphere { center, radius }) => (vec![Solid::Sphere { center, radius }], false),
        Shape::Cylinder(Cylinder { base, top, radius }) => {
            (vec![Solid::Cylinder { base, top, radius }], false)
        }
        Shape::Cone(Cone { base, apex, radius }) => {
            (vec![Solid::Cone { base, apex, radius }], false)
        }
        Shape::Mesh(ref surface) => (triangles(&surface.mesh, surface.smooth), false),
    }
}

/// Returns the surface of a light, if it has one.
pub(super) fn light_solids(light: &LightKind) -> Vec<Solid> {
    match light {
        LightKind::Point(_) => vec![],
        LightKind::Rectangle(light) => rectangle(light.rectangle.vertices),
        LightKind::RectangleLamp(lamp) => rectangle(lamp.rectangle.vertices),
        LightKind::DiscLamp(lamp) => {
            let (center, normal, radius) = (lamp.center, lamp.normal, lamp.radius);
            vec![Solid::Disc { center, normal, radius }]
        }
        LightKind::PointLamp(lamp) if lamp.radius > 0.0 => {
            vec![Solid::Sphere { center: lamp.position, radius: lamp.radius }]
        }
        LightKind::PointLamp(_)
        | LightKind::SpotLamp(_)
        | LightKind::SunLamp(_)
        | LightKind::Environment(_) => vec![],
    }
}

/// Returns two triangles. uv runs from (0, 0) at the first corner along the second to (1, 1) at the
/// third.
fn rectangle([a, b, c]: [DVec3; 3]) -> Vec<Solid> {
    let half = |corners, middle| {
        let uvs = [DVec2::ZERO, middle, DVec2::ONE];
        Solid::Triangle { corners, uvs, normals: None }
    };
    let other = Solid::Triangle {
        corners: [a, c, a + c - b],
        uvs: [DVec2::ZERO, DVec2::ONE, DVec2::Y],
        normals: None,
    };
    vec![half([a, b, c], DVec2::X), other]
}

/// Returns six rectangles that face away from their common middle. uv is not defined.
fn cuboid([a, b, c]: [DVec3; 3], height: f64) -> Vec<Solid> {
    let up = (c - b).cross(a - b).normalize() * height;
    let d = a + c - b;
    let middle = (a + c + up) / 2.0;
    let sides = [
        [a, b, c],
        [a + up, b + up, c + up],
        [a, b, b + up],
        [b, c, c + up],
        [c, d, d + up],
        [d, a, a + up],
    ];
    let outward = |[p, q, r]: [DVec3; 3]| {
        let faces_away = (q - p).cross(r - p).dot(p - middle) > 0.0;
        rectangle(if faces_away { [p, q, r] } else { [r, q, p] })
    };
    sides.into_iter().flat_map(outward).collect()
}

fn triangles(mesh: &Mesh, smooth: bool) -> Vec<Solid> {
    let face = |(number, corners): (usize, &[u32; 3])| {
        let uvs = mesh.face_uvs.get(number).map_or([DVec2::ZERO; 3], |uvs| {
            uvs.map(|i| DVec2::from_array(mesh.uvs[i as usize].map(f64::from)))
        });
        let normal = |i: u32| DVec3::from_array(mesh.normals[i as usize].map(f64::from));
        Solid::Triangle {
            corners: corners.map(|i| mesh.positions[i as usize]),
            uvs,
            normals: smooth.then(|| corners.map(normal)),
        }
    };
    mesh.faces.iter().enumerate().map(face).collect()
}

impl Solid {
    /// Returns the first intersection beyond distance `least`.
    pub(super) fn meet(&self, ray: &Ray, least: f64) -> Option<Meeting> {
        let all = match *self {
            Self::Triangle { corners, uvs, normals } => triangle(ray, corners, uvs, normals),
            Self::Sphere { center, radius } => sphere(ray, center, radius),
            Self::Cylinder { base, top, radius } => cylinder(ray, base, top, radius),
            Self::Cone { base, apex, radius } => cone(ray, base, apex, radius),
            Self::Disc { center, normal, radius } => disc(ray, center, normal, radius),
        };
        all.into_iter().flatten().filter(|m| m.t > least).min_by(|a, b| a.t.total_cmp(&b.t))
    }
}

/// Intersects a triangle by the method of Möller and Trumbore.
fn triangle(
    ray: &Ray,
    [a, b, c]: [DVec3; 3],
    uvs: [DVec2; 3],
    normals: Option<[DVec3; 3]>,
) -> [Option<Meeting>; 4] {
    let (e, f, s) = (b - a, c - a, ray.origin - a);
    let p = ray.direction.cross(f);
    let q = s.cross(e);
    let determinant = e.dot(p);
    let (u, v) = (s.dot(p) / determinant, ray.direction.dot(q) / determinant);
    let w = 1.0 - u - v;
    let meeting = || Meeting {
        t: f.dot(q) / determinant,
        outward: e.cross(f).normalize(),
        smooth: normals.map(|n| n[0] * w + n[1] * u + n[2] * v),
        uv: uvs[0] * w + uvs[1] * u + uvs[2] * v,
        part: 0,
    };
    [(u >= 0.0 && v >= 0.0 && w >= 0.0).then(meeting), None, None, None]
}

/// Returns the two roots of a t^2 + 2 b t + c; NaN if they are not real.
fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - a * c).sqrt();
    [(-b - root) / a, (-b + root) / a]
}

/// Returns the angle of a point around `axis` in turns, starting at `x`.
fn turns(p: DVec3, axis: DVec3, x: DVec3) -> f64 {
    let turns = libm::atan2(p.dot(axis.cross(x)), p.dot(x)) / std::f64::consts::TAU;
    turns - turns.floor()
}

fn sphere(ray: &Ray, center: DVec3, radius: f64) -> [Option<Meeting>; 4] {
    let from = ray.origin - center;
    let b = from.dot(ray.direction);
    let meeting = |t: f64| {
        let outward = (ray.at(t) - center).normalize();
        let latitude = libm::asin(outward.z.clamp(-1.0, 1.0)) / std::f64::consts::PI;
        let uv = DVec2::new(turns(outward, DVec3::Z, DVec3::X), latitude + 0.5);
        Meeting { t, outward, smooth: None, uv, part: 0 }
    };
    let [near, far] = roots(1.0, b, from.length_squared() - radius * radius);
    let meeting = |t: f64| (!t.is_nan()).then(|| meeting(t));
    [meeting(near), meeting(far), None, None]
}

fn disc(ray: &Ray, center: DVec3, normal: DVec3, radius: f64) -> [Option<Meeting>; 4] {
    let t = normal.dot(center - ray.origin) / normal.dot(ray.direction);
    let is_hit = ray.at(t).distance(center) <= radius;
    let meeting = || Meeting { t, outward: normal, smooth: None, uv: DVec2::ZERO, part: 0 };
    [is_hit.then(meeting), None, None, None]
}

/// The common part of a cylinder and a cone: a ray split into its parts along the axis and across
/// it.
struct Axial {
    axis: DVec3,
    height: f64,
    radius: f64,
    /// Part along the axis: at the origin, and for each unit of length of the ray.
    rise: f64,
    slope: f64,
    /// Part across the axis.
    across: DVec3,
    drift: DVec3,
}

impl Axial {
    fn new(ray: &Ray, base: DVec3, tip: DVec3, radius: f64) -> Self {
        let (axis, from) = ((tip - base).normalize(), ray.origin - base);
        let (rise, slope) = (from.dot(axis), ray.direction.dot(axis));
        Self {
            axis,
            height: (tip - base).length(),
            radius,
            rise,
            slope,
            across: from - axis * rise,
            drift: ray.direction - axis * slope,
        }
    }

    fn x(&self) -> DVec3 {
        let upright = self.axis.x == 0.0 && self.axis.y == 0.0;
        if upright { DVec3::X } else { DVec3::Z.cross(self.axis).normalize() }
    }

    /// Returns an intersection with the side, whose normal is `lean` along the axis for 1 across.
    fn side(&self, t: f64, lean: f64) -> Option<Meeting> {
        let s = self.rise + t * self.slope;
        let across = self.across + self.drift * t;
        let outward = (across.normalize_or_zero() + self.axis * lean).normalize();
        let uv = DVec2::new(turns(across, self.axis, self.x()), s / self.height);
        let inside = 0.0 <= s && s <= self.height;
        inside.then_some(Meeting { t, outward, smooth: None, uv, part: 0 })
    }

    /// Returns an intersection with the disc at height `s`.
    fn disc(&self, s: f64, outward: DVec3) -> Option<Meeting> {
        let t = (s - self.rise) / self.slope;
        let p = self.across + self.drift * t;
        let uv = DVec2::new(p.dot(self.x()), p.dot(self.axis.cross(self.x()))) / self.radius;
        (p.length() <= self.radius).then_some(Meeting {
            t,
            outward,
            smooth: None,
            uv: (uv + DVec2::ONE) / 2.0,
            part: 0,
        })
    }
}

fn cylinder(ray: &Ray, base: DVec3, top: DVec3, radius: f64) -> [Option<Meeting>; 4] {
    let c = Axial::new(ray, base, top, radius);
    let room = c.across.length_squared() - radius * radius;
    let [near, far] = roots(c.drift.length_squared(), c.across.dot(c.drift), room);
    [c.side(near, 0.0), c.side(far, 0.0), c.disc(0.0, -c.axis), c.disc(c.height, c.axis)]
}

fn cone(ray: &Ray, base: DVec3, apex: DVec3, radius: f64) -> [Option<Meeting>; 4] {
    let c = Axial::new(ray, base, apex, radius);
    // At distance x below the apex, the cone's radius is k x.
    let (k, below) = (radius / c.height, c.height - c.rise);
    let [near, far] = roots(
        c.drift.length_squared() - k * k * c.slope * c.slope,
        c.across.dot(c.drift) + k * k * below * c.slope,
        c.across.length_squared() - k * k * below * below,
    );
    [c.side(near, k), c.side(far, k), c.disc(0.0, -c.axis), None]
}
