//! Images of every form, written by the crate `exr`, and damaged ones.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks as Form, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Vec2, WritableImage, f16,
};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::load;
use crate::texture::decoded::LoadedTexture;

const COMPRESSIONS: [Compression; 9] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
];

const FORMS: [Form; 2] = [Form::ScanLines, Form::Tiles(Vec2(16, 8))];

/// Columns and rows: not a multiple of any block.
const SIZE: [usize; 2] = [37, 41];

/// A smooth ramp that every compression keeps.
fn ramp(channel: usize, x: usize, y: usize) -> f32 {
    (x + 2 * y + 40 * channel) as f32 / 64.0
}

/// A channel of the ramp.
fn halves(name: &str, channel: usize) -> AnyChannel<FlatSamples> {
    let [width, height] = SIZE;
    let pixels = (0..width * height).map(|i| f16::from_f32(ramp(channel, i % width, i / width)));
    AnyChannel::new(name, FlatSamples::F16(pixels.collect()))
}

fn floats(name: &str, value: impl Fn(usize) -> f32) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32((0..SIZE[0] * SIZE[1]).map(value).collect()))
}

fn file(channels: Vec<AnyChannel<FlatSamples>>, compression: Compression, form: Form) -> Vec<u8> {
    let encoding = Encoding { compression, blocks: form, line_order: LineOrder::Increasing };
    let layer = Layer::new(
        Vec2(SIZE[0], SIZE[1]),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels.into()),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut file).unwrap();
    file.into_inner()
}

fn rgb() -> Vec<AnyChannel<FlatSamples>> {
    vec![halves("R", 0), halves("G", 1), halves("B", 2)]
}

fn loaded(file: &[u8]) -> LoadedTexture {
    load(file).unwrap_or_else(|error| panic!("{}", error.message))
}

#[test]
fn every_compression_in_scan_lines_and_tiles() {
    for compression in COMPRESSIONS {
        for form in FORMS {
            let loaded = loaded(&file(rgb(), compression, form));
            let texture = &loaded.texture;
            assert_eq!([texture.width(), texture.height()].map(|side| side as usize), SIZE);
            assert_eq!(texture.bytes(), SIZE[0] * SIZE[1] * 6);
            let tolerance = match compression {
                Compression::B44 | Compression::B44A | Compression::DWAA(_) => 0.03,
                _ => 0.0,
            };
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let texel = texture.texel(x as u32, y as u32);
                    for (channel, value) in texel.into_iter().enumerate() {
                        let expected = ramp(channel, x, y);
                        let error = (value - expected).abs();
                        assert!(error <= tolerance, "{compression} {x} {y}: {value}, {expected}");
                    }
                }
            }
            let is_dwa = matches!(compression, Compression::DWAA(_));
            assert_eq!(loaded.warnings.len(), usize::from(is_dwa), "{:?}", loaded.warnings);
        }
    }
}

#[test]
fn floats_and_whole_numbers_keep_their_values() {
    let third = |i: usize| i as f32 / 3.0;
    let number = AnyChannel::new(
        "B",
        FlatSamples::U32((0..SIZE[0] * SIZE[1]).map(|i| i as u32 * 100_000).collect()),
    );
    let channels = vec![floats("R", third), halves("G", 1), number];
    let texture = loaded(&file(channels, Compression::ZIP16, Form::ScanLines)).texture;
    assert_eq!(texture.texel(3, 2), [third(2 * 37 + 3), ramp(1, 3, 2), 7_700_000.0]);
    assert!(texture.is_float() && texture.bytes() == SIZE[0] * SIZE[1] * 12);
}

#[test]
fn grey_and_alpha() {
    let texture = loaded(&file(vec![halves("Y", 1)], Compression::PIZ, FORMS[0])).texture;
    assert_eq!(texture.texel_rgba(5, 6), [ramp(1, 5, 6), ramp(1, 5, 6), ramp(1, 5, 6), 1.0]);
    assert!(texture.is_grey() && !texture.has_alpha());

    let with_alpha = |alpha: fn(usize) -> f32| {
        let channels = [rgb(), vec![floats("A", alpha)]].concat();
        loaded(&file(channels, Compression::ZIP1, FORMS[1])).texture
    };
    let clear = with_alpha(|i| if i == 40 { 0.25 } else { 1.0 });
    assert!(clear.has_alpha() && clear.is_transparent() && clear.is_premultiplied());
    assert_eq!(clear.texel_rgba(3, 1), [ramp(0, 3, 1), ramp(1, 3, 1), ramp(2, 3, 1), 0.25]);
    assert_eq!(clear.texel_rgba(4, 1)[3], 1.0);
    let opaque = with_alpha(|_| 1.0);
    assert!(opaque.has_alpha() && !opaque.is_transparent());
    assert_eq!(opaque.texel_rgba(3, 1)[3], 1.0);
    assert_eq!(opaque.bytes(), SIZE[0] * SIZE[1] * 12);
}

