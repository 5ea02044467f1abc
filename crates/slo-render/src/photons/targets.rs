//! Where photons are sent: spheres about everything with sharp lobes.

use glam::Vec3;
use slo_accel::math::Bounds;

/// Most targets of a frame.
const MOST: usize = 16;

/// Something with sharp lobes, and how much light they reflect or let through.
#[derive(Clone, Copy, Debug)]
pub struct Sharp {
    /// Where it is during the shutter.
    pub bounds: Bounds,
    /// Greatest distance of any of its points from the middle of `bounds`.
    pub reach: f32,
    /// Share of the light.
    pub share: f32,
}

/// A sphere that photons are sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// How much of the light that arrives goes on from there: the largest share of anything inside.
    pub(super) share: f32,
}

impl Target {
    /// The sphere about some things, of which there is at least one.
    fn about(things: &[Sharp]) -> Self {
        let bounds = things.iter().fold(Bounds::EMPTY, |all, thing| all.union(thing.bounds));
        let (center, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        let reach = things.iter().fold(0.0f32, |most, thing| {
            let middle = (thing.bounds.min + thing.bounds.max) * 0.5;
            most.max((middle - center).length() + thing.reach)
        });
        // A margin for rounding, and for photons along the sphere's side.
        let far = bounds.min.abs().max(bounds.max.abs()).max_element();
        let radius = half.length().min(reach) * 1.001 + far * 1e-5 + f32::MIN_POSITIVE;
        Self { center, radius, share: things.iter().fold(0.0, |most, thing| most.max(thing.share)) }
    }
}

/// Returns at most 16 spheres about some things. What lies close together shares one.
pub fn targets(things: &[Sharp]) -> Vec<Target> {
    let mut clusters: Vec<Vec<Sharp>> =
        if things.is_empty() { vec![] } else { vec![things.into()] };
    while clusters.len() < MOST {
        let size = |cluster: &Vec<Sharp>| {
            if cluster.len() < 2 { 0.0 } else { Target::about(cluster).radius }
        };
        let largest = (0..clusters.len()).max_by(|&a, &b| {
            // Of equal ones, the first.
            size(&clusters[a]).total_cmp(&size(&clusters[b])).then(b.cmp(&a))
        });
        let Some(largest) = largest.filter(|&i| size(&clusters[i]) > 0.0) else { break };
        let (low, high) = split(&clusters[largest]);
        clusters[largest] = low;
        clusters.insert(largest + 1, high);
    }
    clusters.iter().map(|cluster| Target::about(cluster)).collect()
}

/// Splits two or more things into halves along the axis in which their middles spread most.
fn split(things: &[Sharp]) -> (Vec<Sharp>, Vec<Sharp>) {
    let middle = |thing: &Sharp| (thing.bounds.min + thing.bounds.max) * 0.5;
    let about = Bounds::of_points(things.iter().map(middle));
    let size = about.max - about.min;
    let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
    let mut sorted = things.to_vec();
    sorted.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    // Where the gap between neighbours is largest, things belong together least.
    let gap = |i: &usize| middle(&sorted[*i])[axis] - middle(&sorted[*i - 1])[axis];
    let at = (1..sorted.len()).fold(1, |best, i| if gap(&i) > gap(&best) { i } else { best });
    let high = sorted.split_off(at);
    (sorted, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f32, radius: f32) -> Sharp {
        let center = Vec3::new(x, 0.0, 0.0);
        let bounds = Bounds { min: center - radius, max: center + radius };
        Sharp { bounds, reach: radius, share: 1.0 }
    }

    #[test]
    fn few_things_have_a_sphere_each_and_many_share() {
        assert_eq!(targets(&[]), []);
        let few: Vec<Sharp> = (0..5).map(|i| ball(i as f32 * 4.0, 0.5)).collect();
        let found = targets(&few);
        assert_eq!(found.len(), 5);
        assert!(found.iter().all(|target| target.radius < 0.51));
        let many: Vec<Sharp> = (0..1000).map(|i| ball(i as f32, 0.5)).collect();
        let found = targets(&many);
        assert_eq!(found.len(), MOST);
        for thing in &many {
            let is_covered = found.iter().any(|target| {
                let middle = (thing.bounds.min + thing.bounds.max) * 0.5;
                (middle - target.center).length() + thing.reach <= target.radius
            });
            assert!(is_covered, "{:?}", thing.bounds);
        }
    }
}
