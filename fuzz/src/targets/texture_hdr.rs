//! A texture in a file of the format Radiance HDR.

use crate::Worth;
use crate::readers;

pub(crate) fn run(data: &[u8]) -> Worth {
    if !data.starts_with(b"#?") {
        return Worth::Nothing;
    }
    readers::texture(data);
    Worth::Kept
}
