//! Maps and contact sheets. They replace nothing but other maps and sheets.

use std::io;
use std::path::Path;

use slo_scene::{Encoding, Look, OutputFormat};

use crate::film::Image;
use crate::output::file::{check_free, check_writable};
use crate::output::format::{Crop, Picture, RecipeError, read_recipe};

/// The recipe of a map or a sheet, which is not a picture of a scene.
const NO_RECIPE: &str = "{}";

/// Whether a picture with this recipe is a map or a sheet.
pub fn is_companion(recipe: &str) -> bool {
    recipe == NO_RECIPE
}

/// The format that the name of a map asks for; `None` if no format has its extension.
pub fn map_format(path: &Path) -> Option<OutputFormat> {
    OutputFormat::by_extension(path.extension()?.to_str()?)
}

/// Checks whether a map or a sheet can be written to `path`; creates its folder if necessary.
///
/// # Errors
/// A file exists that is neither an earlier map or sheet nor empty; what the system says of the folder or
/// the file.
pub fn check_companion(path: &Path) -> io::Result<()> {
    check_replaceable(path)?;
    check_writable(path)
}

fn check_replaceable(path: &Path) -> io::Result<()> {
    check_free(path)?;
    match (path.metadata(), read_recipe(path)) {
        (Err(_), _) => Ok(()),
        (Ok(there), _) if there.len() == 0 => Ok(()),
        (_, Ok(recipe)) if is_companion(&recipe) => Ok(()),
        (_, Err(RecipeError::Io(error))) => Err(error),
        _ => Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            "there is a file already that is no map and no sheet of slo-rt",
        )),
    }
}

/// Writes a map or a sheet.
///
/// # Errors
/// As [`check_companion`]; what the system says of writing.
pub(super) fn save(
    path: &Path,
    image: &Image,
    format: OutputFormat,
    crop: Option<Crop>,
) -> io::Result<()> {
    check_replaceable(path)?;
    Picture { image, format, look: Look::of(Encoding::Raw), recipe: NO_RECIPE, crop }.save(path)
}

/// Writes a contact sheet, as PNG: values from 0 to 1 as the screen shows them.
///
/// # Errors
/// A file exists that is no earlier map or sheet; what the system says.
pub fn write_sheet(path: &Path, image: &Image) -> io::Result<()> {
    save(path, image, OutputFormat::Png8, None)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::output::format::samples::{bytes, sample_image};

    #[test]
    fn names_say_the_format() {
        let check = |path: &str, expected| assert_eq!(map_format(Path::new(path)), expected);
        check("a/b.png", Some(OutputFormat::Png8));
        check("b.PNG", Some(OutputFormat::Png8));
        check("b.c.Exr", Some(OutputFormat::Exr));
        for other in ["b.jpg", "png", ".png", "b", "b.png.txt", ""] {
            check(other, None);
        }
    }

    #[test]
    fn only_their_like_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("maps/a.png");
        let image = sample_image();
        check_companion(&path).unwrap();
        for _ in 0..2 {
            write_sheet(&path, &image).unwrap();
            check_companion(&path).unwrap();
        }
        fs::write(&path, "").unwrap();
        write_sheet(&path, &image).unwrap();
        let picture = bytes(OutputFormat::Png8, Encoding::Raw, &image);
        let mut plain = Vec::new();
        let mut encoder = png::Encoder::new(&mut plain, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[1, 2, 3]).unwrap();
        for other in [&picture[..], b"settings s {}", &plain] {
            fs::write(&path, other).unwrap();
            let kind = |result: io::Result<()>| result.unwrap_err().kind();
            assert_eq!(kind(check_companion(&path)), io::ErrorKind::AlreadyExists);
            assert_eq!(kind(write_sheet(&path, &image)), io::ErrorKind::AlreadyExists);
            assert_eq!(fs::read(&path).unwrap(), other);
        }
    }
}
