//! The parts of a JPEG file, looked at before anything is decoded.

use crate::format::FileError;
use crate::texture::decoded::damaged;

/// Scans that an image may have: more make a small file take hours.
const MAX_SCANS: usize = 1000;

/// Bytes of [`Structure::stream`] that follow the data of a scan.
const PADDING: usize = 1 << 12;

/// What is known of an image from its markers.
#[derive(Debug, Default)]
pub(super) struct Structure {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Whether the file has the marker of its end.
    pub(super) has_end: bool,
    /// The file for the decoder. Behind the data of each scan are ones, which begin no code: the
    /// standard reserves them. Data that ends early is then an error, while the decoder alone would continue
    /// with zeros; data that is whole is not touched.
    pub(super) stream: Vec<u8>,
    is_progressive: bool,
    /// Horizontal and vertical sampling factors of the components.
    sampling: Vec<[u32; 2]>,
    scans: usize,
    /// Bytes of all scans.
    data_len: u64,
}

impl Structure {
    /// Goes from marker to marker.
    ///
    /// # Errors
    /// The file ends in front of its first scan, or is of a kind that is not read.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, FileError> {
        let mut structure = Self::default();
        let mut position = 2;
        let mut copied = 0;
        while let Some((marker, start)) = next_marker(bytes, position) {
            position = start;
            match marker {
                0xd9 => {
                    structure.has_end = true;
                    break;
                }
                // Without a length: restarts that stand alone, and one for private use.
                0x01 | 0xd0..=0xd8 => continue,
                _ => {}
            }
            let Some(segment) = segment(bytes, start) else { break };
            structure.segment(marker, segment)?;
            position += 2 + segment.len();
            if marker == 0xda {
                let end = position + data_len(&bytes[position..]);
                structure.data_len += (end - position) as u64;
                structure.stream.extend_from_slice(&bytes[copied..end]);
                structure.stream.extend([0xff, 0x00].repeat(PADDING / 2));
                (position, copied) = (end, end);
            }
        }
        if structure.scans == 0 || structure.sampling.is_empty() {
            return Err(damaged("JPEG", "it is cut off in front of its pixels"));
        }
        let end = if structure.has_end { position } else { copied };
        structure.stream.extend_from_slice(&bytes[copied..end]);
        if !structure.has_end {
            structure.stream.extend([0xff, 0xd9]);
        }
        Ok(structure)
    }

    /// Takes note of a segment.
    fn segment(&mut self, marker: u8, segment: &[u8]) -> Result<(), FileError> {
        match marker {
            0xc0..=0xc2 if self.sampling.is_empty() => {
                self.is_progressive = marker == 0xc2;
                self.frame(segment)
            }
            0xc3 => Err(unsupported("lossless JPEG is not read")),
            0xc5..=0xc7 => Err(unsupported("hierarchical JPEG is not read")),
            0xc9..=0xcf => Err(unsupported("arithmetic coding is not read")),
            0xda => {
                self.scans += 1;
                match self.scans > MAX_SCANS {
                    true => Err(unsupported(&format!("it has more than {MAX_SCANS} scans"))),
                    false => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }

    /// Reads a frame header.
    fn frame(&mut self, segment: &[u8]) -> Result<(), FileError> {
        let [bits, h0, h1, w0, w1, count, components @ ..] = segment else {
            return Err(damaged("JPEG", "its header is too short"));
        };
        if *bits != 8 {
            return Err(unsupported(&format!("it has {bits} bits a channel")));
        }
        self.height = u32::from(u16::from_be_bytes([*h0, *h1]));
        self.width = u32::from(u16::from_be_bytes([*w0, *w1]));
        if self.height == 0 {
            return Err(unsupported("its height stands behind its pixels (DNL)"));
        }
        if self.width == 0 {
            return Err(damaged("JPEG", "it has no pixels"));
        }
        if components.len() != 3 * usize::from(*count) {
            return Err(damaged("JPEG", "its header is of a wrong length"));
        }
        self.sampling =
            components.chunks_exact(3).map(|c| [c[1] >> 4, c[1] & 15].map(u32::from)).collect();
        match self.sampling.as_flattened().iter().all(|factor| (1..=4).contains(factor)) {
            true => Ok(()),
            false => Err(damaged("JPEG", "its sampling factors are wrong")),
        }
    }

    /// Refuses an image whose data are too few for its pixels, before memory is taken for them:
    /// a block of 8 x 8 needs two bits, or one in a progressive image.
    ///
    /// # Errors
    /// There are too few.
    pub(super) fn check_data(&self) -> Result<(), FileError> {
        let most = |axis: usize| self.sampling.iter().map(|s| s[axis]).max().unwrap_or(1);
        let most = [most(0), most(1)];
        let blocks_along = |pixels: u32, factor: u32, most: u32| {
            (u64::from(pixels) * u64::from(factor)).div_ceil(u64::from(most)).div_ceil(8)
        };
        let blocks = self.sampling.iter().map(|&[h, v]| {
            blocks_along(self.width, h, most[0]) * blocks_along(self.height, v, most[1])
        });
        let bits = blocks.sum::<u64>() * if self.is_progressive { 1 } else { 2 };
        if bits <= 8 * self.data_len {
            return Ok(());
        }
        let (width, height, len) = (self.width, self.height, self.data_len);
        Err(damaged("JPEG", &format!("{len} bytes of data can't be {width} x {height} pixels")))
    }
}

/// The next marker at or behind a position, and where it ends.
fn next_marker(bytes: &[u8], position: usize) -> Option<(u8, usize)> {
    let mut position = position;
    loop {
        position += bytes.get(position..)?.iter().position(|&b| b == 0xff)?;
        position += bytes[position..].iter().position(|&b| b != 0xff)?;
        position += 1;
        if bytes[position - 1] != 0 {
            return Some((bytes[position - 1], position));
        }
    }
}

/// What follows the length of a segment that starts there; `None` if it is cut off.
fn segment(bytes: &[u8], start: usize) -> Option<&[u8]> {
    let len = bytes.get(start..start + 2)?;
    let len = usize::from(u16::from_be_bytes([len[0], len[1]]));
    bytes.get(start + 2..start + len)
}

/// Bytes of a scan's data, up to the next marker that is no restart.
fn data_len(bytes: &[u8]) -> usize {
    let mut position = 0;
    while let Some(found) = bytes[position..].iter().position(|&b| b == 0xff) {
        let marker = position + found;
        match bytes.get(marker + 1) {
            Some(0x00 | 0xd0..=0xd7) => position = marker + 2,
            // A fill byte in front of a marker.
            Some(0xff) => position = marker + 1,
            _ => return marker,
        }
    }
    bytes.len()
}

/// What to say about a JPEG image of a rare kind.
pub(super) fn unsupported(what: &str) -> FileError {
    FileError::whole_file(format!("the JPEG image can't be read: {what}"))
        .with_help("save it as a baseline or progressive JPEG of 8 bits a channel, or as PNG")
}
