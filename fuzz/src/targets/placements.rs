//! A `.ply` file of the placements of copies.

use crate::within_limits;
use slo_scene::{Files, load};

const SCENE: &str = "Camera c { fps 25 Film f { width 4 height 3 prefix a output PNG_IMAGE } CamSegment s {
    videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1 blurDuration 0 addPosition { 0 -5 1 } addTarget { 0 0 0 }
    skyStart { 0 0 1 } fovStart 0.4 dofStart 5 lensRadiusStart 0 } }
phong_info m { ambient { 0 0 0 } diffuse { 1 1 1 } reflectance 0 }
material_phong m { phong_info m }
sphere a { center { 0 0 0 } radius 1 material m }
sphere b { center { 0 0 0 } radius 2 material m }
copies row { of a of b placements a.ply }
";

pub(crate) fn run(data: &[u8]) {
    within_limits(data, |data| {
        let files = vec![("a.ply".to_owned(), data.to_vec())];
        let loaded = load("scene.txt", SCENE, &Files::in_memory("", files));
        loaded.diagnostics.render(false);
        let Some(scene) = loaded.scene else { return };
        let placements = scene.copies[0].placements.as_deref().expect("placements without errors");
        let count = placements.len();
        assert!(placements.positions.iter().all(|position| position.is_finite()));
        for length in [
            placements.turns.len(),
            placements.scales.len(),
            placements.kinds.len(),
            placements.tints.len(),
        ] {
            assert!(length == 0 || length == count, "a column is as long as all others");
        }
        for turn in &placements.turns {
            let square: f32 = turn.iter().map(|part| part * part).sum();
            assert!((square - 1.0).abs() < 1e-4, "{turn:?} has length 1");
        }
        let is_scale = |scale: &f32| scale.is_finite() && *scale > 0.0;
        assert!(placements.scales.as_flattened().iter().all(is_scale));
        assert!(placements.kinds.iter().all(|kind| *kind < 2));
        let is_tint = |part: &f32| part.is_finite() && *part >= 0.0;
        assert!(placements.tints.as_flattened().iter().all(is_tint));
    });
}
