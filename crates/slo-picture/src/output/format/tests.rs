//! Every format: what is written comes back, and damage is noticed.

use std::io::{self, Cursor, Read, Seek, Write};

use slo_scene::{Encoding, Look, OutputFormat, ToneMap};

use super::samples::{bytes, sample_image};
use super::*;
use crate::film::{Area, FileLayer, Image, srgb};

const FORMATS: [OutputFormat; OutputFormat::NAMES.len()] = OutputFormat::ALL;

#[test]
fn the_same_picture_gives_the_same_bytes() {
    let image = sample_image();
    for format in FORMATS {
        let once = bytes(format, Encoding::Srgb, &image);
        assert_eq!(once, bytes(format, Encoding::Srgb, &image.clone()), "{format:?}");
    }
}

#[test]
fn the_look_is_in_encoded_values_only() {
    let image = Image { width: 2, height: 1, rgb: vec![[0.0, 0.25, 2.0], [f32::NAN, 1e30, 9.0]] };
    let read = |format, exposure, tone_map| {
        let look = Look { exposure, tone_map, encoding: Encoding::Raw };
        let mut out = Cursor::new(Vec::new());
        let picture = Picture { image: &image, format, look, recipe: "{}", crop: None };
        picture.write(&mut out).unwrap();
        Raster::from_bytes(out.into_inner()).unwrap().image.rgb
    };
    for tone_map in ToneMap::ALL {
        let exr = read(OutputFormat::Exr, -3.0, tone_map);
        assert_eq!(exr, [[0.0, 0.25, 2.0], [0.0, 1e30, 9.0]]);
    }
    assert_eq!(read(OutputFormat::Png16, -3.0, ToneMap::None)[0][2], 16384.0 / 65535.0);
    assert_eq!(read(OutputFormat::Png8, 1.0, ToneMap::None)[0], [0.0, 128.0 / 255.0, 1.0]);
    assert_eq!(read(OutputFormat::Png8, 32.0, ToneMap::None)[1], [0.0, 1.0, 1.0]);
    let [_, green, blue] = read(OutputFormat::Png8, 0.0, ToneMap::Agx)[0];
    assert!(green > 0.15 && blue < 0.9, "bright light stays below white: {green} {blue}");
}

/// A disk that is full after so many bytes.
#[derive(Debug)]
struct SmallDisk {
    file: io::Cursor<Vec<u8>>,
    size: usize,
    /// As the system numbers errors.
    error: i32,
}

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.size.saturating_sub(self.file.position() as usize);
        match left.min(bytes.len()) {
            0 if !bytes.is_empty() => Err(io::Error::from_raw_os_error(self.error)),
            most => self.file.write(&bytes[..most]),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for SmallDisk {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.read(bytes)
    }
}

impl Seek for SmallDisk {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[cfg(unix)]
#[test]
fn what_the_system_says_comes_through_every_encoder() {
    // EIO, ENOSPC, ESTALE, EDQUOT.
    const ERRORS: [i32; 4] = [5, 28, 116, 122];
    let noisy = |i: u32| [0, 1, 2].map(|c| (i.wrapping_mul(2_654_435_761) >> c) as f32 / 4e9);
    let image = Image { width: 90, height: 80, rgb: (0..90 * 80).map(noisy).collect() };
    for format in FORMATS {
        let whole = bytes(format, Encoding::Raw, &image).len();
        let look = Look::default();
        let picture = Picture { image: &image, format, look, recipe: "{}", crop: None };
        for size in [0, 1, 100, 1000, whole / 3, whole / 2, whole - 60] {
            for error in ERRORS {
                let mut disk = SmallDisk { file: io::Cursor::default(), size, error };
                let said = picture.write(&mut disk).unwrap_err();
                assert_eq!(said.raw_os_error(), Some(error), "{format:?} of {size}: {said}");
            }
        }
    }
}

#[test]
fn values_that_are_not_finite_are_counted() {
    let image = sample_image();
    let picture = Picture {
        image: &image,
        format: OutputFormat::Png8,
        look: Look::default(),
        recipe: "",
        crop: None,
    };
    assert_eq!(picture.not_finite(), 1);
}

#[test]
fn a_picture_without_pixels_is_an_error() {
    let image = Image { width: 0, height: 4, rgb: Vec::new() };
    for format in [OutputFormat::Png8, OutputFormat::Exr] {
        let look = Look::default();
        let picture = Picture { image: &image, format, look, recipe: "", crop: None };
        assert!(picture.write(io::Cursor::new(Vec::new())).is_err(), "{format:?}");
    }
}

#[test]
fn it_comes_back_from_every_kind_of_file() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = "{\n  \"frame\": 5\n}";
    for format in FORMATS {
        let path = folder.path().join("picture");
        let image = sample_image();
        let look = Look::default();
        let picture = Picture { image: &image, format, look, recipe, crop: None };
        picture.save(&path).unwrap();
        assert_eq!(read_recipe(&path).unwrap(), recipe, "{format:?}");
    }
}

#[test]
fn a_damaged_file_is_told_from_one_without_a_recipe() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    for format in [OutputFormat::Png8, OutputFormat::Exr] {
        let whole = bytes(format, Encoding::Raw, &sample_image());
        let at = whole.windows(13).position(|found| found == b"slo-rt recipe").unwrap();
        for at in [at, at + 40, whole.len() - 20] {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            std::fs::write(&path, &damaged).unwrap();
            let error = read_recipe(&path).unwrap_err();
            assert!(error.to_string().starts_with("it is damaged: "), "{at}: {error}");
        }
    }
}

