//! Who made an existing file: files of others are not replaced.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::Path;

use crate::output::file::open_regular;
use crate::output::format::{
    KEYWORD, RecipeError, Wholeness, ends_before_pixels, may_lose_recipe, read_checked,
};
use crate::output::state::MAGIC;

/// Marks of our files stand in the first so many bytes.
const START: u64 = 1 << 16;
/// What every recipe holds. A damaged file may lack some of them.
const MARKS: [&str; 4] =
    [KEYWORD, "\"program\": \"slo-rt\"", "\"sceneBlake3\": \"", "\"generatorType\": \""];
/// Beginnings of files that may hold text copied from ours: JPEG, WebP, TIFF.
const OTHER_KINDS: [&[u8]; 4] = [b"\xff\xd8\xff", b"RIFF", b"II*\0", b"MM\0*"];

/// Why the file at `path` is, or may be, the work of others, and must not be replaced. `None` for a
/// file of ours, sound or damaged, for a file without content, and if there is no file.
pub fn made_by_others(path: &Path) -> Option<String> {
    match read_checked(path) {
        Ok((_, Wholeness::Whole)) => None,
        Ok((_, Wholeness::Resaved)) => Some(RESAVED.into()),
        Err(error) => unless_ours(path, &error),
    }
}

/// What is said of a picture with our recipe, but not in the form of our files.
pub(super) const RESAVED: &str = "another program has saved it since";

/// The same as [`made_by_others`] for a file whose recipe can't be read.
pub(super) fn unless_ours(path: &Path, error: &RecipeError) -> Option<String> {
    match error {
        RecipeError::NoRecipe => match has_lost_recipe(path) {
            Ok(true) => None,
            _ => Some("no recipe of slo-rt".into()),
        },
        RecipeError::Io(error) => match error.kind() {
            ErrorKind::IsADirectory => Some("a folder".into()),
            ErrorKind::PermissionDenied | ErrorKind::InvalidInput => Some(error.to_string()),
            _ => None,
        },
        RecipeError::NotAPicture(_) | RecipeError::Damaged(_) => match is_others(path) {
            Ok(true) => Some("no recipe of slo-rt".into()),
            _ => None,
        },
    }
}

/// Whether damage hides the recipe of a file of ours.
fn has_lost_recipe(path: &Path) -> io::Result<bool> {
    let mut start = Vec::new();
    open_regular(path)?.take(START).read_to_end(&mut start)?;
    Ok(may_lose_recipe(&start) && has_marks(&start))
}

fn has_marks(start: &[u8]) -> bool {
    MARKS.iter().any(|mark| holds(start, mark.as_bytes()))
}

/// Whether a file that is no sound picture has content, but no mark of ours.
fn is_others(path: &Path) -> io::Result<bool> {
    let mut file = open_regular(path)?;
    let mut start = Vec::new();
    Read::by_ref(&mut file).take(START).read_to_end(&mut start)?;
    let is_ours = !OTHER_KINDS.iter().any(|kind| start.starts_with(kind)) && has_marks(&start);
    Ok(!is_ours && !is_cut_off_at_once(&start) && !is_blank(&start, file)?)
}

/// Whether a picture or a state is cut off before its first pixel.
fn is_cut_off_at_once(start: &[u8]) -> bool {
    if start.len() as u64 == START {
        return false;
    }
    // A state has no sums in its first bytes.
    ends_before_pixels(start) || MAGIC.starts_with(start) || start.starts_with(&MAGIC)
}

/// Whether all bytes are zero: a file system may leave such a file after a power loss.
fn is_blank(start: &[u8], rest: File) -> io::Result<bool> {
    let is_zero = |bytes: &[u8]| bytes.iter().all(|&byte| byte == 0);
    if !is_zero(start) {
        return Ok(false);
    }
    let mut rest = BufReader::with_capacity(START as usize, rest);
    loop {
        let bytes = io::BufRead::fill_buf(&mut rest)?;
        let (length, blank) = (bytes.len(), is_zero(bytes));
        if length == 0 || !blank {
            return Ok(blank);
        }
        io::BufRead::consume(&mut rest, length);
    }
}

