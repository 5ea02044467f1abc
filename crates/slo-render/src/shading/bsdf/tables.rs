//! Directional albedos of surfaces of microfacets, for the light that single scattering loses and
//! for what layers leave to those below.
//!
//! The tables are integrated when they are first used, in f64 and with nothing but sums, products,
//! quotients and roots: they are the same on every machine.

use std::sync::LazyLock;

use slo_accel::{Isa, Lanewise};

use super::fresnel::between;

/// Nodes of roughness and cosine of the albedo of microfacets that reflect all light.
const FINE: usize = 32;
/// Nodes of roughness, of tables that depend on the index of refraction too.
const ROUGH: usize = 24;
/// Nodes of the root of the cosine of these tables.
const COS: usize = 22;
/// Nodes of the index of refraction of these tables.
const ETA: usize = 16;
/// Nodes of the index of refraction of the table of bodies seen from inside: total reflection makes
/// it vary more.
const ETA_INSIDE: usize = 24;
/// The largest value of [`place`] that has a node of its own.
const LAST: f64 = 0.8;

/// Points to integrate with: for tables of microfacets that reflect all light, and for the others.
const POINTS: [usize; 2] = [256, 256];
/// Points to integrate the table of bodies seen from inside with.
const POINTS_INSIDE: usize = 1024;

/// Where an index of refraction stands among the nodes, 0 to 1; the same for its reciprocal.
#[inline(always)]
fn place(eta: f32) -> f32 {
    let eta = eta.max(1.0 / eta.max(1e-6)).min(1e6);
    ((eta - 1.0) / (eta + 1.0)).sqrt() / LAST as f32
}

/// The index of refraction of a node of `count`, at least 1.
fn index(node: usize, count: usize) -> f64 {
    let root = LAST * node as f64 / (count - 1) as f64;
    (1.0 + root * root) / (1.0 - root * root)
}

/// The albedos; see the functions for their meaning.
#[derive(Debug)]
pub(super) struct Tables {
    single: [[f32; FINE]; FINE],
    mean: [f32; FINE],
    /// Differences from smooth surfaces, which are smaller and smoother than what they correct.
    curve: [[[f32; COS]; ROUGH]; ETA],
    curve_mean: [f32; ETA],
    glass: Body<ETA>,
}

/// The share of light that microfacets which reflect and refract let go at the first scattering, by
/// the index of refraction, the roughness and the cosine; and its mean over all directions.
#[derive(Debug, PartialEq)]
pub(super) struct Body<const N: usize> {
    nodes: [[[f32; COS]; ROUGH]; N],
    mean: [[f32; ROUGH]; N],
}

/// The tables. No thread pool integrates them: its threads may wait for them at the same time.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| Isa::best().run(Integrate(POINTS)));

/// The table of bodies seen from inside. It takes longer to integrate than all others, and few
/// scenes need it.
pub(super) static INSIDE: LazyLock<Body<ETA_INSIDE>> =
    LazyLock::new(|| Isa::best().run(IntegrateInside(POINTS_INSIDE)));

/// Integrates the table of bodies seen from inside with this number of points.
struct IntegrateInside(usize);

impl Lanewise for IntegrateInside {
    type Output = Body<ETA_INSIDE>;

    #[inline(always)]
    fn run(self) -> Body<ETA_INSIDE> {
        let normals = Normals::new(self.0);
        let etas: [f64; ETA_INSIDE] = std::array::from_fn(|e| 1.0 / index(e, ETA_INSIDE));
        let mut body = Body::new();
        for (r, m) in (0..ROUGH * COS).map(|i| (i / COS, i % COS)) {
            let [roughness, cos] = node(r, m);
            body.set(r, m, normals.row(roughness, cos, &etas).glass);
        }
        body.find_means();
        body
    }
}

/// Integrates the tables with these numbers of points.
struct Integrate([usize; 2]);

impl Lanewise for Integrate {
    type Output = Tables;

    #[inline(always)]
    fn run(self) -> Tables {
        Tables::new(self.0)
    }
}

/// Between which nodes of `N` a number of 0 to 1 lies, and how far from the first one.
#[inline(always)]
fn split<const N: usize>(x: f32) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (N - 1) as f32;
    let i = (x as usize).min(N - 2);
    (i, x - i as f32)
}

#[inline(always)]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Returns the number at two coordinates of 0 to 1, linear between the nodes of a table.
#[inline(always)]
pub(super) fn plane<const A: usize, const B: usize>(of: &[[f32; B]; A], a: f32, b: f32) -> f32 {
    let ((i, s), (j, t)) = (split::<A>(a), split::<B>(b));
    mix(mix(of[i][j], of[i][j + 1], t), mix(of[i + 1][j], of[i + 1][j + 1], t), s)
}

