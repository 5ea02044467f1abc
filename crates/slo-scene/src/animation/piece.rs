//! One cubic piece of an object's path.

use glam::{DMat3, DVec3};

use super::bezier::cubic;
use super::orientation::{DEGENERATE, orientation, perpendicular, unit};
use super::rigid::DRigid;

/// From one key to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) pivot: [DVec3; 4],
    pub(super) up: [DVec3; 4],
    pub(super) right: [DVec3; 4],
    pub(super) scale: [DVec3; 4],
}

impl Piece {
    /// The pose at `u` in (0, 1); `rotation_before` is the orientation of the key at its start.
    pub(super) fn pose(&self, u: f64, rotation_before: DMat3) -> DRigid {
        let rotation = self.orientation(u).or_else(|| self.orientation_before(u));
        DRigid { rotation: rotation.unwrap_or(rotation_before), translation: cubic(&self.pivot, u) }
    }

    fn orientation(&self, u: f64) -> Option<DMat3> {
        (self.health(u) > DEGENERATE)
            .then(|| orientation(cubic(&self.right, u), cubic(&self.up, u)))
            .flatten()
    }

    /// The orientation a little before `u`. States without orientation are isolated: up x right
    /// is a polynomial of degree 6 that is not zero at the keys.
    fn orientation_before(&self, u: f64) -> Option<DMat3> {
        (1..24).rev().find_map(|k| self.orientation(u - u / (1_u64 << k) as f64 / 4.0))
    }

    /// Distance of up and right from a state without orientation: the smaller of the length of
    /// right and of what of up is perpendicular to it, in lengths of the control points.
    fn health(&self, u: f64) -> f64 {
        let scale = |curve: &[DVec3; 4]| curve.iter().fold(0.0, |m: f64, p| m.max(p.length()));
        let [right, up] = [cubic(&self.right, u), cubic(&self.up, u)];
        let Some(axis) = unit(right) else { return 0.0 };
        let Some(direction) = perpendicular(axis, up) else { return 0.0 };
        (right.length() / scale(&self.right)).min(up.dot(direction) / scale(&self.up))
    }

    /// Whether nothing changes along the piece.
    pub(super) fn rests(&self) -> bool {
        [self.pivot, self.up, self.right, self.scale].iter().all(is_constant)
    }

    /// Parameters in (0, 1) between which the orientation jumps.
    pub(super) fn collapses(&self) -> Vec<f64> {
        const STEPS: usize = 128;
        if is_constant(&self.up) && is_constant(&self.right) {
            return vec![];
        }
        let at = |i: usize| i as f64 / STEPS as f64;
        let health: Vec<f64> = (0..=STEPS).map(|i| self.health(at(i))).collect();
        (1..STEPS)
            .filter(|&i| health[i] <= health[i - 1] && health[i] < health[i + 1])
            .map(|i| self.weakest(at(i - 1), at(i + 1)))
            .filter(|&u| self.health(u) <= DEGENERATE && self.leaps_at(u))
            .collect()
    }

    /// Where health has its minimum between two parameters that hold one.
    fn weakest(&self, mut low: f64, mut high: f64) -> f64 {
        for _ in 0..100 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if self.health(a) <= self.health(b) {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }

    fn leaps_at(&self, u: f64) -> bool {
        let around = [u - 1e-3, u + 1e-3].map(|u| self.orientation(u));
        let [Some(a), Some(b)] = around else { return true };
        (0..3).any(|axis| a.col(axis).dot(b.col(axis)) < 0.99)
    }
}

fn is_constant(curve: &[DVec3; 4]) -> bool {
    curve.iter().all(|point| *point == curve[0])
}
