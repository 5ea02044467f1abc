//! Curved surfaces, tested in f64.
//!
//! Each test first moves the ray's origin along the ray to where it passes the surface's centre, so
//! that the roots keep their digits however far away the ray starts. Source: Haines et al.,
//! *Precision Improvements for Ray/Sphere Intersection*, Ray Tracing Gems, 2019; here in f64, and
//! for cylinders and cones too.

use glam::{DVec2, DVec3, Vec3, swizzles::Vec3Swizzles as _};

use crate::math::Bounds;
use crate::math::rounding::{round_down, round_up};

/// A curved surface. It is not tessellated, and tested in f64. All but the disc are closed.
///
/// Cylinders and cones whose axis has no length are never hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Curved {
    /// A sphere.
    Sphere {
        /// Centre.
        center: Vec3,
        /// More than 0.
        radius: f32,
    },
    /// A cylinder between two discs.
    Cylinder {
        /// Centre of one disc.
        base: Vec3,
        /// Centre of the other disc.
        top: Vec3,
        /// More than 0.
        radius: f32,
    },
    /// A disc.
    Disc {
        /// Centre.
        center: Vec3,
        /// Unit normal.
        normal: Vec3,
        /// More than 0.
        radius: f32,
    },
    /// A cone on a disc.
    Cone {
        /// Centre of the disc.
        base: Vec3,
        /// Tip.
        apex: Vec3,
        /// Radius of the disc; more than 0.
        radius: f32,
    },
}

/// The part of a curved surface that was hit, stored in [`Hits::u`](crate::Hits::u).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The curved side, all of a sphere: 0.
    Side = 0,
    /// The disc at `base`, and a disc that is all of the surface: 1.
    Base = 1,
    /// The disc at `top`: 2.
    Top = 2,
}

impl Part {
    /// The part for a hit's `u`.
    #[inline]
    pub fn from_u(u: f32) -> Self {
        match u {
            1.0 => Self::Base,
            2.0 => Self::Top,
            _ => Self::Side,
        }
    }

    /// The `u` of hits on the part.
    #[inline]
    pub fn to_u(self) -> f32 {
        self as u8 as f32
    }
}

/// A ray in f64, kept apart from the centre it is measured against.
#[derive(Clone, Copy)]
struct Line {
    origin: DVec3,
    direction: DVec3,
}

impl Line {
    /// The same line with its origin moved next to `center` and measured from there, and the t by
    /// which it was moved.
    fn near(self, center: DVec3) -> (Self, f64) {
        let offset = center - self.origin;
        let t = offset.dot(self.direction) / self.direction.length_squared();
        (Self { origin: t * self.direction - offset, ..self }, t)
    }

