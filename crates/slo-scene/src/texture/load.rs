//! Which decoder an image file is for, and the errors about files of other kinds.

use std::io::Read;

use super::decoded::LoadedTexture;
use super::{exr, hdr, jpeg, png};
use crate::file_kinds::{self, Kind};
use crate::format::FileError;
use crate::mesh;

/// Bytes that an image file may have.
const MAX_FILE_BYTES: u64 = 1 << 31;

/// Reads a PNG, JPEG, OpenEXR or Radiance HDR image; its first bytes say which it is, whatever
/// `path_name` ends in.
///
/// Values keep the precision of the file, and palettes are looked up.
///
/// # Errors
/// The file can't be read, is of none of these formats, is damaged, or has more than 2^28 texels.
pub fn load(path_name: &str, reader: &mut dyn Read) -> Result<LoadedTexture, FileError> {
    let bytes = read_image_file(reader)?;
    match &bytes[..] {
        [] => Err(FileError::whole_file("the image file is empty")),
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => png::load(&bytes),
        [0xff, 0xd8, 0xff, ..] => jpeg::load(&bytes),
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::load(&bytes),
        [b'#', b'?', ..] => hdr::load(&bytes),
        _ => Err(other_kind(path_name, &bytes)),
    }
}

/// The whole file; a limit keeps an endless one out.
fn read_image_file(reader: &mut dyn Read) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    reader
        .take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| FileError::whole_file(format!("the image can't be read: {e}")))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(FileError::whole_file("the image file has more than 2 GB"));
    }
    Ok(bytes)
}

