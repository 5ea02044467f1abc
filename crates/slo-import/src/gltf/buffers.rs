//! The bytes of buffers and images.

use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;
use percent_encoding::percent_decode_str;

use crate::error::ImportError;
use crate::files::Source;

/// Bytes that the parts of any file may take, and how many times the bytes of its buffers.
const LEAST: usize = 64 << 20;
const TIMES: usize = 32;

/// The bytes of a buffer. Several buffers may be one file.
pub(super) type Bytes = Rc<Vec<u8>>;

/// How many bytes numbers and images may still take. A part of a file may be named many times, and is a copy
/// each time.
#[derive(Debug)]
pub(super) struct Left(Cell<usize>);

impl Left {
    /// Takes some of them.
    ///
    /// # Errors
    /// There are not so many left.
    pub(super) fn take(&self, source: &Source, bytes: usize) -> Result<(), ImportError> {
        let Some(left) = self.0.get().checked_sub(bytes) else {
            let message = format!(
                "its parts are used so often that they take more than {TIMES} times its size"
            );
            return Err(source.bad(message));
        };
        self.0.set(left);
        Ok(())
    }
}

/// Reads all buffers, each file once. Returns also how much their parts may take.
pub(super) fn load(
    source: &Source,
    document: &Document,
    blob: Option<&[u8]>,
) -> Result<(Vec<Bytes>, Left), ImportError> {
    let mut buffers = Vec::new();
    let mut known: HashMap<Option<&str>, Bytes> = HashMap::new();
    let mut all = source.bytes.len();
    for buffer in document.buffers() {
        let uri = match buffer.source() {
            gltf::buffer::Source::Bin => None,
            gltf::buffer::Source::Uri(uri) => Some(uri),
        };
        let bytes = match (known.get(&uri), uri) {
            (Some(bytes), _) => bytes.clone(),
            (None, Some(name)) => Rc::new(bytes_of(source, name)?),
            (None, None) => Rc::new(blob.unwrap_or_default().to_vec()),
        };
        if bytes.len() < buffer.length() {
            let message = format!("buffer {} is shorter than the file says", buffer.index());
            return Err(source.bad(message));
        }
        if known.insert(uri, bytes.clone()).is_none() {
            all = all.saturating_add(bytes.len());
        }
        buffers.push(bytes);
    }
    let left = Left(Cell::new(all.saturating_mul(TIMES).saturating_add(LEAST)));
    Ok((buffers, left))
}

/// Reads what a URI names: a file beside this one, or the URI itself.
pub(super) fn bytes_of(source: &Source, uri: &str) -> Result<Vec<u8>, ImportError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').unwrap_or_default();
        return if kind.ends_with(";base64") {
            STANDARD.decode(data).map_err(|error| source.bad(format!("a `data:` URI: {error}")))
        } else {
            Ok(percent_decode_str(data).collect())
        };
    }
    let path = percent_decode_str(uri).decode_utf8_lossy();
    Ok(source.beside(&path)?.bytes)
}
