//! Directional albedos of surfaces of microfacets, for the light that single scattering loses and
//! for what layers leave to those below.
//!
//! The tables are integrated when they are first used, in f64 and with nothing but sums, products,
//! quotients and roots: they are the same on every machine.

use std::sync::LazyLock;

use rayon::prelude::*;

/// Nodes of roughness and cosine of the albedo of microfacets that reflect all light.
const FINE: usize = 32;
/// Nodes of roughness, of tables that depend on the index of refraction too.
const ROUGH: usize = 16;
/// Nodes of the cosine of these tables.
const COS: usize = 16;
/// Nodes of the index of refraction of these tables.
const ETA: usize = 16;
/// The largest value of [`place`] that has a node of its own.
const LAST: f64 = 0.8;

/// Nodes of the azimuth, in half a circle, and of the other coordinate of normals.
const POINTS: [usize; 2] = [8, 16];

/// Where an index of refraction stands among the nodes, 0 to 1; the same for its reciprocal.
#[inline(always)]
fn place(eta: f32) -> f32 {
    let eta = eta.max(1.0 / eta.max(1e-6));
    ((eta - 1.0) / (eta + 1.0)).sqrt() / LAST as f32
}

/// The index of refraction of a node, at least 1.
fn index(node: usize) -> f64 {
    let root = LAST * node as f64 / (ETA - 1) as f64;
    (1.0 + root * root) / (1.0 - root * root)
}

/// The albedos; see the functions for their meaning.
#[derive(Debug)]
pub(super) struct Tables {
    single: [[f32; FINE]; FINE],
    mean: [f32; FINE],
    curve: [[[f32; COS]; ROUGH]; ETA],
    curve_mean: [f32; ETA],
    glass: [[[[f32; COS]; ROUGH]; ETA]; 2],
}

/// The tables.
pub(super) static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables::new(POINTS));

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

#[inline(always)]
fn plane<const A: usize, const B: usize>(of: &[[f32; B]; A], a: f32, b: f32) -> f32 {
    let ((i, s), (j, t)) = (split::<A>(a), split::<B>(b));
    mix(mix(of[i][j], of[i][j + 1], t), mix(of[i + 1][j], of[i + 1][j + 1], t), s)
}

#[inline(always)]
fn space(of: &[[[f32; COS]; ROUGH]; ETA], eta: f32, roughness: f32, cos: f32) -> f32 {
    let (i, t) = split::<ETA>(place(eta));
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

    /// The mean of [`between`](super::fresnel::between) over the light that the microfacets of a
    /// dielectric return at the first scattering.
    #[inline(always)]
    pub(super) fn curve(&self, eta: f32, roughness: f32, cos: f32) -> f32 {
        space(&self.curve, eta, roughness, cos)
    }

    /// The mean of [`between`](super::fresnel::between) over all directions, weighted by the
    /// cosine.
    #[inline(always)]
    pub(super) fn curve_mean(&self, eta: f32) -> f32 {
        let (i, t) = split::<ETA>(place(eta));
        mix(self.curve_mean[i], self.curve_mean[i + 1], t)
    }

    /// The share of light that microfacets which reflect and refract let go at the first
    /// scattering; `eta` is less than 1 where the eye is in the denser medium.
    #[inline(always)]
    pub(super) fn glass(&self, eta: f32, roughness: f32, cos: f32) -> f32 {
        let side = usize::from(eta < 1.0);
        space(&self.glass[side], eta, roughness, cos)
    }

    fn new(points: [usize; 2]) -> Self {
        let normals = Normals::new(points);
        let mut single = [[0.0; FINE]; FINE];
        let mut mean = [0.0; FINE];
        single.par_iter_mut().zip(&mut mean).enumerate().for_each(|(r, (row, mean))| {
            let roughness = r as f64 / (FINE - 1) as f64;
            let step = 1.0 / (FINE - 1) as f64;
            let exact: Vec<f64> =
                (0..FINE).map(|m| normals.single(roughness, m as f64 * step)).collect();
            // Linear between the nodes, times the cosine.
            let part = |(m, pair): (usize, &[f64])| {
                let (c, d) = (m as f64 * step, (m + 1) as f64 * step);
                step / 3.0 * (pair[0] * (2.0 * c + d) + pair[1] * (c + 2.0 * d))
            };
            *mean = exact.windows(2).enumerate().map(part).sum::<f64>() as f32;
            for (to, exact) in row.iter_mut().zip(exact) {
                *to = exact as f32;
            }
        });
        let mut curve = [[[0.0; COS]; ROUGH]; ETA];
        let mut glass = [[[[0.0; COS]; ROUGH]; ETA]; 2];
        let rows: Vec<[[Row; COS]; 1]> = (0..ROUGH)
            .into_par_iter()
            .map(|r| {
                let roughness = r as f64 / (ROUGH - 1) as f64;
                [std::array::from_fn(|m| normals.row(roughness, m as f64 / (COS - 1) as f64))]
            })
            .collect();
        for (r, [row]) in rows.iter().enumerate() {
            for (m, of) in row.iter().enumerate() {
                for e in 0..ETA {
                    curve[e][r][m] = of.curve[e] as f32;
                    glass[0][e][r][m] = of.glass[0][e] as f32;
                    glass[1][e][r][m] = of.glass[1][e] as f32;
                }
            }
        }
        let curve_mean = std::array::from_fn(|e| curve_mean(index(e)) as f32);
        Self { single, mean, curve, curve_mean, glass }
    }
}

