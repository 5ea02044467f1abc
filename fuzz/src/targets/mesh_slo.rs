//! A mesh in a `.slo` file, by itself and as one of several shapes.

use crate::within_limits;
use slo_scene::mesh;

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        for smooth in [false, true] {
            if let Ok(loaded) = mesh::load("a.slo", &mut &data[..], smooth, 0.5) {
                let mesh = loaded.mesh;
                assert!(mesh.positions.iter().all(|position| position.is_finite()));
                let count = mesh.positions.len();
                assert!(mesh.faces.as_flattened().iter().all(|corner| (*corner as usize) < count));
            }
        }
        let _ = mesh::load_shape("a.slo", &mut &data[..], true, 2.0);
    });
}
