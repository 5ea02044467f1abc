//! Moves vertices of a mesh in a file of any format, as in the window onto a scene, and reads what saving writes.

use slo_accel::glam::DVec3;
use crate::pieces::{self, Numbers};
use crate::within_limits;
use slo_scene::mesh;
use slo_view::fuzzing;

/// A long mesh is not copied for every byte of an input.
const MOST_MOVES: usize = 20;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let (moves, files) = pieces::files(data);
        let Some((name, bytes)) = files.first() else { return };
        let mut numbers = Numbers::of(moves);
        let options = numbers.byte();
        let (smooth, is_y_up) = (options & 1 > 0, options & 2 > 0);
        let read = |name: &str, bytes: &[u8]| mesh::load(name, &mut &*bytes, smooth, 1.0);
        let Ok(shown) = read(name, bytes) else { return };
        let mut moves = Vec::new();
        while !numbers.is_empty() && moves.len() < MOST_MOVES {
            let vertex = numbers.below(shown.mesh.positions.len() + 1) as u32;
            let to = [(); 3].map(|()| f64::from(numbers.coordinate()));
            moves.push((vertex, DVec3::from(to)));
        }
        let file = fuzzing::sculpted(&shown.mesh, is_y_up, &moves).expect("finite coordinates");
        let saved = read("a.slo", &file);
        if moves.is_empty() {
            let (saved, shown) = (saved.expect("a mesh").mesh, shown.mesh);
            let in_file = |p: &DVec3| if is_y_up { DVec3::new(p.x, p.z, -p.y) } else { *p };
            let expected: Vec<_> = shown.positions.iter().map(in_file).collect();
            assert_eq!((saved.positions, saved.faces), (expected, shown.faces));
            assert_eq!(saved.normals.len(), shown.normals.len());
        }
        if let Some((_, text)) = files.get(1) {
            fuzzing::with_new_file(&String::from_utf8_lossy(text), "a");
        }
    });
}
