//! What the choice of lights knows of a light.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

/// Bounds of where a light is, where it shines, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Lower corner of the box about the light. For a distant light, of the box about the unit
    /// directions toward it.
    pub min: Vec3,
    /// Upper corner of the box.
    pub max: Vec3,
    /// Unit axis of the directions in which the light shines most.
    pub axis: Vec3,
    /// Angle about `axis` within which lie all directions in which it shines most, radians; pi: it
    /// shines all round.
    pub spread: f32,
    /// Whether it also shines up to a right angle from these directions, by the cosine.
    pub is_flat: bool,
    /// Whether it shines along `-axis` as along `axis`.
    pub two_sided: bool,
    /// Luminance of what a surface receives that faces the light and lies where it shines most:
    /// the irradiance, times the square of the distance if the light falls off.
    pub energy: f32,
    /// Whether its light falls off with the square of the distance.
    pub falls_off: bool,
    /// Whether it is infinitely far away.
    pub is_distant: bool,
}

impl LightBounds {
    /// Bounds of a light that shines all round from within a box, and falls off.
    pub fn all_round([min, max]: [Vec3; 2], energy: f32) -> Self {
        Self {
            min,
            max,
            axis: Vec3::Z,
            spread: PI,
            is_flat: false,
            two_sided: false,
            energy,
            falls_off: true,
            is_distant: false,
        }
    }

    /// Bounds of a flat light with these corners, which falls off.
    pub fn flat(corners: &[Vec3], normal: Vec3, two_sided: bool, energy: f32) -> Self {
        let first = corners[0];
        let [min, max] = corners.iter().fold([first; 2], |[min, max], &p| [min.min(p), max.max(p)]);
        Self {
            axis: normal,
            spread: 0.0,
            is_flat: true,
            two_sided,
            ..Self::all_round([min, max], energy)
        }
    }

    /// Returns the bounds of the light in each of several poses: turned, then moved. Returns the
    /// bounds as they are if there are no poses.
    #[must_use]
    pub fn in_poses(self, poses: impl Iterator<Item = (Mat3, Vec3)>) -> Self {
        let one = |(rotation, translation): (Mat3, Vec3)| {
            let translation = if self.is_distant { Vec3::ZERO } else { translation };
            let center = rotation * ((self.min + self.max) * 0.5) + translation;
            let half = (self.max - self.min) * 0.5;
            let half = rotation.x_axis.abs() * half.x
                + rotation.y_axis.abs() * half.y
                + rotation.z_axis.abs() * half.z;
            let margin = Vec3::splat((center.abs() + half).max_element() * 1e-6);
            Self {
                min: center - half - margin,
                max: center + half + margin,
                axis: rotation * self.axis,
                ..self
            }
        };
        let all: Vec<Self> = poses.map(one).collect();
        Self::about(&mut all.iter().copied())
            .map_or(self, |about| Self { energy: self.energy, ..about })
    }

    /// Returns the bounds of several lights together; `None` if there are none.
    pub(super) fn about(lights: &mut (impl Iterator<Item = Self> + Clone)) -> Option<Self> {
        let first = lights.clone().next()?;
        let two_sided = lights.clone().all(|light| light.two_sided);
        let mixed = !two_sided && lights.clone().any(|light| light.two_sided);
        let aligned = |axis: Vec3| {
            if two_sided && axis.dot(first.axis) < 0.0 { -axis } else { axis }
        };
        let sum: Vec3 = lights.clone().map(|light| aligned(light.axis)).sum();
        let axis = sum.try_normalize().unwrap_or(first.axis);
        let (mut spread, mut energy) = (if mixed { PI } else { 0.0f32 }, 0.0f64);
        let mut all = Self { axis, two_sided, is_flat: false, ..first };
        for light in lights {
            all.min = all.min.min(light.min);
            all.max = all.max.max(light.max);
            all.is_flat |= light.is_flat;
            energy += f64::from(light.energy);
            if spread < PI {
                let cos = axis.dot(aligned(light.axis)).clamp(-1.0, 1.0);
                // The cosine is rounded.
                let off = if light.axis == axis { 0.0 } else { libm::acosf(cos) + 1e-3 };
                spread = spread.max(off + light.spread);
            }
        }
        // Both sides together shine all round from a right angle on.
        let most = if two_sided { 0.5 * PI } else { PI };
        Some(Self { spread: spread.min(most), energy: energy as f32, ..all })
    }
}