    fn at(self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// The nearest hit that was offered.
struct Nearest {
    t_max: f32,
    hit: Option<(f32, Part)>,
}

impl Nearest {
    fn offer(&mut self, t: f64, part: Part) {
        let t = t as f32;
        if t > 0.0 && t < self.t_max {
            self.t_max = t;
            self.hit = Some((t, part));
        }
    }
}

impl Curved {
    /// The `t` of the first hit with `0 < t < t_max`, in lengths of the direction, and the part
    /// hit.
    pub fn intersect(&self, origin: Vec3, direction: Vec3, t_max: f32) -> Option<(f32, Part)> {
        let line = Line { origin: origin.as_dvec3(), direction: direction.as_dvec3() };
        let mut nearest = Nearest { t_max, hit: None };
        match *self {
            Self::Sphere { center, radius } => sphere(line, center, radius, &mut nearest),
            Self::Cylinder { base, top, radius } => {
                cylinder(line, base, top, radius, &mut nearest);
            }
            Self::Disc { center, normal, radius } => {
                disc(line, center, normal, radius, &mut nearest);
            }
            Self::Cone { base, apex, radius } => cone(line, base, apex, radius, &mut nearest),
        }
        nearest.hit
    }

    /// The outward unit normal at a point on a part of the surface.
    #[inline]
    pub fn normal_at(&self, point: Vec3, part: Part) -> Vec3 {
        let point = point.as_dvec3();
        let normal = match (*self, part) {
            (Self::Sphere { center, .. }, _) => point - center.as_dvec3(),
            (Self::Disc { normal, .. }, _) => normal.as_dvec3(),
            (Self::Cylinder { base, top, .. }, Part::Base)
            | (Self::Cone { base, apex: top, .. }, Part::Base) => (base - top).as_dvec3(),
            (Self::Cylinder { base, top, .. }, Part::Top) => (top - base).as_dvec3(),
            (Self::Cylinder { base, top, .. }, Part::Side) => {
                let (axis, _) = axis_of(base, top);
                (point - base.as_dvec3()).reject_from_normalized(axis)
            }
            (Self::Cone { base, apex, radius }, _) => {
                let (axis, height) = axis_of(base, apex);
                let outward = (point - base.as_dvec3()).reject_from_normalized(axis);
                outward.normalize_or_zero() * height + axis * f64::from(radius)
            }
        };
        normal.normalize_or(DVec3::Z).as_vec3()
    }

    /// Distance of a point from the part of the surface that it is close to, along the normal;
    /// negative inside.
    #[inline]
    pub fn signed_distance(&self, point: DVec3, part: Part) -> f64 {
        match (*self, part) {
            (Self::Sphere { center, radius }, _) => {
                (point - center.as_dvec3()).length() - f64::from(radius)
            }
            (Self::Disc { center, normal, .. }, _) => {
                (point - center.as_dvec3()).dot(normal.as_dvec3().normalize_or_zero())
            }
            (Self::Cylinder { base, top, .. }, Part::Base)
            | (Self::Cone { base, apex: top, .. }, Part::Base) => {
                (base.as_dvec3() - point).dot(axis_of(base, top).0)
            }
            (Self::Cylinder { base, top, .. }, Part::Top) => {
                (point - top.as_dvec3()).dot(axis_of(base, top).0)
            }
            (Self::Cylinder { base, top, radius }, Part::Side) => {
                let (axis, _) = axis_of(base, top);
                let across = (point - base.as_dvec3()).reject_from_normalized(axis);
                across.length() - f64::from(radius)
            }
            (Self::Cone { base, apex, radius }, _) => {
                let (axis, height) = axis_of(base, apex);
                let below = (apex.as_dvec3() - point).dot(axis);
                let across = (apex.as_dvec3() - point).reject_from_normalized(axis).length();
                let radius = f64::from(radius);
                (across * height - below * radius) / DVec2::new(height, radius).length()
            }
        }
    }

    /// The smallest box about the surface, rounded outward to f32 and kept finite.
    pub fn bounds(&self) -> Bounds {
        match *self {
            Self::Sphere { center, radius } => {
                let (center, radius) = (center.as_dvec3(), DVec3::splat(f64::from(radius)));
                outward(center - radius, center + radius)
            }
            Self::Cylinder { base, top, radius } => {
                let reach = disc_reach(base, top, radius);
                let (base, top) = (base.as_dvec3(), top.as_dvec3());
                outward(base.min(top) - reach, base.max(top) + reach)
            }
            Self::Disc { center, normal, radius } => {
                let reach = disc_reach(Vec3::ZERO, normal, radius);
                let center = center.as_dvec3();
                outward(center - reach, center + reach)
            }
            Self::Cone { base, apex, radius } => {
                let reach = disc_reach(base, apex, radius);
                let (base, apex) = (base.as_dvec3(), apex.as_dvec3());
                outward(apex.min(base - reach), apex.max(base + reach))
            }
        }
    }
}

fn sphere(line: Line, center: Vec3, radius: f32, nearest: &mut Nearest) {
    let (line, t0) = line.near(center.as_dvec3());
    let room = f64::from(radius) * f64::from(radius) - line.origin.length_squared();
    if room >= 0.0 {
        let half = (room / line.direction.length_squared()).sqrt();
        nearest.offer(t0 - half, Part::Side);
        nearest.offer(t0 + half, Part::Side);
    }
}

fn cylinder(line: Line, base: Vec3, top: Vec3, radius: f32, nearest: &mut Nearest) {
    let (axis, height) = axis_of(base, top);
    let (line, t0) = line.near(base.as_dvec3());
    let (rise, slope) = (line.origin.dot(axis), line.direction.dot(axis));
    let (across, drift) = (line.origin - rise * axis, line.direction - slope * axis);
    let square = f64::from(radius) * f64::from(radius);
    let roots = roots(drift.length_squared(), across.dot(drift), across.length_squared() - square);
    for t in roots {
        let s = rise + t * slope;
        if 0.0 <= s && s <= height {
            nearest.offer(t0 + t, Part::Side);
        }
    }
    for (s, part) in [(0.0, Part::Base), (height, Part::Top)] {
        let t = (s - rise) / slope;
        if (across + t * drift).length_squared() <= square {
            nearest.offer(t0 + t, part);
        }
    }
}

fn disc(line: Line, center: Vec3, normal: Vec3, radius: f32, nearest: &mut Nearest) {
    let (axis, _) = axis_of(Vec3::ZERO, normal);
    let (line, t0) = line.near(center.as_dvec3());
    let t = -line.origin.dot(axis) / line.direction.dot(axis);
    if line.at(t).length_squared() <= f64::from(radius) * f64::from(radius) {
        nearest.offer(t0 + t, Part::Base);
    }
}

fn cone(line: Line, base: Vec3, apex: Vec3, radius: f32, nearest: &mut Nearest) {
    let (axis, height) = axis_of(apex, base);
    let (line, t0) = line.near(apex.as_dvec3());
    let (fall, slope) = (line.origin.dot(axis), line.direction.dot(axis));
    let (across, drift) = (line.origin - fall * axis, line.direction - slope * axis);
    let spread = f64::from(radius) / height;
    let square = spread * spread;
    let roots = roots(
        drift.length_squared() - square * slope * slope,
        across.dot(drift) - square * fall * slope,
        across.length_squared() - square * fall * fall,
    );
    for t in roots {
        let s = fall + t * slope;
        if 0.0 <= s && s <= height {
            nearest.offer(t0 + t, Part::Side);
        }
    }
    let t = (height - fall) / slope;
    let from_base = line.at(t) - height * axis;
    if from_base.length_squared() <= f64::from(radius) * f64::from(radius) {
        nearest.offer(t0 + t, Part::Base);
    }
}

/// The roots of `a t^2 + 2 b t + c`; NaN unless they are real, infinite or NaN if `a` is 0.
fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let q = -(b + (b * b - a * c).sqrt().copysign(b));
    [q / a, c / q]
}

/// Unit vector from one point to another, and their distance. The vector is NaN if the points are
/// the same, so such a surface has no hits.
#[inline]
fn axis_of(from: Vec3, to: Vec3) -> (DVec3, f64) {
    let axis = to.as_dvec3() - from.as_dvec3();
    let length = axis.length();
    (axis / length, length)
}

/// How far a disc across the axis `from..to` reaches along x, y, and z.
fn disc_reach(from: Vec3, to: Vec3, radius: f32) -> DVec3 {
    let (axis, height) = axis_of(from, to);
    let sine = if height > 0.0 {
        DVec3::new(axis.yz().length(), axis.zx().length(), axis.xy().length())
    } else {
        DVec3::ONE
    };
    // One part in 2^40 more covers the rounding of the sine.
    sine * (f64::from(radius) * (1.0 + 1.0 / (1u64 << 40) as f64))
}

fn outward(min: DVec3, max: DVec3) -> Bounds {
    Bounds {
        min: Vec3::from_array(min.to_array().map(round_down)),
        max: Vec3::from_array(max.to_array().map(round_up)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    const SPHERE: Curved = Curved::Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 0.5 };
    const CYLINDER: Curved = Curved::Cylinder { base: Vec3::ZERO, top: Vec3::Z, radius: 0.5 };
    const CONE: Curved = Curved::Cone { base: Vec3::ZERO, apex: Vec3::Z, radius: 0.5 };
    const INF: f32 = f32::INFINITY;

    #[test]
    fn both_roots_of_a_sphere() {
        let origin = Vec3::new(1.0, 2.0, 0.0);
        assert_eq!(SPHERE.intersect(origin, Vec3::Z, INF), Some((2.5, Part::Side)));
        assert_eq!(SPHERE.intersect(origin, 0.5 * Vec3::Z, INF), Some((5.0, Part::Side)));
        let inside = Vec3::new(1.0, 2.0, 3.0);
        assert_eq!(SPHERE.intersect(inside, Vec3::Z, INF), Some((0.5, Part::Side)));
        assert_eq!(SPHERE.intersect(inside, Vec3::Z, 0.5), None);
        assert_eq!(SPHERE.intersect(origin, Vec3::NEG_Z, INF), None);
        assert_eq!(SPHERE.intersect(origin, Vec3::X, INF), None);
    }

    #[test]
    fn parts_of_a_cylinder() {
        let cases = [
            (Vec3::new(0.1, 0.0, 3.0), Vec3::NEG_Z, Some((2.0, Part::Top))),
            (Vec3::new(0.1, 0.0, -3.0), Vec3::Z, Some((3.0, Part::Base))),
            (Vec3::new(-2.0, 0.0, 0.5), Vec3::X, Some((1.5, Part::Side))),
            (Vec3::new(0.1, 0.0, 0.5), Vec3::Z, Some((0.5, Part::Top))),
            (Vec3::new(-2.0, 0.0, 1.5), Vec3::X, None),
            (Vec3::new(0.6, 0.0, 3.0), Vec3::NEG_Z, None),
        ];
        for (origin, direction, expected) in cases {
            assert_eq!(CYLINDER.intersect(origin, direction, INF), expected, "{origin}");
        }
    }

    #[test]
    fn parts_of_a_cone() {
        let cases = [
            (Vec3::new(0.1, 0.0, -3.0), Vec3::Z, Some((3.0, Part::Base))),
            (Vec3::new(-2.0, 0.0, 0.5), Vec3::X, Some((1.75, Part::Side))),
            (Vec3::new(0.25, 0.0, 3.0), Vec3::NEG_Z, Some((2.5, Part::Side))),
            (Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z, Some((0.5, Part::Base))),
            (Vec3::new(-2.0, 0.0, 1.25), Vec3::X, None),
        ];
        for (origin, direction, expected) in cases {
            assert_eq!(CONE.intersect(origin, direction, INF), expected, "{origin}");
        }
    }

    #[test]
    fn a_disc_is_hit_from_both_sides() {
        let disc = Curved::Disc { center: Vec3::X, normal: Vec3::Z, radius: 0.5 };
        let cases = [
            (Vec3::new(1.4, 0.0, 3.0), Vec3::NEG_Z, Some((3.0, Part::Base))),
            (Vec3::new(1.0, 0.4, -2.0), Vec3::Z, Some((2.0, Part::Base))),
            (Vec3::new(1.4, 0.4, 3.0), Vec3::NEG_Z, None),
            (Vec3::new(0.0, 0.0, 0.0), Vec3::X, None),
            (Vec3::new(1.0, 0.0, 3.0), Vec3::Z, None),
        ];
        for (origin, direction, expected) in cases {
            assert_eq!(disc.intersect(origin, direction, INF), expected, "{origin}");
        }
        let bounds = disc.bounds();
        assert!((bounds.min - Vec3::new(0.5, -0.5, 0.0)).abs().max_element() < 1e-6);
        assert!((bounds.max - Vec3::new(1.5, 0.5, 0.0)).abs().max_element() < 1e-6);
        assert_eq!(disc.normal_at(Vec3::X, Part::Base), Vec3::Z);
        assert_eq!(disc.signed_distance(DVec3::new(1.0, 0.2, 2.0), Part::Base), 2.0);
    }

    #[test]
    fn axis_of_no_length_is_not_hit() {
        for flat in [
            Curved::Disc { center: Vec3::X, normal: Vec3::ZERO, radius: 1.0 },
            Curved::Cylinder { base: Vec3::X, top: Vec3::X, radius: 1.0 },
            Curved::Cone { base: Vec3::X, apex: Vec3::X, radius: 1.0 },
        ] {
            assert_eq!(flat.intersect(Vec3::new(1.0, 0.1, 5.0), Vec3::NEG_Z, INF), None);
            assert!(!flat.bounds().is_empty());
        }
    }

    #[test]
    fn far_origins_keep_their_digits() {
        let direction = Vec3::new(1.0, 1.0, 0.0);
        let origin = Vec3::new(-1e6 + 1.0, -1e6 + 2.0, 3.0);
        let (t, _) = SPHERE.intersect(origin, direction, INF).unwrap();
        assert!((t - 1e6).abs() < 0.5);
        let grazing = origin + Vec3::new(0.0, 0.0, 0.53);
        assert_eq!(SPHERE.intersect(grazing, direction, INF), None);
    }

    /// Hits lie on the surface and in its box; normals lean against rays from outside.
    #[test]
    fn random_hits_agree_with_box_and_normal() {
        let mut rng = StdRng::seed_from_u64(11);
        let mut point = || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        for i in 0..30_000 {
            let (base, top, radius) = (point(), point(), point().x.abs() + 0.01);
            let shape = match i % 4 {
                0 => Curved::Sphere { center: base, radius },
                3 => Curved::Disc { center: base, normal: top.normalize(), radius },
                1 => Curved::Cylinder { base, top, radius },
                _ => Curved::Cone { base, apex: top, radius },
            };
            let (origin, direction) = (6.0 * point().normalize(), point());
            let direction = 2.0 * direction - origin;
            let Some((t, part)) = shape.intersect(origin, direction, INF) else { continue };
            let hit = origin + t * direction;
            let bounds = shape.bounds();
            let slack = Vec3::splat(1e-5);
            assert!(hit.cmpge(bounds.min - slack).all() && hit.cmple(bounds.max + slack).all());
            let outside = hit - 1e-3 * direction;
            if outside.cmplt(bounds.min).any() || outside.cmpgt(bounds.max).any() {
                continue;
            }
            let normal = shape.normal_at(hit, part);
            assert!((normal.length() - 1.0).abs() < 1e-6);
            let is_closed = !matches!(shape, Curved::Disc { .. });
            assert!(
                !is_closed || normal.dot(direction) <= 1e-2 * direction.length(),
                "{shape:?} {part:?}"
            );
        }
    }

    #[test]
    fn boxes_are_tight() {
        let b = CYLINDER.bounds();
        assert!((b.min - Vec3::new(-0.5, -0.5, 0.0)).abs().max_element() < 1e-6);
        assert!((b.max - Vec3::new(0.5, 0.5, 1.0)).abs().max_element() < 1e-6);
        assert!((CONE.bounds().max.x - 0.5).abs() < 1e-6);
        let huge = Curved::Sphere { center: Vec3::ZERO, radius: f32::MAX };
        assert!(huge.bounds().max.is_finite());
    }
}
