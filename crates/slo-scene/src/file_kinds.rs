//! What a file is that is not what its name says.

/// What to call a file by its first bytes, if these are of a kind that is neither scene nor mesh
/// of ours, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    /// With its article: "a gzip file".
    pub(crate) name: &'static str,
    pub(crate) help: &'static str,
}

/// Bytes of a file that [`kind`] looks at.
pub(crate) const LOOKED_AT: usize = 1024;

const UNPACK: &str = "unpack it first";
const AS_TEXT: &str = "save it as UTF-8";
const AS_MESH: &str = "export it as .obj or .ply";
const AS_IMAGE: &str = "save it as PNG, JPEG or EXR";

const AS_WHAT_IT_IS: &str = "textures are images, meshes are .slo, .obj or .ply files";

/// Kinds by the bytes that their files begin with.
const MAGIC: [(&[u8], &str, &str); 59] = [
    (
        b"version https://git-lfs.github.com",
        "a Git LFS pointer, not the file itself",
        "fetch the file with `git lfs pull`",
    ),
    (b"\xff\xfe\0\0", "UTF-32 text", AS_TEXT),
    (b"\0\0\xfe\xff", "UTF-32 text", AS_TEXT),
    (b"\xff\xfe", "UTF-16 text", AS_TEXT),
    (b"\xfe\xff", "UTF-16 text", AS_TEXT),
    (b"\x1f\x8b", "a gzip file", UNPACK),
    (b"\x1f\x9d", "a file compressed by `compress`", UNPACK),
    (b"PK\x03\x04", "a zip archive", UNPACK),
    (b"PK\x05\x06", "a zip archive", UNPACK),
    (b"\x28\xb5\x2f\xfd", "a zstd file", UNPACK),
    (b"\xfd7zXZ\0", "an xz file", UNPACK),
    (b"LZIP", "an lzip file", UNPACK),
    (b"\x04\x22\x4d\x18", "an lz4 file", UNPACK),
    (b"BZh", "a bzip2 file", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    (b"\x89PNG\r\n\x1a\n", "a PNG image", AS_WHAT_IT_IS),
    (b"\xff\xd8\xff", "a JPEG image", AS_WHAT_IT_IS),
    (b"GIF8", "a GIF image", AS_IMAGE),
    (b"II*\0", "a TIFF image", AS_IMAGE),
    (b"MM\0*", "a TIFF image", AS_IMAGE),
    (b"II+\0", "a TIFF image", AS_IMAGE),
    (b"MM\0+", "a TIFF image", AS_IMAGE),
    (b"#?RADIANCE", "a Radiance HDR image", AS_WHAT_IT_IS),
    (b"#?RGBE", "a Radiance HDR image", AS_WHAT_IT_IS),
    (b"\x76\x2f\x31\x01", "an OpenEXR image", AS_WHAT_IT_IS),
    (b"8BPS", "a Photoshop document", AS_IMAGE),
    (b"DDS ", "a DDS image", AS_IMAGE),
    (b"\xabKTX ", "a KTX texture", AS_IMAGE),
    (b"gimp xcf", "a GIMP document", AS_IMAGE),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 image", AS_IMAGE),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 image", AS_IMAGE),
    (b"\0\0\0\x0cJXL ", "a JPEG XL image", AS_IMAGE),
    (b"\xff\x0a", "a JPEG XL image", AS_IMAGE),
    (b"\0\0\x01\0", "an icon", AS_IMAGE),
    (b"qoif", "a QOI image", AS_IMAGE),
    (b"PF\n", "a PFM image", AS_IMAGE),
    (b"%PDF", "a PDF document", "export its picture or mesh"),
    (b"Kaydara FBX Binary", "an FBX scene", AS_MESH),
    (b"; FBX", "an FBX scene", AS_MESH),
    (b"BLENDER", "a Blender file", AS_MESH),
    (b"glTF", "a glTF scene", AS_MESH),
    (b"PXR-USDC", "a USD scene", AS_MESH),
    (b"#usda", "a USD scene", AS_MESH),
    (b"Ogawa", "an Alembic scene", AS_MESH),
    (b"\x89HDF", "an HDF5 file", AS_MESH),
    (b"#VRML", "a VRML scene", AS_MESH),
    (b"#Inventor", "an Open Inventor scene", AS_MESH),
    (b"OFF\n", "an OFF mesh", AS_MESH),
    (b"OFF\r", "an OFF mesh", AS_MESH),
    (b"COFF\n", "an OFF mesh", AS_MESH),
    (b"solid ", "an STL mesh", AS_MESH),
    (b"ISO-10303-21", "a STEP file", AS_MESH),
    (b"# vtk DataFile", "a VTK file", AS_MESH),
    (b"\x7fELF", "a program", "name the mesh or the image"),
    (b"MZ\x90\0", "a program", "name the mesh or the image"),
    (b"\x64\x86", "an object file of a compiler", "name the mesh: its extension is .obj too"),
    (b"\x4c\x01", "an object file of a compiler", "name the mesh: its extension is .obj too"),
    (b"SQLite format 3", "a database", "name the mesh or the image"),
];

