//! Where the copies of a list of placements are.

use glam::{DMat3, DQuat, DVec3};

use super::affine::DAffine;
use super::rigid::DRigid;
use crate::placements::Placements;

/// Where one of many copies is, in the space of their list.
pub fn placed(placements: &Placements, copy: usize) -> DAffine {
    let translation = placements.positions[copy];
    let rotation = placements.turns.get(copy).map_or(DMat3::IDENTITY, |turn| {
        DMat3::from_quat(DQuat::from_array(turn.map(f64::from)).normalize())
    });
    let rigid = DRigid { rotation, translation };
    match placements.scales.get(copy) {
        Some(scale) => DAffine::scaled(DVec3::from(scale.map(f64::from)), rigid),
        None => rigid.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placement_scales_turns_and_moves() {
        let half = 0.5_f32.sqrt();
        let placements = Placements {
            positions: vec![DVec3::new(1.0, 2.0, 3.0)],
            turns: vec![[0.0, 0.0, half, half]], // a quarter about z
            scales: vec![[2.0, 1.0, 1.0]],
            ..Placements::default()
        };
        let found = placed(&placements, 0).point(DVec3::ONE);
        assert!((found - DVec3::new(0.0, 4.0, 4.0)).length() < 1e-7, "{found}");
        assert_eq!((placements.kind(0), placements.tint(0), placements.len()), (0, None, 1));
        let plain = Placements { positions: vec![DVec3::X], ..Placements::default() };
        assert!(placed(&plain, 0).is_rigid() && !plain.is_empty());
    }
}
