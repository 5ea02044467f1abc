//! How viewers see radiance: the transfer curve of the picture, and errors on that curve.

use slo_accel::math::elementary::power;
use slo_accel::{Isa, Lanewise};
use slo_scene::settings::FileValues;
use slo_scene::{Encoding, Look, OutputFormat, ToneMap};

use super::agx::agx;
use super::pixel::{Halves, Pixel, base_end};
use super::toning::Toning;

/// What radiance becomes on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    toning: Toning,
    curve: Curve,
}

/// What light of the screen becomes as a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Curve {
    /// Linear from 0 to 1, clamped.
    Raw,
    /// sRGB from 0 to 1, clamped.
    Srgb,
    /// The sRGB curve, continued beyond 1: for pictures whose last exposure is chosen later.
    Unclamped,
}

impl Display {
    /// How viewers see the values of a file. Files of linear values hold radiance, so they have no tone
    /// map; the exposure says which radiance viewers take for white.
    pub fn of(format: OutputFormat, look: Look) -> Self {
        let toning = Toning::of(look);
        match (format.values(), look.encoding) {
            (FileValues::Linear { .. }, _) => {
                let toning = Toning { map: ToneMap::None, ..toning };
                Self { toning, curve: Curve::Unclamped }
            }
            (FileValues::Encoded { .. }, Encoding::Srgb) => Self { toning, curve: Curve::Srgb },
            (FileValues::Encoded { .. }, Encoding::Raw) => Self { toning, curve: Curve::Raw },
        }
    }

    /// Mean squares, over the channels, of the pixels' estimated errors on the curve, in the order of the
    /// pixels; infinite for fewer than two samples. Clamped values have no error.
    pub fn squared_errors<'a>(
        self,
        isa: Isa,
        pixels: impl IntoIterator<Item = &'a Pixel>,
    ) -> Vec<f64> {
        let mut pixels = pixels.into_iter().peekable();
        let mut errors = Vec::with_capacity(pixels.size_hint().0.next_multiple_of(GROUP));
        let mut group = Group::EMPTY;
        while pixels.peek().is_some() {
            let count = group.fill(&mut pixels);
            let begin = errors.len();
            errors.resize(begin + GROUP, 0.0);
            let to = &mut errors[begin..];
            self.squares(isa, &group, to);
            errors.truncate(begin + count);
        }
        errors
    }

    fn squares(self, isa: Isa, group: &Group, to: &mut [f64]) {
        let scale = self.toning.scale;
        match (self.toning.map, self.curve) {
            (ToneMap::None, Curve::Raw) => {
                isa.run(Squares { group, shown: Each { scale, curve: raw }, to });
            }
            (ToneMap::None, Curve::Srgb) => {
                isa.run(Squares { group, shown: Each { scale, curve: clamped }, to });
            }
            (_, Curve::Unclamped) => {
                isa.run(Squares { group, shown: Each { scale, curve: unclamped }, to });
            }
            (ToneMap::Agx, Curve::Raw) => {
                isa.run(Squares { group, shown: Together { scale, curve: raw }, to });
            }
            (ToneMap::Agx, Curve::Srgb) => {
                isa.run(Squares { group, shown: Together { scale, curve: clamped }, to });
            }
        }
    }
}

/// Colours of a group of pixels, in columns.
type Colours = [[f32; GROUP]; 3];

/// Replaces radiance by what the screen shows.
trait Shown {
    fn show(&self, colours: &mut Colours);
}

/// Shows each channel by itself.
struct Each<F> {
    scale: f32,
    curve: F,
}

impl<F: Fn(f32) -> f32> Shown for Each<F> {
    #[inline(always)]
    fn show(&self, colours: &mut Colours) {
        for channel in colours {
            for value in channel {
                *value = (self.curve)(*value * self.scale);
            }
        }
    }
}

/// Shows the channels of a pixel through AgX.
struct Together<F> {
    scale: f32,
    curve: F,
}

impl<F: Fn(f32) -> f32> Shown for Together<F> {
    #[inline(always)]
    fn show(&self, [red, green, blue]: &mut Colours) {
        for i in 0..GROUP {
            let light = agx([red[i], green[i], blue[i]].map(|c| c * self.scale));
            [red[i], green[i], blue[i]] = light.map(&self.curve);
        }
    }
}

#[inline(always)]
fn raw(light: f32) -> f32 {
    light.clamp(0.0, 1.0)
}

#[inline(always)]
fn clamped(light: f32) -> f32 {
    srgb(light.clamp(0.0, 1.0))
}

#[inline(always)]
fn unclamped(light: f32) -> f32 {
    srgb(light.max(0.0))
}

/// Number of pixels whose errors are estimated together.
const GROUP: usize = 64;

/// Sums of a group of pixels, in columns.
struct Group {
    sum: [[f64; GROUP]; 3],
    base: [[f64; GROUP]; 3],
    /// Samples in `sum`, and in `base`.
    all: [f64; GROUP],
    first: [f64; GROUP],
}

impl Group {
    const EMPTY: Self = Self {
        sum: [[0.0; GROUP]; 3],
        base: [[0.0; GROUP]; 3],
        all: [0.0; GROUP],
        first: [0.0; GROUP],
    };

    /// Takes up to [`GROUP`] of the next pixels, and returns how many.
    fn fill<'a>(&mut self, pixels: impl Iterator<Item = &'a Pixel>) -> usize {
        let mut count = 0;
        for pixel in pixels.take(GROUP) {
            for c in 0..3 {
                self.sum[c][count] = pixel.sum[c].to_f64();
                self.base[c][count] = pixel.base[c].to_f64();
            }
            self.all[count] = f64::from(pixel.samples);
            self.first[count] = f64::from(base_end(pixel.samples));
            count += 1;
        }
        count
    }
}

