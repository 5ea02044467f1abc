//! Directional albedos of surfaces of microfacets, for the light that single scattering loses and
//! for what layers leave to those below.
//!
//! Tables that depend on the index of refraction take too long to integrate for a small picture:
//! `tables.bin` has them, and a test writes it. The others are integrated when they are first used, in
//! f64 and with nothing but sums, products, quotients and roots: they are the same on every machine.

use std::sync::LazyLock;

use slo_accel::{Isa, Lanewise};

use super::fresnel::between;
use super::ggx::LEAST_ROUGHNESS;

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

/// Points to integrate with.
const POINTS: usize = 256;

/// The nodes of [`Tables::curve`], times 32767, and those of bodies seen from outside and from inside,
/// times 65535: 16 bits each, the low byte first.
static NODES: &[u8] = include_bytes!("tables.bin");

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
    curve: Nodes<ETA>,
    curve_mean: [f32; ETA],
    outside: Body<ETA>,
    inside: Body<ETA_INSIDE>,
}

/// The share of light that microfacets which reflect and refract let go at the first scattering, by
/// the index of refraction, the roughness and the cosine; and its mean over all directions.
#[derive(Debug, PartialEq)]
pub(super) struct Body<const N: usize> {
    nodes: Nodes<N>,
    mean: [[f32; ROUGH]; N],
}

/// The tables. No thread pool integrates them: its threads may wait for them at the same time.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| Isa::best().run(Integrate(POINTS)));

/// Returns the share of light that microfacets of a roughness return at the first scattering if they
/// reflect all of it, seen at a cosine, and the mean of this over all directions, weighted by the
/// cosine.
pub fn facet_albedos(roughness: f32, cos: f32) -> [f32; 2] {
    let single =
        if roughness < LEAST_ROUGHNESS { 1.0 } else { TABLES.single(roughness, cos).max(0.01) };
    [single, TABLES.mean(roughness)]
}

/// Sets up the tables, and integrates those that need it with this number of points.
struct Integrate(usize);

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

type Nodes<const N: usize> = [[[f32; COS]; ROUGH]; N];

/// Takes nodes from bytes, two each, and makes numbers of them.
fn read<const N: usize>(bytes: &[u8], number: impl Fn([u8; 2]) -> f32) -> Nodes<N> {
    let mut nodes = [[[0.0; COS]; ROUGH]; N];
    let (pairs, _) = bytes.as_chunks();
    for (node, pair) in nodes.iter_mut().flatten().flatten().zip(pairs) {
        *node = number(*pair);
    }
    nodes
}

impl<const N: usize> Body<N> {
    fn new(bytes: &[u8]) -> Self {
        let nodes = read(bytes, |pair| f32::from(u16::from_le_bytes(pair)) / 65535.0);
        let mut body = Self { nodes, mean: [[0.0; ROUGH]; N] };
        body.find_means();
        body
    }

