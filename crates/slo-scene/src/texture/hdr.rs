//! Radiance HDR images (`.hdr`, `.pic`): flat, with the old or the new run lengths.

#[cfg(test)]
mod tests;

use super::decoded::{LoadedTexture, check_size, damaged, texture};
use super::image::Alpha;
use super::texels::{Layout, Samples};
use crate::format::FileError;

/// Bytes of a header: more are no image.
const MOST_HEADER: usize = 1 << 16;

/// How many times larger than its data an image can be, as in PNG images.
const MOST_PIXELS_PER_BYTE: u64 = 1032 * 8;

/// Of a pixel that is not brighter than 2^60, about 1e18.
const MOST_EXPONENT: u8 = 128 + 60;

/// Widths that the new run lengths are for.
const NEW_RUNS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Red, green and blue with a common exponent.
type Pixel = [u8; 4];

/// Decodes an image.
///
/// # Errors
/// The image is damaged, too large, or of a kind that is not read.
pub(super) fn load(bytes: &[u8]) -> Result<LoadedTexture, FileError> {
    let mut lines = Lines { bytes: &bytes[..bytes.len().min(MOST_HEADER)], position: 0 };
    while let Some(line) = lines.next() {
        match line {
            b"" => break,
            b"FORMAT=32-bit_rle_xyze" => {
                return Err(unsupported("its colours are in CIE XYZ, not in RGB"));
            }
            _ => {}
        }
    }
    let resolution = lines.next().ok_or_else(|| damaged("HDR", "it is cut off"))?;
    let order = Order::of(resolution).ok_or_else(|| {
        damaged("HDR", "the line with its size, such as `-Y 512 +X 1024`, is wrong")
    })?;
    let (width, height) = order.size();
    check_size(width, height, 12)?;
    let data = &bytes[lines.position..];
    if u64::from(width) * u64::from(height) > data.len() as u64 * MOST_PIXELS_PER_BYTE {
        let reason = format!("{} bytes can't be {width} x {height} pixels", data.len());
        return Err(damaged("HDR", &reason));
    }
    let mut pixels = vec![Pixel::default(); width as usize * height as usize];
    let mut line = Vec::with_capacity(order.per_line as usize);
    let mut data = Data(data);
    for i in 0..order.lines {
        data.line(order.per_line as usize, &mut line)?;
        for (j, pixel) in (0..order.per_line).zip(&line) {
            if pixel[3] > MOST_EXPONENT {
                return Err(damaged("HDR", "a pixel is brighter than 1e18"));
            }
            pixels[order.place(i, j)] = *pixel;
        }
    }
    let samples = Samples::Rgbe(pixels);
    texture(width, height, Layout::Rgb, samples, Alpha::None, Vec::new())
}

/// The lines of a header.
struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Lines<'a> {
    /// The next line, without its end; `None` if it has none.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.position..];
        let len = rest.iter().position(|&byte| byte == b'\n')?;
        self.position += len + 1;
        Some(rest[..len].trim_ascii_end())
    }
}

/// In which order pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Order {
    lines: u32,
    per_line: u32,
    /// Whether lines are columns.
    is_columns: bool,
    /// Whether the first line is the last row or column of the image.
    lines_turned: bool,
    /// Whether the first pixel of a line is in the last row or column.
    pixels_turned: bool,
}

impl Order {
    /// By a line such as `-Y 512 +X 1024`: the axis of lines, and the axis along them. Y points up.
    fn of(line: &[u8]) -> Option<Self> {
        let line = std::str::from_utf8(line).ok()?;
        let words: Vec<_> = line.split_ascii_whitespace().collect();
        let &[first, lines, second, per_line] = &words[..] else { return None };
        let (is_columns, lines_turned, pixels_turned) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, first == "+Y", second == "-X"),
            ("-X" | "+X", "-Y" | "+Y") => (true, first == "-X", second == "+Y"),
            _ => return None,
        };
        let (lines, per_line) = (side(lines)?, side(per_line)?);
        Some(Self { lines, per_line, is_columns, lines_turned, pixels_turned })
    }

    /// Width and height.
    fn size(self) -> (u32, u32) {
        if self.is_columns { (self.lines, self.per_line) } else { (self.per_line, self.lines) }
    }

    /// Where pixel `j` of line `i` is in an image whose top row comes first.
    fn place(self, i: u32, j: u32) -> usize {
        let i = if self.lines_turned { self.lines - 1 - i } else { i };
        let j = if self.pixels_turned { self.per_line - 1 - j } else { j };
        let (x, y) = if self.is_columns { (i, j) } else { (j, i) };
        y as usize * self.size().0 as usize + x as usize
    }
}

/// A side of an image, more than 0.
fn side(word: &str) -> Option<u32> {
    word.parse().ok().filter(|&side| side > 0)
}

/// What is left of the pixels.
struct Data<'a>(&'a [u8]);

impl Data<'_> {
    /// Reads a line of so many pixels.
    fn line(&mut self, len: usize, line: &mut Vec<Pixel>) -> Result<(), FileError> {
        line.clear();
        match *self.0 {
            [2, 2, high, low, ..] if NEW_RUNS.contains(&len) && high < 128 => {
                if usize::from(high) << 8 | usize::from(low) != len {
                    return Err(damaged("HDR", "a line has a wrong length"));
                }
                self.0 = &self.0[4..];
                line.resize(len, Pixel::default());
                (0..4).try_for_each(|channel| self.new_runs(channel, line))
            }
            _ => self.old_runs(len, line),
        }
    }

    /// A channel of a line: bytes as they are, or one that is repeated.
    fn new_runs(&mut self, channel: usize, line: &mut [Pixel]) -> Result<(), FileError> {
        let mut at = 0;
        while at < line.len() {
            let [count] = self.take()?;
            let (count, is_run) = if count > 128 { (count & 127, true) } else { (count, false) };
            let to = line.get_mut(at..at + usize::from(count)).filter(|to| !to.is_empty());
            let to = to.ok_or_else(|| damaged("HDR", "a run of its bytes is wrong"))?;
            at += to.len();
            if is_run {
                let [value] = self.take()?;
                to.iter_mut().for_each(|pixel| pixel[channel] = value);
            } else {
                for pixel in to {
                    [pixel[channel]] = self.take()?;
                }
            }
        }
        Ok(())
    }

    /// Whole pixels; `1 1 1 n` repeats the last one `n` times, or `256 n` times behind another such
    /// pixel, and so on.
    fn old_runs(&mut self, len: usize, line: &mut Vec<Pixel>) -> Result<(), FileError> {
        let mut shift = 0;
        while line.len() < len {
            let pixel: Pixel = self.take()?;
            let [1, 1, 1, count] = pixel else {
                line.push(pixel);
                shift = 0;
                continue;
            };
            let count = usize::from(count).checked_shl(shift).unwrap_or(usize::MAX);
            let last = line.last().copied();
            let last = last.filter(|_| shift < 32 && count <= len - line.len());
            let last = last.ok_or_else(|| damaged("HDR", "a run of its pixels is wrong"))?;
            line.resize(line.len() + count, last);
            shift += 8;
        }
        Ok(())
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], FileError> {
        let (taken, rest) =
            self.0.split_first_chunk().ok_or_else(|| damaged("HDR", "it is cut off"))?;
        self.0 = rest;
        Ok(*taken)
    }
}

/// What to say about an image of a rare kind.
fn unsupported(what: &str) -> FileError {
    FileError::whole_file(format!("the HDR image can't be read: {what}"))
        .with_help("save it as an RGB image, or as EXR")
}
