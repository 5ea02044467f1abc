//! `sheet`: makes a contact sheet of a sequence.

use std::fmt::Display;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::cli::args::SheetArgs;
use crate::cli::base::{Exit, Problem, print};
use crate::cli::files::new_folders::NewFolders;
use crate::cli::files::paths::{check_distinct, check_path};
use crate::cli::files::pictures::read;
use slo_picture::film::Image;
use slo_picture::output::{claimed_pixels, map_format, write_sheet};
use slo_scene::OutputFormat;

/// Pixels between two pictures.
const GAP: usize = 4;
/// Maximum number of pixels of a sheet.
const MOST_PIXELS: u64 = 1 << 26;
/// Number of pixels above which pictures are read one after the other.
const LARGE: u64 = 1 << 22;
/// Side of a dot of a digit, in pixels.
const DOT: usize = 2;
/// Rows of the digits 0 to 9 and of the minus sign. Each row has three dots; the left dot is the
/// highest bit.
const DIGITS: [[u8; 5]; 11] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 1, 1],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
    [0, 0, 7, 0, 0],
];

/// Writes small copies of the pictures side by side, each with the number from its name.
pub(crate) fn run(args: &SheetArgs) -> Result<(), Problem> {
    if map_format(&args.output) != Some(OutputFormat::Png8) {
        let message = format!("a sheet is a .png file, but `{}` is not", args.output.display());
        return Err(Problem::new(Exit::Usage, message));
    }
    check_distinct(&args.output, &args.pictures)?;
    let _folders = NewFolders::of(&args.output);
    check_path(&args.output)?;
    let width = args.width as usize;
    let small_copies = SmallCopies::default();
    let small = |path: &std::path::PathBuf| {
        let copy = small_copies.of(path, width)?;
        Ok((copy, number(path)))
    };
    let pictures = args.pictures.par_iter().map(small).collect::<Result<Vec<_>, Problem>>()?;
    let sheet = sheet(&pictures, width, args.columns.map(|columns| columns as usize))?;
    write_sheet(&args.output, &sheet).map_err(|error| {
        Problem::new(Exit::CantWrite, format!("can't write `{}`: {error}", args.output.display()))
    })?;
    print(args.output.as_os_str().as_encoded_bytes()).map_err(|error| {
        Problem::new(Exit::Failed, format!("can't print the sheet's path: {error}"))
    })
}

/// Makes small copies, and limits their memory.
#[derive(Default)]
struct SmallCopies {
    /// Held while a large picture is read: several at once would need the memory of all.
    reading: Mutex<()>,
    /// Number of pixels of all copies.
    pixels: AtomicU64,
}

impl SmallCopies {
    /// Makes a small copy of a picture.
    ///
    /// # Errors
    /// The picture can't be read, or the copies are too large.
    fn of(&self, path: &Path, width: usize) -> Result<Image, Problem> {
        let alone = || self.reading.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let _alone = (claimed_pixels(path) > LARGE).then(alone);
        let picture = read(path)?;
        let copy = size(&picture.image, width);
        let pixels = (copy[0] * copy[1]) as u64;
        let before = self.pixels.fetch_add(pixels, Ordering::Relaxed);
        if before + pixels > MOST_PIXELS {
            return Err(too_large(format_args!("more than {} pixels", before + pixels)));
        }
        Ok(picture.into_shown().shrunk(copy))
    }
}

fn too_large(size: impl Display) -> Problem {
    let message = format!("the sheet would have {size}; it may have at most {MOST_PIXELS}");
    Problem::new(Exit::Failed, message).with_help("make its pictures smaller with `--width`")
}

/// Returns the last number in a file's name, as it is written there.
fn number(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let end = stem.rfind(|c: char| c.is_ascii_digit()).map_or(0, |at| at + 1);
    let is_part = |c: char| c.is_ascii_digit();
    let start = stem[..end]
        .rfind(|c| !is_part(c))
        .map_or(0, |at| at + stem[at..].chars().next().map_or(1, char::len_utf8));
    let minus = if stem[..start].ends_with('-') { "-" } else { "" };
    format!("{minus}{}", &stem[start..end])
}

/// Returns the columns and rows of a copy of at most `width` columns.
fn size(image: &Image, width: usize) -> [usize; 2] {
    let (from_width, from_height) = (image.width as usize, image.height as usize);
    let width = width.min(from_width).max(1);
    [width, (from_height * width / from_width.max(1)).max(1)]
}

