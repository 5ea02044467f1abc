//! A texture in a file of the format JPEG.

use libfuzzer_sys::Corpus;
use slo_fuzz::readers;

pub(crate) fn run(data: &[u8]) -> Corpus {
    if !data.starts_with(b"\xff\xd8\xff") {
        return Corpus::Reject;
    }
    readers::texture(data);
    Corpus::Keep
}
