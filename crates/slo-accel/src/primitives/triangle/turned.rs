//! Rays prepared for the [test](super) of triangles in bulk: plain arithmetic on one lane, inlined
//! into loops over all lanes, which become vector code of the caller's instruction set.

use crate::rays::LANES;

/// A ray in the axes of [`ShearedRay`](super::ShearedRay).
pub(crate) struct Turned {
    pub(crate) origin: [f32; 3],
    pub(crate) shear: [f32; 3],
    /// Which axis of space is z of the sheared ones; x and y follow it in cyclic order.
    pub(crate) z_axis: u32,
    /// Size of the direction's largest component.
    pub(crate) largest: f32,
}

impl Turned {
    #[inline(always)]
    pub(crate) fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let [ax, ay, az] = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
        let x_is_largest = ax >= ay && ax >= az;
        let y_is_largest = !x_is_largest && ay >= az;
        let turn = |[x, y, z]: [f32; 3]| {
            if x_is_largest {
                [y, z, x]
            } else if y_is_largest {
                [z, x, y]
            } else {
                [x, y, z]
            }
        };
        let [x, y, z] = turn(direction);
        Self {
            origin: turn(origin),
            shear: [x / z, y / z, 1.0 / z],
            z_axis: if x_is_largest { 0 } else { 2 - u32::from(y_is_largest) },
            largest: z.abs(),
        }
    }
}

/// The larger; `b` if one is NaN. It is a single instruction; `f32::max` is several.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller; `b` if one is NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Sixteen elements of each of three arrays.
#[inline(always)]
pub(crate) fn lanes_from(arrays: &[Vec<f32>; 3], first: usize) -> [[f32; LANES]; 3] {
    let mut lanes = [[0.0; LANES]; 3];
    for axis in 0..3 {
        lanes[axis].copy_from_slice(&arrays[axis][first..first + LANES]);
    }
    lanes
}