#[test]
fn other_files_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let check = |content: &[u8]| {
        let path = folder.path().join("file");
        std::fs::write(&path, content).unwrap();
        read_recipe(&path).unwrap_err().to_string()
    };
    insta::assert_snapshot!(check(b""), @"not a PNG or EXR picture: its first bytes are of another kind of file");
    assert_eq!(check(b"\x89PNG\r\n\x1a\n"), "it is damaged: it ends before its last chunk");
    assert!(check(b"\x76\x2f\x31\x01\x02\0\0\0").starts_with("not a PNG or EXR picture: "));
    let mut plain = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut plain, 1, 1);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[1, 2, 3]).unwrap();
    assert_eq!(check(&plain), "the picture holds no recipe of slo-rt");
    let missing = read_recipe(&folder.path().join("missing"));
    assert!(matches!(missing, Err(RecipeError::Io(_))));
}

#[test]
fn what_was_written_is_read() {
    let image = sample_image();
    let read = |format, encoding| Raster::from_bytes(bytes(format, encoding, &image)).unwrap();
    let exr = read(OutputFormat::Exr, Encoding::Raw);
    assert_eq!((exr.image.width, exr.image.height), (5, 3));
    assert_eq!(exr.image.rgb[3], image.rgb[3]);
    assert_eq!(exr.image.rgb[7], [0.0, 0.0, 0.25], "what is no number is 0");
    for (format, steps) in [(OutputFormat::Png8, 255.0), (OutputFormat::Png16, 65_535.0)] {
        let raw = read(format, Encoding::Raw);
        assert_eq!(raw.values, Values::Raw);
        let curved = read(format, Encoding::Srgb);
        assert_eq!(curved.values, Values::Srgb);
        for (i, rgb) in image.rgb.iter().enumerate().filter(|(i, _)| *i != 7) {
            for (c, radiance) in rgb.iter().enumerate() {
                let expected = radiance.clamp(0.0, 1.0);
                assert!((raw.image.rgb[i][c] - expected).abs() <= 0.51 / steps);
                assert!(
                    (curved.linear(curved.image.rgb[i][c]) - expected).abs() <= 1.3 / steps,
                    "{i}"
                );
                assert!((exr.shown(exr.image.rgb[i][c]) - srgb(expected)).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn a_region_says_where_it_is() {
    let image = sample_image();
    let area = Area { x0: 7, y0: 2, x1: 12, y1: 5 };
    let whole = Area::whole(20, 10);
    let picture = Picture {
        image: &image,
        format: OutputFormat::Exr,
        look: Look::default(),
        recipe: "{}",
        crop: Crop::of(area, whole),
    };
    let mut bytes = Cursor::new(Vec::new());
    picture.write(&mut bytes).unwrap();
    let read = Raster::from_bytes(bytes.into_inner()).unwrap();
    assert_eq!((read.area(), read.whole()), (area, whole));
    let one = Area { x0: 8, y0: 3, x1: 9, y1: 4 };
    assert_eq!(read.cut(one).unwrap().rgb, [image.rgb[6]]);
    assert_eq!(read.cut(Area { x0: 6, ..one }), None);
}

#[test]
fn damage_is_an_error() {
    for format in [OutputFormat::Png8, OutputFormat::Exr] {
        let whole = bytes(format, Encoding::Srgb, &sample_image());
        for length in 0..whole.len() {
            assert!(Raster::from_bytes(whole[..length].to_vec()).is_err(), "{length}");
        }
        // An EXR file whose hash has another name is one of another program.
        for at in (0..whole.len()).filter(|_| format == OutputFormat::Png8) {
            let mut damaged = whole.clone();
            damaged[at] ^= 4;
            assert!(Raster::from_bytes(damaged).is_err(), "{at}");
        }
        assert!(Raster::from_bytes([&whole[..], b"x"].concat()).is_err(), "{format:?}");
    }
}

#[test]
fn layers_that_were_written_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    let image = sample_image();
    let layer = |factor: f32| {
        let rgb = (0..15).map(|i| [i as f32 * factor, -factor, 0.5]).collect();
        Image { width: 5, height: 3, rgb }
    };
    let light = |name: &str| FileLayer::Light(name.to_owned());
    let layers = [
        (FileLayer::Albedo, layer(0.01)),
        (FileLayer::Normal, layer(0.05)),
        (light("Küche.1"), layer(3.0)),
        (light("rest"), layer(-2.0)),
    ];
    let look = Look::default();
    let crop = Crop::of(Area { x0: 7, y0: 2, x1: 12, y1: 5 }, Area::whole(20, 10));
    let picture = |format| Picture { image: &image, format, look, recipe: "{}", crop };
    let exr = picture(OutputFormat::Exr);
    for layers in [&layers[..], &layers[1..], &[]] {
        exr.save_with(&path, layers).unwrap();
        assert_eq!(read_layers(&path).unwrap(), layers);
        let colors = Raster::read(&path).unwrap();
        assert_eq!((colors.image.rgb[3], colors.crop), (image.rgb[3], crop));
    }
    exr.save_with(&path, &layers).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in 4..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(read_layers(&path).is_err(), "{length}");
    }
    picture(OutputFormat::Png8).save_with(&path, &layers).unwrap();
    assert_eq!(read_layers(&path).unwrap(), []);
    assert!(read_layers(&folder.path().join("none")).is_err());
}
