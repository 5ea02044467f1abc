//! Key frames that say nothing new are left out.

use crate::model::{Key, Pose, pose_at};

/// How far a pose may be off, as a share of its numbers.
const TOLERANCE: f64 = 1e-6;

/// Leaves out keys that lie on an even way between others. At least one stays.
pub(crate) fn thin(keys: &mut Vec<Key>) {
    if keys.len() < 2 {
        return;
    }
    let mut keeps = vec![false; keys.len()];
    let last = keys.len() - 1;
    (keeps[0], keeps[last]) = (true, true);
    // Where the way between two keys is off the most, it is divided.
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let ends = [keys[from], keys[to]];
        let off = |i: usize| distance(&keys[i].pose, &pose_at(&ends, keys[i].time));
        let worst = (from + 1..to).map(|i| (i, off(i))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((middle, _)) = worst.filter(|(_, off)| *off > TOLERANCE) {
            keeps[middle] = true;
            open.extend([(from, middle), (middle, to)]);
        }
    }
    let mut keeps = keeps.into_iter();
    keys.retain(|_| keeps.next().unwrap_or(true));
    if let [a, b] = keys[..]
        && distance(&a.pose, &b.pose) <= TOLERANCE
    {
        keys.truncate(1);
    }
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    let size = a.pivot.abs().max_element().max(1.0);
    let pivot = (a.pivot - b.pivot).abs().max_element() / size;
    let scale =
        ((a.scale - b.scale) / a.scale.abs().max(glam::DVec3::splat(1e-12))).abs().max_element();
    let turn = (a.turn - b.turn).length().min((a.turn + b.turn).length());
    pivot.max(scale).max(turn)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn left(ways: &[f64]) -> Vec<f64> {
        let key = |(i, &x): (usize, &f64)| {
            let pivot = DVec3::new(x, 0.0, 0.0);
            Key { time: i as f64, pose: Pose { pivot, ..Pose::default() } }
        };
        let mut keys = ways.iter().enumerate().map(key).collect();
        thin(&mut keys);
        keys.iter().map(|key| key.time).collect()
    }

    #[test]
    fn what_is_even_needs_two_keys() {
        assert_eq!(left(&[0.0, 1.0, 2.0, 3.0]), [0.0, 3.0]);
        assert_eq!(left(&[5.0, 5.0, 5.0]), [0.0]);
        assert_eq!(left(&[0.0, 0.0, 1.0, 1.0]), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(left(&[0.0, 1.0, 4.0]), [0.0, 1.0, 2.0]);
    }
}
