//! The area of a flat region that random points fill.

/// Estimates the area of a convex region from points that fill it evenly; `None` if there are too few.
///
/// The convex hull of the points misses a part of the region at its rim. In the mean, that share is the
/// share of points that are corners of the hull of one point more.
///
/// Source: B. Efron, "The convex hull of a random set of points" (1965).
pub(super) fn area_of(points: impl Iterator<Item = [f32; 2]>) -> Option<f32> {
    let mut points: Vec<[f32; 2]> = points.collect();
    if points.len() < 4 {
        return None;
    }
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut twice = 0.0;
    let mut corners = 0;
    let mut chain: Vec<[f32; 2]> = Vec::with_capacity(64);
    // The lower side from left to right, then the upper one back.
    for pass in 0..2 {
        chain.clear();
        let mut add = |&p: &[f32; 2]| {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        };
        if pass == 0 {
            points.iter().for_each(&mut add);
        } else {
            points.iter().rev().for_each(&mut add);
        }
        for [a, b] in chain.array_windows() {
            twice += a[0] * b[1] - a[1] * b[0];
        }
        corners += chain.len() - 1;
    }
    let outside = corners as f32 / (points.len() as f32 + 1.0);
    let area = 0.5 * twice / (1.0 - outside).max(0.1);
    (area > 0.0).then_some(area)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    #[test]
    fn areas_are_right_in_the_mean() {
        let mut rng = StdRng::seed_from_u64(11);
        for count in [20, 200] {
            let (mut square, mut disc) = (0.0, 0.0);
            const TRIES: u32 = 400;
            for _ in 0..TRIES {
                let mut at = || [rng.random_range(-1.0..1.0f32), rng.random_range(-1.0..1.0f32)];
                let points: Vec<[f32; 2]> = (0..count).map(|_| at()).collect();
                square += area_of(points.into_iter()).unwrap();
                let inside = std::iter::repeat_with(at).filter(|[x, y]| x * x + y * y < 1.0);
                disc += area_of(inside.take(count).collect::<Vec<_>>().into_iter()).unwrap();
            }
            let (square, disc) = (square / TRIES as f32, disc / TRIES as f32);
            assert!((square / 4.0 - 1.0).abs() < 0.03, "square of {count}: {square}");
            assert!((disc / std::f32::consts::PI - 1.0).abs() < 0.03, "disc of {count}: {disc}");
        }
    }

    #[test]
    fn points_on_a_line_have_no_area() {
        assert_eq!(area_of((0..9).map(|i| [i as f32, 1.0])), None);
        assert_eq!(area_of((0..3).map(|i| [i as f32, i as f32 * i as f32])), None);
    }
}
