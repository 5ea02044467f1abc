//! A texture in a file of the format OpenEXR.

use crate::Worth;
use crate::readers;

pub(crate) fn run(data: &[u8]) -> Worth {
    if !data.starts_with(b"\x76\x2f\x31\x01") {
        return Worth::Nothing;
    }
    readers::texture(data);
    Worth::Kept
}