/// The roughness and the cosine of a node.
fn node(r: usize, m: usize) -> [f64; 2] {
    let root = m as f64 / (COS - 1) as f64;
    [r as f64 / (ROUGH - 1) as f64, root * root]
}

impl<const N: usize> Body<N> {
    fn new() -> Self {
        Self { nodes: [[[0.0; COS]; ROUGH]; N], mean: [[0.0; ROUGH]; N] }
    }

    /// Sets the nodes of a roughness and a cosine, for all indices of refraction.
    fn set(&mut self, r: usize, m: usize, values: [f64; N]) {
        for (nodes, value) in self.nodes.iter_mut().zip(values) {
            nodes[r][m] = value as f32;
        }
    }

    /// Computes the means from the nodes.
    fn find_means(&mut self) {
        const STEPS: usize = 8 * (COS - 1);
        for (row, mean) in self.nodes.iter().flatten().zip(self.mean.iter_mut().flatten()) {
            // Linear between the nodes of the root x of the cosine: the weight is 4 x³ dx.
            let part = |i: usize| {
                let x = (i as f32 + 0.5) / STEPS as f32;
                let (j, t) = split::<COS>(x);
                mix(row[j], row[j + 1], t) * (4.0 * x * x * x)
            };
            let cube = |i: usize| {
                let x = (i as f32 + 0.5) / STEPS as f32;
                x * x * x
            };
            let weight = (0..STEPS).map(cube).sum::<f32>();
            *mean = (0..STEPS).map(part).sum::<f32>() / (4.0 * weight);
        }
    }

    /// Returns the share of light that microfacets let go at the first scattering. `eta` may be the
    /// index or its reciprocal.
    #[inline(always)]
    pub(super) fn single(&self, eta: f32, roughness: f32, cos: f32) -> f32 {
        space(&self.nodes, eta, roughness, cos)
    }

    /// Returns the mean of [`single`](Self::single) over all directions, weighted by the cosine.
    #[inline(always)]
    pub(super) fn mean(&self, eta: f32, roughness: f32) -> f32 {
        plane(&self.mean, place(eta), roughness)
    }
}

#[inline(always)]
fn space<const N: usize>(of: &[[[f32; COS]; ROUGH]; N], eta: f32, roughness: f32, cos: f32) -> f32 {
    let (i, t) = split::<N>(place(eta));
    let cos = cos.max(0.0).sqrt();
    mix(plane(&of[i], roughness, cos), plane(&of[i + 1], roughness, cos), t)
}

impl Tables {
    /// The share of light that microfacets of a roughness return at the first scattering if they
    /// reflect all of it, seen at a cosine.
    #[inline(always)]
    pub(super) fn single(&self, roughness: f32, cos: f32) -> f32 {
        plane(&self.single, roughness, cos)
    }

    /// The mean of [`single`](Self::single) over all directions, weighted by the cosine.
    #[inline(always)]
    pub(super) fn mean(&self, roughness: f32) -> f32 {
        let (i, t) = split::<FINE>(roughness);
        mix(self.mean[i], self.mean[i + 1], t)
    }

    /// The mean of [`between`] over the light that the microfacets of a
    /// dielectric return at the first scattering.
    #[inline(always)]
    pub(super) fn curve(&self, eta: f32, roughness: f32, cos: f32) -> f32 {
        let smooth = between(cos, eta);
        (smooth + space(&self.curve, eta, roughness, cos)).clamp(0.0, 1.0)
    }

    /// The mean of [`between`] over all directions, weighted by the
    /// cosine.
    #[inline(always)]
    pub(super) fn curve_mean(&self, eta: f32) -> f32 {
        let (i, t) = split::<ETA>(place(eta));
        mix(self.curve_mean[i], self.curve_mean[i + 1], t)
    }

    /// The table of bodies that the eye sees from the less dense medium.
    #[inline(always)]
    pub(super) fn outside(&self) -> &Body<ETA> {
        &self.glass
    }

    #[inline(always)]
    fn new([fine, coarse]: [usize; 2]) -> Self {
        let normals = Normals::new(fine);
        let mut tables = Self {
            single: [[0.0; FINE]; FINE],
            mean: [0.0; FINE],
            curve: [[[0.0; COS]; ROUGH]; ETA],
            curve_mean: std::array::from_fn(|e| curve_mean(index(e, ETA)) as f32),
            glass: Body::new(),
        };
        let step = 1.0 / (FINE - 1) as f64;
        for (r, row) in tables.single.iter_mut().enumerate() {
            let exact: [f64; FINE] =
                std::array::from_fn(|m| normals.single(r as f64 * step, m as f64 * step));
            // Linear between the nodes, times the cosine.
            let part = |(m, pair): (usize, &[f64])| {
                let (c, d) = (m as f64 * step, (m + 1) as f64 * step);
                step / 3.0 * (pair[0] * (2.0 * c + d) + pair[1] * (c + 2.0 * d))
            };
            tables.mean[r] = exact.windows(2).enumerate().map(part).sum::<f64>() as f32;
            *row = exact.map(|x| x as f32);
        }
        let normals = Normals::new(coarse);
        let etas: [f64; ETA] = std::array::from_fn(|e| index(e, ETA));
        for (r, m) in (0..ROUGH * COS).map(|i| (i / COS, i % COS)) {
            let [roughness, cos] = node(r, m);
            let row = normals.row(roughness, cos, &etas);
            for (e, &eta) in etas.iter().enumerate() {
                let smooth = between_ends(dielectric(cos, eta).0, eta);
                tables.curve[e][r][m] = (row.curve[e] - smooth) as f32;
            }
            tables.glass.set(r, m, row.glass);
        }
        tables.glass.find_means();
        tables
    }
}