/// Squared errors of a group.
struct Squares<'a, S> {
    group: &'a Group,
    shown: S,
    to: &'a mut [f64],
}

impl<S: Shown> Lanewise for Squares<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { group, shown, to } = self;
        let Ok(to): Result<&mut [f64; GROUP], _> = to.try_into() else { return };
        // Each loop has one type of number, so that the compiler makes vector code of it.
        let (mut low, mut high) = ([[0.0f32; GROUP]; 3], [[0.0f32; GROUP]; 3]);
        for i in 0..GROUP {
            let halves = Halves::new(group.first[i], group.all[i]);
            for c in 0..3 {
                let (sum, base) = (group.sum[c][i], group.base[c][i]);
                let (mean, error) = (halves.mean(sum), halves.error(base, sum));
                (low[c][i], high[c][i]) = (mean - error, mean + error);
            }
        }
        shown.show(&mut low);
        shown.show(&mut high);
        for (i, to) in to.iter_mut().enumerate() {
            let half = |c: usize| f64::from(high[c][i] - low[c][i]) / 2.0;
            *to = (half(0) * half(0) + half(1) * half(1) + half(2) * half(2)) / 3.0;
        }
        for (to, &all) in to.iter_mut().zip(&group.all) {
            *to = if all < 2.0 { f64::INFINITY } else { *to };
        }
    }
}

/// Linear light -> sRGB; `[0, 1]` to `[0, 1]`, and the same curve beyond.
///
/// Source: IEC 61966-2-1:1999, 5.3.
#[inline(always)]
pub fn srgb(linear: f32) -> f32 {
    let curved = 1.055 * power(linear, 1.0 / 2.4) - 0.055;
    if linear <= 0.003_130_8 { 12.92 * linear } else { curved }
}

/// Luminance of linear light with the primaries of sRGB.
///
/// Source: ITU-R BT.709-6, 3.
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// sRGB -> linear light; the inverse of [`srgb`].
pub fn linear(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { libm::powf((srgb + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::super::fixed::Fixed;
    use super::*;

    fn pixel(first: f32, second: f32) -> Pixel {
        let mut pixel = Pixel::default();
        for value in [first, second] {
            pixel.add([Fixed::new(value).unwrap(); 3], 1);
        }
        pixel
    }

    fn display(format: OutputFormat, encoding: Encoding) -> Display {
        Display::of(format, Look::of(encoding))
    }

    fn error(display: Display, first: f32, second: f32) -> f32 {
        display.squared_errors(Isa::Portable, [&pixel(first, second)])[0].sqrt() as f32
    }

    #[test]
    fn errors_count_as_they_are_seen() {
        let raw = display(OutputFormat::Png8, Encoding::Raw);
        let srgb = display(OutputFormat::Png16, Encoding::Srgb);
        // The mean is 0.5, its error 0.25.
        assert!((error(raw, 0.25, 0.75) - 0.25).abs() < 1e-6);
        assert_eq!(error(raw, 3.0, 5.0), 0.0, "both are white");
        assert_eq!(error(srgb, 3.0, 5.0), 0.0);
        assert!(error(display(OutputFormat::Exr, Encoding::Raw), 3.0, 5.0) > 0.1);
        assert!(error(srgb, 0.01, 0.03) > 2.0 * error(srgb, 0.51, 0.53));
        assert_eq!(error(srgb, 0.5, 0.5), 0.0);
        let unexposed = raw.squared_errors(Isa::Portable, [&Pixel::default()]);
        assert_eq!(unexposed, [f64::INFINITY]);
    }

    #[test]
    fn the_look_decides_what_is_seen() {
        let with = |format, exposure, tone_map| {
            let look = Look { exposure, tone_map, encoding: Encoding::Srgb };
            error(Display::of(format, look), 3.0, 5.0)
        };
        let (png, exr) = (OutputFormat::Png8, OutputFormat::Exr);
        assert_eq!(with(png, 0.0, ToneMap::None), 0.0, "both are white");
        assert!(with(png, -3.0, ToneMap::None) > 0.05, "both are grey");
        assert!(with(png, 0.0, ToneMap::Agx) > 0.01, "nothing is quite white");
        assert_eq!(with(exr, 0.0, ToneMap::Agx), with(exr, 0.0, ToneMap::None));
        assert!(with(exr, 2.0, ToneMap::None) > 1.5 * with(exr, 0.0, ToneMap::None));
    }

    #[test]
    fn many_errors_are_those_of_each_on_every_instruction_set() {
        let pixels: Vec<Pixel> = (0..GROUP as u32 * 2 + 7)
            .map(|i| {
                let mut pixel = pixel(0.013 * i as f32, 0.02 * (i % 9) as f32);
                (0..i % 5).for_each(|k| pixel.add([Fixed::new(0.1 * k as f32).unwrap(); 3], 1));
                pixel
            })
            .collect();
        let looks = Encoding::ALL.into_iter().flat_map(|encoding| {
            ToneMap::ALL.map(|tone_map| Look { exposure: 0.5, tone_map, encoding })
        });
        for look in looks {
            for format in [OutputFormat::Png8, OutputFormat::Exr] {
                let display = Display::of(format, look);
                let one = |pixel| display.squared_errors(Isa::Portable, [pixel])[0];
                let each: Vec<f64> = pixels.iter().map(one).collect();
                for isa in Isa::available() {
                    assert_eq!(display.squared_errors(isa, &pixels), each, "{display:?} {isa}");
                }
                assert!(display.squared_errors(Isa::Portable, std::iter::empty()).is_empty());
            }
        }
    }
}