fn sheet(
    pictures: &[(Image, String)],
    width: usize,
    columns: Option<usize>,
) -> Result<Image, Problem> {
    let columns = columns.unwrap_or((pictures.len() as f64).sqrt().ceil() as usize).max(1);
    let columns = columns.min(pictures.len().max(1));
    let cell_height = pictures.iter().map(|p| p.0.height as usize).max().unwrap_or(1);
    let (cell_width, rows) = (width + GAP, pictures.len().div_ceil(columns));
    let row_height = cell_height + 5 * DOT + 2 * GAP;
    let (width, height) = (columns * cell_width + GAP, rows * row_height + GAP);
    if (width as u64).saturating_mul(height as u64) > MOST_PIXELS {
        return Err(too_large(format_args!("{width}x{height} pixels")));
    }
    let mut sheet =
        Image { width: width as u32, height: height as u32, rgb: vec![[0.12; 3]; width * height] };
    for (i, (picture, label)) in pictures.iter().enumerate() {
        let at = (GAP + i % columns * cell_width, GAP + i / columns * row_height);
        paste(&mut sheet, picture, at);
        write_number(&mut sheet, label, (at.0, at.1 + cell_height + GAP));
    }
    Ok(sheet)
}

fn paste(sheet: &mut Image, picture: &Image, (x, y): (usize, usize)) {
    let width = picture.width as usize;
    for (row, pixels) in picture.rgb.chunks_exact(width.max(1)).enumerate() {
        let start = (y + row) * sheet.width as usize + x;
        sheet.rgb[start..start + width].copy_from_slice(pixels);
    }
}

fn write_number(sheet: &mut Image, number: &str, (x, y): (usize, usize)) {
    for (i, c) in number.chars().enumerate() {
        let digit = c.to_digit(10).map_or(10, |digit| digit as usize);
        for (row, dots) in DIGITS[digit].iter().enumerate() {
            for column in (0..3).filter(|column| dots >> (2 - column) & 1 == 1) {
                let at = (x + (i * 4 + column) * DOT, y + row * DOT);
                dot(sheet, at);
            }
        }
    }
}

/// Draws a square dot, as far as it lies on the sheet.
fn dot(sheet: &mut Image, (x, y): (usize, usize)) {
    let (width, height) = (sheet.width as usize, sheet.height as usize);
    for (x, y) in (0..DOT * DOT).map(|i| (x + i % DOT, y + i / DOT)) {
        if x < width && y < height {
            sheet.rgb[y * width + x] = [0.85; 3];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names() {
        let check = |name: &str, expected: &str| assert_eq!(number(Path::new(name)), expected);
        check("out/table_00015.png", "00015");
        check("table_-00005.png", "-00005");
        check("čaj2_007.exr", "007");
        check("00015.png", "00015");
        check("table.png", "");
        check("a1b.png", "1");
    }

    #[test]
    fn small_copies_keep_the_mean() {
        let rgb = (0..12).map(|i| [i as f32; 3]).collect();
        let image = Image { width: 4, height: 3, rgb };
        let shrunk = |image: &Image, width| image.shrunk(size(image, width));
        let small = shrunk(&image, 2);
        assert_eq!((small.width, small.height), (2, 1));
        assert_eq!(small.rgb, [[4.5; 3], [6.5; 3]]);
        assert_eq!(shrunk(&image, 100), image);
        let tall = Image { width: 1, height: 9, rgb: vec![[1.0; 3]; 9] };
        assert_eq!(shrunk(&tall, 1), tall);
    }

    #[test]
    fn a_sheet_holds_all_pictures() {
        let picture = |v: f32| Image { width: 10, height: 6, rgb: vec![[v; 3]; 60] };
        let pictures: Vec<_> = (0..5).map(|i| (picture(0.9 + i as f32), "-12".into())).collect();
        let sheet = sheet(&pictures, 10, None).unwrap();
        assert_eq!((sheet.width, sheet.height), (3 * 14 + 4, 2 * (6 + 10 + 8) + 4));
        for i in 0..5 {
            assert_eq!(sheet.rgb.iter().filter(|p| p[0] == 0.9 + i as f32).count(), 60, "{i}");
        }
    }
}