/// What to say about a file that starts like none of the formats.
fn other_kind(path_name: &str, bytes: &[u8]) -> FileError {
    const HELP: &str = "textures are PNG, JPEG, EXR or HDR files";
    let (name, help) = if let Some(Kind { name, help }) = file_kinds::kind(bytes) {
        (name.to_owned(), help)
    } else if let Some(kind) = mesh::kind(&bytes[..bytes.len().min(file_kinds::LOOKED_AT)]) {
        (format!("a .{kind} mesh"), HELP)
    } else {
        (format!("no image, although it is called `{path_name}`"), HELP)
    };
    FileError::whole_file(format!("the file is {name}")).with_help(help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::png::png_reason;

    /// Of a JPEG file everything up to its first scan, or less.
    const START: &[u8] = b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x00\x00\x01\x00\x01\x00\x00\
        \xff\xdb\x00\x43\x00\x08\x06\x06\x07\x06";

    #[test]
    fn damaged_png_images_are_told_without_debug_text() {
        let mut whole = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut whole, 16, 16);
        encoder.set_color(::png::ColorType::Rgb);
        let pixels: Vec<u8> = (0..16 * 16 * 3).map(|i| (i * i % 251) as u8).collect();
        encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
        for at in 8..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x15;
            let Err(error) = load("a.png", &mut &damaged[..]) else { continue };
            let message = error.message;
            assert!(!message.contains(['{', '\n']), "byte {at}: {message}");
        }
        // The length of the last IDAT chunk, so that what follows it is taken for a chunk's name.
        let data = whole.windows(4).position(|name| name == b"IDAT").unwrap();
        for length in 0..=255 {
            let mut damaged = whole.clone();
            damaged[data - 1] = length;
            let Err(error) = load("a.png", &mut &damaged[..]) else { continue };
            assert!(!error.message.contains('{'), "{length}: {}", error.message);
        }
        let said = "Unrecognized critical chunk: ChunkType { type: \\u{16}I,A, critical: true, \
                    private: false, reserved: false, safecopy: false }";
        assert_eq!(png_reason(said), "it has a chunk of a kind that PNG does not know");
        let mut damaged = whole.clone();
        damaged[16] ^= 1;
        let error = load("a.png", &mut &damaged[..]).unwrap_err();
        assert_eq!(
            error.message,
            "the PNG image is damaged: the checksum of its IHDR chunk is wrong"
        );
    }

    /// A PNG image of 4 x 4 pixels.
    fn png_of(color: ::png::ColorType, depth: ::png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut file, 4, 4);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ::png::ColorType::Indexed {
            encoder.set_palette(&[9, 9, 9, 200, 100, 50][..]);
            encoder.set_trns(vec![data[0] * 255]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        file
    }

    /// The file with a chunk in front of its pixels.
    fn with_chunk(file: &[u8], name: &[u8; 4], data: &[u8]) -> Vec<u8> {
        let at = file.windows(4).position(|w| w == b"IDAT").unwrap() - 4;
        let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
        chunk.extend_from_slice(name);
        chunk.extend_from_slice(data);
        chunk.extend(crc32fast::hash(&chunk[4..]).to_be_bytes());
        [&file[..at], &chunk, &file[at..]].concat()
    }

    #[test]
    fn alpha_is_kept_where_a_pixel_is_transparent() {
        use ::png::BitDepth::{Eight, Sixteen};
        use ::png::ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
        // Has alpha, is transparent, alpha of the third pixel, bytes.
        let load = |color, depth, data: &[u8]| {
            let loaded = load("a.png", &mut &png_of(color, depth, data)[..]).unwrap();
            assert_eq!(loaded.warnings, Vec::<String>::new());
            let texture = loaded.texture;
            let alpha = (texture.texel_rgba(2, 0)[3] * 255.0).round() as u8;
            (texture.has_alpha(), texture.is_transparent(), alpha, texture.bytes())
        };
        for (color, channels) in [(GrayscaleAlpha, 2), (Rgba, 4)] {
            for (depth, bytes) in [(Eight, 1), (Sixteen, 2)] {
                let opaque = vec![255; 16 * channels * bytes];
                let len = 16 * (channels - 1) * bytes;
                assert_eq!(load(color, depth, &opaque), (true, false, 255, len));
                let mut clear = opaque.clone();
                clear[3 * channels * bytes - bytes..3 * channels * bytes].fill(51);
                let len = 16 * channels * bytes;
                assert_eq!(load(color, depth, &clear), (true, true, 51, len));
            }
        }
        assert_eq!(load(Rgb, Eight, &[7; 48]), (false, false, 255, 48));
        assert_eq!(load(Grayscale, Eight, &[7; 16]), (false, false, 255, 16));
        assert_eq!(load(Indexed, Eight, &[1; 16]), (true, false, 255, 48));
        let holed = [vec![1; 2], vec![0; 1], vec![1; 13]].concat();
        assert!(!load(Indexed, Eight, &holed).1);
        let holed = [vec![0; 1], vec![1; 1], vec![0; 1], vec![1; 13]].concat();
        assert_eq!(load(Indexed, Eight, &holed), (true, true, 0, 64));
    }

    #[test]
    fn colours_are_as_stored() {
        use ::png::{BitDepth, ColorType};
        let texel = |color, depth, data: &[u8]| {
            let loaded = load("a.png", &mut &png_of(color, depth, data)[..]).unwrap();
            loaded.texture.texel(3, 3).map(|c| (c * 65535.0).round() as u16)
        };
        let rgba = [[0, 0, 0, 0].repeat(15), vec![1, 2, 3, 4]].concat();
        assert_eq!(texel(ColorType::Rgba, BitDepth::Eight, &rgba), [257, 514, 771]);
        let grey = [[0, 0].repeat(15), vec![5, 6]].concat();
        assert_eq!(texel(ColorType::GrayscaleAlpha, BitDepth::Eight, &grey), [1285; 3]);
        let deep = [[0; 6].repeat(15), vec![1, 2, 3, 4, 5, 6]].concat();
        assert_eq!(texel(ColorType::Rgb, BitDepth::Sixteen, &deep), [258, 772, 1286]);
        assert_eq!(texel(ColorType::Grayscale, BitDepth::One, &[0, 0, 0, 16]), [65535; 3]);
        let index = texel(ColorType::Indexed, BitDepth::Eight, &[1; 16]);
        assert_eq!(index, [200 * 257, 100 * 257, 50 * 257]);
    }

    #[test]
    fn chunks_beside_the_pixels_are_not_unpacked_and_may_be_damaged() {
        let plain = png_of(::png::ColorType::Rgb, ::png::BitDepth::Eight, &[7; 48]);
        let expected = load("a.png", &mut &plain[..]).unwrap();
        // A profile and a text that would unpack to 64 MB.
        let zeros = vec![0; 1 << 26];
        let packed = {
            let mut packed = Vec::new();
            let mut encoder = ::png::Encoder::new(&mut packed, 1 << 13, 1 << 13);
            encoder.set_color(::png::ColorType::Grayscale);
            encoder.write_header().unwrap().write_image_data(&zeros).unwrap();
            let at = packed.windows(4).position(|w| w == b"IDAT").unwrap();
            let len = u32::from_be_bytes(packed[at - 4..at].try_into().unwrap()) as usize;
            packed[at + 4..at + 4 + len].to_vec()
        };
        let bombs = [(b"iCCP", &b"p\0\0"[..]), (b"zTXt", b"t\0\0"), (b"iTXt", b"t\0\x01\0\0\0")];
        for (name, head) in bombs {
            let file = with_chunk(&plain, name, &[head, &packed].concat());
            assert_eq!(load("a.png", &mut &file[..]).unwrap(), expected);
        }
        let mut file = with_chunk(&plain, b"tEXt", b"Title\0wood");
        let at = file.windows(4).position(|w| w == b"wood").unwrap();
        file[at] ^= 1;
        assert_eq!(load("a.png", &mut &file[..]).unwrap(), expected);
    }

    #[test]
    fn a_png_image_that_is_cut_off_is_damaged() {
        let whole = png_of(::png::ColorType::Rgb, ::png::BitDepth::Eight, &[7; 48]);
        for len in 9..whole.len() - 4 {
            let error = load("a.png", &mut &whole[..len]).expect_err("it is cut");
            assert!(error.message.starts_with("the PNG image is damaged: "), "{}", error.message);
        }
        let mut large = whole.clone();
        large[16..24].copy_from_slice(&[0, 0, 0x3f, 0, 0, 0, 0x3f, 0]);
        let crc = crc32fast::hash(&large[12..29]).to_be_bytes();
        large[29..33].copy_from_slice(&crc);
        let error = load("a.png", &mut &large[..]).unwrap_err();
        assert!(
            error.message.ends_with("bytes can't be 16128 x 16128 pixels"),
            "{}",
            error.message
        );
    }

    #[test]
    fn other_files_are_said_to_be_what_they_are() {
        let of = |bytes: &[u8]| load("a.png", &mut &bytes[..]).unwrap_err().message;
        let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n";
        assert_eq!(of(pointer), "the file is a Git LFS pointer, not the file itself");
        assert_eq!(of(b"RIFF\x10\0\0\0WEBPVP8 "), "the file is a WebP image");
        let targa = [&[0, 0, 2][..], &[0; 9], &[4, 0, 4, 0, 24, 0], &[7; 48]].concat();
        assert_eq!(of(b"ply\nformat ascii 1.0\n"), "the file is a .ply mesh");
        assert_eq!(of(&targa), "the file is a TGA image");
        assert_eq!(of(b"what?"), "the file is no image, although it is called `a.png`");
        assert_eq!(of(b""), "the image file is empty");
    }

    #[test]
    fn a_cut_image_gives_one_line() {
        for length in [4, 12, 20, 24, START.len()] {
            let error = load("a.jpg", &mut &START[..length]).expect_err("it is cut");
            let message = error.message;
            assert!(message.starts_with("the JPEG image is damaged: "), "{message}");
            assert!(!message.contains('\n') && message.trim_end() == message, "{message:?}");
        }
    }
}
