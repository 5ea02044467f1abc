//! Bézier curves by de Casteljau's algorithm, in f64.

use glam::DVec3;

/// Most control points for de Casteljau's algorithm, whose time grows with their square.
const MOST_FOR_DE_CASTELJAU: usize = 64;

/// The share below which a control point, and all behind it, moves the point of the curve by nothing.
/// The next numbers would be denormal, which makes processors slow.
const VANISHED: f64 = 1e-60;

/// The point at `u` of the Bézier curve with these control points: a curve of degree
/// `control.len() - 1`, so that one point rests and two make a straight line.
///
/// The curve meets its ends exactly, and rests exactly if all control points are equal.
/// No control point at all gives the origin.
///
/// Source: de Casteljau's algorithm; Farin, Curves and Surfaces for CAGD, chapter 4. Beyond 64
/// points: P. Woźny and F. Chudy, "Linear-time geometric algorithm for evaluating Bézier curves"
/// (2020).
pub fn bezier(control: &[DVec3], u: f64) -> DVec3 {
    if control.len() <= MOST_FOR_DE_CASTELJAU {
        return de_casteljau(&mut control.to_vec(), u);
    }
    in_linear_time(control, u)
}

/// The point at `u` of a cubic Bézier curve; as [`bezier`].
pub fn cubic(control: &[DVec3; 4], u: f64) -> DVec3 {
    de_casteljau(&mut control.clone(), u)
}

fn de_casteljau(points: &mut [DVec3], u: f64) -> DVec3 {
    let Some(&last) = points.last() else { return DVec3::ZERO };
    if u == 1.0 {
        return last; // a + (b - a) may miss b by a rounding
    }
    for left in (1..points.len()).rev() {
        for i in 0..left {
            points[i] += (points[i + 1] - points[i]) * u;
        }
    }
    points[0]
}

/// The mean of the control points, weighted by the Bernstein polynomials, taken point by point:
/// `share` is what a point has of the weight of all points up to it.
fn in_linear_time(points: &[DVec3], u: f64) -> DVec3 {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return DVec3::ZERO };
    if u == 1.0 {
        return last;
    }
    let degree = (points.len() - 1) as f64;
    let (mut mean, mut share) = (first, 1.0);
    for (k, point) in points.iter().enumerate().skip(1) {
        let k = k as f64;
        let grown = (degree - k + 1.0) * u * share;
        share = grown / (k * (1.0 - u) + grown);
        mean += (*point - mean) * share;
        if share < VANISHED {
            break;
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZIGZAG: [DVec3; 4] = [
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(2.0, -4.0, 0.1),
        DVec3::new(5.0, 1.0, 0.7),
    ];

    /// The same point by the Bernstein polynomials.
    fn bernstein(control: &[DVec3], u: f64) -> DVec3 {
        let degree = control.len() - 1;
        let power = |x: f64, n: usize| (0..n).fold(1.0, |p, _| p * x);
        let binomial = |k: usize| (0..k).fold(1.0, |c, i| c * (degree - i) as f64 / (i + 1) as f64);
        (0..=degree)
            .map(|k| control[k] * (binomial(k) * power(u, k) * power(1.0 - u, degree - k)))
            .sum()
    }

    #[test]
    fn any_degree_agrees_with_bernstein() {
        let control: Vec<DVec3> = (0..8)
            .map(|i| ZIGZAG[i % 4] * (1.0 + i as f64) + DVec3::splat(i as f64 * 0.3))
            .collect();
        for length in 1..=control.len() {
            for step in 0..=40 {
                let (u, points) = (step as f64 / 40.0, &control[..length]);
                assert!((bezier(points, u) - bernstein(points, u)).length() < 1e-12);
            }
        }
    }

    #[test]
    fn many_points_take_linear_time_and_agree_with_few() {
        let control: Vec<DVec3> =
            (0..200).map(|i| ZIGZAG[i * 7 % 4] + DVec3::X * i as f64).collect();
        for length in [1, 2, 3, 20, 200] {
            for step in 0..=100 {
                let (u, points) = (step as f64 / 100.0, &control[..length]);
                let exact = de_casteljau(&mut points.to_vec(), u);
                assert!((in_linear_time(points, u) - exact).length() < 1e-11, "{length} {u}");
            }
        }
        let still = vec![DVec3::new(0.1, 0.7, 1e6 + 0.3); 1_000_000];
        assert_eq!(bezier(&still, 0.37), still[0]);
        let straight: Vec<DVec3> = (0..=100_000).map(|i| DVec3::X * f64::from(i)).collect();
        assert!((bezier(&straight, 0.3) - DVec3::X * 3e4).length() < 1e-6);
    }

    #[test]
    fn ends_are_exact_and_rest_is_exact() {
        assert_eq!(bezier(&ZIGZAG, 0.0), ZIGZAG[0]);
        assert_eq!(bezier(&ZIGZAG, 1.0), ZIGZAG[3]);
        let rest = [DVec3::new(0.1, 0.7, 1e6 + 0.3); 4];
        for step in 0..=97 {
            assert_eq!(cubic(&rest, step as f64 / 97.0), rest[0]);
        }
    }

    #[test]
    fn middle_of_a_cubic() {
        // (p0 + 3 p1 + 3 p2 + p3) / 8
        let expected = (ZIGZAG[0] + 3.0 * ZIGZAG[1] + 3.0 * ZIGZAG[2] + ZIGZAG[3]) / 8.0;
        assert!((cubic(&ZIGZAG, 0.5) - expected).length() < 1e-14);
    }

    #[test]
    fn stays_in_the_box_of_its_control_points() {
        let min = ZIGZAG.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let max = ZIGZAG.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        for step in 0..=1000 {
            let p = cubic(&ZIGZAG, step as f64 / 1000.0);
            assert!(p.cmpge(min - 1e-15).all() && p.cmple(max + 1e-15).all(), "{p}");
        }
    }

    #[test]
    fn no_control_point_is_the_origin() {
        assert_eq!(bezier(&[], 0.3), DVec3::ZERO);
    }
}
