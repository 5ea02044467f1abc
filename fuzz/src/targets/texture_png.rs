//! A texture in a file of the format PNG.

use crate::Worth;
use crate::readers;

pub(crate) fn run(data: &[u8]) -> Worth {
    if !data.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Worth::Nothing;
    }
    readers::texture(data);
    Worth::Kept
}
