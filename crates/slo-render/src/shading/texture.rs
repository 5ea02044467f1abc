//! Texture lookup, on surfaces and all around.

use slo_accel::math::elementary::{atan2_turns, sin_cos_turns};
use slo_scene::{Curve, Filter, Texture, Wrap};

/// Returns the image's colour at `(u, v)` as Phong materials see it: in the file's values, unless
/// the texture names a curve, and as it stands in the file where it is transparent.
///
/// Coordinates are those of [`sample`].
#[inline(always)]
pub fn sample_bilinear(texture: &Texture, u: f32, v: f32) -> [f32; 3] {
    let is_plain = texture.wrap() == Wrap::Repeat
        && texture.filter() == Filter::Linear
        && texture.data_curve() == Curve::Raw;
    if !is_plain {
        return sample_stored(texture, texture.data_curve(), u, v);
    }
    let columns = repeated(u, texture.width());
    let (below, above, fy) = repeated(v, texture.height());
    let row = |from_bottom| {
        let y = texture.height() - 1 - from_bottom;
        let (left, right, fx) = columns;
        mix(texture.texel(left, y), texture.texel(right, y), fx)
    };
    mix(row(below), row(above), fy)
}

/// Returns the image's colour and alpha at `(u, v)`. `curve` is removed from the colour of each
/// texel before interpolation. Colour is not multiplied by alpha, even if the file's is, except
/// where alpha is 0.
///
/// The image fills the unit square and continues as its [`Wrap`] says. `v` = 0 is its bottom edge,
/// and `v` grows upwards; texel centres lie at half integers. A coordinate that is not finite
/// counts as 0.
pub fn sample(texture: &Texture, curve: Curve, u: f32, v: f32) -> [f32; 4] {
    let at = Neighbours::of(texture, u, v);
    let [r, g, b, a] = at.interpolate(texture, |x, y| texture.decoded_rgba(x, y, curve));
    if texture.is_premultiplied() && a > 0.0 {
        return [r / a, g / a, b / a, a];
    }
    [r, g, b, a]
}

/// As [`sample`], but colours that are multiplied by alpha stay so: what stands in front of black.
fn sample_stored(texture: &Texture, curve: Curve, u: f32, v: f32) -> [f32; 3] {
    let at = Neighbours::of(texture, u, v);
    at.interpolate(texture, |x, y| texture.decoded(x, y, curve))
}

/// Returns the colour that an equirectangular image shows in a direction, with z up. Its length may be
/// from 1e-15 to 1e15.
///
/// The middle of the image lies toward +x, its left half toward +y. Columns wrap; beyond the
/// centres of the first and last row, colours are those of the row. The texture's [`Wrap`] has no
/// effect, its filter has. Colours that are multiplied by alpha stay so.
pub fn sample_equirect(texture: &Texture, curve: Curve, direction: [f32; 3]) -> [f32; 3] {
    sample_around(texture, curve, equirect_uv(direction))
}

/// As [`sample_equirect`], in the direction that the image shows at `(u, v)`.
#[inline(always)]
pub fn sample_around(texture: &Texture, curve: Curve, [u, v]: [f32; 2]) -> [f32; 3] {
    let (left, right, fx) = neighbours(u, texture.width(), Wrap::Repeat, texture.filter());
    let (below, above, fy) = neighbours(v, texture.height(), Wrap::Clamp, texture.filter());
    let [below, above] = [below, above].map(|from_bottom| texture.height() - 1 - from_bottom);
    let places = [(left, below), (right, below), (left, above), (right, above)];
    let [a, b, c, d] = texture.decoded_each(places, curve);
    mix(mix(a, b, fx), mix(c, d, fx), fy)
}

/// Returns where an equirectangular image shows a direction: `u` from 0 at its left edge, `v` from
/// 0 at its bottom edge, both up to 1.
#[inline(always)]
pub fn equirect_uv([x, y, z]: [f32; 3]) -> [f32; 2] {
    let horizontal = (x * x + y * y).sqrt();
    [0.5 - atan2_turns(y, x), elevation_v(z, horizontal)]
}

/// Returns where an equirectangular image shows directions with a height and a length in the
/// horizontal plane, from 0 at its bottom edge to 1.
#[inline(always)]
pub fn elevation_v(z: f32, horizontal: f32) -> f32 {
    0.5 + 2.0 * atan2_turns(z, horizontal)
}

