//! The bytes of buffers and images.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;
use percent_encoding::percent_decode_str;

use crate::error::ImportError;
use crate::files::Source;

/// Reads all buffers.
pub(super) fn load(
    source: &Source,
    document: &Document,
    blob: Option<&[u8]>,
) -> Result<Vec<Vec<u8>>, ImportError> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob.map(<[u8]>::to_vec),
            gltf::buffer::Source::Uri(uri) => Some(bytes_of(source, uri)?),
        };
        let Some(bytes) = bytes.filter(|bytes| bytes.len() >= buffer.length()) else {
            let message = format!("buffer {} is shorter than the file says", buffer.index());
            return Err(source.bad(message));
        };
        buffers.push(bytes);
    }
    Ok(buffers)
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