#[test]
fn values_without_sense_are_replaced_and_counted() {
    let odd = |i: usize| match i {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => -1.0,
        _ => 1.0,
    };
    let of = |channel| loaded(&file(vec![channel], Compression::ZIP16, FORMS[0]));
    let found = of(floats("Y", odd));
    assert_eq!([0, 1, 2, 3].map(|x| found.texture.texel(x, 0)[0]), [0.0, 65504.0, 0.0, 1.0]);
    let halves = FlatSamples::F16((0..SIZE[0] * SIZE[1]).map(|i| f16::from_f32(odd(i))).collect());
    let same = of(AnyChannel::new("Y", halves));
    assert_eq!([0, 1, 2, 3].map(|x| same.texture.texel(x, 0)[0]), [0.0, 65504.0, 0.0, 1.0]);
    assert_eq!(found.warnings, same.warnings);
    insta::assert_snapshot!(found.warnings.join("\n"), @r"
    1 value is NaN and counts as 0
    1 value is negative and counts as 0
    1 value is infinite or more than 1e18 and counts as 65504, the largest half float
    ");
}

#[test]
fn a_part_of_what_is_displayed_is_warned_of() {
    let whole = file(rgb(), Compression::ZIP16, FORMS[0]);
    let mut cropped = whole.clone();
    let name = b"displayWindow\0box2i\0\x10\0\0\0";
    let at = whole.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    cropped[at + 8..at + 12].copy_from_slice(&99_i32.to_le_bytes());
    insta::assert_snapshot!(
        loaded(&cropped).warnings.join("\n"),
        @"its data window (37 x 41) is not its display window (100 x 41): the texture is the data window"
    );
}

#[test]
fn what_is_wrong_is_said() {
    let whole = file(rgb(), Compression::ZIP16, FORMS[0]);
    let with = |at: &[u8], offset: usize, bytes: &[u8]| {
        let mut file = whole.clone();
        let at = whole.windows(at.len()).position(|w| w == at).unwrap() + at.len() + offset;
        file[at..at + bytes.len()].copy_from_slice(bytes);
        load(&file).unwrap_err().message
    };
    let window = b"dataWindow\0box2i\0\x10\0\0\0";
    let said = [
        with(window, 8, &30_000_i32.to_le_bytes()),
        with(window, 8, &i32::MAX.to_le_bytes()),
        with(window, 12, &400_i32.to_le_bytes()),
        with(window, 12, &i32::MAX.to_le_bytes()),
        with(b"compression\0compression\0\x01\0\0\0", 0, &[99]),
        load(&whole[..100]).unwrap_err().message,
        load(&whole[..whole.len() - 9]).unwrap_err().message,
    ];
    insta::assert_snapshot!(said.join("\n"), @r"
    the EXR image is damaged: decompressed data
    the EXR image is damaged: window size exceeding integer maximum
    the EXR image is damaged: chunk count not matching data size
    the EXR image is damaged: window size exceeding integer maximum
    the EXR image can't be read: unknown compression method
    the EXR image is damaged: it is cut off
    the EXR image is damaged: it is cut off
    ");
    for len in 4..whole.len() {
        let error = load(&whole[..len]).expect_err("it is cut");
        assert!(error.message.starts_with("the EXR image is damaged: "), "{}", error.message);
    }
}

#[test]
fn blocks_that_promise_too_much_take_no_memory() {
    for form in FORMS {
        let whole = file(rgb(), Compression::DWAA(None), form);
        // Version 2, then the first counter, which is 0: all channels are of kinds that DWA knows.
        let start = [2_u64.to_le_bytes(), [0; 8]].concat();
        let at = whole.windows(16).rposition(|w| w == start).expect("a block begins so");
        for counter in [1, 6, 7, 8, 9] {
            for count in [1 << 20, 1 << 40, u64::MAX >> 1, u64::MAX] {
                let mut file = whole.clone();
                file[at + 8 * counter..at + 8 * counter + 8].copy_from_slice(&count.to_le_bytes());
                assert_eq!(
                    load(&file).unwrap_err().message,
                    "the EXR image is damaged: a block promises more than it has room for"
                );
            }
        }
    }
}

#[test]
fn mutated_files_never_panic() {
    let mut random = StdRng::seed_from_u64(7);
    let mut refused = 0;
    for compression in COMPRESSIONS {
        for form in FORMS {
            let channels = [rgb(), vec![floats("A", |i| i as f32 / 1e4)]].concat();
            let whole = file(channels, compression, form);
            for _ in 0..300 {
                let mut damaged = whole.clone();
                for _ in 0..random.random_range(1..4) {
                    // Headers and tables are short, and worth more tries.
                    let end = if random.random() { 700 } else { damaged.len() };
                    let at = random.random_range(4..end.min(damaged.len()));
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
                        assert!(!error.message.contains('\n'), "{}", error.message);
                    }
                }
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}