/// Returns the direction, of length 1, that an equirectangular image shows at `(u, v)`.
#[inline(always)]
pub fn equirect_direction(u: f32, v: f32) -> [f32; 3] {
    let (sin_phi, cos_phi) = sin_cos_turns(0.5 - u);
    let (sin_elevation, cos_elevation) = sin_cos_turns(0.5 * v - 0.25);
    [cos_elevation * cos_phi, cos_elevation * sin_phi, sin_elevation]
}

/// Texels around a place, and the weight of the second of two.
type Pair = (u32, u32, f32);

/// The texels around a place of an image: columns from the left, rows from the bottom.
struct Neighbours {
    columns: Pair,
    rows: Pair,
}

impl Neighbours {
    #[inline(always)]
    fn of(texture: &Texture, u: f32, v: f32) -> Self {
        let along =
            |coordinate, size| neighbours(coordinate, size, texture.wrap(), texture.filter());
        Self { columns: along(u, texture.width()), rows: along(v, texture.height()) }
    }

    /// Interpolates between four texels; `texel` takes a column from the left and a row from the
    /// top.
    #[inline(always)]
    fn interpolate<const N: usize>(
        &self,
        texture: &Texture,
        texel: impl Fn(u32, u32) -> [f32; N],
    ) -> [f32; N] {
        let (left, right, fx) = self.columns;
        let (below, above, fy) = self.rows;
        let row = |from_bottom| {
            let y = texture.height() - 1 - from_bottom;
            if fx == 0.0 { texel(left, y) } else { mix(texel(left, y), texel(right, y), fx) }
        };
        if fy == 0.0 { row(below) } else { mix(row(below), row(above), fy) }
    }
}

/// Returns the two texels, in a row of `size` texels, on either side of a coordinate.
#[inline(always)]
fn neighbours(coordinate: f32, size: u32, wrap: Wrap, filter: Filter) -> Pair {
    match (filter, wrap) {
        (Filter::Linear, Wrap::Repeat) => repeated(coordinate, size),
        (Filter::Linear, Wrap::Clamp | Wrap::Mirror) => {
            let x = within(coordinate, wrap) * size as f32 - 0.5;
            let first = x.floor();
            let last = (size - 1) as f32;
            let at = |texel: f32| texel.clamp(0.0, last) as u32;
            (at(first), at(first + 1.0), x - first)
        }
        (Filter::Nearest, _) => {
            let texel = (within(coordinate, wrap) * size as f32) as u32;
            let texel = texel.min(size - 1);
            (texel, texel, 0.0)
        }
    }
}

/// Returns the coordinate from 0 to 1 that shows the same as `coordinate`.
#[inline(always)]
fn within(coordinate: f32, wrap: Wrap) -> f32 {
    if !coordinate.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
        Wrap::Mirror => {
            let of_two = coordinate - 2.0 * (0.5 * coordinate).floor();
            if of_two > 1.0 { 2.0 - of_two } else { of_two }
        }
    }
}

/// As [`neighbours`], of an image that repeats and is interpolated.
#[inline(always)]
fn repeated(coordinate: f32, size: u32) -> Pair {
    let fraction = coordinate - coordinate.floor();
    let x = if fraction.is_finite() { fraction * size as f32 - 0.5 } else { -0.5 };
    let first = x.floor();
    // Left of the first texel's centre, the neighbour is the last texel of the previous repetition.
    let i = if first < 0.0 { size - 1 } else { (first as u32).min(size - 1) };
    let j = if i + 1 == size { 0 } else { i + 1 };
    (i, j, x - first)
}

