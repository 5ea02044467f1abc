//! Objects: spheres, open cones and flat polygons of any number of corners, each with its test.

use slo_accel::glam::{DVec2, DVec3};
use slo_accel::math::Bounds;

/// How a surface continues rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Fill {
    pub(crate) reflects: bool,
    pub(crate) transmits: bool,
    /// Index of refraction.
    pub(crate) ior: f64,
}

/// An object and its material.
#[derive(Debug)]
pub(crate) struct Object {
    pub(crate) shape: Shape,
    pub(crate) fill: Fill,
}

#[derive(Debug)]
pub(crate) enum Shape {
    Sphere { center: DVec3, radius: f64 },
    Cone(Cone),
    Polygon(Polygon),
}

/// The side of a cone or of a cylinder.
#[derive(Debug)]
pub(crate) struct Cone {
    base: DVec3,
    /// Unit vector toward the apex.
    axis: DVec3,
    length: f64,
    base_radius: f64,
    /// By how much the radius changes along the axis.
    slope: f64,
}

/// A flat polygon. Its corners run counter-clockwise as seen from its front.
#[derive(Debug)]
pub(crate) struct Polygon {
    corners: Vec<DVec3>,
    /// One for each corner, or none.
    normals: Vec<DVec3>,
    normal: DVec3,
    /// The two axes on which the polygon is the largest.
    axes: [usize; 2],
    flat: Vec<DVec2>,
}

/// A ray in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
}

impl Shape {
    pub(crate) fn sphere(center: DVec3, radius: f64) -> Self {
        Self::Sphere { center, radius }
    }

    pub(crate) fn cone(base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) -> Self {
        let length = base.distance(apex);
        let axis = (apex - base) / length;
        let slope = (apex_radius - base_radius) / length;
        Self::Cone(Cone { base, axis, length, base_radius, slope })
    }

    /// A polygon, or nothing if it has no area.
    pub(crate) fn polygon(corners: Vec<DVec3>, normals: Vec<DVec3>) -> Option<Self> {
        let count = corners.len();
        let edges =
            (0..count).map(|i| (corners[i] - corners[0], corners[(i + 1) % count] - corners[0]));
        let normal = edges.map(|(a, b)| a.cross(b)).sum::<DVec3>().try_normalize()?;
        let [x, y, z] = normal.abs().to_array();
        let axes = if x > y && x > z {
            [1, 2]
        } else if y > z {
            [0, 2]
        } else {
            [0, 1]
        };
        let flat = corners.iter().map(|corner| flat(*corner, axes)).collect();
        Some(Self::Polygon(Polygon { corners, normals, normal, axes, flat }))
    }

    /// The smallest box about the object.
    pub(crate) fn bounds(&self) -> Bounds {
        let [min, max] = match self {
            Self::Sphere { center, radius } => [*center - *radius, *center + *radius],
            Self::Cone(cone) => {
                // A disc reaches as far along an axis of space as the sine of the angle to its own.
                let reach = (DVec3::ONE - cone.axis * cone.axis).max(DVec3::ZERO).map(f64::sqrt);
                let ends = [0.0, cone.length].map(|along| {
                    let center = cone.base + cone.axis * along;
                    let reach = reach * (cone.base_radius + cone.slope * along);
                    [center - reach, center + reach]
                });
                [ends[0][0].min(ends[1][0]), ends[0][1].max(ends[1][1])]
            }
            Self::Polygon(polygon) => {
                let first = polygon.corners[0];
                let all = polygon.corners.iter();
                all.fold([first; 2], |[min, max], corner| [min.min(*corner), max.max(*corner)])
            }
        };
        Bounds { min: min.as_vec3(), max: max.as_vec3() }
    }

    /// The first t between `least` and `most` at which a ray hits the object.
    pub(crate) fn hit(&self, ray: &Ray, least: f64, most: f64) -> Option<f64> {
        match self {
            Self::Sphere { center, radius } => {
                let from = ray.origin - *center;
                let a = ray.direction.length_squared();
                let b = ray.direction.dot(from);
                let c = from.length_squared() - radius * radius;
                roots(a, b, c)?.into_iter().find(|&t| t > least && t < most)
            }
            Self::Cone(cone) => {
                let from = ray.origin - cone.base;
                let (along, height) = (ray.direction.dot(cone.axis), from.dot(cone.axis));
                let (across, beside) =
                    (ray.direction - cone.axis * along, from - cone.axis * height);
                let radius = cone.base_radius + cone.slope * height;
                let widening = cone.slope * along;
                let a = across.length_squared() - widening * widening;
                let b = across.dot(beside) - radius * widening;
                let c = beside.length_squared() - radius * radius;
                let inside = |t: &f64| (0.0..=cone.length).contains(&(height + t * along));
                roots(a, b, c)?.into_iter().find(|t| *t > least && *t < most && inside(t))
            }
            Self::Polygon(polygon) => {
                let toward = polygon.normal.dot(ray.direction);
                let t = polygon.normal.dot(polygon.corners[0] - ray.origin) / toward;
                let hits = t > least && t < most && polygon.holds(ray.origin + ray.direction * t);
                hits.then_some(t)
            }
        }
    }

    /// The outward normals at a point of the surface: of the shape, and as it is shaded.
    pub(crate) fn normals(&self, point: DVec3) -> [DVec3; 2] {
        match self {
            Self::Sphere { center, .. } => [(point - *center).normalize_or_zero(); 2],
            Self::Cone(cone) => {
                let from = point - cone.base;
                let beside = (from - cone.axis * from.dot(cone.axis)).normalize_or_zero();
                [(beside - cone.axis * cone.slope).normalize_or_zero(); 2]
            }
            Self::Polygon(polygon) => [polygon.normal, polygon.shaded(point)],
        }
    }
}

/// The roots of `a t^2 + 2 b t + c`, the smaller one first.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || a == 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let [s, t] = if q == 0.0 { [0.0, 0.0] } else { [q / a, c / q] };
    Some([s.min(t), s.max(t)])
}

fn flat(point: DVec3, [u, v]: [usize; 2]) -> DVec2 {
    DVec2::new(point[u], point[v])
}

impl Polygon {
    /// Whether a point of the plane is inside: a line from it crosses an odd number of edges.
    fn holds(&self, point: DVec3) -> bool {
        let point = flat(point, self.axes);
        let mut before = self.flat[self.flat.len() - 1];
        let mut inside = false;
        for &corner in &self.flat {
            if (corner.y > point.y) != (before.y > point.y) {
                let share = (point.y - corner.y) / (before.y - corner.y);
                inside ^= point.x < corner.x + share * (before.x - corner.x);
            }
            before = corner;
        }
        inside
    }

    /// The normal of a triangle whose corners have normals, interpolated.
    fn shaded(&self, point: DVec3) -> DVec3 {
        let (&[a, b, c], &[na, nb, nc]) = (&self.corners[..], &self.normals[..]) else {
            return self.normal;
        };
        let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(self.normal);
        let mixed = na * area(point, b, c) + nb * area(point, c, a) + nc * area(point, a, b);
        mixed.try_normalize().unwrap_or(self.normal)
    }
}
