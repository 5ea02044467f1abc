//! Tangents of meshes, packed.

/// Steps of the first octahedral coordinate on either side of 0.
const STEPS_X: f32 = 32767.0;

/// Steps of the second one, which leaves a bit for the side.
const STEPS_Y: f32 = 16383.0;

/// The tangent of a corner of a mesh, in four bytes: its direction to 0.01 degrees, and on which
/// side the bitangent lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tangent(u32);

impl Tangent {
    /// The x axis, not mirrored.
    pub(super) const ALONG_X: Self = Self((2 * STEPS_X as u32) << 16 | (STEPS_Y as u32) << 1);

    /// Packs a direction, which need not be unit; `None` if it has no length.
    ///
    /// If `is_mirrored`, the bitangent is the cross product of tangent and normal, otherwise that of
    /// normal and tangent.
    pub fn new(direction: [f32; 3], is_mirrored: bool) -> Option<Self> {
        let [x, y, z] = direction;
        let sum = x.abs() + y.abs() + z.abs();
        if !(sum.is_finite() && sum > 0.0) {
            return None;
        }
        let [x, y] = if z < 0.0 {
            let [x, y] = [x / sum, y / sum];
            [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)]
        } else {
            [x / sum, y / sum]
        };
        let steps = |value: f32, steps: f32| ((value * steps).round() + steps) as u32;
        let [x, y] = [steps(x, STEPS_X), steps(y, STEPS_Y)];
        Some(Self(x << 16 | y << 1 | u32::from(is_mirrored)))
    }

    /// The unit tangent; then 1, or -1 if mirrored: the bitangent is so many times the cross product of
    /// normal and tangent.
    #[inline]
    pub fn unpacked(self) -> [f32; 4] {
        let x = ((self.0 >> 16) as f32 - STEPS_X) / STEPS_X;
        let y = ((self.0 >> 1 & 0x7fff) as f32 - STEPS_Y) / STEPS_Y;
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        let [x, y] = [x - fold.copysign(x), y - fold.copysign(y)];
        let length = (x * x + y * y + z * z).sqrt();
        let side = if self.0 & 1 == 0 { 1.0 } else { -1.0 };
        [x / length, y / length, z / length, side]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_survive_packing() {
        let mut worst = 0.0_f32;
        for i in 0..20_000 {
            // Points of a spiral around the sphere.
            let z = 1.0 - 2.0 * (i as f32 + 0.5) / 20_000.0;
            let (sin, cos) = libm::sincosf(i as f32 * 2.399_963);
            let radius = (1.0 - z * z).sqrt();
            let direction = [radius * cos, radius * sin, z];
            let mirrored = i % 2 == 1;
            let [x, y, z, side] = Tangent::new(direction, mirrored).expect("it is unit").unpacked();
            assert_eq!(side, if mirrored { -1.0 } else { 1.0 });
            assert!((x * x + y * y + z * z - 1.0).abs() < 1e-6);
            let error = [x - direction[0], y - direction[1], z - direction[2]];
            worst = error.into_iter().map(f32::abs).fold(worst, f32::max);
        }
        assert!(worst < 1.7e-4, "{worst}");
    }

    #[test]
    fn axes_are_exact() {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut direction = [0.0; 3];
                direction[axis] = sign * 5.0;
                let [x, y, z, _] =
                    Tangent::new(direction, false).expect("it has a length").unpacked();
                assert_eq!([x, y, z], direction.map(|c| c / 5.0));
            }
        }
        for none in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(Tangent::new(none, false), None);
        }
    }
}
