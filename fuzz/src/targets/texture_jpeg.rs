//! A texture in a file of the format JPEG.

use crate::Worth;
use crate::readers;

pub(crate) fn run(data: &[u8]) -> Worth {
    if !data.starts_with(b"\xff\xd8\xff") {
        return Worth::Nothing;
    }
    readers::texture(data);
    Worth::Kept
}
