//! Cutting a polygon in the plane ear by ear.

use glam::DVec2;

/// How strictly an ear is judged; each level is used if the one before finds none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    /// It has an area, and no other corner is in it or at its edge.
    Clear,
    /// No other corner is in it.
    Touched,
    /// It has no area: two corners at one place, or the tip of a line.
    Flat,
    /// It has an area. A polygon that needs this crosses itself.
    Any,
    /// It may even be turned over.
    Turned,
}

impl Level {
    fn next(self) -> Self {
        match self {
            Self::Clear => Self::Touched,
            Self::Touched => Self::Flat,
            Self::Flat => Self::Any,
            Self::Any | Self::Turned => Self::Turned,
        }
    }
}

/// A counter-clockwise polygon from which ears are cut.
///
/// Corners may share a place, as those of a hole that is joined to the outline by a bridge.
pub(super) struct Ears {
    points: Vec<DVec2>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Corners that may lie in ears: those that were not convex at the start, in the order of a
    /// coordinate. Convex ones stay so.
    inner: Vec<u32>,
    /// Which coordinate.
    axis: usize,
}

impl Ears {
    /// The polygon with these corners, three or more.
    pub(super) fn new(points: Vec<DVec2>) -> Self {
        let len = points.len() as u32;
        let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut ears = Self {
            previous: (0..len).map(|i| i.checked_sub(1).unwrap_or(len - 1)).collect(),
            next: (0..len).map(|i| (i + 1) % len).collect(),
            inner: Vec::new(),
            axis: (high - low).max_position(),
            points,
        };
        ears.inner = (0..len).filter(|&corner| ears.area(ears.ear(corner)) <= 0.0).collect();
        let (points, axis) = (&ears.points, ears.axis);
        ears.inner.sort_by(|&a, &b| {
            points[a as usize][axis].total_cmp(&points[b as usize][axis]).then(a.cmp(&b))
        });
        ears
    }

    /// All triangles, two fewer than corners, and whether the polygon does not cross itself as far
    /// as that showed. Tries corners against ears at most `tries` times, of which are left what is
    /// left: `None` if that is not enough.
    pub(super) fn cut(mut self, tries: &mut u64) -> Option<(Vec<[u32; 3]>, bool)> {
        let mut triangles = Vec::with_capacity(self.points.len() - 2);
        let mut left = self.points.len();
        let mut corner = 0;
        let mut level = Level::Clear;
        let mut is_simple = true;
        let mut misses = 0;
        while left > 3 {
            let ear = self.ear(corner);
            let after = self.next[corner as usize];
            if self.is_ear(ear, level, tries)? {
                triangles.push(ear);
                self.remove(corner);
                left -= 1;
                is_simple &= level < Level::Any;
                level = Level::Clear;
                misses = 0;
                // Not the neighbour: triangles of one corner after the other are thin.
                corner = self.next[after as usize];
                continue;
            }
            corner = after;
            misses += 1;
            if misses == left {
                level = level.next();
                misses = 0;
            }
        }
        let last = self.ear(corner);
        triangles.push(last);
        Some((triangles, is_simple && self.area(last) >= 0.0))
    }

    /// A corner between its neighbours.
    fn ear(&self, corner: u32) -> [u32; 3] {
        [self.previous[corner as usize], corner, self.next[corner as usize]]
    }

    fn remove(&mut self, corner: u32) {
        let [before, _, after] = self.ear(corner);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        // Marks it as removed.
        self.next[corner as usize] = corner;
    }

    /// Twice the area of a triangle, negative if it is clockwise.
    fn area(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|corner| self.points[corner as usize]);
        (b - a).perp_dot(c - a)
    }

    /// Whether a corner can be cut off. `None`: no tries are left.
    fn is_ear(&self, ear: [u32; 3], level: Level, tries: &mut u64) -> Option<bool> {
        *tries = tries.checked_sub(1)?;
        let area = self.area(ear);
        match level {
            Level::Clear | Level::Touched if area > 0.0 => self.is_empty(ear, level, tries),
            Level::Clear | Level::Touched => Some(false),
            Level::Flat => Some(area == 0.0),
            Level::Any => Some(area > 0.0),
            Level::Turned => Some(true),
        }
    }

    /// Whether no other corner is in the triangle.
    fn is_empty(&self, ear: [u32; 3], level: Level, tries: &mut u64) -> Option<bool> {
        let triangle = ear.map(|corner| self.points[corner as usize]);
        let along = triangle.map(|point| point[self.axis]);
        let low = along.into_iter().fold(f64::INFINITY, f64::min);
        let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let place = |corner: &u32| self.points[*corner as usize][self.axis];
        let start = self.inner.partition_point(|corner| place(corner) < low);
        for corner in self.inner[start..].iter().take_while(|corner| place(corner) <= high) {
            *tries = tries.checked_sub(1)?;
            let point = self.points[*corner as usize];
            if self.next[*corner as usize] != *corner
                && !triangle.contains(&point)
                && contains(triangle, point, level)
                && self.area(self.ear(*corner)) <= 0.0
            {
                return Some(false);
            }
        }
        Some(true)
    }
}

/// Whether a counter-clockwise triangle contains a point; at its edge unless it may be touched.
fn contains([a, b, c]: [DVec2; 3], point: DVec2, level: Level) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(point - from));
    match level {
        Level::Clear => sides.iter().all(|&side| side >= 0.0),
        _ => sides.iter().all(|&side| side > 0.0),
    }
}
