//! Small images of every kind. They show the same six squares, 16 pixels wide; `cjpeg` of libjpeg
//! wrote them (`cmyk` and `turned`: Pillow).

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::load;
use crate::texture::decoded::LoadedTexture;

/// The colours of the squares, row by row.
const SQUARES: [[i32; 3]; 6] =
    [[200, 40, 40], [40, 180, 60], [50, 60, 200], [230, 220, 40], [20, 20, 20], [180, 180, 180]];

macro_rules! file {
    ($name:literal) => {
        ($name, include_bytes!(concat!("files/", $name, ".jpg")).as_slice())
    };
}

const COLORED: [(&str, &[u8]); 16] = [
    file!("together_1x1"),
    file!("together_2x1"),
    file!("together_2x2"),
    file!("together_1x2"),
    file!("together_4x1"),
    file!("apart_1x1"),
    file!("apart_2x1"),
    file!("apart_2x2"),
    file!("apart_1x2"),
    file!("apart_4x1"),
    file!("mixed_2x1"),
    file!("progressive"),
    file!("restarts"),
    file!("rgb"),
    file!("cmyk"),
    file!("turned"),
];
const GREY: &[u8] = include_bytes!("files/grey.jpg");
const ARITHMETIC: &[u8] = include_bytes!("files/arithmetic.jpg");

fn file(name: &str) -> &'static [u8] {
    COLORED.iter().find(|(n, _)| *n == name).expect(name).1
}

fn error_of(bytes: &[u8]) -> String {
    load(bytes).expect_err("an error").message
}

/// The largest difference of a channel in the middle of the squares.
fn difference(loaded: &LoadedTexture, squares: [[i32; 3]; 6]) -> i32 {
    let texture = &loaded.texture;
    assert_eq!((texture.width(), texture.height()), (48, 32));
    let mut largest = 0;
    for (square, expected) in squares.into_iter().enumerate() {
        let (x, y) = (16 * (square as u32 % 3), 16 * (square as u32 / 3));
        for (dx, dy) in [(3, 3), (8, 8), (12, 4), (4, 12)] {
            let texel = texture.texel(x + dx, y + dy);
            for (value, expected) in texel.into_iter().zip(expected) {
                largest = largest.max(((value * 255.0) as i32 - expected).abs());
            }
        }
    }
    largest
}

#[test]
fn every_kind_shows_the_same_picture() {
    for (name, bytes) in COLORED {
        let loaded = load(bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let difference = difference(&loaded, SQUARES);
        assert!(difference <= 8, "{name}: {difference}");
        let is_turned = name == "turned";
        assert_eq!(loaded.warnings.len(), usize::from(is_turned), "{name}: {:?}", loaded.warnings);
    }
    let grey = SQUARES.map(|[r, g, b]| [(299 * r + 587 * g + 114 * b) / 1000; 3]);
    assert!(difference(&load(GREY).expect("grey"), grey) <= 5);
}

#[test]
fn kinds_that_are_not_read_are_named() {
    assert_eq!(error_of(ARITHMETIC), "the JPEG image can't be read: arithmetic coding is not read");
    let with_frame = |change: &dyn Fn(&mut [u8])| {
        let mut bytes = file("together_1x1").to_vec();
        let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame");
        change(&mut bytes[frame..]);
        error_of(&bytes)
    };
    let error = with_frame(&|frame| (frame[1], frame[4]) = (0xc1, 12));
    assert_eq!(error, "the JPEG image can't be read: it has 12 bits a channel");
    let error = with_frame(&|frame| frame[1] = 0xc3);
    assert_eq!(error, "the JPEG image can't be read: lossless JPEG is not read");
    let error = with_frame(&|frame| frame[5..7].fill(0));
    assert_eq!(error, "the JPEG image can't be read: its height stands behind its pixels (DNL)");
}

/// Wherever the file ends, with or without a marker that says so.
#[test]
fn an_image_that_is_cut_off_is_damaged() {
    for name in ["together_2x2", "apart_2x2", "restarts", "rgb", "cmyk"] {
        let whole = file(name);
        let data_end = whole.len() - 2;
        for len in 3..data_end - 3 {
            for end in [&b""[..], b"\xff\xd9"] {
                let cut = [&whole[..len], end].concat();
                let message = error_of(&cut);
                assert!(
                    message.starts_with("the JPEG image is damaged: "),
                    "{name} {len}: {message}"
                );
            }
        }
        // Only the marker is missing: all pixels are there.
        let loaded = load(&whole[..data_end]).expect(name);
        assert_eq!(loaded.texture, load(whole).expect(name).texture);
        assert_eq!(loaded.warnings, ["the file is cut off behind the last pixel"]);
    }
}

/// A header that promises more than there is takes no memory for it.
#[test]
fn a_header_that_promises_too_much_is_damaged() {
    for (name, marker) in [("together_2x2", 0xc0), ("progressive", 0xc2)] {
        let mut bytes = file(name).to_vec();
        let frame = bytes.windows(2).position(|w| w == [0xff, marker]).expect("a frame");
        for (size, shown) in [(8000_u16, "8000 x 8000"), (640, "640 x 640")] {
            bytes[frame + 5..frame + 7].copy_from_slice(&size.to_be_bytes());
            bytes[frame + 7..frame + 9].copy_from_slice(&size.to_be_bytes());
            let message = error_of(&bytes);
            assert!(
                message.contains(&format!("bytes of data can't be {shown} pixels")),
                "{message}"
            );
        }
        bytes[frame + 5..frame + 9].fill(0xff);
        assert!(error_of(&bytes).contains("65535 x 65535 pixels, more than"));
        // Somewhat more: the data end early.
        bytes[frame + 5..frame + 9].copy_from_slice(&[0, 64, 0, 64]);
        assert!(error_of(&bytes).starts_with("the JPEG image is damaged: "));
    }
}

#[test]
fn mutated_files_never_panic() {
    let mut rng = StdRng::seed_from_u64(5);
    let mut read_well = 0;
    for round in 0..20_000 {
        let mut bytes = COLORED[round % COLORED.len()].1.to_vec();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(2..bytes.len());
            match rng.random_range(0..4) {
                0 => bytes[at] = rng.random(),
                1 => bytes[at] ^= 1 << rng.random_range(0..8),
                2 => bytes.insert(at, rng.random()),
                _ => bytes.truncate(at.max(8)),
            }
        }
        match load(&bytes) {
            Ok(_) => read_well += 1,
            Err(error) => assert!(!error.message.contains(['\n', '{']), "{}", error.message),
        }
    }
    assert!(read_well > 500, "only {read_well} files survived");
}
