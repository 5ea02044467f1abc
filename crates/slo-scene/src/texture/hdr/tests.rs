//! Small images in every form, and damaged ones.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::load;
use crate::texture::decoded::LoadedTexture;

/// A file of these pixels, as they are.
fn file(resolution: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n");
    [header.as_bytes(), data].concat()
}

/// Red of all texels, the top row first, if it is 0 to 255 halves.
fn reds(loaded: &LoadedTexture) -> Vec<u32> {
    let texture = &loaded.texture;
    let rows = (0..texture.height()).flat_map(|y| (0..texture.width()).map(move |x| (x, y)));
    rows.map(|(x, y)| (texture.texel(x, y)[0] * 2.0) as u32).collect()
}

/// A pixel of half that red.
fn pixel(red: u8) -> [u8; 4] {
    [red, 7, 9, 135]
}

fn message(file: &[u8]) -> String {
    load(file).unwrap_err().message
}

#[test]
fn flat_pixels_in_every_order() {
    // As it should come out: 1 2 3 / 4 5 6.
    for (resolution, order) in [
        ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
        ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
        ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
        ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
        ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
        ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
        ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
    ] {
        let data = order.map(pixel);
        let loaded = load(&file(resolution, data.as_flattened())).unwrap();
        assert_eq!((loaded.texture.width(), loaded.texture.height()), (3, 2), "{resolution}");
        assert_eq!(reds(&loaded), [1, 2, 3, 4, 5, 6], "{resolution}");
        assert!(loaded.texture.is_float() && !loaded.texture.has_alpha());
    }
}

#[test]
fn values_are_exact() {
    let data = [[128, 64, 32, 129], [255, 0, 1, 136], [9, 9, 9, 0], [200, 100, 50, 148]];
    let loaded = load(&file("-Y 1 +X 4", data.as_flattened())).unwrap();
    let texel = |x| loaded.texture.texel(x, 0);
    assert_eq!(texel(0), [1.0, 0.5, 0.25]);
    assert_eq!(texel(1), [255.0, 0.0, 1.0]);
    assert_eq!(texel(2), [0.0; 3]);
    assert_eq!(texel(3), [200.0 * 4096.0, 100.0 * 4096.0, 50.0 * 4096.0]);
    assert_eq!(loaded.texture.bytes(), 16);
}

#[test]
fn old_runs_repeat_pixels() {
    let data = [pixel(1), [1, 1, 1, 2], pixel(5), pixel(6)];
    let loaded = load(&file("-Y 1 +X 5", data.as_flattened())).unwrap();
    assert_eq!(reds(&loaded), [1, 1, 1, 5, 6]);
    // 3 + 256 * 2 more.
    let data = [pixel(8), [1, 1, 1, 3], [1, 1, 1, 2], pixel(9)];
    let loaded = load(&file("-Y 1 +X 517", data.as_flattened())).unwrap();
    let reds = reds(&loaded);
    assert!(reds[..516].iter().all(|red| *red == 8) && reds[516] == 9);
    for wrong in [[1, 1, 1, 4], [1, 1, 1, 255]] {
        let data = [pixel(1), wrong, pixel(5), pixel(6)];
        assert!(message(&file("-Y 1 +X 4", data.as_flattened())).contains("a run of its pixels"));
    }
    let data = [[1, 1, 1, 1], pixel(1)];
    assert!(message(&file("-Y 1 +X 2", data.as_flattened())).contains("a run of its pixels"));
}

/// A line of 10 pixels with new run lengths: red 1 to 10, the others constant.
fn new_line() -> Vec<u8> {
    let mut line = vec![2, 2, 0, 10, 4, 1, 2, 3, 4, 6, 5, 6, 7, 8, 9, 10];
    line.extend([138, 7, 138, 9, 128 + 5, 135, 128 + 5, 135]);
    line
}

#[test]
fn new_runs_repeat_bytes() {
    let data = [new_line(), new_line()].concat();
    let whole = file("-Y 2 +X 10", &data);
    let loaded = load(&whole).unwrap();
    assert_eq!(reds(&loaded)[..10], [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(reds(&loaded)[10..], [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(loaded.texture.texel(9, 1), [5.0, 3.5, 4.5]);
    // Lines may differ in their form.
    let mixed = [new_line(), [pixel(3), [1, 1, 1, 9]].concat()].concat();
    assert_eq!(reds(&load(&file("-Y 2 +X 10", &mixed)).unwrap())[10..], [3; 10]);
    for len in 0..whole.len() {
        assert!(message(&whole[..len]).starts_with("the HDR image is damaged: "), "{len}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let long = |wrong: &[(usize, u8)]| {
        let mut line = new_line();
        wrong.iter().for_each(|&(at, byte)| line[at] = byte);
        message(&file("-Y 1 +X 10", &line))
    };
    let said = [
        message(&file("-Y 0 +X 3", &[])),
        message(&file("-Y 3 +Y 3", &[0; 100])),
        message(&file("-Y 3", &[0; 100])),
        message(&file("-Y 99999999999 +X 1", &[0; 100])),
        message(&file("-Y 20000 +X 20000", &[0; 100])),
        message(&file("-Y 8192 +X 8192", &[0; 100])),
        message(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234"),
        message(b"#?RADIANCE\n\n"),
        message(b"#?"),
        long(&[(3, 11)]),
        long(&[(4, 11)]),
        long(&[(4, 0)]),
        long(&[(21, 189)]),
        message(&file("-Y 1 +X 2", &[0; 7])),
    ];
    insta::assert_snapshot!(said.join("\n"), @r"
    the HDR image is damaged: the line with its size, such as `-Y 512 +X 1024`, is wrong
    the HDR image is damaged: the line with its size, such as `-Y 512 +X 1024`, is wrong
    the HDR image is damaged: the line with its size, such as `-Y 512 +X 1024`, is wrong
    the HDR image is damaged: the line with its size, such as `-Y 512 +X 1024`, is wrong
    the image has 20000 x 20000 pixels, more than 268435456
    the HDR image is damaged: 100 bytes can't be 8192 x 8192 pixels
    the HDR image can't be read: its colours are in CIE XYZ, not in RGB
    the HDR image is damaged: it is cut off
    the HDR image is damaged: it is cut off
    the HDR image is damaged: a line has a wrong length
    the HDR image is damaged: a run of its bytes is wrong
    the HDR image is damaged: a run of its bytes is wrong
    the HDR image is damaged: a pixel is brighter than 1e18
    the HDR image is damaged: it is cut off
    ");
}

#[test]
fn mutated_files_never_panic() {
    let whole = file("-Y 3 +X 10", &[new_line(), new_line(), new_line()].concat());
    let mut random = StdRng::seed_from_u64(5);
    let mut refused = 0;
    for _ in 0..20_000 {
        let mut damaged = whole.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..damaged.len());
            damaged[at] = random.random();
        }
        match load(&damaged) {
            Ok(loaded) => {
                let texture = loaded.texture;
                let [r, ..] = texture.texel(texture.width() - 1, texture.height() - 1);
                assert!(r.is_finite() && r >= 0.0);
            }
            Err(error) => {
                refused += 1;
                assert!(!error.message.contains(['{', '\n']), "{}", error.message);
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}