/// What a file is that begins with these bytes; `None` for text and for what is not known.
pub(crate) fn kind(start: &[u8]) -> Option<Kind> {
    let start = &start[..start.len().min(LOOKED_AT)];
    let known = MAGIC.iter().find(|(magic, ..)| start.starts_with(magic));
    let (name, help) = match known {
        Some(&(_, name, help)) => (name, help),
        None => special(start)?,
    };
    Some(Kind { name, help })
}

/// As [`kind`], of a text in which `#` begins a comment, whatever that says.
pub(crate) fn kind_of_text(start: &[u8]) -> Option<Kind> {
    kind(start).filter(|_| !start.starts_with(b"#"))
}

/// Kinds that more than the first bytes tell.
fn special(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let text = String::from_utf8_lossy(start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start));
    let text = text.trim_start().to_ascii_lowercase();
    let begins = |with: &[&str]| with.iter().any(|word| text.starts_with(word));
    if begins(&["<!doctype html", "<html", "<head", "<body"])
        || (begins(&["<?xml", "<!--"]) && text.contains("<html"))
    {
        return Some((
            "a web page, not the file itself",
            "download the file: the server sent HTML",
        ));
    }
    if begins(&["<svg"]) || (begins(&["<?xml"]) && text.contains("<svg")) {
        return Some(("an SVG drawing", AS_IMAGE));
    }
    if begins(&["<?xml", "<collada", "<x3d"]) {
        return Some(("an XML file", AS_MESH));
    }
    if text.starts_with('{') && text.contains("\"asset\"") {
        return Some(("a glTF scene", AS_MESH));
    }
    if text.starts_with('{') && text.contains("\":") {
        return Some(("a JSON file", AS_MESH));
    }
    if text.lines().next().is_some_and(|line| line.contains("/annex/objects/")) {
        return Some((
            "a git-annex pointer, not the file itself",
            "fetch the file with `git annex get`",
        ));
    }
    if begins(&["bplist", "from __future__"]) {
        return Some(("a program", "name the mesh or the image"));
    }
    riff(start).or_else(|| media(start)).or_else(|| by_zeros(start))
}

/// Images in the RIFF container.
fn riff(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let is_webp = start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WEBP");
    is_webp.then_some(("a WebP image", AS_IMAGE))
}

/// Images and videos in the container of MPEG-4, bitmaps and simple images.
fn media(start: &[u8]) -> Option<(&'static str, &'static str)> {
    if start.get(4..8) == Some(b"ftyp") {
        return Some(match start.get(8..11)? {
            b"avi" => ("an AVIF image", AS_IMAGE),
            b"hei" | b"hev" | b"mif" | b"msf" => ("an HEIC image", AS_IMAGE),
            _ => ("a video", AS_IMAGE),
        });
    }
    let is_bitmap = start.starts_with(b"BM") && start.get(6..10) == Some(&[0; 4]);
    if is_bitmap {
        return Some(("a BMP image", AS_IMAGE));
    }
    if start.len() > 262 && &start[257..262] == b"ustar" {
        return Some(("a tar archive", UNPACK));
    }
    let is_portable =
        matches!(start, [b'P', b'1'..=b'7', after, ..] if after.is_ascii_whitespace());
    if is_portable {
        return Some(("a PPM image", AS_IMAGE));
    }
    is_targa(start).then_some(("a TGA image", AS_IMAGE))
}