/// The values of all indices of refraction at one roughness and cosine.
struct Row<const N: usize> {
    curve: [f64; N],
    glass: [f64; N],
}

/// Points that the visible normals of microfacets are sampled by.
struct Normals {
    /// Cosine and sine of the azimuth, the height fraction, and the weight; weights sum to 1.
    points: Vec<[f64; 4]>,
}

/// Microfacets seen from (sin, 0, cos).
struct View {
    alpha: f64,
    eye: [f64; 2],
    slant: f64,
}

impl View {
    #[inline(always)]
    fn new(roughness: f64, cos: f64) -> Self {
        let (alpha, cos) = (roughness * roughness, cos.max(1e-4));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Self { alpha, eye: [sin, cos], slant: root(cos * cos + alpha * alpha * sin * sin) }
    }

    /// See [`Seen::sample`](super::ggx::Seen::sample).
    #[inline(always)]
    fn normal(&self, [c, s, v, _]: [f64; 4]) -> [f64; 3] {
        let [x, z] = [self.eye[0] * self.alpha / self.slant, self.eye[1] / self.slant];
        let height = 1.0 - v * (1.0 + z);
        let sin = root((1.0 - height * height).max(0.0));
        let h = [(sin * c + x) * self.alpha, sin * s * self.alpha, height + z];
        let inverse = 1.0 / root(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).max(1e-300);
        h.map(|x| x * inverse)
    }

    /// See [`Seen::passed`](super::ggx::Seen::passed).
    #[inline(always)]
    fn passed(&self, z: f64) -> f64 {
        let z = z.max(0.0);
        let there = root(z * z + self.alpha * self.alpha * (1.0 - z * z).max(0.0));
        z * (self.eye[1] + self.slant) / (z * self.slant + self.eye[1] * there).max(1e-300)
    }
}

#[inline(always)]
fn root(x: f64) -> f64 {
    x.sqrt()
}

/// See [`dielectric`](super::fresnel::dielectric); also returns the cosine beyond.
#[inline(always)]
fn dielectric(cos: f64, eta: f64) -> (f64, f64) {
    let cos_t = root(((eta - 1.0) * (eta + 1.0) + cos * cos).max(0.0)) / eta;
    let s = (cos - eta * cos_t) / (cos + eta * cos_t).max(1e-300);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t).max(1e-300);
    (0.5 * (s * s + p * p), cos_t)
}

/// See [`between`].
#[inline(always)]
fn between_ends(reflected: f64, eta: f64) -> f64 {
    let f0 = (eta - 1.0) / (eta + 1.0);
    ((reflected - f0 * f0) / (1.0 - f0 * f0)).clamp(0.0, 1.0)
}

fn curve_mean(eta: f64) -> f64 {
    const STEPS: usize = 512;
    let part = |i: usize| {
        let cos = (i as f64 + 0.5) / STEPS as f64;
        2.0 * cos * between_ends(dielectric(cos, eta).0, eta) / STEPS as f64
    };
    (0..STEPS).map(part).sum()
}

impl Normals {
    /// `count` points on a spiral that turns by the golden angle.
    fn new(count: usize) -> Self {
        // Cosine and sine of pi (3 - sqrt 5).
        let (c, s) = (-0.737_368_878_078_319_7, 0.675_490_294_261_523_6);
        let (mut x, mut y) = (1.0, 0.0);
        let point = |i: usize| {
            // Normals at great angles decide about shadows: they get more points.
            let left = 1.0 - (i as f64 + 0.5) / count as f64;
            let point = [x, y, 1.0 - left * left, 2.0 * left / count as f64];
            (x, y) = (x * c - y * s, y * c + x * s);
            point
        };
        Self { points: (0..count).map(point).collect() }
    }

    #[inline(always)]
    fn single(&self, roughness: f64, cos: f64) -> f64 {
        let view = View::new(roughness, cos);
        let part = |&point: &[f64; 4]| {
            let h = view.normal(point);
            let along = view.eye[0] * h[0] + view.eye[1] * h[2];
            point[3] * view.passed(2.0 * along * h[2] - view.eye[1])
        };
        self.points.iter().map(part).sum()
    }