/// The values of all indices of refraction at one roughness and cosine.
struct Row {
    curve: [f64; ETA],
    glass: [[f64; ETA]; 2],
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
    fn new(roughness: f64, cos: f64) -> Self {
        let (alpha, cos) = (roughness * roughness, cos.max(1e-4));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Self { alpha, eye: [sin, cos], slant: root(cos * cos + alpha * alpha * sin * sin) }
    }

    /// See [`Seen::sample`](super::ggx::Seen::sample).
    fn normal(&self, [c, s, v, _]: [f64; 4]) -> [f64; 3] {
        let [x, z] = [self.eye[0] * self.alpha / self.slant, self.eye[1] / self.slant];
        let height = 1.0 - v * (1.0 + z);
        let sin = root((1.0 - height * height).max(0.0));
        let h = [(sin * c + x) * self.alpha, sin * s * self.alpha, height + z];
        let inverse = 1.0 / root(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).max(1e-300);
        h.map(|x| x * inverse)
    }

    /// See [`Seen::passed`](super::ggx::Seen::passed).
    fn passed(&self, z: f64) -> f64 {
        let z = z.max(0.0);
        let there = root(z * z + self.alpha * self.alpha * (1.0 - z * z).max(0.0));
        z * (self.eye[1] + self.slant) / (z * self.slant + self.eye[1] * there).max(1e-300)
    }
}

fn root(x: f64) -> f64 {
    x.sqrt()
}

/// See [`dielectric`](super::fresnel::dielectric); also returns the cosine beyond.
fn dielectric(cos: f64, eta: f64) -> (f64, f64) {
    let cos_t = root((1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0));
    let s = (cos - eta * cos_t) / (cos + eta * cos_t).max(1e-300);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t).max(1e-300);
    (0.5 * (s * s + p * p), cos_t)
}

fn between(reflected: f64, eta: f64) -> f64 {
    let f0 = (eta - 1.0) / (eta + 1.0);
    ((reflected - f0 * f0) / (1.0 - f0 * f0)).clamp(0.0, 1.0)
}

fn curve_mean(eta: f64) -> f64 {
    const STEPS: usize = 512;
    let part = |i: usize| {
        let cos = (i as f64 + 0.5) / STEPS as f64;
        2.0 * cos * between(dielectric(cos, eta).0, eta) / STEPS as f64
    };
    (0..STEPS).map(part).sum()
}

impl Normals {
    /// `turns` is a power of two.
    fn new([turns, heights]: [usize; 2]) -> Self {
        // The cosine and sine of half a step of the azimuth, by halving a right angle.
        let (mut c, mut s) = (0.0f64, 1.0f64);
        for _ in 0..turns.trailing_zeros() {
            (c, s) = (root(0.5 * (1.0 + c)), root(0.5 * (1.0 - c)));
        }
        let mut points = Vec::with_capacity(turns * heights);
        let (mut x, mut y) = (c, s);
        let (c, s) = (c * c - s * s, 2.0 * c * s);
        // Normals at great angles decide about shadows: they get more points.
        let height = |v: usize| {
            let left = 1.0 - (v as f64 + 0.5) / heights as f64;
            (1.0 - left * left, 2.0 * left / (turns * heights) as f64)
        };
        for _ in 0..turns {
            points.extend((0..heights).map(height).map(|(v, weight)| [x, y, v, weight]));
            (x, y) = (x * c - y * s, y * c + x * s);
        }
        Self { points }
    }

    fn single(&self, roughness: f64, cos: f64) -> f64 {
        let view = View::new(roughness, cos);
        let part = |&point: &[f64; 4]| {
            let h = view.normal(point);
            let along = view.eye[0] * h[0] + view.eye[1] * h[2];
            point[3] * view.passed(2.0 * along * h[2] - view.eye[1])
        };
        self.points.iter().map(part).sum()
    }

    fn row(&self, roughness: f64, cos: f64) -> Row {
        let view = View::new(roughness, cos);
        let mut row = Row { curve: [0.0; ETA], glass: [[0.0; ETA]; 2] };
        let mut all = 0.0;
        for &point in &self.points {
            let h = view.normal(point);
            let along = (view.eye[0] * h[0] + view.eye[1] * h[2]).clamp(0.0, 1.0);
            let weight = point[3];
            let reflected = weight * view.passed(2.0 * along * h[2] - view.eye[1]);
            all += reflected;
            for e in 0..ETA {
                let eta = index(e);
                row.curve[e] += reflected * between(dielectric(along, eta).0, eta);
                for (side, eta) in [eta, 1.0 / eta].into_iter().enumerate() {
                    let (share, cos_t) = dielectric(along, eta);
                    let z = (view.eye[1] - (along - eta * cos_t) * h[2]) / eta;
                    row.glass[side][e] +=
                        share * reflected + (1.0 - share) * weight * view.passed(z);
                }
            }
        }
        row.curve = row.curve.map(|sum| sum / all);
        row
    }
}