    /// Computes the means from the nodes.
    fn find_means(&mut self) {
        const STEPS: usize = 8 * (COS - 1);
        for (row, mean) in self.nodes.iter().flatten().zip(self.mean.iter_mut().flatten()) {
            // Linear between the nodes of the root x of the cosine: the weight is 4 x³ dx.
            let (mut sum, mut all) = (0.0, 0.0);
            for i in 0..STEPS {
                let x = (i as f32 + 0.5) / STEPS as f32;
                let (j, t) = split::<COS>(x);
                let weight = x * x * x;
                sum += mix(row[j], row[j + 1], t) * weight;
                all += weight;
            }
            *mean = sum / all;
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
fn space<const N: usize>(of: &Nodes<N>, eta: f32, roughness: f32, cos: f32) -> f32 {
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
        &self.outside
    }

    /// The table of bodies that the eye sees from the denser medium.
    #[inline(always)]
    pub(super) fn inside(&self) -> &Body<ETA_INSIDE> {
        &self.inside
    }

    #[inline(always)]
    fn new(points: usize) -> Self {
        const SIZE: usize = 2 * ETA * ROUGH * COS;
        let normals = Normals::new(points);
        let mut tables = Self {
            single: [[0.0; FINE]; FINE],
            mean: [0.0; FINE],
            curve: read(NODES, |pair| f32::from(i16::from_le_bytes(pair)) / 32767.0),
            curve_mean: std::array::from_fn(|e| curve_mean(index(e, ETA)) as f32),
            outside: Body::new(&NODES[SIZE..]),
            inside: Body::new(&NODES[2 * SIZE..]),
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
        tables
    }
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::bsdf::fresnel::normal_incidence;

    /// Points that `tables.bin` was integrated with.
    const BAKED: usize = 4096;

    /// The roughness and the cosine of a node.
    fn node(r: usize, m: usize) -> [f64; 2] {
        let root = m as f64 / (COS - 1) as f64;
        [r as f64 / (ROUGH - 1) as f64, root * root]
    }

    /// The values of all indices of refraction at one roughness and cosine.
    struct Row<const N: usize> {
        curve: [f64; N],
        glass: [f64; N],
    }

    impl Normals {
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

    /// Integrates all nodes of a roughness and a cosine: those of the curve, and of bodies seen from
    /// outside and from inside.
    fn integrate(normals: &Normals, r: usize, m: usize) -> [Vec<f64>; 3] {
        let [roughness, cos] = node(r, m);
        let etas: [f64; ETA] = std::array::from_fn(|e| index(e, ETA));
        let outside = normals.row(roughness, cos, &etas);
        let smooth = etas.map(|eta| between_ends(dielectric(cos, eta).0, eta));
        let curve = outside.curve.iter().zip(smooth).map(|(curve, smooth)| curve - smooth);
        let etas: [f64; ETA_INSIDE] = std::array::from_fn(|e| 1.0 / index(e, ETA_INSIDE));
        let inside = normals.row(roughness, cos, &etas);
        [curve.collect(), outside.glass.to_vec(), inside.glass.to_vec()]
    }

    /// Writes `tables.bin`.
    #[test]
    #[ignore = "writes a source file"]
    fn bake() {
        let normals = Normals::new(BAKED);
        let mut tables: [Vec<u8>; 3] =
            [ETA, ETA, ETA_INSIDE].map(|count| vec![0; 2 * count * ROUGH * COS]);
        for (r, m) in (0..ROUGH * COS).map(|i| (i / COS, i % COS)) {
            for (k, (table, values)) in tables.iter_mut().zip(integrate(&normals, r, m)).enumerate()
            {
                for (e, value) in values.into_iter().enumerate() {
                    let bytes = if k == 0 {
                        ((value * 32767.0).round() as i16).to_le_bytes()
                    } else {
                        ((value * 65535.0).round() as u16).to_le_bytes()
                    };
                    let at = 2 * ((e * ROUGH + r) * COS + m);
                    table[at..at + 2].copy_from_slice(&bytes);
                }
            }
        }
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shading/bsdf/tables.bin");
        std::fs::write(path, tables.concat()).unwrap();
    }

    #[test]
    fn tables_are_integrated_finely_enough() {
        let (tables, finer) = (&*TABLES, Tables::new(2048));
        let (mut worst, mut worst_baked) = (0.0f32, [0.0f32; 3]);
        for r in 0..FINE {
            for m in 1..FINE {
                worst = worst.max((tables.single[r][m] / finer.single[r][m] - 1.0).abs());
            }
        }
        assert!(worst < 0.003, "{worst}");
        // Every seventh node, as it was integrated and with other points.
        assert_eq!(NODES.len(), 2 * (2 * ETA + ETA_INSIDE) * ROUGH * COS);
        for (points, most) in [(BAKED, 2e-5), (3 * BAKED, 0.004)] {
            let normals = Normals::new(points);
            for (r, m) in (0..ROUGH * COS).step_by(7).map(|i| (i / COS, i % COS)) {
                let values = integrate(&normals, r, m);
                let found = [
                    tables.curve.each_ref().map(|nodes| nodes[r][m]).to_vec(),
                    tables.outside.nodes.each_ref().map(|nodes| nodes[r][m]).to_vec(),
                    tables.inside.nodes.each_ref().map(|nodes| nodes[r][m]).to_vec(),
                ];
                for k in 0..3 {
                    for (found, value) in found[k].iter().zip(&values[k]) {
                        worst_baked[k] = worst_baked[k].max((found - *value as f32).abs());
                    }
                }
            }
            assert!(worst_baked.iter().all(|worst| *worst < most), "{points}: {worst_baked:?}");
        }
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
                let inside = [TABLES.inside.single(eta, x, x), TABLES.inside.mean(eta, x)];
                let outside = [TABLES.outside.single(eta, x, x), TABLES.outside.mean(eta, x)];
                assert!(inside.into_iter().chain(outside).all(f32::is_finite), "{eta} {x}");
                assert!(TABLES.curve(eta, x, x.clamp(0.0, 1.0)).is_finite(), "{eta} {x}");
            }
        }
    }
}