    #[inline(always)]
    fn row<const N: usize>(&self, roughness: f64, cos: f64, etas: &[f64; N]) -> Row<N> {
        let view = View::new(roughness, cos);
        let mut row = Row { curve: [0.0; N], glass: [0.0; N] };
        let mut all = 0.0;
        for &point in &self.points {
            let h = view.normal(point);
            let along = (view.eye[0] * h[0] + view.eye[1] * h[2]).clamp(0.0, 1.0);
            let weight = point[3];
            let reflected = weight * view.passed(2.0 * along * h[2] - view.eye[1]);
            all += reflected;
            for (e, &eta) in etas.iter().enumerate() {
                let (share, cos_t) = dielectric(along, eta);
                let z = (view.eye[1] - (along - eta * cos_t) * h[2]) / eta;
                row.curve[e] += reflected * between_ends(share, eta);
                row.glass[e] += share * reflected + (1.0 - share) * weight * view.passed(z);
            }
        }
        row.curve = row.curve.map(|sum| sum / all);
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::bsdf::fresnel::normal_incidence;

    #[test]
    fn tables_are_integrated_finely_enough() {
        let tables = &*TABLES;
        let finer = Tables::new([2048, 1024]);
        let again = Tables::new(POINTS);
        assert!(tables.glass == again.glass && tables.curve == again.curve);
        let (inside, finer_inside) = (&*INSIDE, Isa::best().run(IntegrateInside(8192)));
        let mut worst = [0.0f32; 4];
        for r in 0..FINE {
            for m in 1..FINE {
                let off = (tables.single[r][m] / finer.single[r][m] - 1.0).abs();
                worst[0] = worst[0].max(off);
            }
        }
        // Lower cosines are hardly ever seen.
        for (r, m) in (0..ROUGH * COS).map(|i| (i / COS, i % COS)) {
            let off = |a: &[[[f32; COS]; ROUGH]], b: &[[[f32; COS]; ROUGH]]| {
                let off = a.iter().zip(b).map(|(a, b)| (a[r][m] / b[r][m] - 1.0).abs());
                if m > 2 { off.fold(0.0, f32::max) } else { 0.0 }
            };
            for e in 0..ETA {
                worst[1] = worst[1].max((tables.curve[e][r][m] - finer.curve[e][r][m]).abs());
            }
            worst[2] = worst[2].max(off(&tables.glass.nodes, &finer.glass.nodes));
            worst[3] = worst[3].max(off(&inside.nodes, &finer_inside.nodes));
        }
        assert!(worst[0] < 0.003 && worst[1] < 0.003, "{worst:?}");
        assert!(worst[2] < 0.003 && worst[3] < 0.01, "{worst:?}");
    }

    #[test]
    fn single_scattering_loses_what_it_should() {
        let single = |cos| TABLES.single(1.0, cos);
        assert!((single(1.0) - (1.0 - std::f32::consts::LN_2)).abs() < 2e-4, "{}", single(1.0));
        assert!((single(0.5) - 0.4507).abs() < 5e-4, "{}", single(0.5));
        assert!((single(0.173_648_18) - 0.6682).abs() < 5e-4, "{}", single(0.173_648_18));
        for (cos, expected) in [(1.0, 0.9157), (0.5, 0.8572), (0.173_648_18, 0.8555)] {
            let found = TABLES.single(0.5, cos);
            assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
        }
        assert_eq!(TABLES.single(0.0, 0.3), 1.0);
    }

    #[test]
    fn dielectrics_reflect_their_mean() {
        for (eta, expected) in [(1.5, 0.091_778), (1.33, 0.065_931), (1.45, 0.084_367)] {
            let f0 = normal_incidence(eta);
            let found = f0 + (1.0 - f0) * TABLES.curve_mean(eta);
            assert!((found - expected).abs() < 5e-4, "{found} is not {expected}");
        }
    }

    #[test]
    fn lookups_stay_in_the_tables() {
        for x in [-1.0, 0.0, 0.5, 1.0, 7.0, f32::INFINITY] {
            assert!(TABLES.single(x, x).is_finite() && TABLES.mean(x).is_finite());
            for eta in [0.01, 0.7, 1.0, 1.5, 100.0] {
                let inside = [INSIDE.single(eta, x, x), INSIDE.mean(eta, x)];
                let outside = [TABLES.glass.single(eta, x, x), TABLES.glass.mean(eta, x)];
                assert!(inside.into_iter().chain(outside).all(f32::is_finite), "{eta} {x}");
                assert!(TABLES.curve(eta, x, x.clamp(0.0, 1.0)).is_finite(), "{eta} {x}");
            }
        }
    }
}
