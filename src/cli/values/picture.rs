//! The size of pictures, and regions of them.

use std::fmt;

use super::numbers::{real, whole};

/// `--region`, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}+{}+{}", self.width, self.height, self.x, self.y)
    }
}

/// A pixel, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelAt {
    pub(crate) x: u32,
    pub(crate) y: u32,
}

impl fmt::Display for PixelAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.x, self.y)
    }
}

/// Parses `X,Y`.
pub(crate) fn pixel_at(text: &str) -> Result<PixelAt, String> {
    let (x, y) = text.split_once(',').unwrap_or_default();
    let side = |text: &str| whole(text).and_then(|side| u32::try_from(side).ok());
    let side = |text: &str| side(text).filter(|side| *side < LARGEST_SIDE);
    let found = side(x.trim()).zip(side(y.trim())).map(|(x, y)| PixelAt { x, y });
    found.ok_or_else(|| {
        "expected a column and a row, counted from 0 at the upper left corner, such as 320,180"
            .to_owned()
    })
}

/// `--size`, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// `--size`, as typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SizeChoice {
    Pixels(Size),
    /// Share of each side of the scene's picture.
    Share(f64),
}

impl fmt::Display for SizeChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pixels(Size { width, height }) => write!(f, "{width}x{height}"),
            Self::Share(share) => write!(f, "{}%", share * 100.0),
        }
    }
}

impl SizeChoice {
    /// Returns the size if the scene's picture has `width` x `height` pixels.
    pub(crate) fn of(self, width: u32, height: u32) -> Size {
        match self {
            Self::Pixels(size) => size,
            Self::Share(share) => {
                let side = |side: u32| {
                    (f64::from(side) * share).round().clamp(1.0, f64::from(LARGEST_SIDE)) as u32
                };
                Size { width: side(width), height: side(height) }
            }
        }
    }
}

const LARGEST_SIDE: u32 = 65_536;

/// Sizes with names.
const NAMED: [(&str, [u32; 2]); 7] = [
    ("720p", [1280, 720]),
    ("1080p", [1920, 1080]),
    ("1440p", [2560, 1440]),
    ("2160p", [3840, 2160]),
    ("4k", [3840, 2160]),
    ("4320p", [7680, 4320]),
    ("8k", [7680, 4320]),
];

/// Parses `WxH`, a name, or a share.
pub(crate) fn size(text: &str) -> Result<SizeChoice, String> {
    let text = text.trim();
    if let Some((_, [width, height])) =
        NAMED.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text))
    {
        return Ok(SizeChoice::Pixels(Size { width, height }));
    }
    let share =
        || real(text).filter(|share| text.ends_with('%') && *share > 0.0 && *share <= 100.0);
    let found = pixels(text).map(SizeChoice::Pixels).or_else(|| share().map(SizeChoice::Share));
    found.ok_or_else(|| {
        format!(
            "expected width x height in pixels, each from 1 to {LARGEST_SIDE}, such as 320x180; \
             or a name, such as 1080p or 4k; or a percentage of the scene's size, such as 50%"
        )
    })
}

/// Parses `WxH+X+Y`.
pub(crate) fn region(text: &str) -> Result<Region, String> {
    let expected =
        || "expected width x height + column + row in pixels, such as 320x180+0+90".to_owned();
    let (sides, place) = text.split_once('+').ok_or_else(expected)?;
    let Size { width, height } = pixels(sides).ok_or_else(expected)?;
    let (x, y) = place.split_once('+').ok_or_else(expected)?;
    let number = |text| whole(text).and_then(|number| u32::try_from(number).ok());
    match (number(x), number(y)) {
        (Some(x), Some(y)) => Ok(Region { width, height, x, y }),
        _ => Err(expected()),
    }
}

/// Parses `WxH`.
fn pixels(text: &str) -> Option<Size> {
    let (width, height) = text.split_once(['x', 'X', '×'])?;
    let side = |text: &str| whole(text).and_then(|side| u32::try_from(side).ok());
    let side = |text: &str| side(text).filter(|side| (1..=LARGEST_SIDE).contains(side));
    Some(Size { width: side(width)?, height: side(height)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        let of = |text: &str| {
            let Size { width, height } = size(text).unwrap().of(1280, 720);
            (width, height)
        };
        assert_eq!(of("320x180"), (320, 180));
        assert_eq!(of("65536X1"), (65536, 1));
        assert_eq!(of("1920 × 1080"), (1920, 1080));
        assert_eq!((of("1080p"), of("4K")), ((1920, 1080), (3840, 2160)));
        assert_eq!((of("50%"), of("12.5 %"), of("0.01%")), ((640, 360), (160, 90), (1, 1)));
        for bad in
            ["", "x", "320", "0x5", "5x0", "65537x1", "-1x5", "1x2x3", "1.5x2", "0%", "-5%", "x%"]
        {
            assert!(size(bad).unwrap_err().contains("such as 320x180"), "{bad}");
        }
    }

    #[test]
    fn regions() {
        let expected = Region { width: 320, height: 180, x: 0, y: 90 };
        assert_eq!(region("320x180+0+90"), Ok(expected));
        assert_eq!(region("320X180+0+90"), Ok(expected));
        assert_eq!(expected.to_string(), "320x180+0+90");
        for bad in ["320x180", "320x180+1", "0x5+1+1", "1x1+-1+0", "1x1+1+1+1"] {
            assert!(region(bad).is_err(), "{bad}");
        }
    }
}