/// Whether this is the header of a TGA image, which has no magic bytes.
fn is_targa(start: &[u8]) -> bool {
    let Some(header) = start.first_chunk::<18>() else { return false };
    let [_, palette, kind, p0, p1, p2, p3, bits_of_palette, .., w0, w1, h0, h1, bits, flags] =
        *header;
    let has_palette = palette == 1 && matches!(kind, 1 | 9) && bits_of_palette >= 15;
    let has_none = palette == 0
        && matches!(kind, 2 | 3 | 10 | 11)
        && [p0, p1, p2, p3, bits_of_palette] == [0; 5];
    (has_palette || has_none)
        && [w0, w1] != [0; 2]
        && [h0, h1] != [0; 2]
        && matches!(bits, 8 | 15 | 16 | 24 | 32)
        && flags < 0x40
}

/// Text of two bytes a character without a mark at its start.
fn by_zeros(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let pairs = start.chunks_exact(2).take(16);
    let count = |at: usize| {
        pairs.clone().filter(|pair| pair[at] == 0 && (9..127).contains(&pair[1 - at])).count()
    };
    let len = pairs.clone().count();
    (len >= 4 && (count(0) == len || count(1) == len)).then_some(("UTF-16 text", AS_TEXT))
}

/// Whether bytes are of no text.
pub(crate) fn is_binary(start: &[u8]) -> bool {
    start.contains(&0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(start: &[u8]) -> &'static str {
        kind(start).map_or("", |kind| kind.name)
    }

    #[test]
    fn files_of_other_kinds_are_known() {
        let cases: [(&[u8], &str); 20] = [
            (
                b"version https://git-lfs.github.com/spec/v1\noid",
                "a Git LFS pointer, not the file itself",
            ),
            (b"\n <!DOCTYPE html><html>", "a web page, not the file itself"),
            (b"<?xml version=\"1.0\"?><html xmlns", "a web page, not the file itself"),
            (b"<?xml version=\"1.0\"?><COLLADA", "an XML file"),
            (b"\xff\xfev\0 \0", "UTF-16 text"),
            (b"v\0 \x000\0 \x000\0", "UTF-16 text"),
            (b"\0v\0 \x000\0 \x000", "UTF-16 text"),
            (b"\x1f\x8b\x08\0", "a gzip file"),
            (b"PK\x03\x04\x14\0", "a zip archive"),
            (b"\x28\xb5\x2f\xfd\0", "a zstd file"),
            (b"RIFF\x10\0\0\0WEBPVP8 ", "a WebP image"),
            (b"\0\0\0\x18ftypheic", "an HEIC image"),
            (b"BM\x36\0\0\0\0\0\0\0\x36", "a BMP image"),
            (b"{\"asset\":{\"version\":\"2.0\"}}", "a glTF scene"),
            (b"Kaydara FBX Binary  \0", "an FBX scene"),
            (b"solid cube\n facet normal", "an STL mesh"),
            (b"\x64\x86\x02\0", "an object file of a compiler"),
            (b"P6 3 3 255\n", "a PPM image"),
            (b"#?RADIANCE\n", "a Radiance HDR image"),
            (b"\x89PNG\r\n\x1a\n", "a PNG image"),
        ];
        for (start, expected) in cases {
            assert_eq!(name(start), expected, "{}", String::from_utf8_lossy(start));
        }
    }

    #[test]
    fn comments_say_nothing() {
        assert_eq!(kind_of_text(b"#VRML V2.0"), None);
        assert_eq!(kind(b"#VRML V2.0").map(|kind| kind.name), Some("a VRML scene"));
        assert!(kind_of_text(b"glTF").is_some());
    }

    #[test]
    fn meshes_and_scenes_are_nothing_else() {
        let texts = [
            "",
            "v 0 0 0\n",
            "# solid\nv 0 0 0",
            "ply\nformat ascii 1.0\n",
            "slo_mesh 1\n",
            "Camera main { }",
            "/* <html> */",
            "{",
            "\u{feff}v 0 0 0",
            "mtllib a.mtl",
            "B",
            "P",
            "#\n",
            "o BMW\n",
        ];
        for text in texts {
            assert_eq!(name(text.as_bytes()), "", "{text}");
        }
    }
}