/// Interpolates linearly from `a` (`t` = 0) to `b` (`t` = 1).
#[inline(always)]
fn mix<const N: usize>(a: [f32; N], b: [f32; N], t: f32) -> [f32; N] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grey values of 8 bits, the top row first.
    fn image<const W: usize>(rows: &[[u8; W]]) -> Texture {
        let channels = rows.as_flattened().iter().flat_map(|value| [*value; 3]).collect();
        Texture::from_rgb8(W as u32, rows.len() as u32, channels).unwrap()
    }

    /// What lies at `(u, 0.5)` of a row of texels, in the units of the texels.
    fn along(texture: &Texture, u: f32) -> f32 {
        sample(texture, Curve::Raw, u, 0.5)[0] * 255.0
    }

    #[test]
    fn what_lies_beyond_the_edges() {
        let row = image(&[[0, 100, 200, 40]]);
        let cases = [
            (Wrap::Repeat, [(0.0, 20.0), (1.125, 0.0), (-0.75, 50.0), (-0.625, 100.0)]),
            (Wrap::Clamp, [(0.0, 0.0), (1.125, 40.0), (-0.75, 0.0), (5.125, 40.0)]),
            (Wrap::Mirror, [(0.0, 0.0), (1.125, 40.0), (-0.25, 50.0), (2.375, 100.0)]),
        ];
        for (wrap, expected) in cases {
            let row = row.clone().with_wrap(wrap);
            for (u, expected) in expected {
                let found = along(&row, u);
                assert!((found - expected).abs() < 1e-3, "{wrap} {u}: {found}, not {expected}");
            }
            // All ways agree inside.
            for (u, expected) in [(0.125, 0.0), (0.25, 50.0), (0.375, 100.0), (0.75, 120.0)] {
                assert!((along(&row, u) - expected).abs() < 1e-3, "{wrap} {u}");
            }
        }
    }

    #[test]
    fn the_nearest_texel_keeps_its_value() {
        let row = image(&[[0, 100, 200, 40]]).with_filter(Filter::Nearest);
        for wrap in Wrap::ALL {
            let row = row.clone().with_wrap(wrap);
            for (u, expected) in
                [(0.0, 0.0), (0.249, 0.0), (0.251, 100.0), (0.74, 200.0), (0.99, 40.0)]
            {
                assert_eq!(along(&row, u).round(), expected, "{wrap} {u}");
            }
        }
        let at = |wrap, u| along(&row.clone().with_wrap(wrap), u).round();
        assert_eq!(Wrap::ALL.map(|wrap| at(wrap, 1.3)), [100.0, 40.0, 200.0]);
        assert_eq!(Wrap::ALL.map(|wrap| at(wrap, -0.1)), [40.0, 0.0, 0.0]);
    }

    #[test]
    fn rows_count_from_the_bottom() {
        let square = image(&[[10, 20], [30, 40]]);
        let at = |u, v| (sample(&square, Curve::Raw, u, v)[0] * 255.0).round();
        assert_eq!([at(0.25, 0.25), at(0.75, 0.25)], [30.0, 40.0]);
        assert_eq!([at(0.25, 0.75), at(0.75, 0.75)], [10.0, 20.0]);
        assert_eq!(at(0.5, 0.5), 25.0);
    }

    #[test]
    fn any_coordinate_gives_a_value_of_the_image() {
        let extremes = [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, -f32::MAX, -1e-9, 1e9];
        let square = image(&[[10, 20, 30], [30, 40, 20]]);
        for wrap in Wrap::ALL {
            for filter in Filter::ALL {
                let square = square.clone().with_wrap(wrap).with_filter(filter);
                for u in extremes {
                    for v in extremes {
                        let [value, .., alpha] = sample(&square, Curve::Raw, u, v);
                        let value = value * 255.0;
                        assert!((9.99..40.01).contains(&value), "{wrap} {filter} {u} {v}: {value}");
                        assert_eq!(alpha, 1.0);
                        let [value, ..] = sample_equirect(&square, Curve::Raw, [u, v, u]);
                        assert!((0.0..0.2).contains(&value), "{u} {v}: {value}");
                    }
                    assert_eq!(
                        sample(&square, Curve::Raw, f32::NAN, u),
                        sample(&square, Curve::Raw, 0.0, u)
                    );
                }
            }
        }
    }

    #[test]
    fn the_way_of_old_scenes_is_the_general_one() {
        let square = image(&[[10, 20, 30], [200, 40, 20]]);
        for i in 0..2000_i16 {
            let (u, v) = (f32::from(i) * 0.01 - 7.0, f32::from(i) * 0.0137 - 9.0);
            let [r, g, b, _] = sample(&square, Curve::Raw, u, v);
            assert_eq!(sample_bilinear(&square, u, v), [r, g, b], "{u} {v}");
        }
        let clamped = square.with_wrap(Wrap::Clamp).with_encoding(Some(Curve::Srgb));
        let [r, g, b, _] = sample(&clamped, Curve::Srgb, 2.0, 2.0);
        assert_eq!(sample_bilinear(&clamped, 2.0, 2.0), [r, g, b]);
        assert!((r - 0.012_983).abs() < 1e-5, "{r}");
    }

    #[test]
    fn light_is_decoded_before_it_is_mixed_and_alpha_never() {
        let pixels = vec![0, 0, 0, 0, 255, 255, 255, 255];
        let texture = Texture::from_rgba8(2, 1, pixels).unwrap();
        assert_eq!(sample(&texture, Curve::Srgb, 0.5, 0.5), [0.5; 4]);
        let grey = Texture::from_rgba8(1, 1, vec![128; 4]).unwrap();
        let [r, .., a] = sample(&grey, Curve::Srgb, 0.3, 0.3);
        assert!((r - 0.215_861).abs() < 1e-5 && a == 128.0 / 255.0, "{r} {a}");
    }

    #[test]
    fn colours_that_are_multiplied_by_alpha_are_divided_by_it() {
        // Half a pixel of (0.8, 0.4, 0) beside a clear one.
        let pixels = vec![0.4, 0.2, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0];
        let texture = Texture::from_rgba_f32(2, 1, pixels).unwrap();
        assert_eq!(sample(&texture, Curve::Raw, 0.25, 0.5), [0.8, 0.4, 0.0, 0.5]);
        assert_eq!(sample(&texture, Curve::Raw, 0.5, 0.5), [0.8, 0.4, 0.0, 0.25]);
        assert_eq!(sample(&texture, Curve::Raw, 0.75, 0.5), [0.0; 4]);
        assert_eq!(sample_bilinear(&texture, 0.25, 0.5), [0.4, 0.2, 0.0]);
        assert_eq!(sample_equirect(&texture, Curve::Raw, [0.0, 1.0, 0.0]), [0.4, 0.2, 0.0]);
        assert!(Texture::from_rgba_f32(1, 1, vec![0.0, 0.0, 0.0, 1.5]).is_none());
        assert!(Texture::from_rgb_f32(1, 1, vec![0.0, -1.0, 0.0]).is_none());
    }

    #[test]
    fn directions_and_places_of_a_sky_belong_together() {
        let middle = equirect_uv([1.0, 0.0, 0.0]);
        assert_eq!(middle, [0.5, 0.5]);
        assert_eq!(equirect_uv([0.0, 2.0, 0.0]), [0.25, 0.5]);
        assert_eq!(equirect_uv([0.0, -2.0, 0.0]), [0.75, 0.5]);
        assert_eq!(equirect_uv([0.0, 0.0, 3.0])[1], 1.0);
        assert_eq!(equirect_uv([0.0, 0.0, -3.0])[1], 0.0);
        for i in 0..500_u16 {
            for j in 1..100_u16 {
                let (u, v) = (f32::from(i) / 500.0 + 1e-3, f32::from(j) / 100.0);
                let direction = equirect_direction(u, v);
                let length = direction.map(|x| x * x).iter().sum::<f32>();
                assert!((length - 1.0).abs() < 1e-6, "{length}");
                let found = equirect_uv(direction.map(|x| 0.3 * x));
                assert!((found[0] - u).abs() < 5e-6, "{u} {v}: {found:?}");
                assert!((found[1] - v).abs() < 5e-7, "{u} {v}: {found:?}");
            }
        }
    }

    #[test]
    fn a_sky_wraps_around_and_stops_at_the_poles() {
        let sky = image(&[[10, 20, 30, 40], [50, 60, 70, 80], [90, 100, 110, 120]]);
        let at = |direction| sample_equirect(&sky, Curve::Raw, direction)[0] * 255.0;
        // +x is the middle of the image, between its second and third column.
        assert!((at([1.0, 0.0, 0.0]) - 65.0).abs() < 1e-3);
        // -x is its left and its right edge.
        assert!((at([-1.0, 1e-6, 0.0]) - 65.0).abs() < 1e-3);
        assert!((at([-1.0, -1e-6, 0.0]) - 65.0).abs() < 1e-3);
        // Straight up and just beside it: the first row, not a mixture with the other side.
        let beside = equirect_direction(0.125, 0.999);
        assert!((at(beside) - 10.0).abs() < 1e-3);
        let below = equirect_direction(0.875, 0.001);
        assert!((at(below) - 120.0).abs() < 1e-3);
    }
}
