//! Faces of more than three corners, cut into triangles.
//!
//! Readers cut every polygon into a fan around its first corner, and note its place. If a fan covers
//! something outside of its polygon, because that has a concave corner, ears are cut instead: as
//! many triangles, of the same corners. No library does the cutting: those available drop
//! corners on straight edges, and then neighbours no longer meet.

mod ears;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};

use super::normals::corners;
use ears::Ears;

/// How much of a polygon's area a fan may cover twice: what rounding to six digits does to corners
/// on a line.
const TOLERANCE: f64 = 1e-6;

/// Corners that are tried as being within an ear, for each corner of a polygon.
const TRIES_PER_CORNER: u64 = 1 << 8;

/// Further ones for all polygons of a file together.
const TRIES_PER_FILE: u64 = 1 << 27;

/// A polygon that was cut into a fan.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    /// Its number among the faces of the file, from 0.
    face: u32,
    /// The first of its triangles.
    triangle: u32,
    /// 4 or more.
    corners: u32,
}

/// The polygons of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    polygons: Vec<Polygon>,
}

/// Why a polygon can't be cut well.
enum Flaw {
    /// Its edges cross.
    Crossing,
    /// It has too many concave corners.
    Effort,
}

impl Polygons {
    /// Says that face number `face` of the file became a fan of `corners - 2` triangles, from
    /// number `triangle` on.
    pub(super) fn push(&mut self, face: usize, triangle: usize, corners: usize) {
        if corners > 3 {
            let [face, triangle, corners] = [face, triangle, corners].map(|n| n as u32);
            self.polygons.push(Polygon { face, triangle, corners });
        }
    }

    /// Cuts anew the polygons whose fans cover something else. `faces` are the triangles of the
    /// file, whose vertices are finite; `others` has what else belongs to their corners, where
    /// that is not empty. Says which polygons could not be cut well.
    ///
    /// Takes a time proportional to the file plus a bound: polygons beyond the bound stay fans.
    pub(super) fn cut(
        &self,
        positions: &[DVec3],
        faces: &mut [[u32; 3]],
        others: [&mut [[u32; 3]]; 2],
    ) -> Vec<String> {
        let mut tries = TRIES_PER_FILE;
        let mut flaws = [(0, 0); 2];
        let [first, second] = others;
        for polygon in &self.polygons {
            let range =
                polygon.triangle as usize..(polygon.triangle + polygon.corners - 2) as usize;
            let Err(normal) = check_fan(positions, &faces[range.clone()]) else { continue };
            let cut = polygon.ears(positions, &faces[range.clone()], normal, &mut tries);
            let flaw = match cut {
                Ok((triangles, flaw)) => {
                    let lists = [&mut *faces, &mut *first, &mut *second];
                    for list in lists.into_iter().filter_map(|list| list.get_mut(range.clone())) {
                        rearrange(list, &triangles);
                    }
                    flaw
                }
                Err(flaw) => Some(flaw),
            };
            if let Some(flaw) = flaw {
                let (count, face) = &mut flaws[flaw as usize];
                *face = if *count == 0 { polygon.face } else { *face };
                *count += 1;
            }
        }
        let [crossing, effort] = flaws;
        [
            warning(crossing, "crosses itself and may be", "cross themselves and may be"),
            warning(
                effort,
                "has too many inner corners and is",
                "have too many inner corners and are",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// The warning about polygons with a flaw, by their number and the first face.
fn warning((count, face): (usize, u32), one: &str, many: &str) -> Option<String> {
    match count {
        0 => None,
        1 => Some(format!("1 polygon {one} cut into wrong triangles (face {face})")),
        _ => Some(format!(
            "{count} polygons {many} cut into wrong triangles (the first is face {face})"
        )),
    }
}

/// Whether the triangles of a fan lie side by side; otherwise the normal of their polygon, whose
/// length is twice its area.
fn check_fan(positions: &[DVec3], fan: &[[u32; 3]]) -> Result<(), DVec3> {
    let normal = |&face: &[u32; 3]| {
        let [a, b, c] = corners(positions, face);
        (b - a).cross(c - a)
    };
    let whole: DVec3 = fan.iter().map(normal).sum();
    let least = -TOLERANCE * whole.length_squared();
    let is_turned = |face| normal(face).dot(whole) < least;
    // A polygon that has no area, but triangles that have one, crosses itself.
    let is_nothing = whole == DVec3::ZERO && fan.iter().any(|face| normal(face) != DVec3::ZERO);
    if is_nothing || fan.iter().any(is_turned) { Err(whole) } else { Ok(()) }
}

impl Polygon {
    /// Triangles of the polygon, as numbers of its corners.
    fn ears(
        self,
        positions: &[DVec3],
        fan: &[[u32; 3]],
        normal: DVec3,
        tries: &mut u64,
    ) -> Result<(Vec<[u32; 3]>, Option<Flaw>), Flaw> {
        let flatten = onto_plane(normal).ok_or(Flaw::Crossing)?;
        let points =
            (0..self.corners).map(|corner| flatten(positions[fan_corner(fan, corner) as usize]));
        let own = u64::from(self.corners) * TRIES_PER_CORNER;
        let mut allowed = own + *tries;
        let cut = Ears::new(points.collect()).cut(&mut allowed);
        *tries = allowed.min(*tries);
        let (triangles, is_simple) = cut.ok_or(Flaw::Effort)?;
        Ok((triangles, (!is_simple).then_some(Flaw::Crossing)))
    }
}

/// Projects along the axis that is nearest to the normal, so that no coordinate is rounded, and
/// polygons with that normal are counter-clockwise. `None` if there is no normal.
fn onto_plane(normal: DVec3) -> Option<impl Fn(DVec3) -> DVec2> {
    let axis = normal.abs().max_position();
    let length = normal[axis];
    if length == 0.0 || !length.is_finite() {
        return None;
    }
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    let (x, y) = if length > 0.0 { (first, second) } else { (second, first) };
    Some(move |p: DVec3| DVec2::new(p[x], p[y]))
}

/// A corner of the polygon that was cut into a fan.
fn fan_corner(fan: &[[u32; 3]], corner: u32) -> u32 {
    match corner {
        0 | 1 => fan[0][corner as usize],
        _ => fan[corner as usize - 2][2],
    }
}

/// Replaces a fan by other triangles of the same corners.
fn rearrange(fan: &mut [[u32; 3]], triangles: &[[u32; 3]]) {
    let corners: Vec<u32> = (0..fan.len() as u32 + 2).map(|c| fan_corner(fan, c)).collect();
    for (slot, triangle) in fan.iter_mut().zip(triangles) {
        *slot = triangle.map(|corner| corners[corner as usize]);
    }
}