fn holds(bytes: &[u8], what: &[u8]) -> bool {
    bytes.windows(what.len()).any(|window| window == what)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use slo_scene::{Encoding, Look, OutputFormat};

    use super::*;
    use crate::film::{Area, Film, FirstHitLayers, State, Subject};
    use crate::output::format::Picture;
    use crate::output::format::samples::sample_image;
    use crate::output::state::write_state;

    const RECIPE: &str = "{\n  \"program\": \"slo-rt\",\n  \"version\": \"0.1.0\",\n  \"sceneBlake3\": \"00\",\n  \"generatorType\": \"QUASI\"\n}";

    fn picture(format: OutputFormat) -> Vec<u8> {
        let (image, look) = (&sample_image(), Look::of(Encoding::Srgb));
        let mut out = io::Cursor::new(Vec::new());
        Picture { image, format, look, recipe: RECIPE, crop: None }.write(&mut out).unwrap();
        out.into_inner()
    }

    fn state() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let area = Area::whole(4, 4);
        let subject = Subject {
            recipe: RECIPE.into(),
            area,
            region: area,
            samples: None,
            with_spreads: false,
            with_features: false,
            light_groups: None,
            first_hits: FirstHitLayers::default(),
        };
        let film = Film::new(area, false).unwrap();
        write_state(&path, &State { subject, film, is_complete: true }).unwrap();
        fs::read(&path).unwrap()
    }

    /// A PNG with chunks before its pixels, which are in one piece.
    fn resaved(text: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 50, 50);
        encoder.set_color(png::ColorType::Rgb);
        if text {
            encoder.add_text_chunk(KEYWORD.into(), RECIPE.into()).unwrap();
        }
        encoder.write_header().unwrap().write_image_data(&[7; 7500]).unwrap();
        out
    }

    fn told(bytes: &[u8]) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, bytes).unwrap();
        made_by_others(&path)
    }

    #[test]
    fn what_is_ours_stays_ours_however_it_is_damaged() {
        for whole in OutputFormat::ALL.map(picture).into_iter().chain([state()]) {
            assert_eq!(told(&whole), None);
            for length in 0..whole.len() {
                assert_eq!(told(&whole[..length]), None, "cut off at {length}");
            }
            for at in 0..whole.len() {
                let mut damaged = whole.clone();
                damaged[at..].iter_mut().take(64).for_each(|byte| *byte = 0);
                assert_eq!(told(&damaged), None, "zeros at {at}");
                damaged.clone_from(&whole);
                damaged[at] ^= 0x10;
                assert_eq!(told(&damaged), None, "a bit at {at}");
            }
            assert_eq!(told(&[&whole[..], b"more"].concat()), None);
            assert_eq!(told(&vec![0; whole.len()]), None, "zeros");
        }
        assert_eq!(made_by_others(Path::new("no such file")), None);
    }

    #[test]
    fn what_others_made_is_theirs() {
        let jpeg = [b"\xff\xd8\xff\xe0", RECIPE.as_bytes()].concat();
        let text = b"retouched by hand for three hours\n";
        for others in [&text[..], b"x", &jpeg, b"GIF89a", &[1; 100_000], &resaved(false)] {
            assert_eq!(told(others).as_deref(), Some("no recipe of slo-rt"), "{others:.20?}");
        }
        assert!(told(&resaved(false)[..100]).is_some(), "cut off");
        assert_eq!(told(&resaved(true)).as_deref(), Some(RESAVED));
    }

    #[test]
    fn an_exr_file_that_was_saved_again_is_theirs() {
        use exr::prelude::{WritableImage, read_all_flat_layers_from_file};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        fs::write(&path, picture(OutputFormat::Exr)).unwrap();
        let read = read_all_flat_layers_from_file(&path).unwrap();
        let told = |change: fn(&mut exr::prelude::FlatImage)| {
            let mut changed = read.clone();
            change(&mut changed);
            changed.write().to_file(&path).unwrap();
            made_by_others(&path)
        };
        let resaved = Some(RESAVED.to_owned());
        let other = |image: &mut exr::prelude::FlatImage| {
            let name = exr::meta::attribute::Text::from("GIMP");
            image.layer_data[0].attributes.software_name = Some(name);
        };
        assert_eq!(told(other), resaved);
        let other = |image: &mut exr::prelude::FlatImage| {
            image.layer_data[0].encoding.compression = exr::compression::Compression::ZIP16;
        };
        assert_eq!(told(other), resaved);
        let other = |image: &mut exr::prelude::FlatImage| {
            image.layer_data[0].attributes.other.clear();
        };
        assert_eq!(told(other).as_deref(), Some("no recipe of slo-rt"));
    }
}
